//! Where samples of one surface lie inside another.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::facet_sites::{FacetSites, facet_sites};
use super::tooth_solid::ToothSolid;
use super::{Inside, Overlap};
use crate::face::{Face, Pose, RigidMotion};
use crate::mesh::{Located, Locator, Mesh, Site};
use crate::units::Vec3;

/// Depths below this are rounding, mm.
const ROUNDING_MM: f64 = 1e-6;

/// Samples of a tooth that one thread takes at a time.
const CHUNK: usize = 512;

/// The samples of a face and what they may lie inside of.
///
/// Contact asks its nodes for the closest points of surfaces, by pseudo-normals. Here the samples are dense, the inside
/// of a tooth is what its surface [winds round](crate::mesh::Winding), the inside of tissue is where the map of a cell has
/// a [preimage](Locator::containing). A cell counts as other tissue for the samples that none of its nodes carries.
///
/// Shapes: `n` nodes. Teeth are met where they rest: the samples of tissue are brought there.
#[derive(Clone, Debug)]
pub struct OverlapSearch {
    facets: Vec<FacetSites>,
    teeth: Vec<ToothSolid>,
    /// The cells (0-based) about each node.
    about: Vec<Vec<usize>>,
    /// Nodes on bone.
    fixed: HashSet<usize>,
    rest: [HashMap<Sample, f64>; 3],
}

/// The number of a sample of tissue or of a tooth, and the tooth surface.
type Sample = (usize, Option<usize>);

struct Found {
    sample: Sample,
    at: Vec3,
    depth_mm: f64,
    nodes: Vec<usize>,
}

impl OverlapSearch {
    /// The samples of `face`, with their depths at rest.
    pub fn new(face: &Face) -> Self {
        let mesh = &face.mesh;
        let mut about = vec![Vec::new(); mesh.n_nodes()];
        for (cell, nodes) in mesh.cells.iter().map(|c| c.nodes()).enumerate() {
            nodes.iter().for_each(|&node| about[node].push(cell));
        }
        let fixed: HashSet<usize> = face.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        let tissue = Tissue { locator: Locator::new(mesh), mesh: mesh.clone(), about: &about };
        let mut teeth: Vec<ToothSolid> = face.teeth.par_iter().map(|t| ToothSolid::new(&t.surface)).collect();
        for tooth in &mut teeth {
            let points = std::mem::take(&mut tooth.points).into_par_iter();
            tooth.points = points.filter(|p| !tissue.is_set_in_bone(*p, &fixed)).collect();
        }
        let mut search =
            Self { facets: facet_sites(face, &fixed), teeth, about, fixed, rest: Default::default() };
        let rest = search.found(face, &vec![0.; 3 * mesh.n_nodes()], &Pose::rest());
        search.rest = rest.map(|found| found.iter().map(|f| (f.sample, f.depth_mm)).collect());
        search
    }

    /// What lies inside what where the tissue of `face` moved by `u` (3n, node-major xyz, mm) and its teeth with
    /// their bones by `pose`.
    ///
    /// # Panics
    /// If `u` is shorter than 3n.
    pub fn at(&self, face: &Face, u: &[f64], pose: &Pose) -> Overlap {
        let landmarks: Vec<Vec3> =
            face.landmarks.iter().map(|l| l.site.position + l.site.displacement(u)).collect();
        let nearest = |at: Vec3| {
            let distance = |k: &usize| (landmarks[*k] - at).norm_squared();
            (0..landmarks.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let inside = |(found, rest): (Vec<Found>, &HashMap<Sample, f64>)| {
            let inside = |Found { sample, at, depth_mm, nodes }| {
                let at_rest_mm = rest.get(&sample).copied().unwrap_or(0.);
                let hangs_on_bone = nodes.iter().any(|node| self.fixed.contains(node));
                Inside {
                    at,
                    depth_mm,
                    at_rest_mm,
                    nodes,
                    hangs_on_bone,
                    tooth: sample.1,
                    landmark: nearest(at),
                }
            };
            found.into_iter().map(inside).collect()
        };
        let [teeth, tooth_edges, tissue] = self.found(face, u, pose);
        let [in_teeth, in_tissue, folded] = &self.rest;
        Overlap {
            teeth: inside((teeth, in_teeth)),
            tooth_edges: inside((tooth_edges, in_tissue)),
            tissue: inside((tissue, folded)),
        }
    }

    /// Samples of tissue inside teeth, of teeth inside tissue, of tissue inside other tissue.
    fn found(&self, face: &Face, u: &[f64], pose: &Pose) -> [Vec<Found>; 3] {
        let displaced =
            |(node, p): (usize, &Vec3)| p + Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]);
        let points = face.mesh.points.iter().enumerate().map(displaced).collect();
        let moved = Mesh::new(points, face.mesh.cells.clone());
        let tissue = Tissue { locator: Locator::new(&moved), mesh: moved, about: &self.about };
        let motions: Vec<RigidMotion> = face.teeth.iter().map(|t| pose.motion(face, &t.bone)).collect();
        let by_facet: Vec<[Vec<Found>; 2]> = self
            .facets
            .par_iter()
            .map(|facet| {
                let at: Vec<Vec3> = facet.sites.iter().map(|site| place(site, &tissue.mesh)).collect();
                [self.in_teeth(facet, &at, &motions), tissue.in_other_tissue(facet, &at)]
            })
            .collect();
        let (mut in_teeth, mut in_other) = (Vec::new(), Vec::new());
        for [a, b] in by_facet {
            in_teeth.extend(a);
            in_other.extend(b);
        }
        let of_tooth = |(surface, motion): (usize, &RigidMotion)| {
            let points = &self.teeth[surface].points;
            let chunks = points.par_chunks(CHUNK).enumerate();
            let found = chunks.flat_map_iter(|(chunk, points)| {
                let held = |(k, p): (usize, &Vec3)| {
                    tissue.holding((CHUNK * chunk + k, Some(surface)), motion.apply(*p))
                };
                points.iter().enumerate().filter_map(held).collect::<Vec<_>>()
            });
            found.collect::<Vec<_>>()
        };
        let in_tissue = motions.iter().enumerate().flat_map(of_tooth).collect();
        [in_teeth, in_tissue, in_other]
    }

    fn in_teeth(&self, facet: &FacetSites, at: &[Vec3], motions: &[RigidMotion]) -> Vec<Found> {
        let mut found = Vec::new();
        let Some((centre, radius)) = ball(at) else { return found };
        for (surface, (solid, motion)) in self.teeth.iter().zip(motions).enumerate() {
            if !solid.may_hold(motion.origin_of(centre), radius) {
                continue;
            }
            for (k, (&at, site)) in at.iter().zip(&facet.sites).enumerate() {
                if let Some(depth_mm) = solid.depth(motion.origin_of(at)).filter(|d| *d > ROUNDING_MM) {
                    let sample = (facet.first + k, Some(surface));
                    found.push(Found { sample, at, depth_mm, nodes: carriers(site).collect() });
                }
            }
        }
        found
    }
}

/// The moved tissue.
struct Tissue<'a> {
    mesh: Mesh,
    locator: Locator,
    about: &'a [Vec<usize>],
}

impl Tissue<'_> {
    /// Whether `p` lies in the tissue and bone is the nearest that bounds it there: the root of a tooth.
    fn is_set_in_bone(&self, p: Vec3, fixed: &HashSet<usize>) -> bool {
        let on_bone = |l: &Located| carriers(&l.site).all(|node| fixed.contains(&node));
        self.locator.containing(p).is_some() && self.locator.closest(p).as_ref().is_some_and(on_bone)
    }

    /// The sample of a tooth at `at`, if a cell holds it.
    fn holding(&self, sample: Sample, at: Vec3) -> Option<Found> {
        let cell = self.locator.containing(at)?.cell;
        let depth_mm = self.locator.closest(at)?.distance_mm;
        let nodes = self.mesh.cells[cell].nodes().to_vec();
        (depth_mm > ROUNDING_MM).then_some(Found { sample, at, depth_mm, nodes })
    }

    /// The samples of `facet`, which lie `at`, that cells hold which none of their nodes carries.
    fn in_other_tissue(&self, facet: &FacetSites, at: &[Vec3]) -> Vec<Found> {
        let mut found = Vec::new();
        let mut sides: Vec<(Vec<usize>, Vec<bool>)> = Vec::new();
        for (k, (&at, site)) in at.iter().zip(&facet.sites).enumerate() {
            let is_other =
                |cell: usize| !carriers(site).any(|node| self.mesh.cells[cell].nodes().contains(&node));
            let cells = self.locator.all_containing(at, is_other);
            if cells.is_empty() {
                continue;
            }
            let known = sides.iter().position(|(of, _)| *of == cells);
            let known = known.unwrap_or_else(|| {
                sides.push((cells.clone(), self.nearer_to(&cells, &facet.nodes)));
                sides.len() - 1
            });
            let depth = self.locator.closest_among(at, |f| sides[known].1[f.cell]).map(|l| l.distance_mm);
            if let Some(depth_mm) = depth.filter(|d| *d > ROUNDING_MM) {
                let nodes = carriers(site).collect();
                found.push(Found { sample: (facet.first + k, None), at, depth_mm, nodes });
            }
        }
        found
    }

    /// Whether each cell is nearer to `cells` than to `nodes`, by steps from cell to neighbour: the outside of
    /// these is what a sample on `nodes` passed, that of the others is its own.
    fn nearer_to(&self, cells: &[usize], nodes: &[usize]) -> Vec<bool> {
        let mut side = vec![None; self.mesh.cells.len()];
        let mut is_passed = vec![false; self.mesh.n_nodes()];
        let mut fronts = [cells.to_vec(), nodes.iter().flat_map(|&n| &self.about[n]).copied().collect()];
        while fronts.iter().any(|front| !front.is_empty()) {
            for (front, is_theirs) in fronts.iter_mut().zip([true, false]) {
                front.retain(|&cell| side[cell].is_none() && side[cell].replace(is_theirs).is_none());
                let mut next = Vec::new();
                for &node in front.iter().flat_map(|&cell| self.mesh.cells[cell].nodes()) {
                    if !std::mem::replace(&mut is_passed[node], true) {
                        next.extend(self.about[node].iter().filter(|&&cell| side[cell].is_none()));
                    }
                }
                *front = next;
            }
        }
        side.into_iter().map(|side| side == Some(true)).collect()
    }
}

fn carriers(site: &Site) -> impl Iterator<Item = usize> + '_ {
    site.weights.iter().map(|(node, _)| *node)
}

fn place(site: &Site, mesh: &Mesh) -> Vec3 {
    site.weights.iter().map(|&(node, w)| w * mesh.points[node]).sum()
}

/// A ball about all of `points`: centre and radius.
fn ball(points: &[Vec3]) -> Option<(Vec3, f64)> {
    let centre = points.iter().sum::<Vec3>() / points.len() as f64;
    points.iter().map(|p| (p - centre).norm()).reduce(f64::max).map(|radius| (centre, radius))
}
