//! Which muscle each cell belongs to, for pictures.

use std::collections::BTreeMap;

use super::muscle_tissue::{MuscleAt, muscle_at};
use crate::face::Face;
use crate::units::Vec3;

/// Reference coordinate of the two-point Gauss rule, as a share of the way from centre to corner.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// The muscle (0-based) that most of each cell's tissue belongs to, or `None` where most of it is
/// passive and no muscle has two points or more (e cells).
///
/// Materials are decided at integration points; this is their summary by cell.
pub fn cell_muscles(face: &Face) -> Vec<Option<usize>> {
    let mut samples = Vec::new();
    let mut starts = vec![0];
    for cell in &face.mesh.cells {
        let kind = cell.kind();
        for corner in &kind.node_positions()[..kind.n_corners()] {
            let xi = kind.centre() + GAUSS * (Vec3::from(*corner) - kind.centre());
            let weights = kind.shape(xi);
            samples
                .push(cell.nodes().iter().zip(weights).map(|(&i, w)| w * face.mesh.points[i]).sum::<Vec3>());
        }
        starts.push(samples.len());
    }
    let found = muscle_at(&samples, &face.muscles);
    starts.windows(2).map(|range| most(&found[range[0]..range[1]])).collect()
}

fn most(found: &[MuscleAt]) -> Option<usize> {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for own in found.iter().flatten() {
        *counts.entry(own.muscle).or_default() += 1;
    }
    let (&muscle, &count) = counts.iter().rev().max_by_key(|(_, count)| **count)?;
    let passive = found.len() - counts.values().sum::<usize>();
    (count >= 2 || count > passive).then_some(muscle)
}
