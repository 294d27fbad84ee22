//! Surfaces that a barrier keeps apart.

use rayon::prelude::*;

use super::additive_ccd::{additive_ccd, edge_edge_distance, vertex_triangle_distance};
use super::broad_phase::BroadPhase;
use super::rest::Rest;
use super::separation::{Separation, nearest_on_triangle};
use super::term::{Term, Terms};
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
    /// lie; a vertex has one reach for all that it meets. Pairs that have a vertex in common never count.
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

    /// The pairs that may come within reach while every vertex goes straight `from` there `to` here.
    pub fn candidates(&self, from: &[Vec3], to: &[Vec3]) -> Candidates {
        self.broad.candidates(&self.surface, from, to, |v| self.rest.reaches[v], self.barrier.reach_mm)
    }

    /// The share of the step `from` there `to` here, 1 at most, over which every pair keeps a tenth of its distance at
    /// the start: a lower bound that is near the greatest. 0 when a position is not finite.
    pub fn step_limit(&self, from: &[Vec3], to: &[Vec3], candidates: &Candidates) -> f64 {
        if !from.iter().chain(to).all(|p| p.iter().all(|c| c.is_finite())) {
            return 0.;
        }
        let advance = |vertices: [u32; 4], n_first, distance: fn([Vec3; 4]) -> f64, limit| {
            let start = vertices.map(|v| from[v as usize]);
            let steps = vertices.map(|v| to[v as usize] - from[v as usize]);
            additive_ccd(start, steps, n_first, distance, limit)
        };
        let of_vertices = |pairs: &[[u32; 2]]| {
            pairs.iter().fold(1., |limit, &[v, t]| {
                let [a, b, c] = self.surface.triangles[t as usize];
                advance([v, a, b, c], 1, vertex_triangle_distance, limit)
            })
        };
        let of_edges = |pairs: &[[u32; 2]]| {
            pairs.iter().fold(1., |limit, &[e, f]| {
                let ([a, b], [c, d]) = (self.surface.edges[e as usize], self.surface.edges[f as usize]);
                advance([a, b, c, d], 2, edge_edge_distance, limit)
            })
        };
        let vertices = candidates.vertex_triangles.par_chunks(BATCH).map(of_vertices);
        let edges = candidates.edge_edges.par_chunks(BATCH).map(of_edges);
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
            Separation::of_edges(&[a, b, c, d].map(place)).distance()
        };
        let vertices = candidates.vertex_triangles.iter().map(of_vertex);
        vertices.chain(candidates.edge_edges.iter().map(of_edges)).fold(f64::INFINITY, f64::min)
    }

    fn terms<'a>(&'a self, x: &'a [Vec3]) -> Terms<'a> {
        Terms { surface: &self.surface, rest: &self.rest, barrier: &self.barrier, x }
    }
}
