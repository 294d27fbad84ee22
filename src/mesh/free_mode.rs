//! Rigid motions that nothing prevents.

use std::fmt;

use nalgebra::{DMatrix, SymmetricEigen};

use crate::units::Vec3;

/// A rigid motion that supports or joints leave free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeMode {
    /// A shift along `direction` (unit).
    Translation {
        /// Unit vector.
        direction: Vec3,
    },
    /// A turn about `axis` (unit) through the point `through`, mm, with a shift along the axis if it is a
    /// screw.
    Rotation {
        /// Unit vector.
        axis: Vec3,
        /// A point of the axis, mm.
        through: Vec3,
    },
}

impl fmt::Display for FreeMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation { direction } => write!(f, "translation along {}", Direction(*direction)),
            Self::Rotation { axis, through } => write!(
                f,
                "rotation about {} through ({:.3}, {:.3}, {:.3}) mm",
                Direction(*axis),
                through.x,
                through.y,
                through.z
            ),
        }
    }
}

struct Direction(Vec3);

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, name) in ["x", "y", "z"].iter().enumerate() {
            if self.0[k].abs() > 1. - 1e-9 {
                return f.write_str(name);
            }
        }
        write!(f, "({:.3}, {:.3}, {:.3})", self.0.x, self.0.y, self.0.z)
    }
}

/// The velocity `shift + turn x (p - centre)` of a rigid body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) shift: Vec3,
    pub(super) turn: Vec3,
}

impl FreeMode {
    /// All six, about `centre`.
    pub(super) fn all(centre: Vec3) -> Vec<Self> {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let shifts = axes.map(|direction| Self::Translation { direction });
        let turns = axes.map(|axis| Self::Rotation { axis, through: centre });
        shifts.into_iter().chain(turns).collect()
    }

    /// What `motion` about `centre` is; `size` (mm) weighs turns against shifts.
    pub(super) fn of(motion: Motion, centre: Vec3, size: f64) -> Self {
        let turn = motion.turn.norm();
        if turn * size < 1e-6 * motion.shift.norm() {
            return Self::Translation { direction: upright(motion.shift) };
        }
        let axis = motion.turn / turn;
        let through = centre + axis.cross(&motion.shift) / turn;
        Self::Rotation { axis: upright(axis), through }
    }
}

/// `v` as a unit vector without round-off, its greatest component positive: the same for every run.
fn upright(v: Vec3) -> Vec3 {
    let v = v.normalize().map(|x| if x.abs() < 1e-9 { 0. } else { x });
    if v[v.iamax()] < 0. { -v } else { v }
}

/// The joint motions of `n` rigid bodies that keep the velocities of `rows` zero.
///
/// Each row is a point and its bodies with signs: `sum sign (shift_b + turn_b x (p - centre)) = 0`. A body
/// held at a fixed point is one entry, a joint two.
pub(super) fn free_motions(
    n: usize,
    rows: &[(Vec3, Vec<(usize, f64)>)],
    centre: Vec3,
    size: f64,
) -> Vec<Vec<Motion>> {
    let mut normal = DMatrix::<f64>::zeros(6 * n, 6 * n);
    for (p, bodies) in rows {
        let arm = (p - centre) / size;
        for axis in 0..3 {
            let mut unit = Vec3::zeros();
            unit[axis] = 1.;
            // (turn x arm) . unit = turn . (arm x unit)
            let turn = arm.cross(&unit);
            let row: Vec<(usize, f64)> = bodies
                .iter()
                .flat_map(|&(b, sign)| {
                    (0..3).flat_map(move |k| [(6 * b + k, sign * unit[k]), (6 * b + 3 + k, sign * turn[k])])
                })
                .filter(|entry| entry.1 != 0.)
                .collect();
            for &(i, x) in &row {
                for &(j, y) in &row {
                    normal[(i, j)] += x * y;
                }
            }
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let greatest = eigen.eigenvalues.amax().max(f64::MIN_POSITIVE);
    let mut free: Vec<usize> =
        (0..6 * n).filter(|&k| eigen.eigenvalues[k].abs() <= 1e-10 * greatest).collect();
    free.sort_unstable_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]).then(i.cmp(&j)));
    let motion = |k: usize, b: usize| {
        let v = eigen.eigenvectors.column(k);
        let at = |i: usize| v[6 * b + i];
        Motion { shift: Vec3::new(at(0), at(1), at(2)), turn: Vec3::new(at(3), at(4), at(5)) / size }
    };
    free.into_iter().map(|k| (0..n).map(|b| motion(k, b)).collect()).collect()
}
