//! What is taken from the surfaces at rest: areas, reaches, and whether they cross.

use super::broad_phase::BroadPhase;
use super::error::{BarrierError, Crossing};
use super::separation::{edges_squared_distance, nearest_on_triangle};
use super::{Barrier, CollisionSurface};
use crate::units::Vec3;

/// Share of the distance at rest over which a pair reaches at most: at rest nothing pushes.
const OF_REST: f64 = 0.9;
/// Surfaces that are nearer than this at rest touch, mm.
const TOUCHING_MM: f64 = 1e-6;

/// The surfaces at rest.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    pub(super) positions: Vec<Vec3>,
    /// A third of the triangles about each vertex, mm².
    pub(super) vertex_areas: Vec<f64>,
    /// A third of the triangles about each edge over its length, mm.
    pub(super) edge_widths: Vec<f64>,
    /// How far each vertex reaches, mm.
    pub(super) reaches: Vec<f64>,
}

impl Rest {
    pub(super) fn new(
        surface: &CollisionSurface,
        broad: &BroadPhase,
        positions: &[Vec3],
        barrier: &Barrier,
    ) -> Result<Self, BarrierError> {
        let place = |v: u32| positions[v as usize];
        let crossing = |at, depth_mm, first: &[u32], second: &[u32]| Crossing {
            at,
            depth_mm,
            bodies: [first[0], second[0]].map(|v| surface.body(v as usize)),
            vertices: [first, second].map(|side| side.iter().map(|&v| v as usize).collect()),
        };
        let pierced = broad.crossings(surface, |e, t| {
            let (edge, corners) = (surface.edges[e], surface.triangles[t]);
            let (at, depth_mm) = pierced(edge.map(place), corners.map(place))?;
            let apart = !edge.iter().any(|v| corners.contains(v));
            apart.then(|| crossing(at, depth_mm, &edge, &corners))
        });
        if !pierced.is_empty() {
            return Err(BarrierError::Intersecting { crossings: pierced });
        }
        let (vertex_areas, edge_widths) = areas(surface, positions);
        let far = barrier.reach_mm / OF_REST;
        let near = broad.candidates(surface, positions, positions, |_| far, TOUCHING_MM);
        let mut distances = vec![far; positions.len()];
        let mut touching = Vec::new();
        for &[v, t] in &near.vertex_triangles {
            let corners = surface.triangles[t as usize];
            let distance = nearest_on_triangle(place(v), corners.map(place)).1.sqrt();
            distances[v as usize] = distance.min(distances[v as usize]);
            if distance < TOUCHING_MM {
                touching.push(crossing(place(v), 0., &[v], &corners));
            }
        }
        for &[e, f] in &near.edge_edges {
            let [first, second] = [e, f].map(|e| surface.edges[e as usize]);
            touching.push(crossing(0.5 * (place(first[0]) + place(first[1])), 0., &first, &second));
        }
        if !touching.is_empty() {
            return Err(BarrierError::Intersecting { crossings: touching });
        }
        let reaches = distances.into_iter().map(|d| OF_REST * d).collect();
        Ok(Self { positions: positions.to_vec(), vertex_areas, edge_widths, reaches })
    }

    /// How far two edges reach, mm, whose corners are `vertices`.
    pub(super) fn edge_reach(&self, vertices: [u32; 4], reach_mm: f64) -> f64 {
        let x = vertices.map(|v| self.positions[v as usize]);
        reach_mm.min(OF_REST * edges_squared_distance(&x).sqrt())
    }
}

fn areas(surface: &CollisionSurface, x: &[Vec3]) -> (Vec<f64>, Vec<f64>) {
    let place = |v: u32| x[v as usize];
    let mut vertex_areas = vec![0.; x.len()];
    let mut widths = vec![0.; surface.edges.len()];
    for (t, corners) in surface.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(place);
        let third = (b - a).cross(&(c - a)).norm() / 6.;
        corners.iter().for_each(|&v| vertex_areas[v as usize] += third);
        let lengths = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
        for (edge, length) in surface.edges_of(t).into_iter().zip(lengths) {
            edge.into_iter().for_each(|e| widths[e] += third / length);
        }
    }
    (vertex_areas, widths)
}

/// Where the edge `[p, q]` passes through the triangle `[a, b, c]`, and how far its nearer end is behind that, mm.
fn pierced([p, q]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> Option<(Vec3, f64)> {
    let normal = (b - a).cross(&(c - a));
    let [hp, hq] = [p, q].map(|x| (x - a).dot(&normal));
    if hp * hq > 0. || hp == hq {
        return None;
    }
    let at = p + hp / (hp - hq) * (q - p);
    let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| (b - a).cross(&(at - a)).dot(&normal));
    let depth = hp.abs().min(hq.abs()) / normal.norm();
    sides.iter().all(|s| *s >= 0.).then_some((at, depth))
}
