//! Element by element to the global stiffness.

use nalgebra::Matrix6;
use rayon::prelude::*;

use super::elasticity::isotropic;
use super::muscle_law::tensors;
use super::muscle_tissue::{MuscleAt, muscle_at};
use super::{Element, ElementStiffness, ForwardError, Stiffness};
use crate::face::{Muscle, MuscleTissue, Tissue};
use crate::mesh::{DilatationPatches, Mesh};
use crate::units::N_PER_MM2_PER_KPA;

/// Elements whose matrices are computed in parallel before they are added in order: the sum does not
/// depend on the number of threads, and memory stays bounded.
const BATCH: usize = 4096;

struct PatchStiffness {
    base: ElementStiffness,
    parts: Vec<(usize, ElementStiffness)>,
}

/// The stiffness of the whole mesh, and for each muscle the volume (mm³) of the tissue that was found
/// within it.
///
/// `K0` is all tissue at rest; muscle `m` has one part for each tensor whose coefficient its law changes,
/// in the order of the muscles. A point within a muscle of known cross-section is a mixture: muscle in the
/// volume fraction `min(1, area x length / volume found)`, passive tissue for the rest, so that the
/// muscle's `E A` does not depend on how much tissue the mesh puts within its radius.
///
/// # Errors
/// [`ForwardError::InvertedCell`], [`ForwardError::EmptyMuscle`].
pub fn assemble(
    mesh: &Mesh,
    tissue: Tissue,
    muscle_tissue: MuscleTissue,
    muscles: &[Muscle],
) -> Result<(Stiffness, Vec<f64>), ForwardError> {
    let patches = DilatationPatches::new(mesh);
    let elements: Vec<(Element, Vec<usize>)> = (0..patches.len())
        .into_par_iter()
        .map(|patch| Element::of_patch(mesh, &patches, patch))
        .collect::<Result<_, _>>()?;
    let positions: Vec<_> =
        elements.iter().flat_map(|(e, _)| e.points().iter().map(|p| p.position)).collect();
    let at = muscle_at(&positions, muscles);
    let after =
        |next: &mut usize, (e, _): &(Element, _)| Some(std::mem::replace(next, *next + e.points().len()));
    let starts: Vec<usize> = elements.iter().scan(0, after).collect();

    let mut volumes = vec![0.; muscles.len()];
    for ((element, _), &start) in elements.iter().zip(&starts) {
        for (q, point) in element.points().iter().enumerate() {
            if let Some(own) = at[start + q] {
                volumes[own.muscle] += point.volume;
            }
        }
    }
    if let Some(empty) = volumes.iter().position(|&v| v == 0.) {
        let Muscle { name, radius_mm, .. } = &muscles[empty];
        return Err(ForwardError::EmptyMuscle { muscle: name.clone(), radius_mm: *radius_mm });
    }

    // Where more tissue was found than the muscle has, each point is muscle in part.
    let fraction: Vec<f64> = muscles
        .iter()
        .zip(&volumes)
        .map(|(m, found)| m.volume_mm3().map_or(1., |v| (v / found).min(1.)))
        .collect();

    let passive = isotropic(tissue.young_kpa * N_PER_MM2_PER_KPA, tissue.poisson);
    let rest = isotropic(muscle_tissue.rest_kpa * N_PER_MM2_PER_KPA, muscle_tissue.poisson);
    let active = muscle_tissue.active_tensors();
    let patch_stiffness = |index: usize| {
        let element = &elements[index].0;
        let own: &[MuscleAt] = &at[starts[index]..starts[index] + element.points().len()];
        let base = element.stiffness(|q| match own[q] {
            Some(own) => passive + fraction[own.muscle] * (rest - passive),
            None => passive,
        });
        let mut present: Vec<usize> = own.iter().flatten().map(|own| own.muscle).collect();
        present.sort_unstable();
        present.dedup();
        let part = |muscle: usize, tensor: usize| {
            element.stiffness(|q| match own[q] {
                Some(own) if own.muscle == muscle => fraction[muscle] * tensors(own.direction)[tensor],
                _ => Matrix6::zeros(),
            })
        };
        let parts = present.into_iter().flat_map(|muscle| {
            let first = muscle * active.len();
            active.iter().enumerate().map(move |(k, &tensor)| (first + k, part(muscle, tensor)))
        });
        PatchStiffness { base, parts: parts.collect() }
    };

    let joined = elements.iter().map(|(_, nodes)| nodes.as_slice());
    let mut stiffness = Stiffness::new(mesh.n_nodes(), joined, muscles.len() * active.len());
    for first in (0..elements.len()).step_by(BATCH) {
        let batch = first..elements.len().min(first + BATCH);
        let computed: Vec<PatchStiffness> = batch.clone().into_par_iter().map(patch_stiffness).collect();
        for (index, patch) in batch.zip(computed) {
            let nodes = &elements[index].1;
            stiffness.add_base(nodes, &patch.base);
            for (part, k) in &patch.parts {
                stiffness.add_part(*part, nodes, k);
            }
        }
    }
    stiffness.finish();
    Ok((stiffness, volumes))
}
