//! Contact as a barrier: surfaces that never cross, pushed apart by a potential that rises without bound as
//! they approach.
//!
//! ```text
//! B(x) = sum_v A_v / 2 sum_f w_vf b(d_vf; r_v)  +  sum_ee' pi/2 h_e h_e' m(x) b(d_ee'; r_ee')
//! b(d; r) = -kappa r (d/r - 1)^2 ln(d/r)   for d < r, else 0
//! ```
//!
//! v: vertices of either side with a third of the rest area of their triangles, `A_v`; f: vertices, edges and triangles
//! of the surface that v meets, counted so that a flat surface counts once however it is triangulated; e: edges, of
//! width `h_e = A_e / l_e`, so that edges of two surfaces that cross have between them the area of the surface; m: what
//! smooths edges that are nearly parallel; r: the reach, a quarter as far for edges, and of each vertex and each pair of edges
//! less than its distance at rest. Two flat parallel surfaces so press on each other with -b'(d) per area, exactly down to
//! a quarter of the reach; below it edges hold them farther apart.
//!
//! Every step is cut before surfaces cross: what starts apart stays apart.
//!
//! Source: Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang and Kaufman, Incremental Potential Contact (2020);
//! Li et al., Convergent Incremental Potential Contact (2023), for areas and the count of features; Zhang, Lee and
//! Kim, Interactive continuous collision detection for non-convex polyhedra (2006), for the limit of steps.

mod advance;
mod barrier_contact;
mod broad_phase;
mod collision_surface;
mod derivatives;
mod error;
mod law;
mod local;
mod mollifier;
mod neighbours;
mod report;
mod rest;
mod separation;
mod term;
#[cfg(test)]
mod testing;

pub use barrier_contact::BarrierContact;
pub use broad_phase::Candidates;
pub use collision_surface::{Body, CollisionSurface};
pub use derivatives::ContactDerivatives;
pub use error::{BarrierError, Crossing};
pub use law::Barrier;
pub use local::Curvature;
pub use report::ContactPoint;
