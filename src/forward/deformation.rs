//! How far a displacement field strains and turns the tissue.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::{Element, IntegrationPoint};
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Principal strain above which linear elasticity is out of its range.
const LARGEST_STRAIN: f64 = 0.1;
/// Rotation above which linear elasticity is out of its range, degrees: 10 degrees already fake a strain
/// of `1 - cos` = 1.5 %.
const LARGEST_ROTATION_DEG: f64 = 10.;

/// How far a displacement field strains and turns the tissue, and where most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deformation {
    /// Largest absolute principal value of the small strain `(H + H') / 2`, dimensionless.
    pub strain: f64,
    /// Where, at rest, mm.
    pub strain_at: Vec3,
    /// Largest angle of the small rotation `(H - H') / 2`, degrees.
    pub rotation_deg: f64,
    /// Where, at rest, mm.
    pub rotation_at: Vec3,
    /// Share of the volume out of the range of linear elasticity: strain above 0.1 or rotation above
    /// 10 degrees.
    pub beyond_share: f64,
    /// Cells that it turns inside out at some integration point or node: `det(I + H) <= 0`.
    pub inverted_cells: usize,
    /// Where `det(I + H)` is least, at rest, mm,
    pub inverted_at: Vec3,
    /// and how small it is there: the least share of its volume to which tissue is squeezed.
    pub volume_ratio: f64,
    /// Largest principal stretch, the greatest singular value of `I + H`.
    pub stretch: f64,
    /// Where, at rest, mm.
    pub stretch_at: Vec3,
}

impl Default for Deformation {
    /// None.
    fn default() -> Self {
        let nowhere = Vec3::zeros();
        Self {
            strain: 0.,
            strain_at: nowhere,
            rotation_deg: 0.,
            rotation_at: nowhere,
            beyond_share: 0.,
            inverted_cells: 0,
            inverted_at: nowhere,
            volume_ratio: 1.,
            stretch: 1.,
            stretch_at: nowhere,
        }
    }
}

impl Deformation {
    /// Of the displacement `u` (3n, node-major xyz, mm) of `mesh`, over all integration points, `det(I + H)` also at the
    /// nodes of every cell; cells with a Jacobian that is not positive count nothing.
    pub fn of(mesh: &Mesh, u: &[f64]) -> Self {
        let in_cell = |index: usize| {
            let cell = &mesh.cells[index];
            let nodes: Vec<Vec3> = mesh.cell_points(index).collect();
            let element = Element::new(cell.kind(), &nodes)?;
            let local: Vec<Vec3> =
                cell.nodes().iter().map(|&n| Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2])).collect();
            let inside = element.points().iter().map(|p| Tally::at(p, &p.displacement_gradient(&local)));
            let corners = IntegrationPoint::at_nodes(cell.kind(), &nodes);
            let corners = corners.iter().map(|p| Tally::at_node(p, &p.displacement_gradient(&local)));
            inside.chain(corners).reduce(Tally::join)
        };
        // Collected in order before it is joined: sums and ties are the same for any thread count.
        let cells: Vec<Option<Tally>> = (0..mesh.cells.len()).into_par_iter().map(in_cell).collect();
        let inverted_cells = cells.iter().flatten().filter(|cell| cell.worst.volume_ratio <= 0.).count();
        let Some(all) = cells.into_iter().flatten().reduce(Tally::join) else { return Self::default() };
        Self { beyond_share: all.beyond / all.volume, inverted_cells, ..all.worst }
    }

    /// Whether linear elasticity describes it everywhere.
    pub fn is_small(&self) -> bool {
        self.strain <= LARGEST_STRAIN && self.rotation_deg <= LARGEST_ROTATION_DEG
    }
}

/// The deformation of a part of the tissue, to be joined with others.
#[derive(Clone, Copy)]
struct Tally {
    worst: Deformation,
    volume: f64,
    beyond: f64,
}

impl Tally {
    fn at(point: &IntegrationPoint, gradient: &Matrix3<f64>) -> Self {
        let (strain, spin) = ((gradient + gradient.transpose()) / 2., (gradient - gradient.transpose()) / 2.);
        let axis = Vec3::new(spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]);
        let moved = Matrix3::identity() + gradient;
        let worst = Deformation {
            volume_ratio: moved.determinant(),
            stretch: moved.tr_mul(&moved).symmetric_eigenvalues().max().sqrt(),
            stretch_at: point.position,
            strain: strain.symmetric_eigenvalues().amax(),
            strain_at: point.position,
            rotation_deg: axis.norm().to_degrees(),
            rotation_at: point.position,
            inverted_at: point.position,
            ..Deformation::default()
        };
        let beyond = if worst.is_small() { 0. } else { point.volume };
        Self { worst, volume: point.volume, beyond }
    }

    /// At a node of a cell, where only the ratio of volumes is of use: strain is least accurate there.
    fn at_node(point: &IntegrationPoint, gradient: &Matrix3<f64>) -> Self {
        let volume_ratio = (Matrix3::identity() + gradient).determinant();
        let worst = Deformation { volume_ratio, inverted_at: point.position, ..Deformation::default() };
        Self { worst, volume: 0., beyond: 0. }
    }

    fn join(self, other: Self) -> Self {
        let mut worst = self.worst;
        if other.worst.strain > worst.strain {
            (worst.strain, worst.strain_at) = (other.worst.strain, other.worst.strain_at);
        }
        if other.worst.rotation_deg > worst.rotation_deg {
            (worst.rotation_deg, worst.rotation_at) = (other.worst.rotation_deg, other.worst.rotation_at);
        }
        if other.worst.stretch > worst.stretch {
            (worst.stretch, worst.stretch_at) = (other.worst.stretch, other.worst.stretch_at);
        }
        if other.worst.volume_ratio < worst.volume_ratio {
            (worst.volume_ratio, worst.inverted_at) = (other.worst.volume_ratio, other.worst.inverted_at);
        }
        Self { worst, volume: self.volume + other.volume, beyond: self.beyond + other.beyond }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cell, CellKind};

    /// Unit cubes side by side.
    fn two_cubes() -> Mesh {
        let points: Vec<Vec3> =
            (0..12).map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3 % 2), f64::from(i / 6))).collect();
        let hex =
            |x: usize| Cell::new(CellKind::Hex8, &[x, x + 1, x + 4, x + 3, x + 6, x + 7, x + 10, x + 9]);
        Mesh::new(points, vec![hex(0), hex(1)])
    }

    #[test]
    fn stretch_and_spin_are_told_apart_and_weighed_by_volume() {
        // The right cube is stretched by 0.3 and turned by 0.05 rad.
        let mesh = two_cubes();
        let u: Vec<f64> =
            mesh.points.iter().flat_map(|p| if p.x > 1.5 { [0.3, 0., 0.] } else { [0., 0., 0.] }).collect();
        let stretched = Deformation::of(&mesh, &u);
        assert!((stretched.strain - 0.3).abs() < 1e-12 && stretched.rotation_deg < 1e-9, "{stretched:?}");
        assert!(stretched.strain_at.x > 1. && !stretched.is_small());
        assert!((stretched.beyond_share - 0.5).abs() < 1e-12);
        let turned: Vec<f64> = mesh.points.iter().flat_map(|p| [-0.05 * p.y, 0.05 * p.x, 0.]).collect();
        let turned = Deformation::of(&mesh, &turned);
        assert!(
            (turned.rotation_deg - 0.05f64.to_degrees()).abs() < 1e-9 && turned.strain < 1e-12,
            "{turned:?}"
        );
        assert!(turned.is_small() && turned.beyond_share == 0. && turned.inverted_cells == 0);
    }

    #[test]
    fn a_cell_pushed_through_itself_is_inside_out() {
        let mesh = two_cubes();
        // The far side of the right cell comes back by 0.9 or 1.1 of its width.
        for (back, inverted_cells) in [(0.9, 0), (1.1, 1)] {
            let u: Vec<f64> =
                mesh.points.iter().flat_map(|p| [if p.x > 1.5 { -back } else { 0. }, 0., 0.]).collect();
            let found = Deformation::of(&mesh, &u);
            assert_eq!(found.inverted_cells, inverted_cells, "{found:?}");
            assert!(found.inverted_at.x > 1., "{found:?}");
        }
    }
}
