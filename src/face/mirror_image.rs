//! Contact on a face that is its own mirror image.

use std::collections::{BTreeSet, HashMap};

use super::{Face, Pose, Teeth};
use crate::contact::{Facets, Pair, ToothPoint};
use crate::units::Vec3;

/// How far the two sides of a moved face may be from mirror images, mm, for contact to be linearised where they are:
/// a hundredth of the overlap that counts as none.
const EVEN_MM: f64 = 1e-4;
/// Difference of two pairs, mm and as a share of a normal, that rounding explains.
const SAME: f64 = 1e-9;

/// Which part of a face is the mirror image, in the mid-sagittal plane `x = 0`, of which.
///
/// Where contact surfaces meet at an edge or a corner, rounding decides which of two equally near facets a search
/// finds first. A face that is symmetric to the bit, moved symmetrically, gets here the pairs of one side and their
/// mirror images, so that what touches is symmetric too.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MirrorImage {
    /// The other node of each node (n, 0-based); of one in the plane itself.
    nodes: Vec<usize>,
    /// The other surface of each tooth surface (0-based).
    teeth: Vec<usize>,
}

/// A point by the exact bits of its coordinates, both zeros being one.
type Bits = [u64; 3];

fn bits(p: Vec3) -> Bits {
    [p.x, p.y, p.z].map(|c| (c + 0.).to_bits())
}

/// The mirror image of a point or a displacement in the mid-sagittal plane `x = 0`.
pub(super) fn mirrored(p: Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

impl MirrorImage {
    /// That of `face`, whose outside is `facets` and whose nodes `fixed` (0-based) are held; `None` unless all that may
    /// touch is its own mirror image.
    pub(super) fn of(face: &Face, facets: &Facets, fixed: &BTreeSet<usize>) -> Option<Self> {
        let points = &face.mesh.points;
        let known: HashMap<Bits, usize> = points.iter().enumerate().map(|(k, p)| (bits(*p), k)).collect();
        let partner = |p: &Vec3| known.get(&bits(mirrored(*p))).copied();
        let nodes: Vec<usize> = points.iter().map(partner).collect::<Option<_>>()?;
        // Nodes that share a place have no partner of their own.
        let is_mutual = nodes.iter().enumerate().all(|(node, &other)| nodes[other] == node);
        let is_own_image = |own: &BTreeSet<usize>| own.iter().all(|&node| own.contains(&nodes[node]));
        let lists = [&face.mucosa, &face.upper_lip, &face.lower_lip];
        let outside: BTreeSet<BTreeSet<usize>> =
            facets.corners().iter().map(|facet| facet.iter().copied().collect()).collect();
        let image = |facet: &BTreeSet<usize>| facet.iter().map(|&node| nodes[node]).collect::<BTreeSet<_>>();
        let is_mirrored = is_mutual
            && is_own_image(fixed)
            && lists.into_iter().all(|list| is_own_image(&list.iter().copied().collect()))
            && outside.iter().all(|facet| outside.contains(&image(facet)));
        let surfaces: Vec<[BTreeSet<[Bits; 3]>; 2]> = face.teeth.iter().map(with_image).collect();
        let other = |k: usize| {
            let is_other =
                |j: &usize| surfaces[*j][0] == surfaces[k][1] && face.teeth[*j].upper == face.teeth[k].upper;
            (0..surfaces.len()).find(is_other)
        };
        let teeth = (0..surfaces.len()).map(other).collect::<Option<_>>()?;
        is_mirrored.then_some(Self { nodes, teeth })
    }

    /// The displacement `u` (3n, mm) of `face`, its teeth at `pose`, made exactly its own mirror image; `None` unless it
    /// nearly is.
    pub(super) fn evened_out(&self, face: &Face, u: &[f64], pose: &Pose) -> Option<Vec<f64>> {
        let of = |node: usize| Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]);
        let apart = |(k, &other): (usize, &usize)| (of(k) - mirrored(of(other))).amax();
        let is_even = u.len() == 3 * self.nodes.len()
            && self.nodes.iter().enumerate().all(|pair| apart(pair) <= EVEN_MM)
            && self.keeps(face, pose);
        let mean = |(k, &other): (usize, &usize)| (0.5 * (of(k) + mirrored(of(other)))).data.0[0];
        is_even.then(|| self.nodes.iter().enumerate().flat_map(mean).collect())
    }

    /// Whether the teeth of `face` at `pose` are their own mirror image.
    fn keeps(&self, face: &Face, pose: &Pose) -> bool {
        face.teeth.iter().zip(&self.teeth).all(|(teeth, &other)| {
            let [own, image] = [teeth, &face.teeth[other]].map(|t| pose.motion(face, &t.bone));
            let apart = |p: &Vec3| image.apply(mirrored(*p)) - mirrored(own.apply(*p));
            teeth.surface.points.iter().all(|p| apart(p).amax() <= SAME)
        })
    }

    /// The pairs of `found` whose node is on one side or in the middle, and their mirror images.
    pub(super) fn of_one_side(&self, found: Vec<Pair>) -> Vec<Pair> {
        let mut pairs: Vec<Pair> = Vec::with_capacity(found.len());
        let mut middle = 0..0;
        for pair in found {
            let other = self.nodes[pair.node];
            if other < pair.node {
                continue;
            }
            let image = self.image(&pair);
            if other > pair.node {
                pairs.extend([pair, image]);
                continue;
            }
            if pairs.get(middle.start).is_none_or(|p| (p.kind, p.node) != (pair.kind, pair.node)) {
                middle = pairs.len()..pairs.len();
            }
            if pairs[middle.start..].iter().any(|known| is_same(known, &pair)) {
                continue;
            }
            if is_same(&pair, &image) {
                pairs.push(mean(pair, &image));
            } else {
                pairs.extend([pair, image]);
            }
        }
        pairs.sort_by_key(|pair| pair.kind);
        pairs
    }

    fn image(&self, pair: &Pair) -> Pair {
        let mut row: Vec<(usize, Vec3)> =
            pair.row.iter().map(|(k, g)| (self.nodes[*k], mirrored(*g))).collect();
        row.sort_by_key(|(node, _)| *node);
        let tooth = pair.tooth.map(|t| ToothPoint { surface: self.teeth[t.surface], at: mirrored(t.at) });
        Pair { node: self.nodes[pair.node], row, tooth, ..pair.clone() }
    }
}

/// The triangles of a tooth surface, outward oriented, and those of its mirror image.
fn with_image(teeth: &Teeth) -> [BTreeSet<[Bits; 3]>; 2] {
    let from_least = |t: [Bits; 3]| {
        let k = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
        [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]
    };
    let at = |k: usize| teeth.surface.points[k];
    let triangles = &teeth.surface.triangles;
    [
        triangles.iter().map(|t| from_least(t.map(|k| bits(at(k))))).collect(),
        triangles.iter().map(|&[a, b, c]| from_least([a, c, b].map(|k| bits(mirrored(at(k)))))).collect(),
    ]
}

/// Whether two pairs of one node keep it from the same.
fn is_same(a: &Pair, b: &Pair) -> bool {
    let rows = a.row.iter().zip(&b.row);
    a.row.len() == b.row.len()
        && (a.gap_mm - b.gap_mm).abs() <= SAME
        && rows.into_iter().all(|((k, g), (l, h))| k == l && (g - h).amax() <= SAME)
}

/// Two pairs that are the same to rounding, as one that is exactly its own mirror image.
fn mean(mut a: Pair, b: &Pair) -> Pair {
    for ((_, g), (_, h)) in a.row.iter_mut().zip(&b.row) {
        *g = 0.5 * (*g + h);
    }
    if let (Some(a), Some(b)) = (&mut a.tooth, &b.tooth) {
        a.at = 0.5 * (a.at + b.at);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::RigidMotion;
    use crate::face::standard::{Resolution, standard};

    fn image(face: &Face) -> Option<MirrorImage> {
        let fixed = face.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        MirrorImage::of(face, &Facets::of(&face.mesh), &fixed)
    }

    #[test]
    fn only_what_is_symmetric_to_the_bit_is_a_mirror_image() {
        let face = standard(&Resolution::COARSE);
        let nodes = image(&face).map(|image| image.nodes).unwrap_or_default();
        assert_eq!(nodes.len(), face.mesh.n_nodes());
        let refused = |change: &dyn Fn(&mut Face)| {
            let mut face = face.clone();
            change(&mut face);
            image(&face).is_none()
        };
        let aside = *face.mucosa.iter().find(|&&n| face.mesh.points[n].x > 1.).expect("a node aside");
        assert!(refused(&|face| face.mesh.points[aside].y += 1e-9));
        assert!(refused(&|face| face.mucosa.retain(|n| *n != aside)));
        assert!(refused(&|face| face.teeth[0].surface.points[0].x += 1e-9));
        assert!(refused(&|face| face.supports[0].nodes.retain(|n| face.mesh.points[*n].x <= 0.)));
        // Two nodes at one place, as where lips touch at rest.
        assert!(refused(&|face| {
            let (from, to) = (face.upper_lip[0], face.lower_lip[0]);
            for (from, to) in [(from, to), (nodes[from], nodes[to])] {
                face.mesh.points[from] = face.mesh.points[to];
            }
        }));
    }

    #[test]
    fn what_is_nearly_symmetric_is_made_so() -> Result<(), &'static str> {
        let face = standard(&Resolution::COARSE);
        let mirror = image(&face).ok_or("a mirror image")?;
        let rest = Pose::rest();
        let mut u: Vec<f64> = face.mesh.points.iter().flat_map(|p| [0.1 * p.x, p.x.abs(), p.z]).collect();
        assert_eq!(mirror.evened_out(&face, &u, &rest).ok_or("even")?, u);
        u[0] += 1e-5;
        let even = mirror.evened_out(&face, &u, &rest).ok_or("nearly even")?;
        assert_eq!(mirror.evened_out(&face, &even, &rest).ok_or("even")?, even);
        assert!(even.iter().zip(&u).all(|(even, u)| (even - u).abs() <= 0.5e-5 + 1e-15));
        let aside = rest.with(&face.teeth[1].bone, RigidMotion::translation(Vec3::new(1., 0., 0.)));
        assert!(mirror.evened_out(&face, &even, &aside).is_none());
        u[0] += 1e-3;
        assert!(mirror.evened_out(&face, &u, &Pose::rest()).is_none());
        Ok(())
    }
}
