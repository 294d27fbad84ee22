//! Nearest points of an open surface that faces the same way.

use std::collections::{HashMap, HashSet};

use crate::contact::{Feature, closest_on_triangle};
use crate::mesh::{Aabb, Bvh, Surface};
use crate::units::Vec3;

/// Least cosine between the normals of surfaces that correspond: 60 degrees. The inside of a lip faces the other way.
const FACING: f64 = 0.5;

/// A surface, open as a rule, with normals and an index of its triangles.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) surface: Surface,
    /// Unit normal at each vertex, the mean over its triangles by area; zero where there is none.
    pub(super) normals: Vec<Vec3>,
    /// Area that belongs to each vertex, a third of its triangles', mm².
    pub(super) areas: Vec<f64>,
    tree: Bvh,
    /// Edges that one triangle alone has, from their lesser vertex to the greater,
    rim_edges: HashSet<[usize; 2]>,
    /// and the vertices on them.
    pub(super) on_rim: Vec<bool>,
}

/// The point of a sheet nearest to another.
#[derive(Clone, Debug)]
pub(super) struct Foot {
    pub(super) point: Vec3,
    /// Unit normal there, between those of the vertices.
    pub(super) normal: Vec3,
    pub(super) distance_mm: f64,
    /// The vertices of its triangle and their weights.
    pub(super) carriers: [(usize, f64); 3],
    /// Whether it lies on the rim: what is nearest to it may be beyond the surface's end.
    pub(super) is_rim: bool,
}

impl Sheet {
    pub(super) fn new(surface: Surface) -> Self {
        let n = surface.points.len();
        let (mut normals, mut areas) = (vec![Vec3::zeros(); n], vec![0.; n]);
        let mut edges: HashMap<[usize; 2], usize> = HashMap::with_capacity(2 * surface.triangles.len());
        let mut boxes = Vec::with_capacity(surface.triangles.len());
        for t in &surface.triangles {
            let [a, b, c] = t.map(|v| surface.points[v]);
            let area = (b - a).cross(&(c - a)) / 2.;
            for (k, &v) in t.iter().enumerate() {
                normals[v] += area;
                areas[v] += area.norm() / 3.;
                *edges.entry(sorted(v, t[(k + 1) % 3])).or_default() += 1;
            }
            boxes.push(Aabb::around([a, b, c]));
        }
        normals.iter_mut().for_each(|n| *n = n.try_normalize(0.).unwrap_or_else(Vec3::zeros));
        let mut on_rim = vec![false; n];
        let rim_edges: HashSet<[usize; 2]> =
            edges.into_iter().filter(|(_, owners)| *owners == 1).map(|(edge, _)| edge).collect();
        for v in rim_edges.iter().flatten() {
            on_rim[*v] = true;
        }
        Self { surface, normals, areas, tree: Bvh::new(&boxes), rim_edges, on_rim }
    }

    /// The point nearest to `p` within `reach` (mm) whose triangle faces as the unit vector `facing` does, if one is
    /// given.
    pub(super) fn nearest(&self, p: Vec3, facing: Option<Vec3>, reach: f64) -> Option<Foot> {
        let mut best: Option<(f64, usize, [f64; 3], Feature, Vec3)> = None;
        self.tree.for_each_near(p, |index| {
            let least = best.map_or(reach, |b| b.0);
            let corners = self.surface.triangles[index].map(|v| self.surface.points[v]);
            let at = closest_on_triangle(p, corners);
            let distance = (p - at.point).norm();
            // Of several at one place the first: an order that does not depend on that of the search.
            let is_nearer = match best {
                Some((least, first, ..)) => distance < least || (distance == least && index < first),
                None => distance <= least,
            };
            if is_nearer {
                let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.);
                let faces =
                    facing.is_none_or(|facing| normal.is_some_and(|normal| normal.dot(&facing) >= FACING));
                if faces {
                    best = Some((distance, index, at.weights, at.feature, at.point));
                    return distance;
                }
            }
            least
        });
        let (distance_mm, index, weights, feature, point) = best?;
        let t = self.surface.triangles[index];
        let carriers = [0, 1, 2].map(|k| (t[k], weights[k]));
        let normal: Vec3 = carriers.iter().map(|&(v, w)| w * self.normals[v]).sum();
        let is_rim = match feature {
            Feature::Face => false,
            Feature::Edge(k) => self.rim_edges.contains(&sorted(t[k], t[(k + 1) % 3])),
            Feature::Vertex(k) => self.on_rim[t[k]],
        };
        Some(Foot { point, normal: normal.try_normalize(0.)?, distance_mm, carriers, is_rim })
    }

    /// The closed ways along the rim, each by its vertices, the longest (mm) first.
    pub(super) fn rims(&self) -> Vec<(f64, Vec<usize>)> {
        let n = self.surface.points.len();
        let mut groups = Groups::new(n);
        self.rim_edges.iter().for_each(|&[a, b]| groups.join(a, b));
        let mut rims: HashMap<usize, (f64, Vec<usize>)> = HashMap::new();
        let mut edges: Vec<[usize; 2]> = self.rim_edges.iter().copied().collect();
        edges.sort_unstable();
        for [a, b] in edges {
            let rim = rims.entry(groups.of(a)).or_default();
            rim.0 += (self.surface.points[a] - self.surface.points[b]).norm();
            rim.1.extend([a, b]);
        }
        let mut rims: Vec<(f64, Vec<usize>)> = rims
            .into_values()
            .map(|(length, mut vertices)| {
                vertices.sort_unstable();
                vertices.dedup();
                (length, vertices)
            })
            .collect();
        rims.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        rims
    }
}

fn sorted(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Items in groups that grow together (union-find); the least item stands for its group.
#[derive(Clone, Debug)]
pub(super) struct Groups(Vec<usize>);

impl Groups {
    pub(super) fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    pub(super) fn of(&mut self, mut item: usize) -> usize {
        while self.0[item] != item {
            self.0[item] = self.0[self.0[item]];
            item = self.0[item];
        }
        item
    }

    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}
