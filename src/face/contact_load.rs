//! What contact does to the tissue: forces, pressures and their sums.

use std::collections::{BTreeMap, BTreeSet};

use super::Face;
use crate::contact::{Facets, Pair, PairKind};
use crate::units::Vec3;

/// N/mm² in kPa.
const KPA: f64 = 1e3;

/// Contact forces gathered on the tissue.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLoad {
    /// Force on each node (n), N: `G' lambda`, on both lips of a pair.
    pub force_n: Vec<Vec3>,
    /// Pressure on each node (n), kPa: the size of its force over the area of mucosa and lips that is its own at
    /// rest, `A_i` = integral of its shape function; 0 where a node has none.
    pub pressure_kpa: Vec<f64>,
    /// Sum of the forces `lambda` by what pushes, N.
    pub total_n: BTreeMap<PairKind, f64>,
}

impl Face {
    /// The load of the contact forces `lambda` (c, N) of `pairs`.
    pub fn contact_load(&self, pairs: &[Pair], lambda: &[f64]) -> ContactLoad {
        let mut force_n = vec![Vec3::zeros(); self.mesh.n_nodes()];
        for (pair, force) in pairs.iter().zip(lambda) {
            pair.row.iter().for_each(|(node, g)| force_n[*node] += *force * g);
        }
        let by_kind: Vec<(PairKind, f64)> =
            pairs.iter().map(|p| p.kind).zip(lambda.iter().copied()).collect();
        self.contact_load_of_nodes(force_n, &by_kind)
    }

    /// The load of the forces `force_n` (n) on the nodes, made up of contacts of these kinds and sizes (N).
    pub fn contact_load_of_nodes(&self, force_n: Vec<Vec3>, contacts: &[(PairKind, f64)]) -> ContactLoad {
        let touched: BTreeSet<usize> =
            self.mucosa.iter().chain(&self.upper_lip).chain(&self.lower_lip).copied().collect();
        let surface = Facets::of(&self.mesh).within(&touched.into_iter().collect::<Vec<_>>());
        let areas = surface.node_areas(&self.mesh);
        let mut total_n = BTreeMap::new();
        for (kind, force) in contacts {
            *total_n.entry(*kind).or_insert(0.) += force;
        }
        let pressure = |(node, force): (usize, &Vec3)| {
            areas.get(&node).filter(|area| **area > 0.).map_or(0., |area| KPA * force.norm() / area)
        };
        let pressure_kpa = force_n.iter().enumerate().map(pressure).collect();
        ContactLoad { force_n, pressure_kpa, total_n }
    }
}

impl ContactLoad {
    /// Sum of the forces of `kind`, N.
    pub fn of(&self, kind: PairKind) -> f64 {
        self.total_n.get(&kind).copied().unwrap_or(0.)
    }
}
