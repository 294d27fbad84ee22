//! Contact whose gaps and normals are those of the deformed face.

use std::collections::BTreeMap;

use nalgebra::DVector;

use super::condensed::Condensed;
use super::contact_forces::contact_forces_near;
use super::{ContactError, Equilibrium, FixedStiffness, Touching};
use crate::contact::{Pair, PairKind};
use crate::face::{ContactSearch, Face, TouchedSurfaces};
use crate::units::Vec3;

/// Linearisations of the gaps before giving up,
const MOST_ROUNDS: usize = 60;
/// Farthest that a node moves between linearisations, mm: less than a lip is thick.
const STRIDE_MM: f64 = 1.;
/// How the stride of a node changes when it turns back,
const SHORTER: f64 = 0.5;
/// and when it goes on: so little that a node that turns back at every third linearisation comes to rest.
const LONGER: f64 = 1.2;
/// Share of the load in the first increment.
const FIRST_LOAD: f64 = 0.1;
/// Deepest overlap, mm, that counts as none.
const TOUCHING_MM: f64 = 1e-2;
/// Farthest, mm, from what it presses on that a node may be,
const PRESSING_MM: f64 = 2e-2;
/// but for this share of the contact force.
const STRAY: f64 = 1e-4;

/// Where the tissue comes to rest against surfaces that are not planes.
#[derive(Clone, Debug)]
pub struct SettledContact {
    /// The candidates as last linearised.
    pub pairs: Vec<Pair>,
    /// Displacement and the forces of these pairs.
    pub equilibrium: Equilibrium,
    /// Deepest violation of the linearised gaps, mm.
    pub linear_penetration_mm: f64,
    /// Deepest overlap beyond that at rest, mm, measured on the surfaces of the deformed face.
    pub penetration_mm: f64,
    /// Share of the contact force that acts where those surfaces are more than 0.02 mm apart.
    pub stray_share: f64,
    /// Linearisations made.
    pub rounds: usize,
    /// Whether it satisfies contact on the deformed surfaces: overlap at most 0.01 mm, stray share at most 1e-4.
    pub settled: bool,
}

impl FixedStiffness<'_> {
    /// The equilibrium under `activation` (m), bones at the pose of this stiffness, with gaps and normals linearised
    /// where the tissue went, sought from the displacement `start` (3n, mm; from what the bones alone do when
    /// `None`); where it does not settle, that with the least overlap.
    ///
    /// From rest the load grows in increments that move no candidate by much more than 1 mm, so that surfaces never
    /// overlap deeply and each node keeps its side. Each round solves `0 <= lambda _|_ g + G (u - v) >= 0` with `g`
    /// and `G` of the surfaces at `v`, then moves `v` towards `u`: node by node, by at most a stride that is halved
    /// when the node turns back and grows again while it keeps on. Where a node rides an edge between two planes,
    /// the stride halves down to the edge, where [both planes](crate::contact::Solid::planes) hold it. The compliance is
    /// condensed to the nodes that may touch once, so that a round costs no factorisation. In the second half of the
    /// rounds the load is whole.
    ///
    /// # Errors
    /// [`ContactError`] when no contact forces keep the linearised gaps open before the load was whole once.
    pub fn settle(
        &self,
        face: &Face,
        search: &ContactSearch,
        activation: &[f64],
        start: Option<&[f64]>,
    ) -> Result<SettledContact, ContactError> {
        let start = start.map(|displacement| Nearby { displacement, pairs: &[], touching: &[] });
        self.settle_within(MOST_ROUNDS, face, search, activation, start)
    }

    /// [`settle`](Self::settle) with at most `most_rounds` linearisations, the touching contacts sought from those
    /// of the start.
    pub(crate) fn settle_within(
        &self,
        most_rounds: usize,
        face: &Face,
        search: &ContactSearch,
        activation: &[f64],
        start: Option<Nearby<'_>>,
    ) -> Result<SettledContact, ContactError> {
        let loading_rounds = most_rounds / 2;
        let nodes = search.nodes();
        let condensed = Condensed::new(self, &nodes);
        let settling = Settling { stiff: self, condensed, nodes, activation };
        let pose = self.pose();
        let from =
            start.map_or_else(|| self.displacement_with(&[], &[], &[]), |start| start.displacement.to_vec());
        let is_rest = start.is_none() && pose.is_rest();
        let about = |u: &[f64]| search.at(face, u, &pose).pairs;
        let mut pairs = if is_rest { search.rest().to_vec() } else { about(&from) };
        let first_touching = start.filter(|s| !s.touching.is_empty()).map(|s| (s.pairs, s.touching));
        let mut place = Place::new(from);
        let mut increment = if start.is_some() { 1. } else { FIRST_LOAD };
        let (mut load, mut last, mut best) = (0., None::<Held>, None::<SettledContact>);
        for rounds in 1..=most_rounds {
            let last_touching = last.as_ref().map(Held::touching).or(first_touching);
            let next = if rounds >= loading_rounds { 1. } else { f64::min(1., load + increment) };
            let mut held = match settling.held(pairs.clone(), next, last_touching) {
                // Cells that are turned inside out may leave the gaps no forces: what came before is the answer.
                Err(_) if best.is_some() => break,
                held => held?,
            };
            let way = settling.way(&place.u, &held.displacement);
            if way > 1.5 * STRIDE_MM && next > load && load > 0. && rounds < loading_rounds {
                // Too far at once: what the increment alone moved tells how much of it can be had later.
                let before = settling.held(pairs, load, last_touching)?;
                let moved = settling.way(&before.displacement, &held.displacement);
                increment *= f64::min(0.5, STRIDE_MM / moved.max(STRIDE_MM));
                held = before;
            } else {
                increment *= (STRIDE_MM / way.max(1e-3)).clamp(0.5, 2.);
                load = next;
            }
            let even = search.evened_out(face, &held.displacement, &pose);
            let there = search.at(face, &even, &pose);
            let penetration_mm = there.overlap_mm();
            let stray_share = stray_share(&there, &held.pairs, &held.forces);
            let settled = load >= 1. && penetration_mm <= TOUCHING_MM && stray_share <= STRAY;
            let whole = load >= 1. || rounds == most_rounds;
            if whole && (settled || best.as_ref().is_none_or(|b| penetration_mm < b.penetration_mm)) {
                best = Some(SettledContact {
                    pairs: held.pairs.clone(),
                    equilibrium: Equilibrium {
                        displacement: held.displacement.clone(),
                        contact_forces: held.forces.clone(),
                    },
                    linear_penetration_mm: held.linear_penetration_mm,
                    penetration_mm,
                    stray_share,
                    rounds,
                    settled,
                });
            }
            if settled {
                break;
            }
            place.follow(&even);
            pairs = about(&place.u);
            last = Some(held);
        }
        best.ok_or(ContactError::NotConverged)
    }

    /// Whether an equilibrium against the model's pairs satisfies contact on the deformed surfaces of `face`, as
    /// [`SettledContact::settled`] says.
    pub fn is_settled(&self, face: &Face, search: &ContactSearch, equilibrium: &Equilibrium) -> bool {
        let there = search.at(face, &equilibrium.displacement, &self.pose());
        there.overlap_mm() <= TOUCHING_MM
            && stray_share(&there, self.model().pairs(), &equilibrium.contact_forces) <= STRAY
    }
}

/// Share of the `forces` of `pairs` that act where the surfaces are not in touch.
fn stray_share(there: &TouchedSurfaces, pairs: &[Pair], forces: &DVector<f64>) -> f64 {
    let distance = there.distances();
    let is_stray = |p: &Pair| distance.get(&(p.kind, p.node)).is_none_or(|d| *d > PRESSING_MM);
    let stray = pairs.iter().zip(forces.iter()).filter(|(p, _)| is_stray(p));
    stray.map(|(_, f)| f).sum::<f64>() / forces.sum().max(f64::MIN_POSITIVE)
}

/// A face beside the one that is sought.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearby<'a> {
    /// Its displacement (3n), mm.
    pub displacement: &'a [f64],
    /// Its contacts,
    pub pairs: &'a [Pair],
    /// and those of them that touch; none where that is not known.
    pub touching: &'a [usize],
}

/// The contacts of one linearisation and the forces that hold them.
struct Held {
    pairs: Vec<Pair>,
    forces: DVector<f64>,
    touching: Touching,
    displacement: Vec<f64>,
    linear_penetration_mm: f64,
}

impl Held {
    /// Its contacts, and those of them that touch.
    fn touching(&self) -> (&[Pair], &[usize]) {
        (&self.pairs, self.touching.contacts())
    }
}

/// What stays the same from round to round.
struct Settling<'a> {
    stiff: &'a FixedStiffness<'a>,
    condensed: Condensed,
    nodes: Vec<usize>,
    activation: &'a [f64],
}

impl Settling<'_> {
    /// The equilibrium under the share `load` of the activations against `pairs`, its touching contacts sought
    /// from those of the linearisation before.
    fn held(
        &self,
        pairs: Vec<Pair>,
        load: f64,
        last: Option<(&[Pair], &[usize])>,
    ) -> Result<Held, ContactError> {
        let a = load * DVector::from_column_slice(self.activation);
        let mut contact = self.condensed.contact(&pairs);
        contact.gap += self.stiff.gap_changes(&pairs);
        let near = last.map(|last| Touching::new(&contact.compliance, same_contacts(last, &pairs)));
        let (forces, touching) = contact_forces_near(&contact, &a, near.as_ref())?;
        let gaps = &contact.gap + &contact.approach * &a + &contact.compliance * &forces;
        let displacement = self.stiff.displacement_with(&pairs, a.as_slice(), forces.as_slice());
        let linear_penetration_mm = gaps.iter().fold(0f64, |deepest, gap| deepest.max(-gap));
        Ok(Held { pairs, forces, touching, displacement, linear_penetration_mm })
    }

    /// Farthest that a node that may touch moves from `here` (3n) to `there` (3n), mm.
    fn way(&self, here: &[f64], there: &[f64]) -> f64 {
        self.nodes.iter().map(|&n| (of_node(there, n) - of_node(here, n)).norm()).fold(0., f64::max)
    }
}

/// Where the gaps are linearised.
struct Place {
    /// Displacement (3n), mm.
    u: Vec<f64>,
    step: Vec<Vec3>,
    stride_mm: Vec<f64>,
}

impl Place {
    fn new(u: Vec<f64>) -> Self {
        let n = u.len() / 3;
        Self { u, step: vec![Vec3::zeros(); n], stride_mm: vec![STRIDE_MM; n] }
    }

    /// Moves each node towards its place in `to` (3n, mm), by its stride at most.
    fn follow(&mut self, to: &[f64]) {
        for node in 0..self.step.len() {
            let step = of_node(to, node) - of_node(&self.u, node);
            let stride = &mut self.stride_mm[node];
            let turned = step.dot(&self.step[node]) < 0.;
            *stride = if turned { SHORTER * *stride } else { f64::min(LONGER * *stride, STRIDE_MM) };
            self.step[node] = step;
            let taken = step * f64::min(1., *stride / step.norm().max(f64::MIN_POSITIVE));
            for axis in 0..3 {
                self.u[3 * node + axis] += taken[axis];
            }
        }
    }
}

fn of_node(u: &[f64], node: usize) -> Vec3 {
    Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2])
}

/// The contacts of `pairs` that were `touching` among those `before`: of the same node the plane that is turned
/// least.
fn same_contacts((before, touching): (&[Pair], &[usize]), pairs: &[Pair]) -> Vec<usize> {
    let mut of_node: BTreeMap<(PairKind, usize), Vec<usize>> = BTreeMap::new();
    for (k, pair) in pairs.iter().enumerate() {
        of_node.entry((pair.kind, pair.node)).or_default().push(k);
    }
    let mut same = Vec::new();
    for old in touching.iter().map(|&i| &before[i]) {
        let likeness = |k: &usize| pairs[*k].normal().dot(&old.normal());
        let candidates = of_node.get(&(old.kind, old.node)).into_iter().flatten();
        if let Some(&k) = candidates.max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
            && !same.contains(&k)
        {
            same.push(k);
        }
    }
    same
}
