//! Small surfaces for the unit tests of this module.

use crate::mesh::{Cell, CellKind, Mesh, Surface};
use crate::units::Vec3;

/// A slab of 12 x 12 mm, `n` x `n` hexahedra, from 1 mm below the height `z` to `z`.
pub(super) fn sheet(n: usize, z: f64) -> Mesh {
    let at = |i: usize, j: usize, k: usize| i + (n + 1) * (j + (n + 1) * k);
    let mut points = Vec::new();
    for height in [z - 1., z] {
        for j in 0..=n {
            for i in 0..=n {
                points.push(Vec3::new(12. * i as f64 / n as f64, 12. * j as f64 / n as f64, height));
            }
        }
    }
    let mut cells = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let quad = |k: usize| [at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)];
            cells.push(Cell::new(CellKind::Hex8, &[quad(0), quad(1)].concat()));
        }
    }
    Mesh::new(points, cells)
}

/// The square of 12 x 12 mm at the height `z` in 2 x `n` x `n` triangles that look down.
pub(super) fn triangulated(n: usize, z: f64) -> Surface {
    let at = |i: usize, j: usize| i + (n + 1) * j;
    let mut surface = Surface::default();
    for j in 0..=n {
        for i in 0..=n {
            surface.points.push(Vec3::new(12. * i as f64 / n as f64, 12. * j as f64 / n as f64, z));
        }
    }
    for j in 0..n {
        for i in 0..n {
            surface.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            surface.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    surface
}

/// Numbers that look random and are the same everywhere (`SplitMix64`).
pub(super) struct Random(pub(super) u64);

impl Random {
    /// Uniform from -1 to 1.
    pub(super) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.
    }

    pub(super) fn point(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}
