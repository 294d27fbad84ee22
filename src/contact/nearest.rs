//! Nearest points of an oriented triangle surface.

use std::collections::HashMap;

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};

use super::closest::{Feature, TrianglePoint, closest_on_triangle};
use crate::mesh::Surface;
use crate::units::Vec3;

/// Closest points whose distances differ by less than this are ties, mm: all of them count, so that
/// the answer does not depend on the order of triangles and mirrors with the surface.
const TIE_MM: f64 = 1e-7;

/// Distances below this carry no direction, mm.
pub(super) const TOUCHING_MM: f64 = 1e-9;

/// Directions of the rays that count windings, which no grid or symmetry favours.
const RAYS: [Vec3; 3] = [
    Vec3::new(0.5731, 0.2917, 0.7657),
    Vec3::new(-0.7829, 0.5113, 0.3547),
    Vec3::new(0.1873, -0.8821, -0.4321),
];

/// A closest point of a surface.
#[derive(Clone, Debug)]
pub(super) struct Hit {
    /// The triangle.
    pub(super) triangle: usize,
    /// The closest point and its weights in the triangle.
    pub(super) at: TrianglePoint,
    /// Distance, mm, not signed.
    pub(super) distance: f64,
    /// Unit outward pseudo-normal of the vertex, edge or face that the closest point lies on.
    pub(super) normal: Vec3,
}

/// Nearest-point queries on an oriented surface, open or closed.
///
/// The hierarchy is parry's; the projection is not, because ties and the choice among facing
/// triangles need every candidate, and parry answers one.
#[derive(Clone, Debug)]
pub(super) struct Nearest {
    surface: Surface,
    bvh: Bvh,
    face_normals: Vec<Vec3>,
    edge_normals: HashMap<(usize, usize), Vec3>,
    vertex_normals: Vec<Vec3>,
    /// Triangles about each vertex.
    about: Vec<Vec<u32>>,
}

impl Nearest {
    /// An index of `surface`, whose vertices are shared between neighbouring triangles.
    pub(super) fn new(surface: Surface) -> Self {
        let mut edge_normals: HashMap<(usize, usize), Vec3> = HashMap::new();
        let mut vertex_normals = vec![Vec3::zeros(); surface.points.len()];
        let mut face_normals = Vec::with_capacity(surface.triangles.len());
        let mut boxes = Vec::with_capacity(surface.triangles.len());
        let mut about: Vec<Vec<u32>> = vec![Vec::new(); surface.points.len()];
        for (index, t) in surface.triangles.iter().enumerate() {
            t.iter().for_each(|&v| about[v].push(index as u32));
            let p = t.map(|v| surface.points[v]);
            boxes.push(Aabb::from_points(p.map(|q| Vector::new(q.x, q.y, q.z))));
            let normal = (p[1] - p[0]).cross(&(p[2] - p[0])).try_normalize(0.).unwrap_or_else(Vec3::zeros);
            face_normals.push(normal);
            for k in 0..3 {
                let (here, next, last) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
                let angle = (next - here).angle(&(last - here));
                vertex_normals[t[k]] += if angle.is_finite() { angle * normal } else { Vec3::zeros() };
                *edge_normals.entry(sorted(t[k], t[(k + 1) % 3])).or_insert_with(Vec3::zeros) += normal;
            }
        }
        let unit = |n: &mut Vec3| *n = n.try_normalize(0.).unwrap_or_else(Vec3::zeros);
        edge_normals.values_mut().for_each(unit);
        vertex_normals.iter_mut().for_each(unit);
        let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Self { surface, bvh, face_normals, edge_normals, vertex_normals, about }
    }

    pub(super) fn surface(&self) -> &Surface {
        &self.surface
    }

    pub(super) fn face_normal(&self, triangle: usize) -> Vec3 {
        self.face_normals[triangle]
    }

    /// The closest points of `p` within `reach` among the triangles that `accept` takes: one, or
    /// several distinct points when they tie, in the order of the triangles; none when there is none.
    pub(super) fn hits(&self, p: Vec3, reach: f64, accept: impl Fn(usize) -> bool) -> Vec<Hit> {
        let project = |leaf: u32, limit: f64| {
            let at = closest_on_triangle(p, self.corners(leaf as usize));
            let distance = (p - at.point).norm();
            (distance <= limit && accept(leaf as usize)).then_some((distance, at))
        };
        let Some((_, (best, _))) = self.bvh.find_best(f64::MAX, |node, _| box_distance(node, p), project)
        else {
            return Vec::new();
        };
        if best > reach {
            return Vec::new();
        }
        let mut leaves: Vec<u32> = self.bvh.leaves(|node| box_distance(node, p) <= best + TIE_MM).collect();
        leaves.sort_unstable();
        let mut hits: Vec<Hit> = Vec::new();
        for leaf in leaves {
            let Some((distance, at)) = project(leaf, best + TIE_MM) else { continue };
            let known = hits.iter().any(|h| (h.at.point - at.point).norm() <= TIE_MM);
            if !known {
                let triangle = leaf as usize;
                hits.push(Hit { triangle, at, distance, normal: self.normal(triangle, at.feature) });
            }
        }
        hits
    }

    /// The local minima of the distance from `p` over the surface, no farther than `reach`, in the order of
    /// the triangles: the foot on a triangle from which no triangle about it leads closer. A convex surface
    /// has one, a groove one on either flank.
    pub(super) fn feet(&self, p: Vec3, reach: f64) -> Vec<Hit> {
        let mut leaves: Vec<u32> = self.bvh.leaves(|node| box_distance(node, p) <= reach).collect();
        leaves.sort_unstable();
        let mut feet: Vec<Hit> = Vec::new();
        for leaf in leaves {
            let triangle = leaf as usize;
            let at = closest_on_triangle(p, self.corners(triangle));
            let distance = (p - at.point).norm();
            let is_new = || feet.iter().all(|f| (f.at.point - at.point).norm() > TIE_MM);
            if distance <= reach && is_new() && self.is_foot(p, triangle, at.feature, distance) {
                feet.push(Hit { triangle, at, distance, normal: self.normal(triangle, at.feature) });
            }
        }
        feet
    }

    /// Whether no triangle that shares `feature` of `triangle` is closer to `p` than `distance`.
    fn is_foot(&self, p: Vec3, triangle: usize, feature: Feature, distance: f64) -> bool {
        let t = self.surface.triangles[triangle];
        let shared = match feature {
            Feature::Face => return true,
            Feature::Edge(k) => vec![t[k], t[(k + 1) % 3]],
            Feature::Vertex(k) => vec![t[k]],
        };
        self.about[shared[0]].iter().all(|&other| {
            let corners = self.surface.triangles[other as usize];
            !shared.iter().all(|v| corners.contains(v))
                || (p - closest_on_triangle(p, self.corners(other as usize)).point).norm()
                    >= distance - TIE_MM
        })
    }

    /// The triangles within `reach` of the point of `foot`, ascending, each with its point closest to that.
    pub(super) fn adjoining(&self, foot: &Hit, reach: f64) -> Vec<Hit> {
        let p = foot.at.point;
        let mut leaves: Vec<u32> = self.bvh.leaves(|node| box_distance(node, p) <= reach).collect();
        leaves.sort_unstable();
        let hit = |leaf: u32| {
            let triangle = leaf as usize;
            let at = closest_on_triangle(p, self.corners(triangle));
            let distance = (p - at.point).norm();
            (distance <= reach).then(|| Hit { triangle, at, distance, normal: self.face_normals[triangle] })
        };
        leaves.into_iter().filter_map(hit).collect()
    }

    /// How often the closed surface winds round `p`: 0 outside, 1 inside, 2 where it overlaps itself.
    ///
    /// `sum of sign(n . r)` over the triangles that a ray from `p` along `r` crosses; the median of three rays,
    /// since one may graze an edge.
    pub(super) fn winding(&self, p: Vec3) -> i32 {
        let mut counts = RAYS.map(|ray| {
            let leaves = self.bvh.leaves(|node| meets_box(node, p, ray));
            leaves.map(|leaf| crossing(p, ray, self.corners(leaf as usize))).sum::<i32>()
        });
        counts.sort_unstable();
        counts[1]
    }

    /// Whether `p` lies on the outward side of the plane of `triangle`.
    pub(super) fn is_before(&self, p: Vec3, triangle: usize) -> bool {
        (p - self.corners(triangle)[0]).dot(&self.face_normals[triangle]) >= 0.
    }

    /// A point just outside the middle of `triangle`.
    pub(super) fn just_outside(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        let size = (b - a).norm().max((c - a).norm());
        (a + b + c) / 3. + 1e-6 * size * self.face_normals[triangle]
    }

    fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.surface.triangles[triangle].map(|v| self.surface.points[v])
    }

    /// Angle-weighted pseudo-normal, whose sign tells inside from outside at every feature.
    /// Source: Baerentzen and Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243.
    fn normal(&self, triangle: usize, feature: Feature) -> Vec3 {
        let t = self.surface.triangles[triangle];
        match feature {
            Feature::Face => self.face_normals[triangle],
            Feature::Edge(k) => self.edge_normals[&sorted(t[k], t[(k + 1) % 3])],
            Feature::Vertex(k) => self.vertex_normals[t[k]],
        }
    }
}

fn sorted(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

fn box_distance(node: &BvhNode, p: Vec3) -> f64 {
    let (lo, hi) = (node.mins(), node.maxs());
    let past = |x: f64, lo: f64, hi: f64| (lo - x).max(x - hi).max(0.);
    Vec3::new(past(p.x, lo.x, hi.x), past(p.y, lo.y, hi.y), past(p.z, lo.z, hi.z)).norm()
}

fn meets_box(node: &BvhNode, p: Vec3, ray: Vec3) -> bool {
    let (lo, hi) = (node.mins(), node.maxs());
    let (mut from, mut to) = (0f64, f64::INFINITY);
    for (x, r, lo, hi) in [(p.x, ray.x, lo.x, hi.x), (p.y, ray.y, lo.y, hi.y), (p.z, ray.z, lo.z, hi.z)] {
        let (a, b) = ((lo - x) / r, (hi - x) / r);
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    // A flat box may be missed by rounding.
    from <= to + 1e-9
}

/// 1 where the ray leaves through the triangle, -1 where it enters, 0 where it misses.
/// Source: Moeller and Trumbore, J. Graphics Tools 2 (1997) 21.
fn crossing(p: Vec3, ray: Vec3, [a, b, c]: [Vec3; 3]) -> i32 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let det = -ray.dot(&ab.cross(&ac));
    if det == 0. {
        return 0;
    }
    let turned = ap.cross(&ray);
    let (u, v) = (ac.dot(&turned) / det, -ab.dot(&turned) / det);
    let t = ap.dot(&ab.cross(&ac)) / det;
    if u < 0. || v < 0. || u + v > 1. || t <= 0. {
        return 0;
    }
    if det < 0. { 1 } else { -1 }
}
