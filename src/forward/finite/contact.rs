//! The contact of a face as a part of its potential.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::contact::Facets;
use crate::contact::{Barrier, BarrierContact, CollisionSurface, ContactPoint};
use crate::face::{Face, Pose};
use crate::forward::model::fixed_dofs;
use crate::mesh::Surface;
use crate::units::Vec3;

use super::{FiniteError, Place};

/// Distance from which surfaces push each other apart, mm: half of what the standard face keeps from its teeth.
const REACH_MM: f64 = 0.2;
/// Pressure at about half of the reach, N/mm²: lips press on teeth with some 10 kPa.
const PRESSURE: f64 = 0.01;
/// Pieces along an edge into which a facet is cut, so that four triangles about the middle of each follow its twist.
const SUBDIVISION: usize = 1;
/// How far beyond mucosa and lips the outside is met, mm along it: the rims of the lips and the skin about them fold.
const RIM_MM: f64 = 12.;

/// Which surfaces of a face may not cross: mucosa, lips and the outside about them, where every node can move, and its
/// teeth. What is in part
/// attached to bone meets nothing: there the tissue runs onto the bone that carries the teeth.
#[derive(Clone, Debug)]
pub struct FaceContact {
    pub(super) barrier: BarrierContact,
}

/// What touches in a face at rest.
#[derive(Clone, Debug)]
pub struct TouchedContact {
    /// Pairs that were near enough to be looked at.
    pub candidates: usize,
    /// Those that push each other.
    pub points: Vec<ContactPoint>,
    /// The force of contact on each node (n), N.
    pub node_forces: Vec<Vec3>,
}

/// Points of the tooth surfaces, mm: a list for each.
pub(super) type Obstacles = Arc<Vec<Vec<Vec3>>>;

impl FaceContact {
    /// The contact of `face`, its teeth included.
    ///
    /// # Errors
    /// [`FiniteError::Contact`] when surfaces cross at rest.
    pub fn new(face: &Face) -> Result<Self, FiniteError> {
        let held = fixed_dofs(face);
        let facets = Facets::of(&face.mesh);
        let own = face.mucosa.iter().chain(&face.upper_lip).chain(&face.lower_lip).copied().collect();
        let mut met = facets.around(&face.mesh, &own, &BTreeSet::new(), RIM_MM);
        met.retain(|&node| !held[3 * node]);
        let facets = facets.within(&met);
        let surfaces: Vec<&Surface> = face.teeth.iter().map(|t| &t.surface).collect();
        let surface = CollisionSurface::new(&face.mesh, &facets, &surfaces, SUBDIVISION);
        let rest = surface.positions(&face.mesh.points, &teeth_at(face, &Pose::rest()));
        let barrier = Barrier { reach_mm: REACH_MM, stiffness: PRESSURE };
        Ok(Self { barrier: BarrierContact::new(surface, &rest, barrier)? })
    }

    /// What touches at `place`.
    pub(super) fn touched(&self, place: &Place) -> TouchedContact {
        let at = self.positions(&place.x, &place.obstacles);
        let candidates = self.barrier.candidates(&at, &at);
        let mut points = self.barrier.contact_points(&at, &candidates);
        points.retain(|point| point.force_n != Vec3::zeros());
        let mut node_forces = vec![Vec3::zeros(); place.x.len()];
        let surface = self.barrier.surface();
        for (vertex, force) in self.barrier.vertex_forces(&at, &candidates).iter().enumerate() {
            surface.carriers(vertex).iter().for_each(|(node, share)| node_forces[*node] += *share * force);
        }
        TouchedContact { candidates: candidates.len(), points, node_forces }
    }

    /// All vertices, mm, with the nodes at `x` and the teeth at `obstacles`.
    pub(super) fn positions(&self, x: &[Vec3], obstacles: &Obstacles) -> Vec<Vec3> {
        self.barrier.surface().positions(x, obstacles)
    }
}

/// The tooth surfaces of `face` where `pose` brings them.
pub(super) fn teeth_at(face: &Face, pose: &Pose) -> Obstacles {
    Arc::new(face.teeth_at(pose).into_iter().map(|t| t.surface.points).collect())
}
