//! The muscle law on one element: what it keeps of the seed's constants and what it gives up.

use crate::common::{cell_displacements, grid, solve};
use modiolus::face::{Fibre, Muscle, MuscleLaw, MuscleTissue, Tissue};
use modiolus::forward::elasticity::{isotropic, reinforced};
use modiolus::forward::{Element, assemble, tensors};
use modiolus::mesh::CellKind;
use modiolus::units::Vec3;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector6};

const REST_KPA: f64 = 6.2;
const EXTRA_KPA: f64 = 103.8;

/// Modulus (kPa) of a unit cube of muscle, fibres along x, stretched along `axis` by one finite
/// element with free sides.
fn modulus_kpa(activation: f64, axis: usize) -> f64 {
    let mesh = grid(CellKind::Hex8, [1, 1, 1], |p| p);
    let law = reinforced(REST_KPA, 0.49, activation * EXTRA_KPA, Vec3::x());
    let mut prescribed = Vec::new();
    for (n, p) in mesh.points.iter().enumerate() {
        for side in 0..3 {
            if p[side] == 0. {
                prescribed.push((3 * n + side, 0.));
            } else if side == axis {
                prescribed.push((3 * n + side, 1e-3));
            }
        }
    }
    let u = solve(&mesh, |_, _| law, &prescribed, &[0.; 24]);
    let element = Element::new(CellKind::Hex8, &mesh.cell_points(0).collect::<Vec<_>>()).unwrap();
    let stress = law * element.strain(0, &cell_displacements(&mesh, 0, &u));
    assert!((0..6).all(|i| i == axis || stress[i].abs() < 1e-12), "not uniaxial: {stress}");
    stress[axis] / 1e-3
}

#[test]
fn along_the_fibre_the_modulus_is_linear_in_activation() {
    for activation in [0., 0.25, 0.5, 0.7, 1.] {
        let expected = 6.2 + 103.8 * activation;
        let computed = modulus_kpa(activation, 0);
        assert!((computed / expected - 1.).abs() < 1e-10, "a = {activation}: {computed} for {expected}");
    }
}

#[test]
fn across_the_fibre_the_modulus_drifts_to_at_most_8_1_kpa() {
    let across: Vec<f64> = [0., 0.1, 0.5, 1.].into_iter().map(|a| modulus_kpa(a, 1)).collect();
    println!("across the fibre, kPa: {across:?}");
    assert!((across[0] - 6.2).abs() < 1e-10);
    assert!(across.windows(2).all(|w| w[0] < w[1]), "it rises with activation: {across:?}");
    assert!(across[3] < 8.1, "{across:?}");
    // Plane strain along a rigid fibre is the limit: E / (1 - nu²).
    assert!(across[3] < 6.2 / (1. - 0.49f64.powi(2)));
}

#[test]
fn the_bulk_modulus_stays_that_of_nearly_incompressible_tissue() {
    for activation in [0., 0.5, 1.] {
        let compliance = reinforced(REST_KPA, 0.49, activation * EXTRA_KPA, Vec3::x()).try_inverse().unwrap();
        // Volume change under unit hydrostatic stress.
        let volume: f64 = compliance.view((0, 0), (3, 3)).sum();
        let bulk = 1. / volume;
        println!("effective bulk modulus at a = {activation}: {bulk:.2} kPa");
        assert!((bulk / 103. - 1.).abs() < 0.02, "a = {activation}: {bulk}");
    }
}

#[test]
fn a_uniform_strain_stores_the_energy_of_each_tissue_in_its_own_volume() {
    // Two muscles share the middle cells of a block, each with its own fibre direction; the ends are
    // passive. Under u = epsilon x every energy is a closed form.
    let mesh = grid(CellKind::Hex8, [3, 3, 3], |p| Vec3::new(30. * p.x, 6. * p.y, 6. * p.z));
    let fibre = |x: f64, f: Vec3| {
        let points: Vec<Vec3> = (-1..=1).map(|k| Vec3::new(x, 3., 3.) + f64::from(k) * f).collect();
        Fibre { points, closed: false }
    };
    let (along, across) = (Vec3::new(1., 2., 2.) / 3., Vec3::new(2., -2., 1.) / 3.);
    let muscle = |name: &str, x: f64, f: Vec3| Muscle {
        name: name.into(),
        max_force_n: 1.,
        radius_mm: 7.2,
        area_mm2: None,
        insertion_mm: 0.,
        fibres: vec![fibre(x, f)],
    };
    let muscles = [muscle("a_l", 9., along), muscle("a_r", 21., across)];
    let (stiffness, volumes) = assemble(&mesh, Tissue::default(), MuscleTissue::default(), &muscles).unwrap();
    let total = 30. * 6. * 6.;
    let passive_volume = total - volumes.iter().sum::<f64>();
    assert!(volumes.iter().all(|v| *v > 0.2 * total), "{volumes:?}");
    let strain: Matrix3<f64> = 1e-2 * Matrix3::new(1., 0.3, -0.2, 0.3, -0.4, 0.5, -0.2, 0.5, 0.7);
    let u: Vec<f64> =
        mesh.points.iter().flat_map(|p| (strain * p).iter().copied().collect::<Vec<_>>()).collect();
    let energy = |coefficients: [f64; 2]| -> f64 {
        stiffness
            .pattern()
            .multiply(&stiffness.at(&coefficients), &u)
            .iter()
            .zip(&u)
            .map(|(f, u)| f * u)
            .sum()
    };
    // kPa = 1e-3 N/mm².
    let isotropic_density = |young: f64, nu: f64| {
        let (lambda, mu) = (young * nu / ((1. + nu) * (1. - 2. * nu)), young / (2. * (1. + nu)));
        1e-3 * (lambda * strain.trace().powi(2) + 2. * mu * strain.norm_squared())
    };
    let rest = passive_volume * isotropic_density(15., 0.49)
        + (total - passive_volume) * isotropic_density(6.2, 0.49);
    let computed = energy([0., 0.]);
    assert!((computed / rest - 1.).abs() < 1e-12, "at rest: {computed} for {rest}");
    for (part, f) in [along, across].into_iter().enumerate() {
        let mut coefficients = [0.; 2];
        coefficients[part] = 0.6 * 1e-3 * EXTRA_KPA;
        let added = energy(coefficients) - computed;
        let expected = coefficients[part] * volumes[part] * f.dot(&(strain * f)).powi(2);
        assert!((added / expected - 1.).abs() < 1e-9, "muscle {part}: {added} for {expected}");
    }
}

/// Law `orthotropic` with the default constants.
fn orthotropic() -> MuscleTissue {
    MuscleTissue { law: MuscleLaw::Orthotropic, ..MuscleTissue::default() }
}

/// Engineering constants of `C` (N/mm²) with the fibre along x: `E_f`, `E_t` in kPa, `nu_ft`, `nu_tt`.
fn engineering(c: Matrix6<f64>) -> [f64; 4] {
    let s = c.try_inverse().unwrap();
    [1e3 / s[(0, 0)], 1e3 / s[(1, 1)], -s[(0, 1)] / s[(0, 0)], -s[(1, 2)] / s[(1, 1)]]
}

#[test]
fn the_orthotropic_law_keeps_the_modulus_across_and_hardly_changes_volume() {
    for a in [0., 0.2, 0.5, 1.] {
        let [along, across, nu_ft, nu_tt] = engineering(orthotropic().stiffness(a, Vec3::x()));
        assert!((along / (6.2 + 103.8 * a) - 1.).abs() < 1e-10, "a = {a}: E_f {along}");
        assert!((across / 6.2 - 1.).abs() < 1e-10, "a = {a}: E_t {across}");
        assert!((nu_ft - 0.49).abs() < 1e-10 && nu_tt < 0.98, "a = {a}: {nu_ft} {nu_tt}");
        let compliance = orthotropic().stiffness(a, Vec3::x()).try_inverse().unwrap();
        let bulk = 1. / compliance.view((0, 0), (3, 3)).sum();
        println!("orthotropic, a = {a}: nu_tt {nu_tt:.3}, bulk {:.1} kPa", 1e3 * bulk);
        // Pulled along or across, the volume changes by (1 - 2 nu) of the stretch.
        let expected = 1. / (0.02 * (1. / along + 2. / across)) * 1e-3;
        assert!((bulk / expected - 1.).abs() < 1e-9, "a = {a}: {bulk} for {expected}");
    }
}

#[test]
fn both_laws_are_isotropic_at_rest_turn_with_the_fibre_and_stay_positive_definite() {
    let f = Vec3::new(2., -1., 3.).normalize();
    for law in [MuscleLaw::Reinforced, MuscleLaw::Orthotropic] {
        let tissue = MuscleTissue { law, ..MuscleTissue::default() };
        assert!((tissue.stiffness(0., f) - isotropic(6.2e-3, 0.49)).amax() < 1e-12);
        // Energies of a strain and of the same strain turned with the fibre.
        let turn = Rotation3::rotation_between(&Vec3::x(), &f).unwrap();
        let strain = Matrix3::new(1., 0.3, -0.2, 0.3, -0.4, 0.5, -0.2, 0.5, 0.7);
        let voigt = |e: Matrix3<f64>| {
            Vector6::new(e[(0, 0)], e[(1, 1)], e[(2, 2)], 2. * e[(0, 1)], 2. * e[(1, 2)], 2. * e[(2, 0)])
        };
        let (plain, turned) = (voigt(strain), voigt(turn.matrix() * strain * turn.matrix().transpose()));
        for a in [0., 0.3, 1.] {
            let here = (plain.transpose() * tissue.stiffness(a, Vec3::x()) * plain)[0];
            let there = (turned.transpose() * tissue.stiffness(a, f) * turned)[0];
            assert!((here / there - 1.).abs() < 1e-10, "{law:?} a = {a}: {here} {there}");
            assert!(tissue.stiffness(a, f).symmetric_eigenvalues().min() > 0., "{law:?} a = {a}");
        }
    }
    let reinforced = MuscleTissue::default().stiffness(0.7, f);
    assert!((reinforced - isotropic(6.2e-3, 0.49) - (tensors(f)[4] * 0.7 * 103.8e-3)).amax() < 1e-12);
}

#[test]
fn coefficient_slopes_are_derivatives() {
    for law in [MuscleLaw::Reinforced, MuscleLaw::Orthotropic] {
        let tissue = MuscleTissue { law, ..MuscleTissue::default() };
        for a in [0.1, 0.5, 0.9] {
            let (hi, lo) = (tissue.coefficients(a + 1e-5), tissue.coefficients(a - 1e-5));
            for (k, slope) in tissue.coefficient_slopes(a).into_iter().enumerate() {
                let difference = (hi[k] - lo[k]) / 2e-5;
                assert!((slope - difference).abs() < 1e-6 * 0.1, "{law:?} {k}: {slope} {difference}");
            }
        }
    }
}

#[test]
fn inadmissible_orthotropic_constants_are_refused_with_the_activation() {
    for (rest_kpa, active_kpa, poisson) in [(100., 20., 0.49), (10., 30., -0.8), (10., -2., 0.3)] {
        let tissue = MuscleTissue { rest_kpa, active_kpa, poisson, law: MuscleLaw::Orthotropic };
        let threshold = tissue.stable_below().unwrap();
        let least = |a: f64| tissue.stiffness(a, Vec3::x()).symmetric_eigenvalues().min();
        assert!(least(threshold - 1e-3) > 0., "{tissue:?}: still stable just below {threshold}");
        assert!(least(threshold + 1e-3) < 0., "{tissue:?}: unstable just above {threshold}");
    }
    assert_eq!(orthotropic().stable_below(), None);
}

#[test]
fn a_known_cross_section_fixes_the_stiffness_whatever_the_radius() {
    // Fibres along x through a 30 x 6 x 6 bar; the ends' added stiffness is E A / L of 8 mm2, not of the bar.
    let mesh = grid(CellKind::Hex8, [5, 2, 2], |p| Vec3::new(30. * p.x, 6. * p.y, 6. * p.z));
    let u: Vec<f64> = mesh.points.iter().flat_map(|p| [1e-3 * p.x, 0., 0.]).collect();
    let added = |radius_mm: f64, area_mm2: Option<f64>| {
        let points = (0..=30).map(|k| Vec3::new(f64::from(k), 3., 3.)).collect();
        let muscle = Muscle {
            name: "a".into(),
            max_force_n: 1.,
            radius_mm,
            area_mm2,
            insertion_mm: 0.,
            fibres: vec![Fibre { points, closed: false }],
        };
        let (k, volumes) =
            assemble(&mesh, Tissue::default(), MuscleTissue::default(), &[muscle]).expect("a stiffness");
        let energy = |coefficient: f64| -> f64 {
            let force = k.pattern().multiply(&k.at(&[coefficient]), &u);
            force.iter().zip(&u).map(|(f, u)| f * u).sum()
        };
        (energy(1.) - energy(0.), volumes[0], energy(0.))
    };
    // Stretched along x alone, tissue of volume V at rest stores V (lambda + 2 mu) strain^2.
    let modulus = |young_kpa: f64| 1e-3 * young_kpa * 0.51 / (1.49 * 0.02);
    let at_rest = |muscle: f64| 1e-6 * (muscle * modulus(6.2) + (30. * 36. - muscle) * modulus(15.));
    // At a unit coefficient, 1 N/mm2, and the strain 1e-3.
    let exact = 8. * 30. * 1e-6;
    for radius in [2.5, 3.5, 5.] {
        let (found, volume, rest) = added(radius, Some(8.));
        assert!(volume > 1.5 * 240. && (found / exact - 1.).abs() < 1e-9, "{radius}: {found} {volume}");
        // What is not muscle is passive tissue.
        assert!((rest / at_rest(240.) - 1.).abs() < 1e-9, "{radius}: {rest} at rest");
    }
    // Without a cross-section, or with one that the radius does not hold, all of the tissue is muscle, once.
    for area in [None, Some(100.)] {
        let (in_full, volume, rest) = added(5., area);
        assert!((in_full / exact - volume / 240.).abs() < 1e-6, "{area:?}: {in_full} {volume}");
        assert!((rest / at_rest(volume) - 1.).abs() < 1e-9, "{area:?}: {rest} at rest");
    }
}
