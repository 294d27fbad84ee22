//! Unilateral contact: who may touch whom, how far apart they are at rest, and along which normal.

mod barrier;
mod closed_surface;
mod closest;
mod facet;
mod lips;
mod nearest;
mod orientation;
mod pair;
mod solid;
mod teeth;
mod teeth_error;

pub use barrier::{
    Barrier, BarrierContact, BarrierError, Body, Candidates, CollisionSurface, ContactDerivatives,
    ContactPoint, Crossing, Curvature,
};
pub use closed_surface::closed_surface;
pub use closest::{Feature, TrianglePoint, closest_on_triangle};
pub use facet::{Facets, Patch};
pub use lips::{Lip, lip_pairs};
pub use orientation::oriented;
pub use pair::{Pair, PairKind, ToothPoint};
pub use solid::{Projection, Solid};
pub use teeth::{teeth_pairs, teeth_planes};
pub use teeth_error::{BoundaryLoop, EdgeAt, Piece, TeethError, TeethWarning};
