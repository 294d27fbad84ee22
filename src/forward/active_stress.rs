//! Muscle force as a continuum stress, the second model beside fibres.

use super::elasticity::fibre_dyad;
use super::{Element, ForwardError};
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Nodal forces (3n, N) of an active stress: `-integral B' s f(x)f`, the load that tissue under a
/// contractile stress `s = T/A` (N/mm²) along unit fibres `f` exerts on the nodes.
///
/// `stress(x)` gives `s` and `f` at `x` (mm), or `None` outside the muscle. A dense bundle of
/// embedded fibres of the same total tension tends to it: both are loads, carried by the
/// displacement's own interpolation `B`, not by `B_bar`.
///
/// # Errors
/// [`ForwardError::InvertedCell`].
pub fn active_stress_forces(
    mesh: &Mesh,
    stress: impl Fn(Vec3) -> Option<(f64, Vec3)>,
) -> Result<Vec<f64>, ForwardError> {
    let mut forces = vec![0.; 3 * mesh.n_nodes()];
    for (index, cell) in mesh.cells.iter().enumerate() {
        let nodes: Vec<Vec3> = mesh.cell_points(index).collect();
        let element = Element::new(cell.kind(), &nodes)
            .ok_or(ForwardError::InvertedCell { cell: mesh.cell_ids[index] })?
            .fully_integrated();
        for (q, point) in element.points().iter().enumerate() {
            let Some((s, f)) = stress(point.position) else { continue };
            for (&node, force) in cell.nodes().iter().zip(element.stress_force(q, &(fibre_dyad(f) * s))) {
                for axis in 0..3 {
                    forces[3 * node + axis] -= force[axis];
                }
            }
        }
    }
    Ok(forces)
}
