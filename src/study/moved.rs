//! A face that was moved.

use crate::contact::PairKind;
use crate::contact::{Body, ContactPoint};
use crate::face::{ContactLoad, Face, overlap};
use crate::forward::SettledContact;
use crate::forward::finite::{FiniteState, SettlingCost};

/// A face under activations and with its bones at a pose.
#[derive(Clone, Debug)]
pub struct MovedFace {
    /// Displacement (3n, node-major xyz), mm.
    pub displacement: Vec<f64>,
    /// What touches; `None` when contact is off.
    pub contact: Option<MovedContact>,
    /// Whether every small push finds it stable: at linear strain by itself, at finite strain where the tangent
    /// stiffness is positive definite.
    pub is_stable: bool,
    /// What it took; `None` at linear strain.
    pub cost: Option<SettlingCost>,
}

/// What touches in a moved face.
#[derive(Clone, Debug)]
pub struct MovedContact {
    /// Pairs that may touch.
    pub candidates: usize,
    /// Pairs that push.
    pub active: usize,
    /// Sum of their forces, N.
    pub force_n: f64,
    /// Forces and pressures on the nodes.
    pub load: ContactLoad,
    /// Deepest overlap of surfaces beyond that at rest, mm: at finite strain by [geometry that contact does not
    /// use](overlap), at linear strain at the nodes that contact meets.
    pub overlap_mm: f64,
    /// Deepest penetration of the linearised gaps, mm.
    pub linear_penetration_mm: f64,
    /// Linearisations of the gaps.
    pub linearisations: usize,
    /// Whether the gaps are those of where the tissue went.
    pub settled: bool,
}

impl MovedContact {
    /// The contact of a linear face.
    pub fn of_linear(face: &Face, settled: &SettledContact) -> Self {
        let forces = &settled.equilibrium.contact_forces;
        Self {
            candidates: forces.len(),
            active: forces.iter().filter(|f| **f > 0.).count(),
            force_n: forces.sum(),
            load: face.contact_load(&settled.pairs, forces.as_slice()),
            overlap_mm: settled.penetration_mm,
            linear_penetration_mm: settled.linear_penetration_mm,
            linearisations: settled.rounds,
            settled: settled.settled,
        }
    }

    /// The contact of a face at finite strain; `None` when contact is off.
    pub fn of_finite(face: &Face, state: &FiniteState) -> Option<Self> {
        let touched = state.contact()?;
        let kind = |point: &ContactPoint| {
            let tooth = point.bodies.iter().find_map(|body| match body {
                Body::Tissue => None,
                Body::Obstacle(k) => face.teeth.get(*k),
            });
            match tooth {
                None => PairKind::Lips,
                Some(teeth) if teeth.upper => PairKind::UpperTeeth,
                Some(_) => PairKind::LowerTeeth,
            }
        };
        let forces: Vec<(PairKind, f64)> =
            touched.points.iter().map(|point| (kind(point), point.force_n.norm())).collect();
        Some(Self {
            candidates: touched.candidates,
            active: forces.iter().filter(|(_, f)| *f > 0.).count(),
            force_n: forces.iter().map(|(_, f)| f).sum(),
            load: face.contact_load_of_nodes(touched.node_forces.clone(), &forces),
            overlap_mm: overlap(face, state.displacement(), state.pose()).off_bone_mm(),
            linear_penetration_mm: 0.,
            linearisations: 0,
            settled: true,
        })
    }
}
