//! Closed forms and published benchmarks near incompressibility, where plain elements lock.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use crate::common::{
    add_quad_traction, add_traction_on_tetrahedra, five_tetrahedra, grid, solve, solve_with,
};
use modiolus::forward::Element;
use modiolus::forward::elasticity::isotropic;
use modiolus::mesh::{Cell, CellKind, Mesh};
use modiolus::units::Vec3;

/// Nodes of `mesh` where `select` holds, as prescribed zeros of `axis`.
fn roller(mesh: &Mesh, axis: usize, select: impl Fn(Vec3) -> bool) -> Vec<(usize, f64)> {
    (0..mesh.n_nodes()).filter(|&n| select(mesh.points[n])).map(|n| (3 * n + axis, 0.)).collect()
}

/// An octant of a thick sphere, 1 <= r <= 2: three patches of `n x n` columns of `radial` cells, hexes or what they are
/// cut in.
fn sphere(kind: CellKind, n: usize, radial: usize) -> Mesh {
    let mut merged = Mesh::default();
    let mut known: HashMap<[i64; 3], usize> = HashMap::new();
    let mut cells = Vec::new();
    for patch in 0..3 {
        // Directions (1, tan s, tan t), rotated so that the three patches share the diagonal.
        let mesh = grid(kind, [n, n, radial], |p| {
            let d = Vec3::new(1., (p.x * FRAC_PI_2 / 2.).tan(), (p.y * FRAC_PI_2 / 2.).tan()).normalize()
                * (1. + p.z);
            Vec3::from_fn(|i, _| d[(i + 3 - patch) % 3])
        });
        let place: Vec<usize> = mesh
            .points
            .iter()
            .map(|p| {
                *known.entry(p.map(|x| (x * 1e8).round() as i64).into()).or_insert_with(|| {
                    merged.points.push(*p);
                    merged.points.len() - 1
                })
            })
            .collect();
        cells.extend(mesh.cells.iter().map(|c| c.nodes().iter().map(|&i| place[i]).collect::<Vec<_>>()));
    }
    let cells = cells.iter().map(|nodes| Cell::new(kind, nodes)).collect();
    Mesh::new(merged.points, cells)
}

/// Radial displacement of the inner surface under unit pressure, E = 15, of `n` cells through its thickness.
fn sphere_displacement(kind: CellKind, n: usize, poisson: f64, shape: impl Fn(Element) -> Element) -> f64 {
    let mesh = sphere(kind, n, n);
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    if kind == CellKind::Tet4 {
        let is_inner = |p: Vec3| (p.norm() - 1.).abs() < 1e-9;
        add_traction_on_tetrahedra(&mesh, is_inner, |x| x.normalize(), &mut force);
    }
    for cell in mesh.cells.iter().filter(|c| c.kind() == CellKind::Hex8) {
        let inner: Vec<usize> =
            cell.nodes().iter().copied().filter(|&n| mesh.points[n].norm() < 1. + 1e-9).collect();
        if let Ok(quad) = <[usize; 4]>::try_from(inner) {
            add_quad_traction(&mesh, quad, |x, _| x.normalize(), &mut force);
        }
    }
    let planes: Vec<_> = (0..3).flat_map(|axis| roller(&mesh, axis, move |p| p[axis].abs() < 1e-9)).collect();
    let u = solve_with(&mesh, shape, |_, _| isotropic(15., poisson), &planes, &force);
    let pole = mesh.points.iter().position(|p| (p - Vec3::x()).norm() < 1e-9).unwrap();
    u[3 * pole]
}

#[test]
fn thick_sphere_follows_lame_up_to_near_incompressibility() {
    for (poisson, exact) in [(0.3, 0.053_333_3), (0.49, 0.056_952_4), (0.499, 0.057_123_8)] {
        // Lamé: u(a) = p a / (E (b³ - a³)) ((1 - 2 nu) a³ + (1 + nu) b³ / 2) with a = 1, b = 2, p = 1.
        let lame: f64 = ((1. - 2. * poisson) + (1. + poisson) * 4.) / (15. * 7.);
        assert!((lame - exact).abs() < 1e-7, "the closed form itself: {lame}");
        let computed = sphere_displacement(CellKind::Hex8, 8, poisson, |e| e);
        println!("sphere nu {poisson}: {computed:.7} ({:+.2} %)", 100. * (computed / exact - 1.));
        assert!((computed / exact - 1.).abs() < 0.006, "nu = {poisson}: {computed} for {exact}");
    }
}

#[test]
fn without_mean_dilatation_the_sphere_locks() {
    for kind in [CellKind::Hex8, CellKind::Tet4] {
        let loss = 1. - sphere_displacement(kind, 8, 0.499, Element::fully_integrated) / 0.057_123_8;
        println!("fully integrated sphere of {kind:?}, nu 0.499: {:.1} % lost", 100. * loss);
        assert!(loss > 0.3, "{loss}");
    }
}

#[test]
fn a_thick_sphere_of_tetrahedra_follows_lame_as_well_when_nearly_incompressible() {
    for (poisson, exact) in [(0.3, 0.053_333_3), (0.49, 0.056_952_4), (0.499, 0.057_123_8)] {
        let loss = [4, 8].map(|n| 1. - sphere_displacement(CellKind::Tet4, n, poisson, |e| e) / exact);
        println!("sphere of tetrahedra, nu {poisson}: {:.2} %, {:.2} % lost", 100. * loss[0], 100. * loss[1]);
        assert!(loss[1].abs() < 0.018, "nu = {poisson}: {loss:?}");
        assert!((loss[0] / loss[1]).log2() > 1.6, "nu = {poisson}: {loss:?}");
    }
}

#[test]
fn thick_cylinder_follows_lame() {
    // MacNeal and Harder (1985): radii 3 to 9, graded, plane strain, E = 1000, unit pressure.
    let radii = [3., 3.5, 4.2, 5.2, 6.75, 9.];
    let mesh = grid(CellKind::Hex8, [5, 9, 1], |p| {
        let r = radii[(p.x * 5.).round() as usize];
        let (sin, cos) = (p.y * FRAC_PI_2).sin_cos();
        Vec3::new(r * cos, r * sin, p.z)
    });
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    for cell in &mesh.cells {
        let c = cell.nodes();
        if mesh.points[c[0]].xy().norm() < 3. + 1e-9 {
            let outward = |x: Vec3, _| Vec3::new(x.x, x.y, 0.).normalize();
            add_quad_traction(&mesh, [c[0], c[3], c[7], c[4]], outward, &mut force);
        }
    }
    let mut fixed = roller(&mesh, 2, |_| true);
    fixed.extend(roller(&mesh, 0, |p| p.x.abs() < 1e-9));
    fixed.extend(roller(&mesh, 1, |p| p.y.abs() < 1e-9));
    let node = mesh.points.iter().position(|p| (p - Vec3::new(3., 0., 0.)).norm() < 1e-9).unwrap();
    for (poisson, exact) in [(0.49, 5.0399e-3), (0.499, 5.0602e-3), (0.4999, 5.0623e-3)] {
        let u = solve(&mesh, |_, _| isotropic(1000., poisson), &fixed, &force)[3 * node];
        println!("cylinder nu {poisson}: {u:.4e} ({:+.2} %)", 100. * (u / exact - 1.));
        assert!((u / exact - 1.).abs() < 0.01, "nu = {poisson}: {u} for {exact}");
    }
}

/// Cook's membrane in plane strain: vertical displacement of the top corner.
fn cook(n: usize, shape: impl Fn(Element) -> Element) -> f64 {
    let mesh =
        grid(CellKind::Hex8, [n, n, 1], |p| Vec3::new(48. * p.x, 44. * p.x + p.y * (44. - 28. * p.x), p.z));
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    for cell in &mesh.cells {
        let c = cell.nodes();
        if (mesh.points[c[1]].x - 48.).abs() < 1e-9 {
            // F = 100 spread over the 16 x 1 edge.
            add_quad_traction(
                &mesh,
                [c[1], c[2], c[6], c[5]],
                |_, _| Vec3::new(0., 100. / 16., 0.),
                &mut force,
            );
        }
    }
    let mut fixed = roller(&mesh, 2, |_| true);
    fixed.extend(roller(&mesh, 0, |p| p.x.abs() < 1e-9));
    fixed.extend(roller(&mesh, 1, |p| p.x.abs() < 1e-9));
    let u = solve_with(&mesh, shape, |_, _| isotropic(250., 0.4999), &fixed, &force);
    let corner = mesh.points.iter().position(|p| (p - Vec3::new(48., 60., 0.)).norm() < 1e-9).unwrap();
    u[3 * corner + 1]
}

#[test]
fn cooks_membrane_bends_when_incompressible() {
    for (n, tolerance) in [(16, 0.03), (32, 0.012)] {
        let u = cook(n, |e| e);
        println!("Cook n = {n}: {u:.3} ({:+.2} %)", 100. * (u / 7.771 - 1.));
        assert!((u / 7.771 - 1.).abs() < tolerance, "n = {n}: {u}");
    }
}

/// [`cook`] of tetrahedra, hexes cut in six or in five.
fn cook_of_tetrahedra(n: usize, five: bool, shape: impl Fn(Element) -> Element) -> f64 {
    let map = |p: Vec3| Vec3::new(48. * p.x, 44. * p.x + p.y * (44. - 28. * p.x), p.z);
    let mesh = if five { five_tetrahedra([n, n, 1], map) } else { grid(CellKind::Tet4, [n, n, 1], map) };
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    let is_end = |p: Vec3| (p.x - 48.).abs() < 1e-9;
    add_traction_on_tetrahedra(&mesh, is_end, |_| Vec3::new(0., 100. / 16., 0.), &mut force);
    let mut fixed = roller(&mesh, 2, |_| true);
    fixed.extend(roller(&mesh, 0, |p| p.x.abs() < 1e-9));
    fixed.extend(roller(&mesh, 1, |p| p.x.abs() < 1e-9));
    let u = solve_with(&mesh, shape, |_, _| isotropic(250., 0.4999), &fixed, &force);
    let corner = mesh.points.iter().position(|p| (p - Vec3::new(48., 60., 0.)).norm() < 1e-9).unwrap();
    u[3 * corner + 1]
}

#[test]
fn cooks_membrane_of_tetrahedra_bends_when_incompressible() {
    for five in [false, true] {
        for (n, tolerance) in [(16, 0.08), (32, 0.03)] {
            let u = cook_of_tetrahedra(n, five, |e| e);
            println!("Cook of tetrahedra, n = {n}, five {five}: {u:.3} ({:+.2} %)", 100. * (u / 7.771 - 1.));
            assert!((u / 7.771 - 1.).abs() < tolerance, "n = {n}: {u}");
        }
        let u = cook_of_tetrahedra(16, five, Element::fully_integrated);
        println!("Cook of tetrahedra, n = 16, five {five}, plain: {u:.3}");
        assert!(u < 6., "{u}");
    }
}

#[test]
fn without_mean_dilatation_cooks_membrane_locks() {
    let u = cook(16, Element::fully_integrated);
    println!("Cook n = 16, fully integrated: {u:.3}");
    assert!(u < 4., "{u}");
}
