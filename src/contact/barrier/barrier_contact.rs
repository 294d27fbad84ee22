//! Surfaces that a barrier keeps apart.

use rayon::prelude::*;

use super::advance::{advance, of_edges, of_vertex_triangle};
use super::broad_phase::BroadPhase;
use super::rest::Rest;
use super::separation::{edges_squared_distance, nearest_on_triangle};
use super::term::Terms;
use super::{
    Barrier, BarrierError, Candidates, CollisionSurface, ContactDerivatives, ContactPoint, Curvature,
};
use crate::units::Vec3;

/// Pairs that one task looks at.
const BATCH: usize = 1024;

/// The contact potential of surfaces that are apart at rest.
///
/// Positions are those of all vertices of its surface, (v), mm: see [`CollisionSurface::positions`]. Functions that take
/// [`Candidates`] answer for the positions between the two that these were found for.
///
/// # Panics
/// All functions, if there are not as many positions as vertices, or candidates are of another surface.
#[derive(Clone, Debug)]
pub struct BarrierContact {
    surface: CollisionSurface,
    barrier: Barrier,
    rest: Rest,
    broad: BroadPhase,
}

impl BarrierContact {
    /// Contact of `surface`, whose vertices are at `rest` at rest.
    ///
    /// No pair reaches over more than 0.9 of its distance at rest, so that nothing pushes there, however near surfaces
    /// lie; a vertex has one reach for all that it meets. Pairs never count that have a vertex in common, or a mesh node
    /// while they look the same way at rest within 60 degrees: parts of one sheet, which the cells behind keep from
    /// folding.
    ///
    /// # Errors
    /// [`BarrierError`] when surfaces cross or touch at rest, a position is not finite, or a constant of `barrier` is not
    /// positive.
    pub fn new(surface: CollisionSurface, rest: &[Vec3], barrier: Barrier) -> Result<Self, BarrierError> {
        assert_eq!(rest.len(), surface.n_vertices(), "positions at rest");
        for (name, value) in [("reach_mm", barrier.reach_mm), ("stiffness", barrier.stiffness)] {
            if !(value > 0. && value.is_finite()) {
                return Err(BarrierError::Constant { name, value });
            }
        }
        if let Some(vertex) = rest.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(BarrierError::NotFinite { vertex, value: rest[vertex].into() });
        }
        let broad = BroadPhase::new(&surface, rest);
        let rest = Rest::new(&surface, &broad, rest, &barrier)?;
        Ok(Self { surface, barrier, rest, broad })
    }

    /// The surface.
    pub fn surface(&self) -> &CollisionSurface {
        &self.surface
    }

    /// The barrier.
    pub fn barrier(&self) -> Barrier {
        self.barrier
    }

    /// Area that belongs to each vertex at rest, (v), mm²: a third of its triangles.
    pub fn vertex_areas_mm2(&self) -> &[f64] {
        &self.rest.vertex_areas
    }

    /// How far each vertex reaches, (v), mm.
    pub fn reaches_mm(&self) -> &[f64] {
        &self.rest.reaches
    }

    /// The pairs that may come within reach while every vertex goes straight `from` there `to` here.
    pub fn candidates(&self, from: &[Vec3], to: &[Vec3]) -> Candidates {
        self.broad.candidates(&self.surface, from, to, |v| self.rest.reaches[v], self.barrier.edge_reach_mm())
    }

    /// The share of the step `from` there `to` here, 1 at most, over which every pair keeps a tenth of its distance at
    /// the start: a lower bound that is near the greatest. 0 when a position is not finite.
    pub fn step_limit(&self, from: &[Vec3], to: &[Vec3], candidates: &Candidates) -> f64 {
        if !from.iter().chain(to).all(|p| p.iter().all(|c| c.is_finite())) {
            return 0.;
        }
        let go = |vertices: [u32; 4], n_first, offset: fn(&[Vec3; 4]) -> Vec3, limit| {
            let start = vertices.map(|v| from[v as usize]);
            let steps = vertices.map(|v| to[v as usize] - from[v as usize]);
            advance(start, steps, n_first, offset, limit)
        };
        let vertices_go = |pairs: &[[u32; 2]]| {
            pairs.iter().fold(1., |limit, &[v, t]| {
                let [a, b, c] = self.surface.triangles[t as usize];
                go([v, a, b, c], 1, of_vertex_triangle, limit)
            })
        };
        let edges_go = |pairs: &[[u32; 2]]| {
            pairs.iter().fold(1., |limit, &[e, f]| {
                let ([a, b], [c, d]) = (self.surface.edges[e as usize], self.surface.edges[f as usize]);
                go([a, b, c, d], 2, of_edges, limit)
            })
        };
        let vertices = candidates.vertex_triangles.par_chunks(BATCH).map(vertices_go);
        let edges = candidates.edge_edges.par_chunks(BATCH).map(edges_go);
        vertices.chain(edges).reduce(|| 1., f64::min)
    }

    /// The potential, N mm; infinite where surfaces touch.
    pub fn energy(&self, x: &[Vec3], candidates: &Candidates) -> f64 {
        let terms = self.terms(x).of(candidates);
        terms.iter().map(|term| term.energy(&self.barrier, x)).sum()
    }

    /// The potential and its derivatives by mesh nodes.
    ///
    /// Nodes that are held fast are among them. They are finite where surfaces are apart.
    pub fn derivatives(
        &self,
        x: &[Vec3],
        candidates: &Candidates,
        curvature: Curvature,
    ) -> ContactDerivatives {
        let terms = self.terms(x);
        terms.derivatives(&terms.of(candidates), curvature)
    }

    /// The force of contact on each vertex, (v), N, those of obstacles included: their sum is zero.
    pub fn vertex_forces(&self, x: &[Vec3], candidates: &Candidates) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); self.surface.n_vertices()];
        for term in self.terms(x).of(candidates) {
            let gradient = term.gradient(&self.barrier, x);
            let vertices = &term.vertices[..term.n];
            vertices.iter().zip(gradient).for_each(|(&v, g)| forces[v as usize] -= g);
        }
        forces
    }

    /// What pushes what, vertices first.
    pub fn contact_points(&self, x: &[Vec3], candidates: &Candidates) -> Vec<ContactPoint> {
        let terms = self.terms(x);
        terms.of(candidates).iter().map(|term| terms.contact_point(term)).collect()
    }

    /// The least distance among `candidates`, mm; infinite when there is none.
    pub fn least_distance_mm(&self, x: &[Vec3], candidates: &Candidates) -> f64 {
        let place = |v: u32| x[v as usize];
        let of_vertex = |&[v, t]: &[u32; 2]| {
            nearest_on_triangle(place(v), self.surface.triangles[t as usize].map(place)).1.sqrt()
        };
        let of_edges = |&[e, f]: &[u32; 2]| {
            let ([a, b], [c, d]) = (self.surface.edges[e as usize], self.surface.edges[f as usize]);
            edges_squared_distance(&[a, b, c, d].map(place)).sqrt()
        };
        let vertices = candidates.vertex_triangles.iter().map(of_vertex);
        vertices.chain(candidates.edge_edges.iter().map(of_edges)).fold(f64::INFINITY, f64::min)
    }

    fn terms<'a>(&'a self, x: &'a [Vec3]) -> Terms<'a> {
        Terms { surface: &self.surface, rest: &self.rest, barrier: &self.barrier, x }
    }
}

#[cfg(test)]
mod tests {
    use std::slice;

    use nalgebra::{DMatrix, Rotation3};

    use super::*;
    use crate::contact::Facets;
    use crate::contact::barrier::testing::{Random, sheet, triangulated};
    use crate::contact::barrier::{Body, Crossing};
    use crate::mesh::{Cell, CellKind, Mesh, Surface};

    const BARRIER: Barrier = Barrier { reach_mm: 0.4, stiffness: 0.1 };

    struct Pressed {
        contact: BarrierContact,
        mesh: Mesh,
        obstacle: Surface,
    }

    /// The top of a slab of `n` x `n` cells below a plane of `m` x `m` squares, 1 mm apart at rest.
    fn pressed(n: usize, m: usize, subdivision: usize) -> Pressed {
        let (mesh, obstacle) = (sheet(n, 0.), triangulated(m, 1.));
        let top: Vec<usize> = (0..mesh.n_nodes()).filter(|&k| mesh.points[k].z == 0.).collect();
        let facets = Facets::of(&mesh).within(&top);
        let surface = CollisionSurface::new(&mesh, &facets, &[&obstacle], subdivision);
        let rest = surface.positions(&mesh.points, slice::from_ref(&obstacle.points));
        Pressed { contact: BarrierContact::new(surface, &rest, BARRIER).unwrap(), mesh, obstacle }
    }

    impl Pressed {
        fn at(&self, nodes: &[Vec3], lift: f64) -> Vec<Vec3> {
            let obstacle = self.obstacle.points.iter().map(|p| p + Vec3::z() * lift).collect();
            self.contact.surface.positions(nodes, &[obstacle])
        }

        /// Nodes displaced by up to `by`, mm.
        fn shaken(&self, by: f64, seed: u64) -> Vec<Vec3> {
            let mut random = Random(seed);
            self.mesh.points.iter().map(|p| p + by * random.point()).collect()
        }
    }

    #[test]
    fn nothing_pushes_at_rest_however_near_surfaces_lie() {
        for gap in [3., 0.3, 0.02, 1e-4] {
            let (mesh, obstacle) = (sheet(3, 1. - gap), triangulated(4, 1.));
            let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[&obstacle], 1);
            let rest = surface.positions(&mesh.points, slice::from_ref(&obstacle.points));
            let contact = BarrierContact::new(surface, &rest, BARRIER).unwrap();
            let candidates = contact.candidates(&rest, &rest);
            let derivatives = contact.derivatives(&rest, &candidates, Curvature::Exact);
            assert_eq!((derivatives.energy, derivatives.blocks.len()), (0., 0), "{gap}");
            // Half as near, and it does.
            let nodes: Vec<Vec3> = mesh.points.iter().map(|p| p + Vec3::z() * 0.8 * gap).collect();
            let x = contact.surface.positions(&nodes, slice::from_ref(&obstacle.points));
            let energy = contact.energy(&x, &contact.candidates(&x, &x));
            assert_eq!(energy > 0., 0.2 * gap < 0.4, "{gap}: {energy}");
        }
    }

    #[test]
    fn flat_surfaces_press_alike_however_they_are_meshed() {
        for gap in [0.2, 0.1] {
            let pressure = -BARRIER.at(gap, 0.4)[1];
            for (n, m, subdivision) in [(3, 5, 1), (4, 4, 1), (5, 17, 1), (7, 10, 2), (16, 9, 1), (8, 3, 3)] {
                let pressed = pressed(n, m, subdivision);
                let x = pressed.at(&pressed.mesh.points, gap - 1.);
                let forces = pressed.contact.vertex_forces(&x, &pressed.contact.candidates(&x, &x));
                let tissue = pressed.contact.surface.n_tissue_vertices();
                let on: [Vec3; 2] = [&forces[..tissue], &forces[tissue..]].map(|f| f.iter().sum());
                let error = -on[0].z / (144. * pressure) - 1.;

                assert!(error.abs() < 1e-12, "{n} {m} {subdivision}: {error}");
                assert!((on[0] + on[1]).norm() < 1e-12 * on[0].norm());
                assert!(on[0].xy().norm() < 0.01 * on[0].norm(), "{}", on[0]);
            }
        }
    }

    #[test]
    fn derivatives_by_nodes_are_those_of_the_energy() {
        for subdivision in [1, 2] {
            let pressed = pressed(2, 3, subdivision);
            let nodes = pressed.shaken(0.05, 6);
            let at = |nodes: &[Vec3]| {
                let x = pressed.at(nodes, -0.8);
                let candidates = pressed.contact.candidates(&x, &x);
                pressed.contact.derivatives(&x, &candidates, Curvature::Exact)
            };
            let here = at(&nodes);
            let n = 3 * nodes.len();
            let mut dense = DMatrix::zeros(n, n);
            for (i, j, block) in &here.blocks {
                assert!(i >= j);
                dense.view_mut((3 * i, 3 * j), (3, 3)).copy_from(block);
                dense.view_mut((3 * j, 3 * i), (3, 3)).copy_from(&block.transpose());
            }
            assert!(here.energy > 0.);
            let (h, scale) = (1e-6, dense.amax());
            for k in 0..n {
                let [hi, lo] = [h, -h].map(|h| {
                    let mut nodes = nodes.clone();
                    nodes[k / 3][k % 3] += h;
                    at(&nodes)
                });
                let slope = (hi.energy - lo.energy) / (2. * h);
                assert!((slope - here.gradient[k]).abs() < 1e-7, "{k}: {slope} {}", here.gradient[k]);
                for j in 0..n {
                    let slope = (hi.gradient[j] - lo.gradient[j]) / (2. * h);
                    assert!(
                        (slope - dense[(j, k)]).abs() < 1e-6 * scale,
                        "{j} {k}: {slope} {}",
                        dense[(j, k)]
                    );
                }
            }
            let mut order: Vec<_> = here.blocks.iter().map(|b| (b.0, b.1)).collect();
            order.dedup();
            assert!(order.is_sorted() && order.len() == here.blocks.len());
        }
    }

    #[test]
    fn a_surface_that_slides_over_ridges_and_valleys_does_the_work_of_its_energy() {
        // Facets of the obstacle stand at all angles to each other, so that the top of the slab passes from triangle to
        // edge to vertex of it, and of several at once.
        let mut pressed = pressed(3, 7, 1);
        let mut random = Random(11);
        pressed.obstacle.points.iter_mut().for_each(|p| p.z += 0.2 * random.number());
        let surface =
            CollisionSurface::new(&pressed.mesh, &Facets::of(&pressed.mesh), &[&pressed.obstacle], 1);
        let rest = surface.positions(&pressed.mesh.points, slice::from_ref(&pressed.obstacle.points));
        pressed.contact = BarrierContact::new(surface, &rest, BARRIER).unwrap();
        let steps = 1500;
        let along = Vec3::new(2.9, 1.7, 0.);
        let state = |k: usize| {
            let shift = along * (k as f64 / steps as f64);
            let nodes: Vec<Vec3> = pressed.mesh.points.iter().map(|p| p + shift).collect();
            let x = pressed.at(&nodes, -0.7);
            let d =
                pressed.contact.derivatives(&x, &pressed.contact.candidates(&x, &x), Curvature::Projected);
            let slope: f64 = d.gradient.chunks(3).map(|g| Vec3::new(g[0], g[1], g[2]).dot(&along)).sum();
            (d.energy, slope / steps as f64)
        };
        let mut before = state(0);
        let mut range = [before.0; 2];
        for k in 1..=steps {
            let now = state(k);
            let work = 0.5 * (before.1 + now.1);
            assert!((now.0 - before.0 - work).abs() < 3e-5 * now.0, "{k}: {} {work}", now.0 - before.0);
            range = [range[0].min(now.0), range[1].max(now.0)];
            before = now;
        }
        assert!(range[1] > 1.2 * range[0], "{range:?}");
    }

    #[test]
    fn every_pair_that_comes_within_reach_is_a_candidate() {
        let pressed = pressed(4, 5, 1);
        let contact = &pressed.contact;
        let from = pressed.at(&pressed.shaken(0.05, 12), -0.3);
        let to = pressed.at(&pressed.shaken(0.4, 13), -0.9);
        let candidates = contact.candidates(&from, &to);
        let surface = &contact.surface;
        let (mut missed, mut met) = (0, 0);
        for share in [0., 0.3, 0.5, 0.8, 1.] {
            let x: Vec<Vec3> = from.iter().zip(&to).map(|(p, q)| p.lerp(q, share)).collect();
            let place = |v: u32| x[v as usize];
            for v in 0..x.len() as u32 {
                for (t, corners) in surface.triangles.iter().enumerate() {
                    let obstacles =
                        surface.carriers(v as usize).is_empty() && t >= surface.n_tissue_triangles;
                    let distance = nearest_on_triangle(place(v), corners.map(place)).1.sqrt();
                    let shares = surface.carriers(v as usize).iter().any(|(node, _)| {
                        corners.iter().any(|&c| surface.carriers(c as usize).iter().any(|s| s.0 == *node))
                    });
                    if distance < contact.rest.reaches[v as usize] && !obstacles && !shares {
                        met += 1;
                        missed += usize::from(!candidates.vertex_triangles.contains(&[v, t as u32]));
                    }
                }
            }
            for (e, &[a, b]) in surface.edges[..surface.n_tissue_edges].iter().enumerate() {
                for (f, &[c, d]) in surface.edges.iter().enumerate().skip(surface.n_tissue_edges) {
                    if edges_squared_distance(&[a, b, c, d].map(place)).sqrt() < BARRIER.edge_reach_mm() {
                        met += 1;
                        missed += usize::from(!candidates.edge_edges.contains(&[e as u32, f as u32]));
                    }
                }
            }
        }
        assert!(met > 200 && missed == 0, "{missed} of {met}");
        let unique = |pairs: &[[u32; 2]]| pairs.is_sorted_by(|a, b| a < b);
        assert!(unique(&candidates.vertex_triangles) && unique(&candidates.edge_edges));
    }

    #[test]
    fn turned_and_moved_surfaces_have_the_same_energy_and_turned_forces() {
        let pressed = pressed(4, 5, 1);
        let x = pressed.at(&pressed.shaken(0.05, 7), -0.8);
        let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.);
        let turned: Vec<Vec3> = x.iter().map(|p| rotation * p + Vec3::new(3., -20., 8.)).collect();
        let contact = &pressed.contact;
        let [here, there] = [&x, &turned].map(|x| contact.candidates(x, x));
        let energy = contact.energy(&x, &here);
        assert!(energy > 0. && (contact.energy(&turned, &there) / energy - 1.).abs() < 1e-11);
        let forces = contact.vertex_forces(&x, &here);
        let largest = forces.iter().map(|f| f.norm()).fold(0., f64::max);
        for (f, g) in forces.iter().zip(contact.vertex_forces(&turned, &there)) {
            assert!((rotation * f - g).norm() < 1e-10 * largest);
        }
        let mut moments = Vec3::zeros();
        x.iter().zip(&forces).for_each(|(x, f)| moments += x.cross(f));
        assert!(forces.iter().sum::<Vec3>().norm() < 1e-12 * largest && moments.norm() < 1e-11 * largest);
    }

    #[test]
    fn a_mirrored_face_has_mirrored_forces_and_stiffness() {
        // The slab is its own mirror image about x = 6; the obstacle's squares are not, so it is mirrored by hand.
        let mesh = sheet(4, 0.);
        let mirror = |p: &Vec3| Vec3::new(12. - p.x, p.y, p.z);
        let obstacle = triangulated(6, 1.);
        let mirrored = Surface {
            points: obstacle.points.iter().map(mirror).collect(),
            triangles: obstacle.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        };
        let image: Vec<usize> = mesh
            .points
            .iter()
            .map(|p| mesh.points.iter().position(|q| (mirror(p) - q).norm() < 1e-9).unwrap())
            .collect();
        let sides = [&obstacle, &mirrored].map(|obstacle| {
            let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[obstacle], 1);
            let rest = surface.positions(&mesh.points, slice::from_ref(&obstacle.points));
            BarrierContact::new(surface, &rest, BARRIER).unwrap()
        });
        let mut random = Random(8);
        let nodes: Vec<Vec3> = mesh.points.iter().map(|p| p + 0.03 * random.point()).collect();
        let mut other = nodes.clone();
        nodes.iter().zip(&image).for_each(|(p, &k)| other[k] = mirror(p));
        let lowered = |s: &Surface| s.points.iter().map(|p| p - Vec3::z() * 0.75).collect::<Vec<_>>();
        let [here, there] =
            [(&sides[0], &nodes, &obstacle), (&sides[1], &other, &mirrored)].map(|(c, nodes, o)| {
                let x = c.surface.positions(nodes, &[lowered(o)]);
                let candidates = c.candidates(&x, &x);
                let derivatives = c.derivatives(&x, &candidates, Curvature::Projected);
                (candidates.len(), derivatives)
            });
        assert_eq!(here.0, there.0);
        let scale = here.1.gradient.iter().fold(0., |m: f64, g| m.max(g.abs()));
        for (k, &other) in image.iter().enumerate() {
            for axis in 0..3 {
                let sign = if axis == 0 { -1. } else { 1. };
                let (g, h) = (here.1.gradient[3 * k + axis], there.1.gradient[3 * other + axis]);
                assert!((g - sign * h).abs() < 1e-12 * scale, "{g} {h}");
            }
        }
        let trace =
            |d: &ContactDerivatives| d.blocks.iter().filter(|b| b.0 == b.1).map(|b| b.2.trace()).sum::<f64>();
        assert!((trace(&here.1) / trace(&there.1) - 1.).abs() < 1e-12);
        assert_eq!(here.1.blocks.len(), there.1.blocks.len());
    }

    #[test]
    fn answers_do_not_depend_on_the_number_of_threads() {
        let pressed = pressed(12, 16, 2);
        let [from, to] =
            [(0.02, -0.5), (0.03, -0.85)].map(|(by, lift)| pressed.at(&pressed.shaken(by, 9), lift));
        let answer = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let candidates = pressed.contact.candidates(&from, &to);
                let limit = pressed.contact.step_limit(&from, &to, &candidates);
                let derivatives = pressed.contact.derivatives(&to, &candidates, Curvature::Projected);
                (candidates, limit.to_bits(), derivatives)
            })
        };
        let one = answer(1);
        assert!(one.0.len() > 2000 && one == answer(4));
    }

    #[test]
    fn what_passes_through_within_one_step_is_stopped() {
        let pressed = pressed(3, 4, 1);
        let from = pressed.at(&pressed.mesh.points, 0.);
        for fall in [-1.1, -5., -100.] {
            let to = pressed.at(&pressed.mesh.points, fall);
            let candidates = pressed.contact.candidates(&from, &to);
            let limit = pressed.contact.step_limit(&from, &to, &candidates);
            let left = 1. + limit * fall;
            assert!((0.1 - 1e-12..0.2).contains(&left), "{fall}: {left}");
        }
        let to = pressed.at(&pressed.mesh.points, -0.5);
        assert_eq!(pressed.contact.step_limit(&from, &to, &pressed.contact.candidates(&from, &to)), 1.);
        let mut to = to;
        to[3].x = f64::NAN;
        assert_eq!(pressed.contact.step_limit(&from, &to, &Candidates::default()), 0.);
    }

    /// Whether an edge of one triangle passes through the other one.
    fn cross(a: [Vec3; 3], b: [Vec3; 3]) -> bool {
        let pierces = |[p, q]: [Vec3; 2], [a, b, c]: [Vec3; 3]| {
            let volume = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| (b - a).cross(&(c - a)).dot(&(d - a)) > 0.;
            let around = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
            volume(a, b, c, p) != volume(a, b, c, q) && (around == [true; 3] || around == [false; 3])
        };
        (0..3).any(|k| pierces([a[k], a[(k + 1) % 3]], b) || pierces([b[k], b[(k + 1) % 3]], a))
    }

    #[test]
    fn a_soup_of_tetrahedra_never_crosses() {
        let mut random = Random(10);
        let (mut points, mut cells): (Vec<Vec3>, Vec<Cell>) = (Vec::new(), Vec::new());
        let faces =
            |p: [Vec3; 4]| [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].map(|f: [usize; 3]| f.map(|k| p[k]));
        while cells.len() < 12 {
            let centre = 2. * random.point();
            let corners: [Vec3; 4] = std::array::from_fn(|_| centre + random.point());
            let crosses = |other: &[Vec3]| {
                let other = faces([other[0], other[1], other[2], other[3]]);
                faces(corners).iter().any(|a| other.iter().any(|b| cross(*a, *b)))
            };
            if !points.chunks(4).any(crosses) {
                let first = points.len();
                cells.push(Cell::new(CellKind::Tet4, &[first, first + 1, first + 2, first + 3]));
                points.extend(corners);
            }
        }
        let mesh = Mesh::new(points, cells);
        let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[], 1);
        let mut x = surface.positions(&mesh.points, &[]);
        let contact = BarrierContact::new(surface, &x, BARRIER).unwrap();
        let triangles: Vec<[usize; 3]> = contact.surface.triangles().collect();
        let mut cut = 0;
        for step in 0..100 {
            let to: Vec<Vec3> = x.iter().map(|p| p + 0.5 * random.point() - 0.1 * p).collect();
            let candidates = contact.candidates(&x, &to);
            let limit = contact.step_limit(&x, &to, &candidates);
            cut += usize::from(limit < 1.);
            x = x.iter().zip(&to).map(|(p, q)| p.lerp(q, limit)).collect();
            for (k, a) in triangles.iter().enumerate() {
                for b in triangles[..k].iter().filter(|b| !a.iter().any(|v| b.contains(v))) {
                    assert!(!cross(a.map(|v| x[v]), b.map(|v| x[v])), "step {step}: {a:?} {b:?}");
                }
            }
            assert!(contact.energy(&x, &candidates).is_finite());
        }
        assert!(cut > 50, "{cut}");
    }

    #[test]
    fn surfaces_that_cross_or_touch_at_rest_are_refused_with_their_places() {
        for (height, deepest) in [(1.3, 0.3), (1., 0.)] {
            let (mesh, obstacle) = (sheet(3, height), triangulated(4, 1.));
            let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[&obstacle], 1);
            let rest = surface.positions(&mesh.points, slice::from_ref(&obstacle.points));
            let Err(BarrierError::Intersecting { crossings }) = BarrierContact::new(surface, &rest, BARRIER)
            else {
                panic!("{height} is taken");
            };
            let depth = crossings.iter().map(|c| c.depth_mm).fold(0., f64::max);
            assert!((depth - deepest).abs() < 1e-9, "{depth}");
            let of_both =
                |c: &Crossing| c.bodies.contains(&Body::Tissue) && c.bodies.contains(&Body::Obstacle(0));
            assert!(crossings.iter().all(of_both) && !crossings.is_empty());
        }
    }

    #[test]
    fn constants_and_positions_that_make_no_sense_are_refused() {
        let mesh = sheet(1, 0.);
        let surface = CollisionSurface::new(&mesh, &Facets::of(&mesh), &[], 1);
        let mut rest = surface.positions(&mesh.points, &[]);
        for (reach_mm, stiffness) in [(0., 1.), (1., f64::NAN), (f64::INFINITY, 1.), (1., -1.)] {
            let refused = BarrierContact::new(surface.clone(), &rest, Barrier { reach_mm, stiffness });
            assert!(matches!(refused, Err(BarrierError::Constant { .. })));
        }
        rest[2].y = f64::NAN;
        let refused = BarrierContact::new(surface, &rest, BARRIER);
        assert!(matches!(refused, Err(BarrierError::NotFinite { vertex: 2, .. })));
    }

    #[test]
    fn contact_points_tell_who_pushes_whom() {
        let pressed = pressed(3, 4, 1);
        let x = pressed.at(&pressed.mesh.points, -0.8);
        let candidates = pressed.contact.candidates(&x, &x);
        let points = pressed.contact.contact_points(&x, &candidates);
        let mut total = Vec3::zeros();
        for point in &points {
            let sign = if point.bodies[0] == Body::Tissue { 1. } else { -1. };
            assert_ne!(point.bodies[0], point.bodies[1]);
            assert!((point.gap_mm - 0.2).abs() < 0.21 && point.position.z > 0. && point.position.z < 0.2);
            total += sign * point.force_n;
        }
        let tissue = pressed.contact.surface.n_tissue_vertices();
        let on_tissue: Vec3 = pressed.contact.vertex_forces(&x, &candidates)[..tissue].iter().sum();
        assert!((total - on_tissue).norm() < 1e-12 * total.norm() && total.z < 0.);
        assert!((pressed.contact.least_distance_mm(&x, &candidates) - 0.2).abs() < 1e-12);
    }
}
