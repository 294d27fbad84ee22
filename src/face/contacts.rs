//! The contact candidates of a face.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::mirror_image::MirrorImage;
use super::{Face, Pose};
use crate::contact::{Facets, Lip, Pair, PairKind, Solid, lip_pairs, teeth_pairs, teeth_planes};
use crate::mesh::Mesh;
use crate::units::Vec3;

/// Distance between two surfaces, mm, up to which a node heeds both: what it moves from one linearisation to
/// the next.
const NEAR_MM: f64 = 1.5;

/// Which contact candidates to look for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactReach {
    /// Farthest node from a tooth, mm.
    pub teeth_mm: f64,
    /// Farthest node from the other lip, mm.
    pub lips_mm: f64,
}

impl Default for ContactReach {
    /// 12 mm either way: about the largest movement of a posed smile (13.7 mm at the commissure,
    /// J Korean Soc Plast Reconstr Surg 2003;30:393), of which little goes straight to the teeth.
    fn default() -> Self {
        Self { teeth_mm: 12., lips_mm: 12. }
    }
}

/// How far a face overlaps its teeth at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestOverlap {
    /// Mucosa nodes.
    pub nodes: usize,
    /// Those inside a tooth surface.
    pub inside: usize,
    /// Median depth of these, mm.
    pub median_mm: f64,
    /// Greatest depth, mm.
    pub deepest_mm: f64,
}

/// Who may touch whom on a face, at rest and where the tissue has moved.
#[derive(Clone, Debug)]
pub struct ContactSearch {
    reach: ContactReach,
    /// The tooth surfaces at rest, upper before lower, with their place among the face's.
    teeth: Vec<(PairKind, usize, Solid)>,
    lips: [Lip; 2],
    facets: Facets,
    fixed: BTreeSet<usize>,
    mucosa: Vec<usize>,
    /// Which side is the mirror image of which, where one is.
    mirror: Option<MirrorImage>,
    rest: Vec<Pair>,
}

/// The contacts of a face whose tissue has moved.
#[derive(Clone, Debug, Default)]
pub struct TouchedSurfaces {
    /// The candidates, linearised there: `gap + G u` is the signed distance at the displacement `u`, from
    /// which the rest overlap of the same node is forgiven. A gap may therefore be negative.
    pub pairs: Vec<Pair>,
    /// Signed distance of each pair there, mm, the rest overlap forgiven.
    pub distance_mm: Vec<f64>,
}

impl TouchedSurfaces {
    /// Deepest overlap beyond that at rest, mm, measured on the surfaces themselves.
    pub fn overlap_mm(&self) -> f64 {
        self.distance_mm.iter().fold(0., |deepest, d| deepest.max(-d))
    }

    /// Least distance, mm, of each node from what it may touch.
    pub fn distances(&self) -> BTreeMap<(PairKind, usize), f64> {
        let mut least = BTreeMap::new();
        for (pair, &d) in self.pairs.iter().zip(&self.distance_mm) {
            let known = least.entry((pair.kind, pair.node)).or_insert(d);
            *known = f64::min(*known, d);
        }
        least
    }
}

impl ContactSearch {
    /// The search on `face` within `reach`.
    pub fn new(face: &Face, reach: ContactReach) -> Self {
        let kind = |upper| if upper { PairKind::UpperTeeth } else { PairKind::LowerTeeth };
        let arches = [true, false]
            .into_iter()
            .flat_map(|upper| face.teeth.iter().enumerate().filter(move |(_, t)| t.upper == upper));
        let fixed: BTreeSet<usize> = face.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        let facets = Facets::of(&face.mesh);
        let mirror = MirrorImage::of(face, &facets, &fixed);
        let mut search = Self {
            reach,
            teeth: arches.map(|(k, t)| (kind(t.upper), k, Solid::new(&t.surface))).collect(),
            lips: Lip::both(&face.mesh, &facets, &face.upper_lip, &face.lower_lip),
            facets,
            mucosa: face.mucosa.iter().filter(|node| !fixed.contains(node)).copied().collect(),
            fixed,
            mirror,
            rest: Vec::new(),
        };
        search.rest = search.pairs_on(face, &face.mesh, &Pose::rest(), None);
        if let Some(mirror) = &search.mirror {
            search.rest = mirror.of_one_side(search.rest);
        }
        search
    }

    /// The candidates at rest: mucosa nodes against the upper then the lower arch, upper against lower lip.
    /// Nodes fixed to bone have none.
    pub fn rest(&self) -> &[Pair] {
        &self.rest
    }

    /// The nodes (0-based, ascending) that may touch something or be touched.
    pub fn nodes(&self) -> Vec<usize> {
        let all = self.mucosa.iter().copied().chain(self.lips.iter().flat_map(Lip::touched));
        all.filter(|node| !self.fixed.contains(node)).collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// The displacement `u` (3n, mm), made exactly symmetric where `face` and its teeth at `pose` are and `u` nearly is:
    /// where contact is to be linearised.
    pub(crate) fn evened_out<'u>(&self, face: &Face, u: &'u [f64], pose: &Pose) -> Cow<'u, [f64]> {
        let even = self.mirror.as_ref().and_then(|mirror| mirror.evened_out(face, u, pose));
        even.map_or(Cow::Borrowed(u), Cow::Owned)
    }

    /// The candidates where the tissue has moved by `u` (3n, node-major xyz, mm) and the teeth with their bones by
    /// `pose`. On a face that is its own mirror image to the bit a displacement that is so to 1e-4 mm is taken to be it
    /// exactly, and so are its pairs.
    pub fn at(&self, face: &Face, u: &[f64], pose: &Pose) -> TouchedSurfaces {
        let even = self.mirror.as_ref().and_then(|mirror| Some((mirror, mirror.evened_out(face, u, pose)?)));
        let u = even.as_ref().map_or(u, |(_, even)| even);
        let mut moved = face.mesh.clone();
        for (point, by) in moved.points.iter_mut().zip(u.chunks_exact(3)) {
            *point += Vec3::new(by[0], by[1], by[2]);
        }
        let forgiven: BTreeMap<(PairKind, usize), f64> =
            self.rest.iter().map(|pair| ((pair.kind, pair.node), pair.rest_overlap_mm)).collect();
        let mut pairs = self.pairs_on(face, &moved, pose, Some(NEAR_MM));
        if let Some((mirror, _)) = even {
            pairs = mirror.of_one_side(pairs);
        }
        let by_teeth = face.tooth_changes(&pairs, pose);
        let mut distance_mm = Vec::with_capacity(pairs.len());
        for (pair, by_tooth) in pairs.iter_mut().zip(by_teeth) {
            let overlap = forgiven.get(&(pair.kind, pair.node)).copied().unwrap_or(0.);
            let distance = pair.gap_mm - pair.rest_overlap_mm + overlap;
            distance_mm.push(distance);
            pair.rest_overlap_mm = overlap;
            pair.gap_mm = distance - pair.change_mm(u) - by_tooth;
        }
        TouchedSurfaces { pairs, distance_mm }
    }

    /// The pairs on the moved `mesh` of `face` with its teeth at `pose`, of nodes near a tooth with every plane
    /// within `near_mm`. Teeth are met where they rest: the nodes are brought there.
    fn pairs_on(&self, face: &Face, mesh: &Mesh, pose: &Pose, near_mm: Option<f64>) -> Vec<Pair> {
        let normals = self.facets.node_normals(mesh);
        let mut pairs = Vec::new();
        for (kind, surface, solid) in &self.teeth {
            let motion = pose.motion(face, &face.teeth[*surface].bone);
            let (mut points, mut facing) = (Cow::Borrowed(&mesh.points), Cow::Borrowed(&normals));
            if !motion.is_rest() {
                for &node in &self.mucosa {
                    points.to_mut()[node] = motion.origin_of(mesh.points[node]);
                }
                facing = Cow::Owned(normals.iter().map(|(&k, n)| (k, motion.turned_back(*n))).collect());
            }
            let (nodes, far) = (&self.mucosa, self.reach.teeth_mm);
            let mut found = match near_mm {
                None => teeth_pairs(*kind, *surface, solid, &points, nodes, &facing, far),
                Some(near) => teeth_planes(*kind, *surface, solid, &points, nodes, &facing, [far, near]),
            };
            if !motion.is_rest() {
                found.iter_mut().flat_map(|pair| &mut pair.row).for_each(|(_, n)| *n = motion.turned(*n));
            }
            pairs.extend(found);
        }
        let lips = lip_pairs(mesh, &self.facets, &self.lips, self.reach.lips_mm, near_mm);
        pairs.extend(lips.into_iter().filter(|pair| !self.fixed.contains(&pair.node)));
        pairs
    }
}

impl Face {
    /// The contact candidates within `reach`: mucosa nodes against the upper then the lower arch,
    /// upper against lower lip. Nodes fixed to bone have none.
    pub fn contact_pairs(&self, reach: ContactReach) -> Vec<Pair> {
        ContactSearch::new(self, reach).rest
    }

    /// [`ContactSearch::at`], for one displacement only.
    pub fn contact_pairs_at(&self, reach: ContactReach, u: &[f64], pose: &Pose) -> TouchedSurfaces {
        ContactSearch::new(self, reach).at(self, u, pose)
    }

    /// How far the mucosa overlaps the teeth at rest: for each node the deeper of the two arches.
    pub fn rest_overlap(&self) -> RestOverlap {
        let solids: Vec<Solid> = self.teeth.iter().map(|t| Solid::new(&t.surface)).collect();
        let depth = |node: &usize| {
            let of = |solid: &Solid| solid.project(self.mesh.points[*node]).map(|p| -p.distance_mm);
            solids.iter().filter_map(of).fold(0f64, f64::max)
        };
        let mut depths: Vec<f64> = self.mucosa.iter().map(depth).filter(|d| *d > 0.).collect();
        depths.sort_by(f64::total_cmp);
        let n = depths.len();
        let middle = |k: usize| depths.get(k).copied().unwrap_or(0.);
        RestOverlap {
            nodes: self.mucosa.len(),
            inside: n,
            median_mm: (middle(n / 2) + middle(n.saturating_sub(1) / 2)) / 2.,
            deepest_mm: depths.last().copied().unwrap_or(0.),
        }
    }
}
