//! How long the muscles are, and how hard each pulls at a length.

use super::{Mechanics, Stiffness, Strain};
use crate::face::{Face, Fibre, Muscle, polyline_length};
use crate::mesh::Locator;
use crate::units::{N_PER_MM2_PER_KPA, Vec3};

/// Length of each muscle of `face` under the displacement `u` (3n, mm) over that at rest (m): the sums over its fibres. The
/// tissue carries the points; those outside it stay where they are.
pub fn muscle_stretches(face: &Face, u: &[f64]) -> Vec<f64> {
    let locator = Locator::new(&face.mesh);
    let moved = |p: &Vec3| locator.locate(*p).map_or(*p, |found| p + found.site.displacement(u));
    let of = |muscle: &Muscle| {
        let length = |moved: &dyn Fn(&Vec3) -> Vec3| -> f64 {
            let of = |f: &Fibre| polyline_length(&f.points.iter().map(moved).collect::<Vec<_>>(), f.closed);
            muscle.fibres.iter().map(of).sum()
        };
        let rest = length(&|p| *p);
        if rest > 0. { length(&moved) / rest } else { 1. }
    };
    face.muscles.iter().map(of).collect()
}

/// The force along a muscle, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MuscleForce {
    /// Its tension, and what activation adds to the stiffness of its fibres.
    pub active_n: f64,
    /// Its tissue at rest.
    pub passive_n: f64,
}

/// The force along `muscle` of `face` at activation `a` and so much `stretch` (length over that at rest), N, by the laws of
/// `mechanics`: that of the bundle alone, of its cross-section `A`, pulled along its fibres and free across them.
///
/// ```text
/// linear   active  a T + A a E_x (l - 1)             passive  A E_r (l - 1)
/// finite   active  a (T + A E_x ln l / l)            passive  A 2 (l - 1/l^2) (c_1 + 2 c_2 (l^2 + 2/l - 3))
/// ```
///
/// `T`: force at full activation; `E_r`, `E_x`: modulus at rest and what full activation adds; `c_1`, `c_2`: constants of the
/// passive law, whose volume is kept. Where stiffness is held, that part of it counts as passive. A muscle without a
/// cross-section has its tension alone.
pub fn muscle_force(face: &Face, muscle: &Muscle, mechanics: Mechanics, a: f64, stretch: f64) -> MuscleForce {
    let tissue = &face.muscle_tissue;
    let area = muscle.area_mm2.unwrap_or(0.);
    let rest = tissue.rest_kpa * N_PER_MM2_PER_KPA;
    let extra = (tissue.active_kpa - tissue.rest_kpa) * N_PER_MM2_PER_KPA;
    let tension = a * muscle.max_force_n;
    let l = stretch;
    match (mechanics.strain, mechanics.stiffness) {
        (Strain::Linear, Stiffness::Fixed(held)) => {
            MuscleForce { active_n: tension, passive_n: area * (rest + held * extra) * (l - 1.) }
        }
        (Strain::Linear, Stiffness::Activated) => {
            MuscleForce { active_n: tension + area * a * extra * (l - 1.), passive_n: area * rest * (l - 1.) }
        }
        (Strain::Finite, _) => {
            let c1 = rest / (4. * (1. + tissue.poisson));
            let c2 = c1 * face.tissue.strain_stiffening;
            let invariant = l * l + 2. / l;
            MuscleForce {
                active_n: tension + area * a * extra * l.ln() / l,
                passive_n: area * 2. * (l - 1. / (l * l)) * (c1 + 2. * c2 * (invariant - 3.)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::{MuscleTissue, standard, standard::Resolution};
    use crate::forward::finite::{Patch, PatchPoint, PointFibre, PointMaterial};

    /// The derivative of the energy that the finite model minimises, of a tetrahedron of this muscle.
    #[test]
    fn the_force_is_the_slope_of_the_energy_at_finite_strain() {
        let face = standard(&Resolution::COARSE).with_strength(2.5);
        let muscle = &face.muscles[0];
        let area = muscle.area_mm2.expect("the standard face has them");
        let MuscleTissue { rest_kpa, active_kpa, poisson, .. } = face.muscle_tissue;
        let material = PointMaterial {
            shear: rest_kpa * 1e-3 / (2. * (1. + poisson)),
            strain_stiffening: face.tissue.strain_stiffening,
            bulk: 1.,
            fibre: Some(PointFibre {
                muscle: 0,
                direction: Vec3::x(),
                stiffening: (active_kpa - rest_kpa) * 1e-3,
                tension: muscle.max_force_n / area,
            }),
        };
        let gradients = vec![-Vec3::repeat(1.), Vec3::x(), Vec3::y(), Vec3::z()];
        let point = PatchPoint { volume: 1. / 6., gradients, material };
        let patch = Patch::new(vec![0, 1, 2, 3], vec![point]);
        let energy = |l: f64, a: f64| {
            let across = 1. / l.sqrt();
            let x = [Vec3::zeros(), l * Vec3::x(), across * Vec3::y(), across * Vec3::z()];
            patch.energy(&x, &[a]).expect("upright")
        };
        let mechanics = Mechanics { strain: Strain::Finite, ..Mechanics::default() };
        for a in [0., 0.3, 1.] {
            for l in [0.7, 0.95, 1., 1.2, 1.6] {
                let slope = 6. * area * (energy(l + 1e-5, a) - energy(l - 1e-5, a)) / 2e-5;
                let MuscleForce { active_n, passive_n } = muscle_force(&face, muscle, mechanics, a, l);
                assert!((active_n + passive_n - slope).abs() < 1e-6 * (1. + slope.abs()), "{a} {l}: {slope}");
            }
        }
    }

    /// Free across, a bar of the linear law has the modulus along the fibre.
    #[test]
    fn the_linear_force_has_the_modulus_of_the_law() {
        let face = standard(&Resolution::COARSE);
        let muscle = &face.muscles[0];
        let mechanics = Mechanics::default();
        for a in [0., 0.4, 1.] {
            let c = face.muscle_tissue.stiffness(a, Vec3::x());
            let along = 1. / c.try_inverse().expect("positive")[(0, 0)];
            let force = |l: f64| {
                let MuscleForce { active_n, passive_n } = muscle_force(&face, muscle, mechanics, a, l);
                active_n + passive_n
            };
            let slope = (force(1.1) - force(0.9)) / 0.2;
            assert!((slope / (along * muscle.area_mm2.expect("known")) - 1.).abs() < 1e-9, "{a}");
            assert!((force(1.) - a * muscle.max_force_n).abs() < 1e-12);
        }
    }

    #[test]
    fn a_face_that_grows_lengthens_its_muscles_alike() {
        let face = standard(&Resolution::COARSE);
        let u: Vec<f64> = face.mesh.points.iter().flat_map(|p| [0.1 * p.x, 0.1 * p.y, 0.1 * p.z]).collect();
        let inside = muscle_stretches(&face, &u);
        // Fibres that reach out of the tissue stay there with those points.
        assert!(inside.iter().all(|s| (0.95..1.1 + 1e-9).contains(s)), "{inside:?}");
        assert!(inside.iter().filter(|s| (**s - 1.1).abs() < 1e-9).count() > inside.len() / 2, "{inside:?}");
    }
}
