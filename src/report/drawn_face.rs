//! A face as the page draws it.

use std::collections::HashMap;

use serde::Serialize;

use super::arrays::{ArrayRef, Arrays};
use crate::face::{Face, opposite_skin};
use crate::mesh::{Site, boundary_facets};
use crate::render::{Scene, muscle_stems, to_srgb};
use crate::units::Vec3;

/// Distance between the points of a fibre that are drawn, mm.
const FIBRE_STEP_MM: f64 = 2.5;

/// A face as the page draws it: everything that moves is carried by a list of points, the carriers, whose displacements
/// are all that a state of the face is.
#[derive(Clone, Debug)]
pub(super) struct DrawnFace {
    /// What moves each carrier: first the nodes of the surfaces, then the points of the fibres.
    pub(super) carriers: Vec<Site>,
    /// Index among the carriers of each node that is one.
    nodes: HashMap<usize, usize>,
    /// Mesh nodes of the first carriers.
    pub(super) surface_nodes: Vec<usize>,
    pub(super) json: FaceJson,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct FaceJson {
    name: String,
    /// Rest positions of the carriers, mm, xyz.
    carriers: ArrayRef,
    skin: SkinJson,
    muscles: Vec<MuscleJson>,
    teeth: Vec<SolidJson>,
    bones: Vec<BoneJson>,
    /// The point of the skin opposite each node of the skin.
    opposite: OppositeJson,
}

#[derive(Clone, Debug, Serialize)]
struct SkinJson {
    /// Carriers of each vertex and their shares, row by row.
    counts: ArrayRef,
    carriers: ArrayRef,
    weights: ArrayRef,
    /// Corners of the quadrilaterals.
    quads: ArrayRef,
    /// sRGB of each vertex.
    colours: ArrayRef,
    /// Triangles of carriers whose strain is that of the skin.
    triangles: ArrayRef,
}

#[derive(Clone, Debug, Serialize)]
struct MuscleJson {
    name: String,
    /// Name without side.
    stem: String,
    /// "left", "right" or "both".
    side: &'static str,
    max_force_n: f64,
    /// First carrier, number of carriers, and whether the fibre is closed.
    fibres: Vec<(usize, usize, bool)>,
}

#[derive(Clone, Debug, Serialize)]
struct SolidJson {
    upper: bool,
    bone: String,
    /// mm, xyz.
    points: ArrayRef,
    triangles: ArrayRef,
}

#[derive(Clone, Debug, Serialize)]
struct BoneJson {
    name: String,
    /// Triangles of carriers.
    triangles: ArrayRef,
}

#[derive(Clone, Debug, Serialize)]
struct OppositeJson {
    /// Carriers that have a point opposite.
    of: ArrayRef,
    counts: ArrayRef,
    carriers: ArrayRef,
    weights: ArrayRef,
}

/// A marker's place among the carriers.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PlaceJson {
    carriers: Vec<usize>,
    weights: Vec<f64>,
}

/// Rows of weights, one after the other.
#[derive(Default)]
struct Rows {
    counts: Vec<u8>,
    columns: Vec<usize>,
    weights: Vec<f64>,
}

impl Rows {
    fn push(&mut self, weights: impl Iterator<Item = (usize, f64)>) {
        let before = self.columns.len();
        for (column, weight) in weights.filter(|(_, w)| *w != 0.) {
            self.columns.push(column);
            self.weights.push(weight);
        }
        self.counts.push(u8::try_from(self.columns.len() - before).unwrap_or(u8::MAX));
    }
}

fn flat(points: impl Iterator<Item = Vec3>) -> Vec<f64> {
    points.flat_map(|p| [p.x, p.y, p.z]).collect()
}

/// Triangles of the facets with these corners.
fn fanned<'a>(facets: impl Iterator<Item = &'a [usize]>) -> Vec<usize> {
    facets.flat_map(|f| (1..f.len() - 1).flat_map(|k| [f[0], f[k], f[k + 1]])).collect()
}

impl DrawnFace {
    /// Puts `face` into the `arrays`.
    pub(super) fn new(face: &Face, arrays: &mut Arrays) -> Self {
        let scene = Scene::new(face);
        let surface = scene.surface();
        let mut nodes: HashMap<usize, usize> = HashMap::new();
        let mut carriers: Vec<Site> = Vec::new();
        let mut surface_nodes: Vec<usize> = Vec::new();
        let mut carrier = |node: usize| {
            *nodes.entry(node).or_insert_with(|| {
                carriers.push(Site::node(node, face.mesh.points[node]));
                surface_nodes.push(node);
                carriers.len() - 1
            })
        };

        let mut rows = Rows::default();
        for site in &surface.sites {
            rows.push(site.weights.iter().map(|&(node, w)| (carrier(node), w)));
        }
        let facets = boundary_facets(&face.mesh);
        let bones: Vec<(String, Vec<usize>)> = face
            .supports
            .iter()
            .map(|support| {
                let on_bone = |f: &&[usize]| f.iter().all(|n| support.nodes.binary_search(n).is_ok());
                let corners = facets.iter().map(|f| f.corners()).filter(on_bone);
                (support.bone.clone(), fanned(corners).into_iter().map(&mut carrier).collect())
            })
            .collect();
        let mut opposite = (Vec::new(), Rows::default());
        for (&node, site) in face.skin.iter().zip(opposite_skin(face)) {
            let Some(site) = site else { continue };
            opposite.0.push(carrier(node));
            opposite.1.push(site.weights.iter().map(|&(n, w)| (carrier(n), w)));
        }
        let on_skin = |f: &&[usize]| f.iter().all(|n| face.skin.binary_search(n).is_ok());
        let triangles: Vec<usize> = fanned(facets.iter().map(|f| f.corners()).filter(on_skin))
            .into_iter()
            .map(&mut carrier)
            .collect();

        let mut muscles = Vec::new();
        let stems = muscle_stems(face);
        for (muscle, bundle) in face.muscles.iter().zip(scene.fibres()) {
            let mut fibres = Vec::new();
            for (sites, fibre) in bundle.iter().zip(&muscle.fibres) {
                let first = carriers.len();
                carriers.extend(thinned(sites, fibre.closed));
                fibres.push((first, carriers.len() - first, fibre.closed));
            }
            let stem = stems.iter().find(|s| muscle.name.strip_prefix(s.as_str()).is_some_and(is_side));
            let side = match () {
                () if muscle.name.ends_with("_l") => "left",
                () if muscle.name.ends_with("_r") => "right",
                () => "both",
            };
            muscles.push(MuscleJson {
                name: muscle.name.clone(),
                stem: stem.unwrap_or(&muscle.name).clone(),
                side,
                max_force_n: muscle.max_force_n,
                fibres,
            });
        }

        let quads: Vec<usize> = surface.quads.iter().flatten().copied().collect();
        let colours: Vec<u8> = scene.tint().into_iter().flat_map(to_srgb).collect();
        let skin = SkinJson {
            counts: arrays.bytes(&rows.counts),
            carriers: arrays.indices(&rows.columns),
            weights: arrays.shares(&rows.weights),
            quads: arrays.indices(&quads),
            colours: arrays.bytes(&colours),
            triangles: arrays.indices(&triangles),
        };
        let teeth = face
            .teeth
            .iter()
            .map(|teeth| SolidJson {
                upper: teeth.upper,
                bone: teeth.bone.clone(),
                points: arrays.reals(&flat(teeth.surface.points.iter().copied())),
                triangles: arrays
                    .indices(&teeth.surface.triangles.iter().flatten().copied().collect::<Vec<_>>()),
            })
            .collect();
        let bones = bones
            .into_iter()
            .filter(|(_, triangles)| !triangles.is_empty())
            .map(|(name, triangles)| BoneJson { name, triangles: arrays.indices(&triangles) })
            .collect();
        let (of, rows) = opposite;
        let opposite = OppositeJson {
            of: arrays.indices(&of),
            counts: arrays.bytes(&rows.counts),
            carriers: arrays.indices(&rows.columns),
            weights: arrays.reals(&rows.weights),
        };
        let json = FaceJson {
            name: face.name.clone(),
            carriers: arrays.reals(&flat(carriers.iter().map(|s| s.position))),
            skin,
            muscles,
            teeth,
            bones,
            opposite,
        };
        Self { carriers, nodes, surface_nodes, json }
    }

    /// The displacement of the carriers in the field `u` (3n), mm, xyz.
    pub(super) fn displacement(&self, u: &[f64]) -> Vec<f64> {
        flat(self.carriers.iter().map(|site| site.displacement(u)))
    }

    /// The carriers of `site`, as far as its nodes are carriers; `None` where they are not.
    pub(super) fn place(&self, site: &Site) -> Option<PlaceJson> {
        let carriers = site.weights.iter().map(|(node, _)| self.nodes.get(node).copied());
        let carriers: Vec<usize> = carriers.collect::<Option<_>>()?;
        Some(PlaceJson { carriers, weights: site.weights.iter().map(|(_, w)| *w).collect() })
    }
}

/// Whether `rest` is what follows a muscle's name without side.
fn is_side(rest: &str) -> bool {
    ["", "_l", "_r"].contains(&rest)
}

/// The points of a fibre, about [`FIBRE_STEP_MM`] apart, its ends among them.
fn thinned(sites: &[Site], closed: bool) -> Vec<Site> {
    let mut kept: Vec<Site> = Vec::new();
    let mut gone = f64::INFINITY;
    for (k, site) in sites.iter().enumerate() {
        if k > 0 {
            gone += (site.position - sites[k - 1].position).norm();
        }
        if gone >= FIBRE_STEP_MM || (k + 1 == sites.len() && !closed) {
            kept.push(site.clone());
            gone = 0.;
        }
    }
    kept
}
