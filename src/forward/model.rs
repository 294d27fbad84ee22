//! The forward model of a face: everything that does not depend on the activations.

use std::sync::Arc;

use super::assembly::assemble;
use super::fibre_force::fibre_forces;
use super::moved_bones::MovedBones;
use super::{Cholesky, FixedStiffness, ForwardError, SparseColumn, Stiffness, SymbolicFactor};
use crate::contact::Pair;
use crate::face::{Face, JawRange, Muscle, MuscleTissue, Pose};
use crate::mesh::{Locator, Mesh};

/// How far outside the mesh a fibre point may lie, mm, before it is refused: points that were
/// projected onto the skin or the bone are off it by rounding and by the curvature of a face.
const OUTSIDE_MM: f64 = 0.5;

/// The forward model `K_ff(a) u_f = F a + G' lambda - K_fb(a) u_b` of a face (DESIGN 3), with `u_b` the displacement
/// of the nodes on bones.
///
/// Shapes: `n` nodes, `m` muscles, `c` contact pairs.
#[derive(Clone, Debug)]
pub struct Model {
    face: Arc<Face>,
    muscles: Vec<String>,
    tissue: MuscleTissue,
    stiffness: Arc<Stiffness>,
    symbolic: Arc<SymbolicFactor>,
    loads: Arc<Vec<SparseColumn>>,
    pairs: Vec<Pair>,
    muscle_volumes: Vec<f64>,
}

impl Model {
    /// Assembles the stiffness and the muscle loads of `face`; `pairs` are the contact candidates,
    /// empty when contact is off.
    ///
    /// # Errors
    /// [`ForwardError`] for inverted cells, fibres outside the mesh, muscles without tissue and
    /// loaded nodes without cells.
    pub fn new(face: &Face, pairs: Vec<Pair>) -> Result<Self, ForwardError> {
        let mesh = &face.mesh;
        let (stiffness, muscle_volumes) = assemble(mesh, face.tissue, face.muscle_tissue, &face.muscles)?;
        let fixed = fixed_dofs(face);
        let symbolic = Arc::new(SymbolicFactor::new(stiffness.pattern(), &fixed)?);
        let locator = Locator::new(mesh);
        let loads = face.muscles.iter().map(|m| load(m, &locator)).collect::<Result<Vec<_>, _>>()?;
        check_loaded_nodes(mesh, &pairs)?;
        let muscles = face.muscles.iter().map(|m| m.name.clone()).collect();
        let (face, tissue) = (Arc::new(face.clone()), face.muscle_tissue);
        let (stiffness, loads) = (Arc::new(stiffness), Arc::new(loads));
        Ok(Self { face, muscles, tissue, stiffness, symbolic, loads, pairs, muscle_volumes })
    }

    /// This model with other contact candidates, on nodes of the same face: nothing is assembled again.
    #[must_use]
    pub fn with_pairs(&self, pairs: Vec<Pair>) -> Self {
        Self { pairs, ..self.clone() }
    }

    /// This model with another stiffness on the same pattern and other loads on the same muscles.
    #[must_use]
    pub(super) fn with_stiffness(&self, stiffness: Arc<Stiffness>, loads: Arc<Vec<SparseColumn>>) -> Self {
        Self { stiffness, loads, ..self.clone() }
    }

    /// The model at the fixed stiffness `K(abar)`, its bones at rest; `activation` (m) is `abar`.
    ///
    /// # Errors
    /// [`ForwardError::Activation`] outside [0, 1], [`ForwardError::NotPositiveDefinite`].
    pub fn at(&self, activation: &[f64]) -> Result<FixedStiffness<'_>, ForwardError> {
        self.at_pose(activation, &Pose::rest())
    }

    /// The model at the fixed stiffness `K(abar)`, its bones moved by `pose`.
    ///
    /// # Errors
    /// As [`at`](Self::at).
    pub fn at_pose(&self, activation: &[f64], pose: &Pose) -> Result<FixedStiffness<'_>, ForwardError> {
        let (values, cholesky) = self.factorised(activation)?;
        let bones = (!pose.is_rest()).then(|| MovedBones::new(self, &values, &cholesky, pose.clone()));
        Ok(FixedStiffness::new(self, activation, cholesky, bones))
    }

    /// The model at the fixed stiffness `K(abar)` with the jaw as an unknown beside the activations, opened by
    /// the `share` (0 to 1) of `range`.
    ///
    /// # Errors
    /// As [`at`](Self::at), and [`ForwardError::NoJaw`].
    pub fn at_opening(
        &self,
        activation: &[f64],
        range: JawRange,
        share: f64,
    ) -> Result<FixedStiffness<'_>, ForwardError> {
        if self.face.jaw.is_none() {
            return Err(ForwardError::NoJaw);
        }
        let (values, cholesky) = self.factorised(activation)?;
        let bones = MovedBones::opened(self, &values, &cholesky, range, share);
        Ok(FixedStiffness::new(self, activation, cholesky, Some(bones)))
    }

    fn factorised(&self, activation: &[f64]) -> Result<(Vec<f64>, Cholesky), ForwardError> {
        for (muscle, &value) in self.muscles.iter().zip(activation) {
            if !(0. ..=1.).contains(&value) {
                return Err(ForwardError::Activation { muscle: muscle.clone(), value });
            }
        }
        let values = self.stiffness_at(activation);
        let cholesky = Cholesky::new(Arc::clone(&self.symbolic), &values)?;
        Ok((values, cholesky))
    }

    /// Values of `K(a)` on the pattern of [`stiffness`](Self::stiffness).
    pub fn stiffness_at(&self, activation: &[f64]) -> Vec<f64> {
        let rest = self.tissue.coefficients(0.);
        let coefficients: Vec<f64> = activation
            .iter()
            .flat_map(|&a| {
                let at = self.tissue.coefficients(a);
                self.tissue.active_tensors().iter().map(move |&k| at[k] - rest[k])
            })
            .collect();
        self.stiffness.at(&coefficients)
    }

    /// `dK/da_m u` (3n), N, of `muscle` at its activation `a`: how its tissue stiffens against the
    /// displacement `u` (3n, mm).
    pub fn stiffening(&self, muscle: usize, a: f64, u: &[f64]) -> Vec<f64> {
        let slopes = self.tissue.coefficient_slopes(a);
        let active = self.tissue.active_tensors();
        let mut force = vec![0.; u.len()];
        for (k, &tensor) in active.iter().enumerate() {
            self.stiffness.add_part_product(muscle * active.len() + k, slopes[tensor], u, &mut force);
        }
        force
    }

    /// The face.
    pub fn face(&self) -> &Face {
        &self.face
    }

    /// Names of the `m` muscles.
    pub fn muscles(&self) -> &[String] {
        &self.muscles
    }

    /// The parts of the stiffness over all dofs.
    pub fn stiffness(&self) -> &Stiffness {
        &self.stiffness
    }

    /// The analysis of the free part of `K`.
    pub fn symbolic(&self) -> &Arc<SymbolicFactor> {
        &self.symbolic
    }

    /// Columns of `F`: nodal forces of each muscle at full activation, N.
    pub fn loads(&self) -> &[SparseColumn] {
        &self.loads
    }

    /// The contact candidates.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Volume of the tissue found within each muscle, mm³.
    pub fn muscle_volumes(&self) -> &[f64] {
        &self.muscle_volumes
    }

    /// Number of dofs that may move.
    pub fn n_free(&self) -> usize {
        self.symbolic.free().len()
    }

    /// Number of dofs, supports included.
    pub fn n_dofs(&self) -> usize {
        self.symbolic.n_dofs()
    }
}

/// Marks the dofs of the nodes that are fixed to bone, and of nodes without a cell.
pub(super) fn fixed_dofs(face: &Face) -> Vec<bool> {
    let mut used = vec![false; face.mesh.n_nodes()];
    for cell in &face.mesh.cells {
        for &node in cell.nodes() {
            used[node] = true;
        }
    }
    for &node in face.supports.iter().flat_map(|s| &s.nodes) {
        used[node] = false;
    }
    used.iter().flat_map(|&moves| [!moves; 3]).collect()
}

fn check_loaded_nodes(mesh: &Mesh, pairs: &[Pair]) -> Result<(), ForwardError> {
    let mut used = vec![false; mesh.n_nodes()];
    for &node in mesh.cells.iter().flat_map(|cell| cell.nodes()) {
        used[node] = true;
    }
    match pairs.iter().flat_map(|p| &p.row).find(|(node, _)| !used[*node]) {
        Some(&(node, _)) => Err(ForwardError::LoadedOrphan { node: mesh.node_ids[node] }),
        None => Ok(()),
    }
}

/// The column of `F` of one muscle: its fibres' forces carried to the nodes by interpolation.
fn load(muscle: &Muscle, locator: &Locator) -> Result<SparseColumn, ForwardError> {
    let tension = muscle.max_force_n / muscle.fibres.len() as f64;
    let mut column = SparseColumn::new();
    for (index, fibre) in muscle.fibres.iter().enumerate() {
        let forces = fibre_forces(fibre, tension, muscle.insertion_mm);
        for (point, (&position, force)) in fibre.points.iter().zip(forces).enumerate() {
            let outside = |distance_mm| ForwardError::FibreOutside {
                muscle: muscle.name.clone(),
                fibre: index,
                point,
                position,
                distance_mm,
            };
            let found = locator.locate(position).ok_or(outside(f64::INFINITY))?;
            if found.distance_mm > OUTSIDE_MM {
                return Err(outside(found.distance_mm));
            }
            for (node, weight) in found.site.weights {
                column.extend((0..3).map(|axis| (3 * node + axis, weight * force[axis])));
            }
        }
    }
    // Stable, so that equal entries are summed in the same order on every run.
    column.sort_by_key(|&(dof, _)| dof);
    column.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    Ok(column)
}
