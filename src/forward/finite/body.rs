//! The whole tissue as patches.

use rayon::prelude::*;

use super::material::{PointFibre, PointMaterial};
use super::patch::{Patch, PatchPoint};
use crate::face::{Face, Muscle};
use crate::forward::muscle_tissue::{InMuscle, MuscleAt, muscle_at};
use crate::forward::stiffness::Pattern;
use crate::forward::{Element, ForwardError, IntegrationPoint};
use crate::mesh::{CellKind, DilatationPatches, Mesh, corner_neighbours};
use crate::units::{N_PER_MM2_PER_KPA, Vec3};

/// Patches whose derivatives are computed in parallel before they are added in order: sums do not depend on the
/// number of threads, and memory stays bounded.
const BATCH: usize = 1024;

/// The tissue of a face: patches that share nodes, their material decided point by point.
#[derive(Clone, Debug)]
pub struct FiniteBody {
    patches: Vec<Patch>,
    n_nodes: usize,
    n_muscles: usize,
}

impl FiniteBody {
    /// The body of `mesh`, `material(q)` being what its integration point `q` is made of, in the order of its
    /// [dilatation patches](DilatationPatches) and of the [points](Element::points) of each.
    ///
    /// # Errors
    /// [`ForwardError::InvertedCell`].
    pub fn new(
        mesh: &Mesh,
        n_muscles: usize,
        material: impl Fn(usize) -> PointMaterial,
    ) -> Result<Self, ForwardError> {
        let mut patches = Vec::new();
        let mut next = 0;
        for Part { element, nodes, corners } in parts(mesh)? {
            let point = |(q, point): (usize, &IntegrationPoint)| PatchPoint {
                volume: point.volume,
                gradients: point.gradients().to_vec(),
                material: material(next + q),
            };
            let points: Vec<PatchPoint> = element.points().iter().enumerate().map(point).collect();
            next += points.len();
            let stiffness = points.iter().map(|p| p.volume * p.material.shear).sum();
            let mut own: Vec<Patch> = match element.shares_dilatation() {
                true => vec![Patch::new(nodes, points)],
                false => points.into_iter().map(|point| Patch::new(nodes.clone(), vec![point])).collect(),
            };
            if let Some(last) = own.last_mut() {
                // Of the whole cell, though each point of a quadratic tetrahedron is a patch.
                let gradients: Vec<&[Vec3]> = corners.iter().map(IntegrationPoint::gradients).collect();
                last.keep_upright(&gradients, stiffness);
            }
            patches.append(&mut own);
        }
        Ok(Self { patches, n_nodes: mesh.n_nodes(), n_muscles })
    }

    /// The body of `mesh` in which each corner of a hexahedron or wedge is a tetrahedron of its own, of one `material`
    /// without fibres: its energy grows without bound as any corner is folded flat, not only as a material point is. What
    /// is folded at rest is left out.
    pub fn of_corners(mesh: &Mesh, material: PointMaterial) -> Self {
        let mut patches = Vec::new();
        for cell in &mesh.cells {
            let pieces: Vec<(CellKind, Vec<usize>)> = match cell.kind() {
                kind @ (CellKind::Hex8 | CellKind::Wedge6) => corner_neighbours(kind)
                    .iter()
                    .map(|corner| (CellKind::Tet4, corner.map(|k| cell.nodes()[k]).to_vec()))
                    .collect(),
                kind => vec![(kind, cell.nodes().to_vec())],
            };
            for (kind, nodes) in pieces {
                let at: Vec<Vec3> = nodes.iter().map(|&node| mesh.points[node]).collect();
                let points = Element::new(kind, &at).map(|element| element.points().to_vec());
                patches.extend(points.into_iter().flatten().map(|point| {
                    let (volume, gradients) = (point.volume, point.gradients().to_vec());
                    Patch::new(nodes.clone(), vec![PatchPoint { volume, gradients, material }])
                }));
            }
        }
        Self { patches, n_nodes: mesh.n_nodes(), n_muscles: 0 }
    }

    /// The body of `face`.
    ///
    /// A point within a muscle of known cross-section is a mixture, as in [`assemble`](crate::forward::assemble). The
    /// contractile stress of a muscle falls along the insertion like the tension of its fibres, and its integral over
    /// the tissue is that of the tension over the lengths of the fibres, whatever the tissue found within its radius.
    ///
    /// # Errors
    /// [`ForwardError::InvertedCell`], [`ForwardError::EmptyMuscle`].
    pub fn of_face(face: &Face) -> Result<Self, ForwardError> {
        let parts = parts(&face.mesh)?;
        let points = || parts.iter().flat_map(|part| part.element.points());
        let positions: Vec<Vec3> = points().map(|p| p.position).collect();
        let volumes: Vec<f64> = points().map(|p| p.volume).collect();
        let at = muscle_at(&positions, &face.muscles);
        let muscles = face
            .muscles
            .iter()
            .enumerate()
            .map(|(index, muscle)| MuscleInTissue::new(index, muscle, &at, &volumes))
            .collect::<Result<Vec<_>, _>>()?;
        Self::new(&face.mesh, muscles.len(), |q| material(face, &muscles, at[q].as_ref()))
    }

    /// The patches.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// Number of muscles.
    pub fn n_muscles(&self) -> usize {
        self.n_muscles
    }

    /// Whether no point is inside out with the nodes at `x` (n, mm).
    pub fn is_upright(&self, x: &[Vec3]) -> bool {
        self.patches.par_iter().all(|patch| patch.is_upright(&at_nodes(patch, x)))
    }

    /// `Pi`, N mm, without contact, with the nodes at `x` (n, mm) under the activations `a` (m); `None` where a point
    /// is inside out.
    pub fn energy(&self, x: &[Vec3], a: &[f64]) -> Option<f64> {
        let energies: Option<Vec<f64>> =
            self.patches.par_iter().map(|patch| patch.energy(&at_nodes(patch, x), a)).collect();
        Some(energies?.iter().sum())
    }

    /// The gradient of `Pi_0` (n, N) and those of each `Pi_m` (m x n, N), with the nodes at `x` (n, mm); `None` where a
    /// point is inside out.
    pub fn forces(&self, x: &[Vec3]) -> Option<(Vec<Vec3>, Vec<Vec<Vec3>>)> {
        let mut passive = vec![Vec3::zeros(); self.n_nodes];
        let mut active = vec![vec![Vec3::zeros(); self.n_nodes]; self.n_muscles];
        for batch in self.patches.chunks(BATCH) {
            let computed: Option<Vec<_>> =
                batch.par_iter().map(|patch| patch.forces(&at_nodes(patch, x))).collect();
            for (patch, (own, muscles)) in batch.iter().zip(computed?) {
                add(&mut passive, patch.nodes(), &own);
                for (muscle, forces) in muscles {
                    add(&mut active[muscle], patch.nodes(), &forces);
                }
            }
        }
        Some((passive, active))
    }

    /// The gradient of `Pi` (n, N), its Hessian being added to `values` on `pattern` (N/mm), with the nodes at `x`
    /// (n, mm) under the activations `a` (m); `None` where a point is inside out.
    pub fn derivatives(
        &self,
        x: &[Vec3],
        a: &[f64],
        pattern: &Pattern,
        values: &mut [f64],
    ) -> Option<Vec<Vec3>> {
        let mut gradient = vec![Vec3::zeros(); self.n_nodes];
        for batch in self.patches.chunks(BATCH) {
            let computed: Option<Vec<_>> =
                batch.par_iter().map(|patch| patch.derivatives(&at_nodes(patch, x), a)).collect();
            for (patch, own) in batch.iter().zip(computed?) {
                add(&mut gradient, patch.nodes(), &own.gradient);
                pattern.scatter(patch.nodes(), &own.hessian, |at, value| values[at] += value);
            }
        }
        Some(gradient)
    }
}

/// A dilatation patch of a mesh.
struct Part {
    element: Element,
    /// Its nodes (0-based).
    nodes: Vec<usize>,
    /// The points at the nodes of its cell, where that can fold between its points of integration.
    corners: Vec<IntegrationPoint>,
}

/// The dilatation patches of `mesh`, in order.
fn parts(mesh: &Mesh) -> Result<Vec<Part>, ForwardError> {
    let patches = DilatationPatches::new(mesh);
    let of = |patch: usize| {
        let (element, nodes) = Element::of_patch(mesh, &patches, patch)?;
        let corners = match patches.cells()[patch][..] {
            [cell] if mesh.cells[cell].kind() != CellKind::Tet4 => IntegrationPoint::at_nodes(
                mesh.cells[cell].kind(),
                &mesh.cell_points(cell).collect::<Vec<_>>(),
            ),
            _ => Vec::new(),
        };
        Ok(Part { element, nodes, corners })
    };
    (0..patches.len()).into_par_iter().map(of).collect()
}

/// A muscle as the tissue's points hold it.
struct MuscleInTissue {
    /// Share of muscle in the tissue within its radius.
    fraction: f64,
    /// Contractile stress per unit share of tension, N/mm².
    stress: f64,
}

impl MuscleInTissue {
    fn new(index: usize, muscle: &Muscle, at: &[MuscleAt], volumes: &[f64]) -> Result<Self, ForwardError> {
        let own = || at.iter().zip(volumes).filter_map(|(at, v)| Some((at.as_ref()?, v)));
        let (mut found, mut shared) = (0., 0.);
        for (at, volume) in own().filter(|(at, _)| at.muscle == index) {
            found += volume;
            shared += volume * at.share;
        }
        if found == 0. {
            let Muscle { name, radius_mm, .. } = muscle;
            return Err(ForwardError::EmptyMuscle { muscle: name.clone(), radius_mm: *radius_mm });
        }
        let fraction = muscle.volume_mm3().map_or(1., |volume| (volume / found).min(1.));
        let stress = if shared > 0. { muscle.tension_moment() / shared } else { 0. };
        Ok(Self { fraction, stress })
    }
}

fn material(face: &Face, muscles: &[MuscleInTissue], at: Option<&InMuscle>) -> PointMaterial {
    let tissue = &face.tissue;
    let shear = |young: f64, poisson: f64| young * N_PER_MM2_PER_KPA / (2. * (1. + poisson));
    let bulk = |young: f64, poisson: f64| young * N_PER_MM2_PER_KPA / (3. * (1. - 2. * poisson));
    let mut material = PointMaterial {
        shear: shear(tissue.young_kpa, tissue.poisson),
        strain_stiffening: tissue.strain_stiffening,
        bulk: bulk(tissue.young_kpa, tissue.poisson),
        fibre: None,
    };
    let Some(at) = at else { return material };
    let (own, muscle) = (&face.muscle_tissue, &muscles[at.muscle]);
    let mixed = |passive: f64, own: f64| passive + muscle.fraction * (own - passive);
    material.shear = mixed(material.shear, shear(own.rest_kpa, own.poisson));
    material.bulk = mixed(material.bulk, bulk(own.rest_kpa, own.poisson));
    material.fibre = Some(PointFibre {
        muscle: at.muscle,
        direction: at.direction,
        stiffening: muscle.fraction * (own.active_kpa - own.rest_kpa) * N_PER_MM2_PER_KPA,
        tension: muscle.stress * at.share,
    });
    material
}

fn at_nodes(patch: &Patch, x: &[Vec3]) -> Vec<Vec3> {
    patch.nodes().iter().map(|&node| x[node]).collect()
}

fn add(total: &mut [Vec3], nodes: &[usize], forces: &[Vec3]) {
    for (&node, force) in nodes.iter().zip(forces) {
        total[node] += force;
    }
}
