//! A tooth surface as a solid, by other means than contact's.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;

use crate::mesh::{Surface, Winding};
use crate::units::Vec3;

/// Greatest distance of neighbouring samples of an edge, mm.
const EDGE_STEP_MM: f64 = 0.5;

/// A point is inside where the surface winds round it at least this often.
const INSIDE: f64 = 0.5;

/// How far outside of a triangle, as a share of its size, is asked whether it bounds the whole solid.
const JUST_OUTSIDE: f64 = 1e-3;

/// A closed surface whose inside is what it winds round: it may cross itself.
#[derive(Clone, Debug)]
pub(super) struct ToothSolid {
    triangles: Vec<Triangle>,
    bvh: Bvh,
    winding: Winding,
    /// Whether each triangle bounds the solid and is not a part inside it; asked for where something is inside.
    is_exposed: Vec<OnceLock<bool>>,
    /// Vertices and samples of the edges, mm.
    pub(super) points: Vec<Vec3>,
}

impl ToothSolid {
    pub(super) fn new(surface: &Surface) -> Self {
        let corners = |t: &[usize; 3]| t.map(|v| to_parry(surface.points[v]));
        let triangles: Vec<Triangle> =
            surface.triangles.iter().map(corners).map(|[a, b, c]| Triangle::new(a, b, c)).collect();
        let boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::from_points([t.a, t.b, t.c])).collect();
        Self {
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            winding: Winding::new(surface),
            is_exposed: vec![OnceLock::new(); triangles.len()],
            triangles,
            points: points(surface),
        }
    }

    /// Whether any point of the ball about `centre` may lie inside.
    pub(super) fn may_hold(&self, centre: Vec3, radius: f64) -> bool {
        self.distance(centre, radius, |_| true).is_some() || self.holds(centre)
    }

    /// How deep inside `p` is, mm: its distance from what bounds the solid; `None` outside.
    pub(super) fn depth(&self, p: Vec3) -> Option<f64> {
        if self.holds(p) { self.distance(p, f64::MAX, |triangle| self.is_exposed(triangle)) } else { None }
    }

    fn holds(&self, p: Vec3) -> bool {
        !self.triangles.is_empty()
            && self.bvh.root_aabb().contains_local_point(to_parry(p))
            && self.winding.number(p) >= INSIDE
    }

    /// Distance of `p` from the triangles that `accept` takes, if it is below `reach`.
    fn distance(&self, p: Vec3, reach: f64, accept: impl Fn(usize) -> bool) -> Option<f64> {
        let p = to_parry(p);
        let to_box =
            |node: &parry3d_f64::partitioning::BvhNode, _| node.aabb().distance_to_local_point(p, true);
        let to_triangle = |leaf: u32, best: f64| {
            let distance = self.triangles[leaf as usize].distance_to_local_point(p, false);
            (distance < best && accept(leaf as usize)).then_some(distance)
        };
        self.bvh.find_best(reach, to_box, to_triangle).map(|(_, distance)| distance)
    }

    fn is_exposed(&self, triangle: usize) -> bool {
        *self.is_exposed[triangle].get_or_init(|| {
            let Triangle { a, b, c } = self.triangles[triangle];
            let [a, b, c] = [a, b, c].map(|x| Vec3::new(x.x, x.y, x.z));
            let normal = (b - a).cross(&(c - a)).try_normalize(0.);
            let size = (b - a).norm().max((c - a).norm());
            normal.is_some_and(|n| self.winding.number((a + b + c) / 3. + JUST_OUTSIDE * size * n) < INSIDE)
        })
    }
}

fn to_parry(p: Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn points(surface: &Surface) -> Vec<Vec3> {
    let vertices: BTreeSet<usize> = surface.triangles.iter().flatten().copied().collect();
    let edge = |a: usize, b: usize| (a.min(b), a.max(b));
    let edges: BTreeSet<(usize, usize)> =
        surface.triangles.iter().flat_map(|&[a, b, c]| [edge(a, b), edge(b, c), edge(c, a)]).collect();
    let mut points: Vec<Vec3> = vertices.into_iter().map(|v| surface.points[v]).collect();
    for (a, b) in edges {
        let (a, b) = (surface.points[a], surface.points[b]);
        let steps = ((b - a).norm() / EDGE_STEP_MM).ceil();
        let along = (1..).map(f64::from).take_while(|k| *k < steps);
        points.extend(along.map(|k| a.lerp(&b, k / steps)));
    }
    points
}
