//! Bones of the patient, onto which the tissue that belongs there is brought.

use std::collections::BTreeMap;

use super::correspondence::inner_nodes;
use super::sheet::{Foot, Sheet};
use super::tissue::Spring;
use super::{RegistrationError, RegistrationWarning};
use crate::contact::Facets;
use crate::face::Face;
use crate::mesh::Surface;
use crate::units::Vec3;

/// How far bone may be from the tissue that belongs on it, mm.
const REACH_MM: f64 = 12.;
/// Share of a bone's nodes that must find it, and below which that is told.
const NEEDED: f64 = 0.1;
const TOLD: f64 = 0.7;

/// The bones that were given, each with the side outward on which the tissue lies.
pub(super) struct Bones {
    all: Vec<(String, Sheet)>,
}

/// The inside of a face as it comes to lie: unit normals out of the tissue, and areas (mm²), by node.
struct Inside {
    normals: BTreeMap<usize, Vec3>,
    areas: BTreeMap<usize, f64>,
}

impl Inside {
    fn of(face: &Face, x: &[Vec3]) -> Self {
        let mut mesh = face.mesh.clone();
        mesh.points = x.to_vec();
        let facets = Facets::of(&mesh).within(&inner_nodes(face));
        Self {
            normals: facets.node_normals(&mesh).into_iter().collect(),
            areas: facets.node_areas(&mesh).into_iter().collect(),
        }
    }

    /// The nodes of `face` that rest on the bone `name`, at `x` (n, mm), and the point of `sheet` that is nearest to each and
    /// faces the tissue; `None` where there is none within reach.
    fn feet(&self, face: &Face, x: &[Vec3], name: &str, sheet: &Sheet) -> Vec<(usize, Option<Foot>)> {
        let supports = face.supports.iter().filter(|support| support.bone == name);
        let foot = |&node: &usize| {
            let normal = self.normals.get(&node)?;
            let foot = sheet.nearest(x[node], Some(-normal), REACH_MM).filter(|foot| !foot.is_rim);
            Some((node, foot))
        };
        supports.flat_map(|support| &support.nodes).filter_map(foot).collect()
    }
}

impl Bones {
    /// `given` in the frame of `face`, each turned so that the tissue finds more of it.
    pub(super) fn new(
        given: impl Iterator<Item = (String, Surface)>,
        face: &Face,
        warnings: &mut Vec<RegistrationWarning>,
    ) -> Self {
        let x = &face.mesh.points;
        let inside = Inside::of(face, x);
        let facing = |(name, surface): (String, Surface)| {
            let turned = Sheet::new(Surface {
                points: surface.points.clone(),
                triangles: surface.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
            });
            let sheet = Sheet::new(surface);
            let found = |sheet: &Sheet| {
                inside.feet(face, x, &name, sheet).iter().filter(|(_, foot)| foot.is_some()).count()
            };
            if found(&turned) > found(&sheet) {
                warnings.push(RegistrationWarning::BoneInsideOut { bone: name.clone() });
                return (name, turned);
            }
            (name, sheet)
        };
        Self { all: given.map(facing).collect() }
    }

    /// Nodes of `face`, at `x` (n, mm), that the bones hold, ascending, and the springs that do, `stiffness` in N/mm³.
    pub(super) fn springs(&self, face: &Face, x: &[Vec3], stiffness: f64) -> (Vec<usize>, Vec<Spring>) {
        let (mut nodes, mut springs) = (Vec::new(), Vec::new());
        if self.all.is_empty() {
            return (nodes, springs);
        }
        let inside = Inside::of(face, x);
        for (name, sheet) in &self.all {
            for (node, foot) in inside.feet(face, x, name, sheet) {
                let (Some(foot), Some(area)) = (foot, inside.areas.get(&node)) else { continue };
                nodes.push(node);
                springs.push(Spring::sliding(vec![(node, 1.)], foot.point, foot.normal, stiffness * area));
            }
        }
        nodes.sort_unstable();
        (nodes, springs)
    }

    /// Tells which bones the tissue of `face` has not found where it came to lie, at `x` (n, mm).
    ///
    /// # Errors
    /// [`RegistrationError::BoneAway`] for one of which it found next to nothing.
    pub(super) fn tell(
        &self,
        face: &Face,
        x: &[Vec3],
        warnings: &mut Vec<RegistrationWarning>,
    ) -> Result<(), RegistrationError> {
        let inside = Inside::of(face, x);
        for (name, sheet) in &self.all {
            let feet = inside.feet(face, x, name, sheet);
            let held =
                feet.iter().filter(|(_, foot)| foot.is_some()).count() as f64 / feet.len().max(1) as f64;
            if held < NEEDED {
                return Err(RegistrationError::BoneAway { bone: name.clone(), held, reach_mm: REACH_MM });
            }
            if held < TOLD {
                warnings.push(RegistrationWarning::BonePartly { bone: name.clone(), held });
            }
        }
        Ok(())
    }
}
