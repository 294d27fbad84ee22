//! How far the surfaces of a face pass into each other, by geometry that contact does not use.

mod facet_sites;
mod search;
mod tooth_solid;

pub use search::OverlapSearch;

use super::{Face, Pose};
use crate::units::Vec3;

/// A sample of one surface that lies inside what another one bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Inside {
    /// Where it is, mm.
    pub at: Vec3,
    /// Distance to the surface that it passed, mm.
    pub depth_mm: f64,
    /// The depth of the same sample at rest, mm: data that overlap there.
    pub at_rest_mm: f64,
    /// The nodes (0-based) that carry a sample of tissue; those of the cell that holds a sample of a tooth.
    pub nodes: Vec<usize>,
    /// Whether one of these nodes is fixed to bone: there the tissue runs onto the bone that carries the roots of the
    /// teeth.
    pub hangs_on_bone: bool,
    /// Which of the face's tooth surfaces, from 0; `None` for tissue in tissue.
    pub tooth: Option<usize>,
    /// The nearest of the face's landmarks.
    pub landmark: Option<usize>,
}

impl Inside {
    /// How much deeper it is than at rest, mm.
    pub fn beyond_rest_mm(&self) -> f64 {
        (self.depth_mm - self.at_rest_mm).max(0.)
    }
}

/// How far the surfaces of a face pass into each other: every sample that lies inside, rest overlap included.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlap {
    /// Samples of mucosa, lips and the outside about them that lie inside a tooth.
    pub teeth: Vec<Inside>,
    /// Vertices and samples of the edges of teeth that lie inside the tissue.
    pub tooth_edges: Vec<Inside>,
    /// Samples of mucosa, lips and the outside about them that lie inside other tissue: lip in lip, cheek in
    /// cheek.
    pub tissue: Vec<Inside>,
}

impl Overlap {
    /// Deepest sample of tissue inside a tooth, mm.
    pub fn teeth_mm(&self) -> f64 {
        depth_mm(&self.teeth)
    }

    /// Deepest sample of a tooth inside tissue, mm.
    pub fn tooth_edges_mm(&self) -> f64 {
        depth_mm(&self.tooth_edges)
    }

    /// Deepest sample of tissue inside other tissue, mm.
    pub fn tissue_mm(&self) -> f64 {
        depth_mm(&self.tissue)
    }

    /// Every sample that lies inside something.
    pub fn all(&self) -> impl Iterator<Item = &Inside> {
        self.teeth.iter().chain(&self.tooth_edges).chain(&self.tissue)
    }

    /// The deepest sample, the first of several.
    pub fn deepest(&self) -> Option<&Inside> {
        greatest(self.all(), |inside| inside.depth_mm)
    }

    /// Greatest depth, mm, 0 where the surfaces are apart.
    pub fn deepest_mm(&self) -> f64 {
        self.deepest().map_or(0., |inside| inside.depth_mm)
    }

    /// The sample that went deepest from where it was at rest.
    pub fn deepest_beyond_rest(&self) -> Option<&Inside> {
        greatest(self.all(), Inside::beyond_rest_mm)
    }

    /// The sample off bone that is deepest beyond its depth at rest: what contact has to answer for.
    pub fn deepest_off_bone(&self) -> Option<&Inside> {
        greatest(self.all().filter(|inside| !inside.hangs_on_bone), Inside::beyond_rest_mm)
    }

    /// Greatest increase of a depth off bone since rest, mm.
    pub fn off_bone_mm(&self) -> f64 {
        self.deepest_off_bone().map_or(0., Inside::beyond_rest_mm)
    }

    /// Greatest increase of a depth since rest, mm.
    pub fn beyond_rest_mm(&self) -> f64 {
        self.deepest_beyond_rest().map_or(0., Inside::beyond_rest_mm)
    }
}

fn depth_mm(samples: &[Inside]) -> f64 {
    samples.iter().fold(0., |deepest, inside| deepest.max(inside.depth_mm))
}

fn greatest<'a>(
    samples: impl Iterator<Item = &'a Inside>,
    size: impl Fn(&Inside) -> f64,
) -> Option<&'a Inside> {
    samples.reduce(|best, next| if size(next) > size(best) { next } else { best })
}

/// How far the surfaces of `face` pass into each other where its tissue moved by `u` (3n, node-major xyz, mm) and its
/// teeth with their bones by `pose`. For one displacement only; [`OverlapSearch`] serves several.
///
/// # Panics
/// If `u` is shorter than 3n.
pub fn overlap(face: &Face, u: &[f64], pose: &Pose) -> Overlap {
    OverlapSearch::new(face).at(face, u, pose)
}
