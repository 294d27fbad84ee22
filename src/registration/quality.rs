//! How far a registered face can be trusted.

use rayon::prelude::*;

use super::correspondence::{FaceSkin, SkinAt, counterpart, inner_nodes};
use super::scan::Scan;
use super::sheet::{Foot, Sheet};
use crate::face::{Face, Muscle, Symmetry, polyline_length};
use crate::mesh::{Facet, Quality, Skin, boundary_facets};
use crate::units::Vec3;

/// How far the skin may be from the scan to be covered by it, mm.
const COVER_MM: f64 = 20.;
/// How far a point of the scan may be from the skin to be one of it, mm: beyond lie nostrils, mouth, ears and neck.
const SEEN_MM: f64 = 8.;

/// Distances between two surfaces, by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Mean, mm.
    pub mean_mm: f64,
    /// Root mean square, mm.
    pub rms_mm: f64,
    /// What 95 % of the area is within, mm.
    pub p95_mm: f64,
    /// Greatest, mm.
    pub max_mm: f64,
}

impl Distances {
    /// Of pairs of distance and area.
    fn of(mut all: Vec<(f64, f64)>) -> Self {
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let area: f64 = all.iter().map(|(_, area)| area).sum();
        let mean = |power: i32| all.iter().map(|(d, a)| d.powi(power) * a).sum::<f64>() / area.max(1e-300);
        let mut below = 0.;
        let p95 = all.iter().find(|(_, a)| {
            below += a;
            below >= 0.95 * area
        });
        Self {
            mean_mm: mean(1),
            rms_mm: mean(2).sqrt(),
            p95_mm: p95.map_or(0., |(d, _)| *d),
            max_mm: all.last().map_or(0., |(d, _)| *d),
        }
    }
}

/// What a given landmark was used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LandmarkUse {
    /// For the position, and the skin is held to it.
    Held,
    /// For the position alone: it is off the scan or far from where the others have it.
    Position,
}

/// A landmark that was given.
#[derive(Clone, Debug, PartialEq)]
pub struct LandmarkError {
    /// Its name.
    pub name: String,
    /// Where it was given, in the axes of the face, mm.
    pub given_mm: Vec3,
    /// How far from there that of the face is, mm.
    pub error_mm: f64,
    /// What it was used for.
    pub used: LandmarkUse,
}

/// A muscle's length.
#[derive(Clone, Debug, PartialEq)]
pub struct MuscleLength {
    /// Its name.
    pub name: String,
    /// Mean over its fibres, mm.
    pub length_mm: f64,
    /// That of the template, mm.
    pub template_mm: f64,
}

/// Depth of bone or mucosa below a landmark.
#[derive(Clone, Debug, PartialEq)]
pub struct LandmarkDepth {
    /// The landmark.
    pub name: String,
    /// Its distance from the inner surface, mm.
    pub depth_mm: f64,
    /// That of the template, mm.
    pub template_mm: f64,
}

/// How far a pair of landmarks is from a mirror image at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PairAsymmetry {
    /// Its name without the side.
    pub name: String,
    /// Distance of the one from the mirror image of the other, mm.
    pub distance_mm: f64,
}

/// How far a registered face can be trusted.
#[derive(Clone, Debug, PartialEq)]
pub struct RegistrationQuality {
    /// From the skin to the scan, where that covers it.
    pub from_skin: Distances,
    /// From the scan to the skin, where there is skin.
    pub from_scan: Distances,
    /// Share of the skin's area that the scan covers.
    pub covered: f64,
    /// Landmarks that were given.
    pub landmarks: Vec<LandmarkError>,
    /// Least over the cells; 1 for a cube, 0 for a cell that is folded flat.
    pub scaled_jacobian: f64,
    /// Cells turned inside out.
    pub inverted: usize,
    /// Muscles against the template's.
    pub muscles: Vec<MuscleLength>,
    /// Depths below landmarks against the template's.
    pub depths: Vec<LandmarkDepth>,
    /// Asymmetry at rest of each pair of landmarks.
    pub asymmetry: Vec<PairAsymmetry>,
    /// Of every node (n): distance to the scan, mm; NaN off the skin and where it is not covered.
    pub distance_map_mm: Vec<f64>,
    /// Of every node (n): depth below the skin, mm; NaN but on bones and mucosa.
    pub depth_map_mm: Vec<f64>,
    /// Of every node (n): distance from the mirror image of the skin, mm; NaN off the skin and where there is none.
    pub asymmetry_map_mm: Vec<f64>,
}

impl RegistrationQuality {
    /// That of `face`, which was `template`, on the `scan`; `known` landmarks by their number and place (mm), of which those of
    /// `held` held it.
    pub(super) fn new(
        face: &Face,
        template: &Face,
        scan: &Scan,
        known: &[(usize, Vec3)],
        held: &[(usize, Vec3)],
    ) -> Self {
        let skin = FaceSkin::of(face).at(face, &face.mesh.points);
        let n = face.mesh.n_nodes();
        let surface = &skin.sheet.surface;
        let area: f64 = skin.sheet.areas.iter().sum();
        let on_scan = |v: usize| {
            let normal = skin.sheet.normals[v];
            counterpart(&scan.sheet, surface.points[v], normal, COVER_MM)
        };
        let feet: Vec<Option<Foot>> = (0..skin.nodes.len()).into_par_iter().map(on_scan).collect();
        let mut distance_map_mm = vec![f64::NAN; n];
        let mut distances = Vec::new();
        for (v, foot) in feet.iter().enumerate() {
            let Some(foot) = foot else { continue };
            distance_map_mm[skin.nodes[v]] = foot.distance_mm;
            distances.push((foot.distance_mm, skin.sheet.areas[v]));
        }
        let covered = distances.iter().map(|(_, a)| a).sum::<f64>() / area;
        let cells = face.mesh.cells.par_iter().map(|cell| Quality::new(cell, &face.mesh.points));
        let cells: Vec<Quality> = cells.collect();
        let landmark = |&(k, given_mm): &(usize, Vec3)| {
            let own = &face.landmarks[k];
            let used = match held.iter().any(|(other, _)| *other == k) {
                true => LandmarkUse::Held,
                false => LandmarkUse::Position,
            };
            let error_mm = (own.site.position - given_mm).norm();
            LandmarkError { name: own.name.clone(), given_mm, error_mm, used }
        };
        let pairs = face.muscles.iter().zip(&template.muscles);
        let muscles = pairs
            .map(|(own, other)| MuscleLength {
                name: own.name.clone(),
                length_mm: length(own),
                template_mm: length(other),
            })
            .collect();
        let symmetry = Symmetry::of(face, &vec![0.; 3 * n]);
        let asymmetry = symmetry
            .pairs
            .into_iter()
            .map(|pair| PairAsymmetry { name: pair.name, distance_mm: pair.rest_mm })
            .collect();
        Self {
            from_skin: Distances::of(distances),
            from_scan: from_scan(scan, &skin),
            covered,
            landmarks: known.iter().map(landmark).collect(),
            scaled_jacobian: cells.iter().map(|q| q.scaled_jacobian).fold(f64::INFINITY, f64::min),
            inverted: cells.iter().filter(|q| q.is_inverted()).count(),
            muscles,
            depths: depths(face, template),
            asymmetry,
            distance_map_mm,
            depth_map_mm: depth_map(face, &skin),
            asymmetry_map_mm: asymmetry_map(&skin, n),
        }
    }
}

fn length(muscle: &Muscle) -> f64 {
    let lengths = muscle.fibres.iter().map(|f| polyline_length(&f.points, f.closed));
    lengths.sum::<f64>() / muscle.fibres.len().max(1) as f64
}

fn from_scan(scan: &Scan, skin: &SkinAt) -> Distances {
    let sheet = &scan.sheet;
    let distance = |&v: &usize| {
        if sheet.on_rim[v] || sheet.normals[v] == Vec3::zeros() {
            return None;
        }
        let foot = counterpart(&skin.sheet, sheet.surface.points[v], sheet.normals[v], SEEN_MM)?;
        Some((foot.distance_mm, sheet.areas[v]))
    };
    Distances::of(scan.drawn.par_iter().filter_map(distance).collect())
}

/// The inner surface of a face.
fn inside(face: &Face) -> Sheet {
    let inner = inner_nodes(face);
    let is_inner = |facet: &Facet| facet.corners().iter().all(|n| inner.binary_search(n).is_ok());
    let facets: Vec<Facet> = boundary_facets(&face.mesh).into_iter().filter(is_inner).collect();
    Sheet::new(Skin::new(&face.mesh, &facets).surface)
}

fn depths(face: &Face, template: &Face) -> Vec<LandmarkDepth> {
    let sheets = [face, template].map(inside);
    let pairs = face.landmarks.iter().zip(&template.landmarks);
    let depth = |sheet: &Sheet, p: Vec3| sheet.nearest(p, None, f64::INFINITY).map(|foot| foot.distance_mm);
    pairs
        .filter_map(|(own, other)| {
            Some(LandmarkDepth {
                name: own.name.clone(),
                depth_mm: depth(&sheets[0], own.site.position)?,
                template_mm: depth(&sheets[1], other.site.position)?,
            })
        })
        .collect()
}

fn depth_map(face: &Face, skin: &SkinAt) -> Vec<f64> {
    let mut map = vec![f64::NAN; face.mesh.n_nodes()];
    for node in inner_nodes(face) {
        let foot = skin.sheet.nearest(face.mesh.points[node], None, f64::INFINITY);
        map[node] = foot.map_or(f64::NAN, |foot| foot.distance_mm);
    }
    map
}

fn asymmetry_map(skin: &SkinAt, n: usize) -> Vec<f64> {
    let mirrored = |p: Vec3| Vec3::new(-p.x, p.y, p.z);
    let mut map = vec![f64::NAN; n];
    for (v, &node) in skin.nodes.iter().enumerate() {
        let (p, normal) = (skin.sheet.surface.points[v], skin.sheet.normals[v]);
        let foot = skin.sheet.nearest(mirrored(p), Some(mirrored(normal)), COVER_MM);
        map[node] = foot.map_or(f64::NAN, |foot| foot.distance_mm);
    }
    map
}
