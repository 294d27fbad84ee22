//! Teeth and jaw of the patient: given ones, or the standard's brought along with the tissue about them.

use rayon::prelude::*;

use super::similarity::Similarity;
use super::tissue::Spring;
use crate::contact::{Projection, Solid};
use crate::face::{Face, Jaw, Teeth};
use crate::units::Vec3;

/// Clearances beyond which the mucosa is not behind teeth, mm.
const BEHIND_MM: [f64; 2] = [-4., 8.];
/// The widest clearance that is kept, mm.
const WIDEST_MM: f64 = 3.;

/// Where the mucosa is with respect to the teeth.
pub(super) struct Clearance {
    /// Nodes of the mucosa near teeth, the solid that each faces, and its gap to it at the start, mm.
    nodes: Vec<(usize, f64)>,
}

/// The teeth as solids.
pub(super) struct Solids(Vec<Solid>);

impl Solids {
    pub(super) fn of(teeth: &[Teeth]) -> Self {
        Self(teeth.iter().map(|teeth| Solid::new(&teeth.surface)).collect())
    }

    /// The least signed distance of `p`, with its foot.
    pub(super) fn project(&self, p: Vec3) -> Option<Projection> {
        let all = self.0.iter().filter_map(|solid| solid.project(p));
        all.min_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm))
    }
}

impl Clearance {
    /// That of the mucosa of `face`, whose nodes are at `x` (n, mm), to `solids`.
    pub(super) fn new(face: &Face, x: &[Vec3], solids: &Solids) -> Self {
        let gap = |&node: &usize| {
            let gap = solids.project(x[node])?.distance_mm;
            (gap <= BEHIND_MM[1]).then_some((node, gap.min(WIDEST_MM)))
        };
        Self { nodes: face.mucosa.par_iter().filter_map(gap).collect() }
    }

    /// Springs of `stiffness` (N/mm a node) that give the nodes at `x` (n, mm) their gaps to `solids` again, or where `only_out`
    /// just keep them from lesser ones.
    pub(super) fn springs(&self, x: &[Vec3], solids: &Solids, stiffness: f64, only_out: bool) -> Vec<Spring> {
        let spring = |&(node, gap): &(usize, f64)| {
            let at = solids.project(x[node])?;
            let is_behind = (BEHIND_MM[0]..=BEHIND_MM[1]).contains(&at.distance_mm);
            let is_asked = is_behind && (!only_out || at.distance_mm < gap);
            is_asked.then(|| Spring {
                carriers: vec![(node, 1.)],
                target: at.point + gap * at.normal,
                normal: at.normal,
                along: stiffness,
                across: 0.,
            })
        };
        self.nodes.par_iter().filter_map(spring).collect()
    }
}

/// How the tissue of one jaw has moved from `from` to `to` (n, mm): the similarity of its nodes on bone and mucosa.
pub(super) fn jaw_motion(face: &Face, upper: bool, from: &[Vec3], to: &[Vec3]) -> Option<Similarity> {
    let mut nodes: Vec<usize> = face
        .supports
        .iter()
        .filter(|support| (support.bone == "mandible") != upper)
        .flat_map(|support| support.nodes.iter().copied())
        .collect();
    let middle = face.landmark("stomion_superius").map_or(0., |l| l.site.position.y);
    nodes.extend(face.mucosa.iter().copied().filter(|&n| (face.mesh.points[n].y >= middle) == upper));
    nodes.sort_unstable();
    nodes.dedup();
    let pairs: Vec<[Vec3; 2]> = nodes.iter().map(|&n| [from[n], to[n]]).collect();
    Similarity::fit(&pairs, &vec![1.; pairs.len()], false)
}

/// `teeth` moved by `motion`.
pub(super) fn moved(teeth: &Teeth, motion: &Similarity) -> Teeth {
    let mut teeth = teeth.clone();
    teeth.surface.points.iter_mut().for_each(|p| *p = motion.apply(*p));
    teeth
}

/// `jaw` moved by `motion`, its incisal point on the lower `teeth` where they are the patient's.
pub(super) fn moved_jaw(jaw: &Jaw, motion: &Similarity, given: Option<&Teeth>) -> Jaw {
    let carried = motion.apply(jaw.incisor);
    let nearest = given.and_then(|teeth| {
        let by_distance = |a: &&Vec3, b: &&Vec3| {
            let distance = |p: &Vec3| (p - carried).norm();
            distance(a).total_cmp(&distance(b))
        };
        teeth.surface.points.iter().min_by(by_distance).copied()
    });
    Jaw {
        bone: jaw.bone.clone(),
        condyles: jaw.condyles.map(|c| motion.apply(c)),
        incisor: nearest.unwrap_or(carried),
    }
}
