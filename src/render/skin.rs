//! The skin, the lips and the lining of the mouth as one smooth surface.

use std::collections::HashSet;

use super::{Refined, refine};
use crate::face::Face;
use crate::mesh::boundary_facets;
use crate::units::Vec3;

/// Halvings of the mesh's facets: its cells of some 2 to 5 mm become about half a pixel to one of a portrait.
const LEVELS: usize = 2;

/// The surface to draw, at rest.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    pub(super) surface: Refined,
    /// Share of mucosa at each vertex: 1 inside the mouth.
    pub(super) mucosa: Vec<f32>,
    /// Triangles of the surface.
    pub(super) triangles: Vec<[usize; 3]>,
}

impl Skin {
    /// The boundary facets of `face` on skin, lips and mucosa; all of them when the face has no skin.
    pub(super) fn new(face: &Face) -> Self {
        let sets = [&face.skin, &face.mucosa, &face.upper_lip, &face.lower_lip];
        let shown: HashSet<usize> = sets.into_iter().flatten().copied().collect();
        let facets: Vec<Vec<usize>> = boundary_facets(&face.mesh)
            .iter()
            .map(|f| f.corners().to_vec())
            .filter(|f| face.skin.is_empty() || f.iter().all(|node| shown.contains(node)))
            .collect();
        let surface = refine(&face.mesh.points, &facets, LEVELS);
        let outer: HashSet<usize> = face.skin.iter().copied().collect();
        let inner: HashSet<usize> = face.mucosa.iter().copied().filter(|n| !outer.contains(n)).collect();
        let share = |weights: &[(usize, f64)]| {
            weights.iter().filter(|(node, _)| inner.contains(node)).map(|(_, w)| *w as f32).sum()
        };
        let mucosa = surface.sites.iter().map(|site| share(&site.weights)).collect();
        let triangles = surface.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { surface, mucosa, triangles }
    }

    /// Displacement of each vertex, mm, under `u` (3n).
    pub(super) fn displacement(&self, u: Option<&[f64]>) -> Vec<Vec3> {
        let of = |site: &crate::mesh::Site| u.map_or_else(Vec3::zeros, |u| site.displacement(u));
        self.surface.sites.iter().map(of).collect()
    }

    /// Unit normal at each of the vertices `points`: the mean of the quadrilaterals there.
    pub(super) fn normals(&self, points: &[Vec3]) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); points.len()];
        for q in &self.surface.quads {
            let [a, b, c, d] = q.map(|v| points[v]);
            let area = (c - a).cross(&(d - b));
            q.iter().for_each(|&v| normals[v] += area);
        }
        normals.iter_mut().for_each(|n| *n = n.try_normalize(0.).unwrap_or_else(Vec3::z));
        normals
    }
}
