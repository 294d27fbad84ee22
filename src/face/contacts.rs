//! The contact candidates of a face.

use std::collections::{BTreeMap, BTreeSet};

use super::Face;
use crate::contact::{Facets, Pair, PairKind, Solid, lip_pairs, teeth_pairs};
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Which contact candidates to look for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactReach {
    /// Farthest node from a tooth, mm.
    pub teeth_mm: f64,
    /// Farthest node from the other lip, mm.
    pub lips_mm: f64,
}

impl Default for ContactReach {
    /// 12 mm either way: about the largest movement of a posed smile (13.7 mm at the commissure,
    /// J Korean Soc Plast Reconstr Surg 2003;30:393), of which little goes straight to the teeth.
    fn default() -> Self {
        Self { teeth_mm: 12., lips_mm: 12. }
    }
}

/// How far a face overlaps its teeth at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestOverlap {
    /// Mucosa nodes.
    pub nodes: usize,
    /// Those inside a tooth surface.
    pub inside: usize,
    /// Median depth of these, mm.
    pub median_mm: f64,
    /// Greatest depth, mm.
    pub deepest_mm: f64,
}

impl Face {
    /// The contact candidates within `reach`: mucosa nodes against the upper then the lower arch,
    /// upper against lower lip. Nodes fixed to bone have none.
    pub fn contact_pairs(&self, reach: ContactReach) -> Vec<Pair> {
        self.pairs_on(&self.mesh, reach)
    }

    /// The contact candidates where the tissue has moved by `u` (3n, node-major xyz, mm), and the
    /// deepest overlap there beyond that at rest, mm, measured on the surfaces themselves.
    ///
    /// Rows and gaps are linearised about `u`: `gap + G u` is the signed distance there, from which the
    /// `rest` overlap of the same node is forgiven. A gap may therefore be negative.
    pub fn contact_pairs_at(&self, reach: ContactReach, rest: &[Pair], u: &[f64]) -> (Vec<Pair>, f64) {
        let mut moved = self.mesh.clone();
        for (node, point) in moved.points.iter_mut().enumerate() {
            *point += Vec3::from_fn(|axis, _| u.get(3 * node + axis).copied().unwrap_or(0.));
        }
        let forgiven: BTreeMap<(PairKind, usize), f64> =
            rest.iter().map(|pair| ((pair.kind, pair.node), pair.rest_overlap_mm)).collect();
        let mut deepest = 0f64;
        let mut pairs = self.pairs_on(&moved, reach);
        for pair in &mut pairs {
            let overlap = forgiven.get(&(pair.kind, pair.node)).copied().unwrap_or(0.);
            let distance = pair.gap_mm - pair.rest_overlap_mm + overlap;
            deepest = deepest.max(-distance);
            pair.rest_overlap_mm = overlap;
            pair.gap_mm = distance - pair.change_mm(u);
        }
        (pairs, deepest)
    }

    fn pairs_on(&self, mesh: &Mesh, reach: ContactReach) -> Vec<Pair> {
        let facets = Facets::of(mesh);
        let normals = facets.node_normals(mesh);
        let fixed: BTreeSet<usize> = self.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        let free = |nodes: &[usize]| -> Vec<usize> {
            nodes.iter().filter(|node| !fixed.contains(node)).copied().collect()
        };
        let mucosa = free(&self.mucosa);
        let mut pairs = Vec::new();
        for upper in [true, false] {
            let kind = if upper { PairKind::UpperTeeth } else { PairKind::LowerTeeth };
            for teeth in self.teeth.iter().filter(|t| t.upper == upper) {
                let solid = Solid::new(&teeth.surface);
                let points = &mesh.points;
                pairs.extend(teeth_pairs(kind, &solid, points, &mucosa, &normals, reach.teeth_mm));
            }
        }
        let lips = lip_pairs(mesh, &facets, &self.upper_lip, &self.lower_lip, reach.lips_mm);
        pairs.extend(lips.into_iter().filter(|pair| !fixed.contains(&pair.node)));
        pairs
    }

    /// How far the mucosa overlaps the teeth at rest: for each node the deeper of the two arches.
    pub fn rest_overlap(&self) -> RestOverlap {
        let solids: Vec<Solid> = self.teeth.iter().map(|t| Solid::new(&t.surface)).collect();
        let depth = |node: &usize| {
            let of = |solid: &Solid| solid.project(self.mesh.points[*node]).map(|p| -p.distance_mm);
            solids.iter().filter_map(of).fold(0f64, f64::max)
        };
        let mut depths: Vec<f64> = self.mucosa.iter().map(depth).filter(|d| *d > 0.).collect();
        depths.sort_by(f64::total_cmp);
        let n = depths.len();
        let middle = |k: usize| depths.get(k).copied().unwrap_or(0.);
        RestOverlap {
            nodes: self.mucosa.len(),
            inside: n,
            median_mm: (middle(n / 2) + middle(n.saturating_sub(1) / 2)) / 2.,
            deepest_mm: depths.last().copied().unwrap_or(0.),
        }
    }
}
