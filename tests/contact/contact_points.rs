//! Where contact is asked for: at the nodes of the tissue, or at quadrature points of its facets.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::time::Instant;

use crate::common::{add_quad_traction, contact_response, factor, grid, half_space, isotropic};
use modiolus::contact::{Facets, Pair, PairKind, Solid};
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, ContactSearch};
use modiolus::forward::{Cholesky, Model, SparseColumn, contact_forces};
use modiolus::mesh::{CellKind, Mesh};
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector};

/// Where on the facets contact is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    Nodes,
    /// 2 x 2 Gauss points of each facet.
    Gauss,
    /// The middle of each facet.
    Middle,
}

const RULES: [Rule; 3] = [Rule::Nodes, Rule::Gauss, Rule::Middle];

/// A point of the surface, the nodes that carry it, and the area that it stands for, mm².
struct Point {
    weights: Vec<(usize, f64)>,
    at: Vec3,
    area: f64,
}

impl Point {
    /// The row of the gap to what comes down along -z.
    fn pair(&self, gap_mm: f64) -> Pair {
        Pair {
            kind: PairKind::UpperTeeth,
            node: self.weights[0].0,
            row: self.weights.iter().map(|&(node, w)| (node, -w * Vec3::z())).collect(),
            tooth: None,
            gap_mm,
            rest_overlap_mm: 0.,
        }
    }

    fn height(&self, u: &[f64]) -> f64 {
        self.weights.iter().map(|(node, w)| w * u[3 * node + 2]).sum()
    }
}

/// The point of a facet at `(x, y)` in the unit square.
fn on_facet(mesh: &Mesh, facet: &[usize], [x, y]: [f64; 2], share: f64) -> Point {
    let shape = [(1. - x) * (1. - y), x * (1. - y), x * y, (1. - x) * y];
    let p: Vec<Vec3> = facet.iter().map(|&node| mesh.points[node]).collect();
    let along_x = (1. - y) * (p[1] - p[0]) + y * (p[2] - p[3]);
    let along_y = (1. - x) * (p[3] - p[0]) + x * (p[2] - p[1]);
    Point {
        weights: facet.iter().copied().zip(shape).collect(),
        at: p.iter().zip(shape).map(|(p, n)| n * p).sum(),
        area: share * along_x.cross(&along_y).norm(),
    }
}

fn points(mesh: &Mesh, surface: &Facets, rule: Rule) -> Vec<Point> {
    let near = 0.5 - 0.5 / 3f64.sqrt();
    let gauss = [[near, near], [1. - near, near], [1. - near, 1. - near], [near, 1. - near]];
    let facets = surface.corners().iter();
    match rule {
        Rule::Nodes => {
            let areas = surface.node_areas(mesh).into_iter();
            areas.map(|(n, area)| Point { weights: vec![(n, 1.)], at: mesh.points[n], area }).collect()
        }
        Rule::Gauss => facets.flat_map(|f| gauss.map(|at| on_facet(mesh, f, at, 0.25))).collect(),
        Rule::Middle => facets.map(|f| on_facet(mesh, f, [0.5; 2], 1.)).collect(),
    }
}

/// Forces at the `points` (c), N, and the displacement (3n), mm, under one load and an `approach` of all points, mm.
struct Pressed {
    forces: DVector<f64>,
    u: Vec<f64>,
    compliance: DMatrix<f64>,
    seconds: f64,
}

fn press(cholesky: &Cholesky, load: &SparseColumn, n: usize, pairs: &[Pair]) -> Pressed {
    let start = Instant::now();
    let contact = contact_response(cholesky, load, pairs);
    let forces = contact_forces(&contact, &DVector::from_element(1, 1.)).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let mut force = vec![0.; 3 * n];
    load.iter().for_each(|(dof, f)| force[*dof] += f);
    for (pair, lambda) in pairs.iter().zip(forces.iter()) {
        pair.row.iter().for_each(|(node, g)| force[3 * node + 2] += lambda * g.z);
    }
    let u = cholesky.displacements(&[force]).swap_remove(0);
    Pressed { forces, u, compliance: contact.compliance, seconds }
}

/// Root mean square of `found - expected` over that of `expected`, each weighted by its area.
fn deviation(of: impl Iterator<Item = (f64, f64, f64)>) -> f64 {
    let (mut off, mut all) = (0., 0.);
    for (found, expected, area) in of {
        off += area * (found - expected).powi(2);
        all += area * expected * expected;
    }
    (off / all).sqrt()
}

/// What a rule gives for a paraboloid of radius 10 mm pressed 0.1 mm into a half space: contact radius 1 mm.
#[derive(Debug)]
struct Hertz {
    points: usize,
    force: f64,
    radius: f64,
    /// Deviation of the pressures at the points, and of those at the nodes, `(G' lambda)_i / A_i`.
    pressure: f64,
    nodal_pressure: f64,
    /// Points within 0.7 of the radius that carry nothing.
    idle: usize,
    inner: usize,
    /// Rank of the compliance of these points.
    rank: usize,
    overlap: f64,
    seconds: f64,
}

const RADIUS: f64 = 10.;
const DEPTH: f64 = 0.1;

const YOUNG: f64 = 0.015;
const POISSON: f64 = 0.3;

fn hertz(mesh: &Mesh, cholesky: &Cholesky, rule: Rule) -> Hertz {
    let front: Vec<usize> = (0..mesh.n_nodes()).filter(|&k| mesh.points[k].z == 0.).collect();
    let surface = Facets::of(mesh).within(&front);
    let gap = |p: Vec3| (p.x * p.x + p.y * p.y) / (2. * RADIUS) - DEPTH;
    let near: Vec<Point> = points(mesh, &surface, rule).into_iter().filter(|p| p.at.norm() < 1.6).collect();
    let pairs: Vec<Pair> = near.iter().map(|p| p.pair(gap(p.at))).collect();
    let pressed = press(cholesky, &SparseColumn::new(), mesh.n_nodes(), &pairs);
    let forces = &pressed.forces;

    let modulus = YOUNG / (1. - POISSON * POISSON);
    let peak = 2. * modulus / (std::f64::consts::PI * RADIUS);
    let pressure = |p: Vec3| peak * (1. - p.norm_squared()).max(0.).sqrt();
    let mut nodal = vec![0.; mesh.n_nodes()];
    for (point, lambda) in near.iter().zip(forces.iter()) {
        point.weights.iter().for_each(|(node, w)| nodal[*node] += w * lambda);
    }
    let nodes = points(mesh, &surface, Rule::Nodes);
    let inner: Vec<usize> = (0..near.len()).filter(|&i| near[i].at.norm() < 0.7).collect();
    let among = DMatrix::from_fn(inner.len(), inner.len(), |i, j| pressed.compliance[(inner[i], inner[j])]);
    let eigenvalues = among.symmetric_eigenvalues();

    // Between the points, where nobody asked.
    let mut overlap = 0f64;
    for facet in surface.corners() {
        for k in 0..81 {
            let at = on_facet(mesh, facet, [f64::from(k / 9) / 8., f64::from(k % 9) / 8.], 0.);
            overlap = overlap.max(at.height(&pressed.u) - gap(at.at));
        }
    }
    let touching = near.iter().zip(forces.iter()).filter(|(_, f)| **f > 0.);
    Hertz {
        points: near.len(),
        force: 4. * forces.sum() / (4. / 3. * modulus * RADIUS.sqrt() * DEPTH.powf(1.5)) - 1.,
        radius: touching.map(|(p, _)| p.at.norm()).fold(0., f64::max),
        pressure: deviation(
            near.iter().zip(forces.iter()).map(|(p, f)| (f / p.area, pressure(p.at), p.area)),
        ),
        nodal_pressure: deviation(
            nodes.iter().map(|p| (nodal[p.weights[0].0] / p.area, pressure(p.at), p.area)),
        ),
        idle: inner.iter().filter(|&&i| forces[i] == 0.).count(),
        rank: eigenvalues.iter().filter(|e| **e > 1e-10 * eigenvalues.amax()).count(),
        inner: inner.len(),
        overlap,
        seconds: pressed.seconds,
    }
}

#[test]
fn a_sphere_is_met_at_nodes_and_at_quadrature_points() {
    println!(
        "cells rule   points  force %  radius  pressure %  nodal %  idle/inner  rank  overlap um     ms"
    );
    for cells in [4, 8] {
        let (mesh, cholesky) = half_space(isotropic(YOUNG, POISSON), cells);
        let all = RULES.map(|rule| hertz(&mesh, &cholesky, rule));
        for (rule, h) in RULES.iter().zip(&all) {
            let rule = format!("{rule:?}");
            println!(
                "{cells:5} {rule:6} {:6} {:+8.2} {:7.3} {:11.1} {:8.1} {:7}/{:<4} {:4} {:11.3} {:6.0}",
                h.points,
                100. * h.force,
                h.radius,
                100. * h.pressure,
                100. * h.nodal_pressure,
                h.idle,
                h.inner,
                h.rank,
                1e3 * h.overlap,
                1e3 * h.seconds
            );
        }
        let [nodes, gauss, middle] = all;
        let step = 1. / cells as f64;
        // Force, radius and pressure at the nodes are right, and no better at quadrature points.
        assert!(nodes.force.abs() < 0.05 && (nodes.radius - 1.).abs() <= step + 1e-12, "{nodes:?}");
        assert!(nodes.pressure < 0.6 * step, "{nodes:?}");
        for other in [&gauss, &middle] {
            assert!(other.force.abs() > nodes.force.abs(), "{other:?} {nodes:?}");
            assert!(other.nodal_pressure > nodes.nodal_pressure, "{other:?} {nodes:?}");
            assert!(other.pressure > 2. * nodes.pressure, "{other:?} {nodes:?}");
        }
        // Four Gauss points a facet are more than the nodes can tell apart: what each carries is arbitrary.
        assert_eq!((nodes.rank, nodes.idle), (nodes.inner, 0));
        assert_eq!(middle.rank, middle.inner);
        assert!(gauss.rank < 2 * gauss.inner / 3 && gauss.idle > gauss.inner / 2, "{gauss:?}");
        // The chord of a facet of size h lies in the paraboloid by h^2 / 4R at its middle when its corners touch, by
        // h^2 / 12R when its Gauss points do.
        for (found, share) in [(nodes.overlap, 4.), (gauss.overlap, 12.)] {
            let expected = step * step / (share * RADIUS);
            assert!((found / expected - 1.).abs() < 0.01, "{found} {expected}");
        }
    }
}

/// What a rule gives for a confined block whose front, meshed as `map` says, meets a plane wall: deviations from the
/// uniform state, as shares of it.
#[derive(Debug)]
struct Block {
    displacement: f64,
    pressure: f64,
    nodal_pressure: f64,
    force: f64,
}

fn block(rule: Rule, distortion: f64) -> Block {
    let (side, height, gap, load) = (6., 4., 0.01, 5e-3);
    let (young, poisson) = (0.015, 0.49);
    let modulus = young * (1. - poisson) / ((1. + poisson) * (1. - 2. * poisson));
    let mesh = grid(CellKind::Hex8, [4; 3], |p| {
        let wave = |x: f64| (std::f64::consts::PI * x).sin();
        let shift = distortion * wave(p.x) * wave(p.y);
        Vec3::new(side * p.x + shift, side * p.y - 0.7 * shift, height * p.z)
    });
    let cholesky = factor(&mesh, isotropic(young, poisson), |p, k| match k {
        2 => p.z == 0.,
        _ => p[k] == 0. || p[k] == side,
    });
    let front: Vec<usize> = (0..mesh.n_nodes()).filter(|&k| mesh.points[k].z == height).collect();
    let surface = Facets::of(&mesh).within(&front);
    let mut force = vec![0.; 3 * mesh.n_nodes()];
    for facet in surface.corners() {
        let quad = [facet[0], facet[1], facet[2], facet[3]];
        add_quad_traction(&mesh, quad, |_, outward| load * outward, &mut force);
    }
    let column: SparseColumn = force.iter().copied().enumerate().filter(|(_, f)| *f != 0.).collect();
    let near = points(&mesh, &surface, rule);
    let pairs: Vec<Pair> = near.iter().map(|p| p.pair(gap)).collect();
    let pressed = press(&cholesky, &column, mesh.n_nodes(), &pairs);
    let expected = load - modulus * gap / height;
    assert!(expected > 0.3 * load, "the wall carries a good part");
    let mut nodal = vec![0.; mesh.n_nodes()];
    for (point, lambda) in near.iter().zip(pressed.forces.iter()) {
        point.weights.iter().for_each(|(node, w)| nodal[*node] += w * lambda);
    }
    let worst = |of: &mut dyn Iterator<Item = f64>| of.fold(0f64, |worst, x| worst.max((x - 1.).abs()));
    let nodes = points(&mesh, &surface, Rule::Nodes);
    Block {
        displacement: worst(&mut front.iter().map(|n| pressed.u[3 * n + 2] / gap)),
        pressure: worst(&mut near.iter().zip(pressed.forces.iter()).map(|(p, f)| f / p.area / expected)),
        nodal_pressure: worst(&mut nodes.iter().map(|p| nodal[p.weights[0].0] / p.area / expected)),
        force: pressed.forces.sum() / (expected * side * side) - 1.,
    }
}

#[test]
fn a_plane_wall_is_met_with_uniform_pressure() {
    println!("shift rule    displacement  pressure  nodal pressure    force");
    for distortion in [0., 0.8] {
        let all = RULES.map(|rule| block(rule, distortion));
        for (rule, b) in RULES.iter().zip(&all) {
            let rule = format!("{rule:?}");
            println!(
                "{distortion:5} {rule:6} {:13.1e} {:9.1e} {:15.1e} {:8.1e}",
                b.displacement, b.pressure, b.nodal_pressure, b.force
            );
        }
        let [nodes, gauss, middle] = all;
        let is_uniform = |b: &Block| b.displacement.max(b.nodal_pressure).max(b.force.abs()) < 1e-6;
        assert!(is_uniform(&nodes) && nodes.pressure < 1e-6, "{nodes:?}");
        // The sum of the Gauss points is right, each of them is not.
        assert!(is_uniform(&gauss) && gauss.pressure > 1., "{gauss:?}");
        // A quarter of a skew facet is not what its corner has of it.
        assert_eq!(is_uniform(&middle), distortion == 0., "{middle:?}");
        assert!(distortion == 0. || middle.nodal_pressure > 0.01 && middle.displacement > 0.1, "{middle:?}");
    }
}

#[test]
fn between_nodes_a_finer_face_overlaps_its_teeth_less() {
    let mut deep_shares = Vec::new();
    for (name, resolution) in [("coarse", Resolution::COARSE), ("standard", Resolution::STANDARD)] {
        let face = standard(&resolution);
        let search = ContactSearch::new(&face, ContactReach::default());
        let model = Model::new(&face, search.rest().to_vec()).unwrap();
        let is_on = |n: &String| f64::from(u8::from(n.starts_with("buccinator")));
        let a: Vec<f64> = model.muscles().iter().map(is_on).collect();
        let settled = model.at(&a).unwrap().settle(&face, &search, &a, None).unwrap();
        let u = &settled.equilibrium.displacement;
        let mut moved = face.mesh.clone();
        for (node, p) in moved.points.iter_mut().enumerate() {
            *p += Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]);
        }
        let arches: Vec<Solid> = face.teeth.iter().map(|t| Solid::new(&t.surface)).collect();
        let depth = |p: Vec3| arches.iter().map(|s| -s.project(p).unwrap().distance_mm).fold(0., f64::max);
        let mucosa = Facets::of(&face.mesh).within(&face.mucosa);
        let depths: Vec<f64> =
            points(&moved, &mucosa, Rule::Gauss).iter().map(|point| depth(point.at)).collect();
        let at_nodes = face.mucosa.iter().map(|&n| depth(moved.points[n])).fold(0., f64::max);
        let share = depths.iter().filter(|d| **d > 0.1).count() as f64 / depths.len() as f64;
        println!(
            "{name}: {} mucosa nodes at most {at_nodes:.4} mm deep; {} Gauss points, {:.1} % deeper than 0.1 mm, at most {:.2} mm",
            face.mucosa.len(),
            depths.len(),
            100. * share,
            depths.iter().copied().fold(0., f64::max)
        );
        assert!(settled.settled && at_nodes <= 0.01, "{at_nodes}");
        assert!(depths.len() > 3 * face.mucosa.len());
        deep_shares.push(share);
    }
    // A facet does not bend round the edge of a tooth; a smaller one has less to bend.
    assert!(deep_shares[1] < 0.5 * deep_shares[0] && deep_shares[1] < 0.06, "{deep_shares:?}");
}
