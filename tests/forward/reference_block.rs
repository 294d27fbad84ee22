//! A distorted two-material block against independent programs.

use std::path::PathBuf;

use crate::common::solve_with;
use modiolus::forward::Element;
use modiolus::forward::elasticity::{isotropic, reinforced};
use modiolus::mesh::{Cell, CellKind, Mesh};
use modiolus::units::{N_PER_MM2_PER_KPA, Vec3};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn vectors(value: &Value) -> Vec<Vec3> {
    value.as_array().unwrap().iter().map(|v| Vec3::from_vec(numbers(v))).collect()
}

/// Largest difference relative to the largest displacement.
fn difference(case: &Value, kind: CellKind, key: &str) -> f64 {
    let indices = |v: &Value| -> Vec<usize> { numbers(v).iter().map(|&x| x as usize).collect() };
    let cells = case["cells"].as_array().unwrap().iter().map(|c| Cell::new(kind, &indices(c))).collect();
    let mesh = Mesh::new(vectors(&case["points_mm"]), cells);
    let (young, extra) = (numbers(&case["young_kpa"]), numbers(&case["fibre_extra_kpa"]));
    let fibres = vectors(&case["fibre"]);
    let poisson = case["poisson"].as_f64().unwrap();
    let law = |cell: usize, _| {
        let young = young[cell] * N_PER_MM2_PER_KPA;
        match extra[cell] * N_PER_MM2_PER_KPA {
            0. => isotropic(young, poisson),
            extra => reinforced(young, poisson, extra, fibres[cell]),
        }
    };
    let prescribed: Vec<_> = indices(&case["fixed_nodes"])
        .iter()
        .flat_map(|n| [(3 * n, 0.), (3 * n + 1, 0.), (3 * n + 2, 0.)])
        .collect();
    let force: Vec<f64> =
        vectors(&case["load_mn"]).iter().flat_map(|f| [f.x * 1e-3, f.y * 1e-3, f.z * 1e-3]).collect();
    // The other program's linear tetrahedra are plain: they do not share their dilatation in patches.
    let plain = |element: Element| if kind == CellKind::Tet4 { element.fully_integrated() } else { element };
    let u = solve_with(&mesh, plain, law, &prescribed, &force);
    let expected = vectors(&case["displacement_mm"][key]);
    let largest = expected.iter().map(|e| e.amax()).fold(0., f64::max);
    let worst = expected
        .iter()
        .enumerate()
        .map(|(n, e)| (e - Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2])).amax())
        .fold(0., f64::max);
    worst / largest
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn the_block_moves_as_calculix_and_an_independent_program_say() {
    let data = PathBuf::from(std::env::var("MODIOLUS_DATA").expect("MODIOLUS_DATA names the data folder"));
    let text = std::fs::read_to_string(data.join("../reference/block.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let cases = [
        (CellKind::Hex8, "C3D8bbar", 1e-8),
        (CellKind::Wedge6, "C3D6bbar", 1e-8),
        (CellKind::Tet4, "ccx", 1e-6),
        (CellKind::Tet10, "ccx", 1e-6),
    ];
    for (case, (kind, key, tolerance)) in reference["cases"].as_array().unwrap().iter().zip(cases) {
        let worst = difference(case, kind, key);
        println!("{kind:?} {key}: {worst:.1e}");
        assert!(worst < tolerance, "{kind:?} against {key}: {worst:e}");
    }
}
