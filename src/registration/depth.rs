//! The depth of bones and mucosa below the skin, kept while the skin moves.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::correspondence::{SkinAt, inner_areas, inner_nodes};
use super::tissue::Spring;
use crate::face::Face;
use crate::units::Vec3;

/// Inner nodes, each held where it lay below the skin.
pub(super) struct Depths {
    /// Nodes on bones and mucosa, ascending.
    pub(super) nodes: Vec<usize>,
    /// Area of each, mm².
    areas: Vec<f64>,
    /// Mesh nodes and weights of the skin's point nearest to each, two of the former that give a direction, and the way
    /// from that point to the inner node in the frame there.
    places: Vec<Option<Place>>,
}

struct Place {
    carriers: [(usize, f64); 3],
    offset: Vec3,
}

impl Depths {
    /// Those of `face` with its nodes at `x` (n, mm), whose skin is `skin`.
    pub(super) fn new(face: &Face, x: &[Vec3], skin: &SkinAt) -> Self {
        let nodes = inner_nodes(face);
        let normals = normals(x.len(), skin);
        let place = |&node: &usize| {
            let foot = skin.sheet.nearest(x[node], None, f64::INFINITY)?;
            let carriers = foot.carriers.map(|(v, w)| (skin.nodes[v], w));
            let (point, frame) = frame(&carriers, x, &normals)?;
            Some(Place { carriers, offset: frame.transpose() * (x[node] - point) })
        };
        let places = nodes.par_iter().map(place).collect();
        Self { areas: inner_areas(face, &nodes), nodes, places }
    }

    /// Springs of `stiffness` (N/mm³) that hold each inner node, with the skin `skin` of nodes at `x` (n, mm), but those
    /// that `is_free`.
    pub(super) fn springs(
        &self,
        x: &[Vec3],
        skin: &SkinAt,
        stiffness: f64,
        is_free: impl Fn(usize) -> bool,
    ) -> Vec<Spring> {
        let normals = normals(x.len(), skin);
        let all = self.nodes.iter().zip(&self.areas).zip(&self.places);
        all.filter(|((node, _), _)| !is_free(**node))
            .filter_map(|((&node, area), place)| {
                let place = place.as_ref()?;
                let (point, frame) = frame(&place.carriers, x, &normals)?;
                let k = stiffness * area;
                Some(Spring {
                    carriers: vec![(node, 1.)],
                    target: point + frame * place.offset,
                    normal: frame.column(2).into(),
                    along: k,
                    across: k,
                })
            })
            .collect()
    }
}

fn normals(n: usize, skin: &SkinAt) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); n];
    for (&node, normal) in skin.nodes.iter().zip(&skin.sheet.normals) {
        normals[node] = *normal;
    }
    normals
}

/// A point of the skin and a right-handed frame there whose third axis is the normal.
fn frame(carriers: &[(usize, f64); 3], x: &[Vec3], normals: &[Vec3]) -> Option<(Vec3, Matrix3<f64>)> {
    let point = carriers.iter().map(|&(n, w)| w * x[n]).sum();
    let normal: Vec3 = carriers.iter().map(|&(n, w)| w * normals[n]).sum();
    let normal = normal.try_normalize(0.)?;
    let [a, b, c] = carriers.map(|(n, _)| x[n]);
    // A direction that all three corners have a say in.
    let along = b + c - 2. * a;
    let first = (along - along.dot(&normal) * normal).try_normalize(0.)?;
    Some((point, Matrix3::from_columns(&[first, normal.cross(&first), normal])))
}
