//! The terms of the potential that are within reach.

use super::broad_phase::Candidates;
use super::mollifier::Mollifier;
use super::rest::Rest;
use super::separation::{OnEdge, Separation, edges_squared_distance, nearest_on_edge, nearest_on_triangle};
use super::{Barrier, CollisionSurface};
use crate::units::Vec3;
use rayon::prelude::*;

/// Weight of edges. Vertices measure a flat surface exactly, edges only on the mean over how two meshes lie on each
/// other, and so reach less far; but where two creases cross no vertex is near, and all that presses there presses on a
/// few pairs of edges. With a tenth of this weight they come within micrometres, where steps turn about each other.
const OF_EDGES: f64 = 1.;
/// Area that two crossing edges have between them over the product of their widths, `1 / sin`, on the mean over all
/// angles between meshes that lie on each other at random.
const OF_WIDTHS: f64 = std::f64::consts::FRAC_PI_2;
/// No corner.
const NONE: u32 = u32::MAX;
/// Pairs that one task looks at.
const BATCH: usize = 1024;

/// `weight b(d)`, for edges `weight m b(d)`, with its place in the potential.
#[derive(Clone, Debug)]
pub(super) struct Term {
    /// The vertices: a vertex and one to three corners of what it meets, or the ends of two edges.
    pub(super) vertices: [u32; 4],
    /// How many, and how many of them are the first side.
    pub(super) n: usize,
    pub(super) n_first: usize,
    /// mm².
    pub(super) weight: f64,
    pub(super) reach_mm: f64,
    pub(super) separation: Separation,
    pub(super) mollifier: Option<Mollifier>,
}

impl Term {
    /// Positions of the vertices; those it has not are where the first one is.
    pub(super) fn places(vertices: [u32; 4], x: &[Vec3]) -> [Vec3; 4] {
        vertices.map(|v| x[if v == NONE { vertices[0] } else { v } as usize])
    }

    /// The energy, N mm.
    pub(super) fn energy(&self, barrier: &Barrier, x: &[Vec3]) -> f64 {
        let factor = self.mollifier.map_or(1., |m| m.value(&Self::places(self.vertices, x)));
        let [b, ..] = barrier.at(self.separation.distance(), self.reach_mm);
        // Parallel edges that touch: their vertices say so.
        if factor == 0. { 0. } else { factor * self.weight * b }
    }
}

/// What terms are made from.
#[derive(Clone, Copy)]
pub(super) struct Terms<'a> {
    pub(super) surface: &'a CollisionSurface,
    pub(super) rest: &'a Rest,
    pub(super) barrier: &'a Barrier,
    pub(super) x: &'a [Vec3],
}

impl Terms<'_> {
    /// The terms of `candidates` that are within reach, those of vertices first, in the order of the candidates.
    pub(super) fn of(&self, candidates: &Candidates) -> Vec<Term> {
        let groups: Vec<&[[u32; 2]]> = candidates.vertex_triangles.chunk_by(|a, b| a[0] == b[0]).collect();
        let of_vertices = |groups: &[&[[u32; 2]]]| {
            let (mut features, mut terms) = (Features::default(), Vec::new());
            groups.iter().for_each(|group| self.of_vertex(group, &mut features, &mut terms));
            terms
        };
        let of_edges = |pairs: &[[u32; 2]]| pairs.iter().filter_map(|&pair| self.of_edges(pair)).collect();
        let mut terms: Vec<Vec<Term>> = groups.par_chunks(BATCH / 8).map(of_vertices).collect();
        terms.par_extend(candidates.edge_edges.par_chunks(BATCH).map(of_edges));
        terms.into_iter().flatten().collect()
    }

    /// The terms of one vertex with the features of the triangles that it meets.
    ///
    /// Each triangle counts once, an edge once less than it has triangles, a vertex so that all that meet there count
    /// once: a sum over triangles alone would count a closest point on an edge for each side of it. Only what is within
    /// reach is asked, and all that meets at a feature within reach is.
    fn of_vertex(&self, group: &[[u32; 2]], features: &mut Features, terms: &mut Vec<Term>) {
        let v = group[0][0];
        let reach_mm = self.rest.reaches[v as usize];
        let (p, place) = (self.x[v as usize], |w: u32| self.x[w as usize]);
        features.clear();
        for &[_, t] in group {
            let corners = self.surface.triangles[t as usize];
            let (carries, squared) = nearest_on_triangle(p, corners.map(place));
            if squared >= reach_mm * reach_mm {
                continue;
            }
            features.count(feature(corners, carries), 1);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                features.edges.push([a.min(b), a.max(b)]);
                features.corners.push((a, 1));
            }
        }
        features.edges.sort_unstable();
        for run in features.edges.chunk_by(|a, b| a == b) {
            let (edge, count) = (run[0], 1 - run.len() as i32);
            if count != 0 {
                let near = match nearest_on_edge(p, edge.map(place)) {
                    OnEdge::End(k) => [edge[k], NONE, NONE],
                    OnEdge::Inside(_) => [edge[0], edge[1], NONE],
                };
                features.counts.push((near, count));
                features.corners.extend(edge.map(|a| (a, count)));
            }
        }
        features.corners.sort_unstable();
        for run in features.corners.chunk_by(|a, b| a.0 == b.0) {
            let count = 1 - run.iter().map(|(_, n)| n).sum::<i32>();
            if count != 0 {
                features.counts.push(([run[0].0, NONE, NONE], count));
            }
        }
        features.counts.sort_unstable();
        for run in features.counts.chunk_by(|a, b| a.0 == b.0) {
            let count: i32 = run.iter().map(|(_, n)| n).sum();
            if count == 0 {
                continue;
            }
            let [a, b, c] = run[0].0;
            let (vertices, n) = ([v, a, b, c], 2 + usize::from(b != NONE) + usize::from(c != NONE));
            let separation = Separation::of_vertex(&Term::places(vertices, self.x), n);
            if separation.distance() < reach_mm {
                let share = 0.5 * self.rest.vertex_areas[v as usize];
                let weight = f64::from(count) * share;
                terms.push(Term { vertices, n, n_first: 1, weight, reach_mm, separation, mollifier: None });
            }
        }
    }

    fn of_edges(&self, [e, f]: [u32; 2]) -> Option<Term> {
        let ([a, b], [c, d]) = (self.surface.edges[e as usize], self.surface.edges[f as usize]);
        let vertices = [a, b, c, d];
        let x = Term::places(vertices, self.x);
        let far = self.barrier.edge_reach_mm();
        let distance = edges_squared_distance(&x).sqrt();
        if distance >= far {
            return None;
        }
        let reach_mm = self.rest.edge_reach(vertices, far);
        if distance >= reach_mm {
            return None;
        }
        let separation = Separation::of_edges(&x);
        let mollifier = Mollifier::new(&Term::places(vertices, &self.rest.positions), &x);
        let [width, other] = [e, f].map(|e| self.rest.edge_widths[e as usize]);
        let weight = OF_EDGES * OF_WIDTHS * width * other;
        Some(Term { vertices, n: 4, n_first: 2, weight, reach_mm, separation, mollifier })
    }
}

/// The features of the triangles that a vertex meets, and how often each counts.
#[derive(Default)]
struct Features {
    counts: Vec<([u32; 3], i32)>,
    edges: Vec<[u32; 2]>,
    corners: Vec<(u32, i32)>,
}

impl Features {
    fn clear(&mut self) {
        self.counts.clear();
        self.edges.clear();
        self.corners.clear();
    }

    fn count(&mut self, feature: [u32; 3], times: i32) {
        self.counts.push((feature, times));
    }
}

/// The corners that carry a closest point: a whole triangle as it is, an edge as its ascending ends.
fn feature(corners: [u32; 3], carries: [bool; 3]) -> [u32; 3] {
    let [a, b, c] = corners;
    match carries {
        [true, true, true] => corners,
        [true, true, false] => [a.min(b), a.max(b), NONE],
        [false, true, true] => [b.min(c), b.max(c), NONE],
        [true, false, true] => [a.min(c), a.max(c), NONE],
        [_, true, false] => [b, NONE, NONE],
        [_, false, true] => [c, NONE, NONE],
        [_, false, false] => [a, NONE, NONE],
    }
}
