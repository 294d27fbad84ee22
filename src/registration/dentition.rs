//! Teeth and jaw of the patient: given ones, or the standard's brought along with the tissue about them.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::similarity::Similarity;
use super::tissue::Spring;
use crate::contact::{Facets, Projection, Solid};
use crate::face::{Face, Jaw, Teeth};
use crate::units::Vec3;

/// Clearances beyond which the mucosa is not behind teeth, mm.
const BEHIND_MM: [f64; 2] = [-4., 8.];
/// The widest clearance that is kept, mm.
const WIDEST_MM: f64 = 3.;

/// A point of the inner surface: its nodes and their weights.
type Carriers = Vec<(usize, f64)>;

/// How far what faces the teeth is from them.
pub(super) struct Clearance {
    /// Free nodes inside, middles of their edges and facets, with the gap of each at the start, mm.
    points: Vec<(Carriers, f64)>,
}

/// The teeth as solids.
pub(super) struct Solids(Vec<Solid>);

impl Solids {
    pub(super) fn of(teeth: &[Teeth]) -> Self {
        Self(teeth.iter().map(|teeth| Solid::new(&teeth.surface)).collect())
    }

    /// The least signed distance of `p`, with its foot.
    pub(super) fn project(&self, p: Vec3) -> Option<Projection> {
        let all = self.0.iter().filter_map(|solid| solid.project(p));
        all.min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))
    }
}

impl Clearance {
    /// That of `face`, whose nodes are at `x` (n, mm), to `solids`.
    pub(super) fn new(face: &Face, x: &[Vec3], solids: &Solids) -> Self {
        // All of the surface that can move but skin, as contact meets it: also what runs on from mucosa between the jaws.
        let held: BTreeSet<usize> = face.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        let facets = Facets::of(&face.mesh);
        let is_free = |n: &usize| !held.contains(n) && face.skin.binary_search(n).is_err();
        let outside: BTreeSet<usize> = facets.corners().iter().flatten().copied().filter(is_free).collect();
        let mut all: BTreeSet<Vec<usize>> = outside.iter().map(|&n| vec![n]).collect();
        for facet in facets.within(&Vec::from_iter(outside)).corners() {
            for (k, &a) in facet.iter().enumerate() {
                let b = facet[(k + 1) % facet.len()];
                all.insert(vec![a.min(b), a.max(b)]);
            }
            all.insert(facet.clone());
        }
        let all: Vec<Vec<usize>> = all.into_iter().collect();
        let gap = |nodes: &Vec<usize>| {
            let carriers: Carriers = nodes.iter().map(|&n| (n, 1. / nodes.len() as f64)).collect();
            let gap = solids.project(place(&carriers, x))?.distance_mm;
            (gap <= BEHIND_MM[1]).then_some((carriers, gap.min(WIDEST_MM)))
        };
        Self { points: all.par_iter().filter_map(gap).collect() }
    }

    /// Springs of `stiffness` (N/mm each) that give the points at `x` (n, mm) their gaps to `solids` again, or where `only_out`
    /// just keep them from lesser ones.
    pub(super) fn springs(&self, x: &[Vec3], solids: &Solids, stiffness: f64, only_out: bool) -> Vec<Spring> {
        let spring = |(carriers, gap): &(Carriers, f64)| {
            let p = place(carriers, x);
            let at = solids.project(p)?;
            let is_behind = (BEHIND_MM[0]..=BEHIND_MM[1]).contains(&at.distance_mm);
            let is_asked = is_behind && (!only_out || at.distance_mm < *gap);
            is_asked.then(|| Spring {
                carriers: carriers.clone(),
                // Not from the foot: in the middle of a groove there are two.
                target: p + (*gap - at.distance_mm) * at.normal,
                normal: at.normal,
                along: stiffness,
                across: 0.,
            })
        };
        self.points.par_iter().filter_map(spring).collect()
    }

    /// How many points at `x` (n, mm) are nearer to `solids` than half of what they should be.
    pub(super) fn lacking(&self, x: &[Vec3], solids: &Solids) -> usize {
        let is_near = |(carriers, gap): &&(Carriers, f64)| {
            solids.project(place(carriers, x)).is_some_and(|at| at.distance_mm < 0.5 * gap)
        };
        self.points.par_iter().filter(is_near).count()
    }
}

fn place(carriers: &Carriers, x: &[Vec3]) -> Vec3 {
    carriers.iter().map(|&(n, w)| w * x[n]).sum()
}

/// How the tissue of one jaw has moved from `from` to `to` (n, mm): the similarity of its nodes on bone and mucosa.
pub(super) fn jaw_motion(face: &Face, upper: bool, from: &[Vec3], to: &[Vec3]) -> Option<Similarity> {
    let mut nodes: Vec<usize> = face
        .supports
        .iter()
        .filter(|support| (support.bone == "mandible") != upper)
        .flat_map(|support| support.nodes.iter().copied())
        .collect();
    let middle = face.landmark("stomion_superius").map_or(0., |l| l.site.position.y);
    nodes.extend(face.mucosa.iter().copied().filter(|&n| (face.mesh.points[n].y >= middle) == upper));
    nodes.sort_unstable();
    nodes.dedup();
    let pairs: Vec<[Vec3; 2]> = nodes.iter().map(|&n| [from[n], to[n]]).collect();
    Similarity::fit(&pairs, &vec![1.; pairs.len()], false)
}

/// `teeth` moved by `motion`.
pub(super) fn moved(teeth: &Teeth, motion: &Similarity) -> Teeth {
    let mut teeth = teeth.clone();
    teeth.surface.points.iter_mut().for_each(|p| *p = motion.apply(*p));
    teeth
}

/// `jaw` moved by `motion`, its incisal point on the lower `teeth` where they are the patient's.
pub(super) fn moved_jaw(jaw: &Jaw, motion: &Similarity, given: Option<&Teeth>) -> Jaw {
    let carried = motion.apply(jaw.incisor);
    let nearest = given.and_then(|teeth| {
        let by_distance = |a: &&Vec3, b: &&Vec3| {
            let distance = |p: &Vec3| (p - carried).norm();
            distance(a).total_cmp(&distance(b))
        };
        teeth.surface.points.iter().min_by(by_distance).copied()
    });
    Jaw {
        bone: jaw.bone.clone(),
        condyles: jaw.condyles.map(|c| motion.apply(c)),
        incisor: nearest.unwrap_or(carried),
    }
}
