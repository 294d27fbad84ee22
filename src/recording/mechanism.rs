//! What muscles and jaw do to the markers, at one stiffness.

use nalgebra::{DMatrix, DVector};

use super::marker_map::JawFreedom;
use super::tracker::Touched;
use crate::face::{Face, Jaw, Pose, RigidMotion};
use crate::forward::finite::{FiniteModel, FiniteState};
use crate::forward::{ContactError, ContactResponse, FixedStiffness, Response, Touching, forces_holding};
use crate::mesh::Site;
use crate::units::Vec3;

/// Unknowns of the jaw: its opening, protrusion and shift to the left, in shares of their farthest.
pub const JAW_UNKNOWNS: [&str; 3] = ["jaw_opening", "jaw_protrusion", "jaw_left"];
/// Openings, mm, from which the two parts of the hinge's movement are found.
const PROBES_MM: [f64; 2] = [5., 15.];

/// How the unknowns `x` (n: activations, then the jaw's) move the observed points and open the gaps, with contact forces that
/// follow.
///
/// At one stiffness everything is linear in the features `xi(x)` (w): the activations, `sin t` and `1 - cos t` of the hinge's
/// angle `t`, the jaw's protrusion and shift, and one. The rigid motion of a hinge is linear in the two functions of its
/// angle, and the tissue follows its bones linearly, so that the jaw may open widely. [About](Self::about_rest) a face at rest at
/// finite strain it is the tangent there, contact included, and the hinge's arc is bent as at linear strain.
#[derive(Clone, Debug)]
pub struct Mechanism {
    /// Names of the muscles (m).
    pub muscles: Vec<String>,
    jaw: Option<Hinge>,
    /// Displacements of the observed points without contact forces (d x w), mm.
    observed: DMatrix<f64>,
    contact: Option<Contacts>,
}

#[derive(Clone, Debug)]
struct Hinge {
    freedom: JawFreedom,
    arm_mm: f64,
}

#[derive(Clone, Debug)]
struct Contacts {
    /// Gaps without contact forces (c x w), mm.
    gaps: DMatrix<f64>,
    compliance: DMatrix<f64>,
    /// (d x c), mm/N.
    reach: DMatrix<f64>,
}

/// Contacts that touch, and the movement with their forces eliminated.
#[derive(Clone, Debug)]
pub(super) struct TouchingPiece {
    touching: Touching,
    /// Displacements of the observed points (d x w), mm.
    pub(super) observed: DMatrix<f64>,
    /// Forces of the touching contacts (k x w), N.
    forces: DMatrix<f64>,
}

impl Mechanism {
    /// That of the points `sites` at the stiffness of `fixed`, whose model has the contact candidates, with a jaw of so much
    /// `freedom` where there is one.
    pub fn new(fixed: &FixedStiffness<'_>, sites: &[Site], freedom: Option<JawFreedom>) -> Self {
        Self::of(fixed, fixed.response(sites), sites, freedom)
    }

    /// That of the same points where it is right to first order: about the unknowns `x` (n), whose activations are those of the
    /// stiffness of `fixed`. A change of activation there changes the stiffness, too.
    ///
    /// # Errors
    /// [`ContactError`] when no contact forces hold the face there.
    pub fn about(
        fixed: &FixedStiffness<'_>,
        sites: &[Site],
        freedom: Option<JawFreedom>,
        x: &[f64],
    ) -> Result<Self, ContactError> {
        let response = fixed.response(sites);
        let held = Self::of(fixed, response.clone(), sites, freedom);
        let u = held.displacement(fixed, x)?;
        Ok(Self::of(fixed, fixed.tangent(sites, &response, &u), sites, freedom))
    }

    /// That of the same points at finite strain, to first order about the face of `model` at rest in `state`, whose unknowns are `x`
    /// (n); `self` is that at linear strain. Contact is in the tangent: no contact is told. `None` where the tissue of `state` has
    /// no tangent.
    pub fn about_rest(
        &self,
        model: &FiniteModel,
        state: &FiniteState,
        sites: &[Site],
        x: &[f64],
    ) -> Option<Self> {
        let (face, m) = (model.face(), self.muscles.len());
        let seen = |u: &[f64]| {
            let rows = sites.iter().flat_map(|site| <[f64; 3]>::from(site.displacement(u)));
            DVector::from_iterator(3 * sites.len(), rows)
        };
        let mut observed = self.observed.clone();
        for (k, field) in model.tangent(state, None)?.fields().iter().enumerate() {
            observed.set_column(k, &seen(field));
        }
        if let (Some(Hinge { freedom, arm_mm }), Some([opening_mm, ..])) = (&self.jaw, self.jaw_mm(x)) {
            let opening = model.follow(state, |bone, p| face.jaw_slope(bone, opening_mm, p));
            // r du/dq = A cos t + B sin t  gives A; the arc's bend B is the linear one's.
            let (sine, cosine) = (opening_mm / arm_mm).sin_cos();
            let versine = observed.column(m + 1).into_owned();
            observed.set_column(m, &((*arm_mm * seen(&opening) - sine * versine) / cosine));
            let shifts = [Vec3::new(0., 0., freedom.protrusion_mm), Vec3::new(freedom.lateral_mm, 0., 0.)];
            for (k, shift) in shifts.into_iter().enumerate() {
                let way = |bone: &str, _| if face.is_of_jaw(bone) { shift } else { Vec3::zeros() };
                observed.set_column(m + 2 + k, &seen(&model.follow(state, way)));
            }
        }
        let last = observed.ncols() - 1;
        observed.column_mut(last).fill(0.);
        let moved = &observed * self.features(&DVector::from_column_slice(x));
        observed.set_column(last, &(seen(state.displacement()) - moved));
        Some(Self { muscles: self.muscles.clone(), jaw: self.jaw.clone(), observed, contact: None })
    }

    fn of(
        fixed: &FixedStiffness<'_>,
        response: Response,
        sites: &[Site],
        freedom: Option<JawFreedom>,
    ) -> Self {
        let face = fixed.model().face();
        let jaw = freedom.zip(face.jaw.as_ref());
        let motions = jaw.map(|(freedom, jaw)| jaw_columns(jaw, &freedom, fixed, sites));
        let columns = |own: &DMatrix<f64>, constant: &DVector<f64>, moved: fn(&Moved) -> &DVector<f64>| {
            let mut all: Vec<DVector<f64>> = own.column_iter().map(|c| c.into_owned()).collect();
            all.extend(motions.iter().flatten().map(|motion| moved(motion).clone()));
            all.push(constant.clone());
            DMatrix::from_columns(&all)
        };
        let observed = columns(&response.map, &response.offset, |motion| &motion.0);
        let contact = response.contact.map(|contact| {
            let ContactResponse { gap, approach, compliance, reach, .. } = contact;
            Contacts { gaps: columns(&approach, &gap, |motion| &motion.1), compliance, reach }
        });
        let jaw = jaw.map(|(freedom, jaw)| Hinge { freedom, arm_mm: jaw.arm_mm() });
        Self { muscles: response.muscles, jaw, observed, contact }
    }

    /// Names of the unknowns (n).
    pub fn unknowns(&self) -> Vec<String> {
        let jaw = JAW_UNKNOWNS.iter().filter(|_| self.jaw.is_some()).map(|s| (*s).to_owned());
        self.muscles.iter().cloned().chain(jaw).collect()
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.muscles.len() + if self.jaw.is_some() { JAW_UNKNOWNS.len() } else { 0 }
    }

    /// Least and greatest values of the unknowns (n).
    pub fn bounds(&self) -> (DVector<f64>, DVector<f64>) {
        let (m, n) = (self.muscles.len(), self.n_unknowns());
        let least = DVector::from_fn(n, |k, _| if k > m { -1. } else { 0. });
        (least, DVector::from_element(n, 1.))
    }

    /// The jaw's freedom, if it may move.
    pub fn jaw(&self) -> Option<&JawFreedom> {
        self.jaw.as_ref().map(|jaw| &jaw.freedom)
    }

    /// The jaw's opening, protrusion and shift to the left at `x` (n), mm.
    pub fn jaw_mm(&self, x: &[f64]) -> Option<[f64; 3]> {
        let m = self.muscles.len();
        self.jaw.as_ref().map(|Hinge { freedom, .. }| {
            [x[m] * freedom.opening_mm, x[m + 1] * freedom.protrusion_mm, x[m + 2] * freedom.lateral_mm]
        })
    }

    /// `xi(x)` (w).
    pub(super) fn features(&self, x: &DVector<f64>) -> DVector<f64> {
        let m = self.muscles.len();
        let mut xi = DVector::zeros(self.observed.ncols());
        xi.rows_mut(0, m).copy_from(&x.rows(0, m));
        if let Some(Hinge { freedom, arm_mm }) = &self.jaw {
            let (sine, cosine) = (x[m] * freedom.opening_mm / arm_mm).sin_cos();
            (xi[m], xi[m + 1], xi[m + 2], xi[m + 3]) = (sine, 1. - cosine, x[m + 1], x[m + 2]);
        }
        let last = xi.len() - 1;
        xi[last] = 1.;
        xi
    }

    /// `matrix dxi/dx` at `x` (any x n), of a `matrix` over the features (any x w).
    pub(super) fn by_unknowns(&self, matrix: &DMatrix<f64>, x: &DVector<f64>) -> DMatrix<f64> {
        let (m, n) = (self.muscles.len(), self.n_unknowns());
        let mut slopes = DMatrix::zeros(matrix.nrows(), n);
        slopes.columns_mut(0, m).copy_from(&matrix.columns(0, m));
        if let Some(Hinge { freedom, arm_mm }) = &self.jaw {
            let rate = freedom.opening_mm / arm_mm;
            let (sine, cosine) = (x[m] * rate).sin_cos();
            let mut opening = slopes.column_mut(m);
            opening.axpy(rate * cosine, &matrix.column(m), 0.);
            opening.axpy(rate * sine, &matrix.column(m + 1), 1.);
            slopes.column_mut(m + 1).copy_from(&matrix.column(m + 2));
            slopes.column_mut(m + 2).copy_from(&matrix.column(m + 3));
        }
        slopes
    }

    /// Second derivative, by the jaw's opening, of what has the slopes `by_features` (w) at `x`; zero by all other unknowns.
    pub(super) fn bend(&self, by_features: &DVector<f64>, x: &DVector<f64>) -> f64 {
        let m = self.muscles.len();
        self.jaw.as_ref().map_or(0., |Hinge { freedom, arm_mm }| {
            let rate = freedom.opening_mm / arm_mm;
            let (sine, cosine) = (x[m] * rate).sin_cos();
            rate * rate * (cosine * by_features[m + 1] - sine * by_features[m])
        })
    }

    /// Whether contacts are told.
    pub(super) fn has_contact(&self) -> bool {
        self.contact.is_some()
    }

    /// Nothing touches.
    pub(super) fn open(&self) -> TouchingPiece {
        let forces = DMatrix::zeros(0, self.observed.ncols());
        let touching = Touching::new(&DMatrix::zeros(0, 0), []);
        TouchingPiece { touching, observed: self.observed.clone(), forces }
    }

    /// The contacts that touch at the features `xi`, sought from those of `near`; `None` without contact.
    pub(super) fn touching(
        &self,
        xi: &DVector<f64>,
        near: &TouchingPiece,
    ) -> Result<Option<Touching>, ContactError> {
        let Some(contact) = &self.contact else { return Ok(None) };
        let (_, touching) = forces_holding(&contact.compliance, &(&contact.gaps * xi), Some(&near.touching))?;
        Ok(Some(touching))
    }

    /// The movement while `touching` goes on touching.
    pub(super) fn piece(&self, touching: Touching) -> TouchingPiece {
        let Some(contact) = &self.contact else { return self.open() };
        let held = touching.contacts();
        let mut forces = -contact.gaps.select_rows(held);
        touching.solve(&mut forces);
        let observed = &self.observed + contact.reach.select_columns(held) * &forces;
        TouchingPiece { touching, observed, forces }
    }

    /// The forces of all contacts (c), N, at the unknowns `x` (n); none without contact.
    ///
    /// # Errors
    /// [`ContactError`] when no forces keep the gaps open.
    pub fn contact_forces(&self, x: &[f64]) -> Result<Vec<f64>, ContactError> {
        let Some(contact) = &self.contact else { return Ok(Vec::new()) };
        let free = &contact.gaps * self.features(&DVector::from_column_slice(x));
        Ok(forces_holding(&contact.compliance, &free, None)?.0.as_slice().to_vec())
    }

    /// Displacements (d), mm, of the observed points at the unknowns `x` (n), contact included.
    ///
    /// # Errors
    /// [`ContactError`] when no forces keep the gaps open.
    pub fn observed_mm(&self, x: &[f64]) -> Result<DVector<f64>, ContactError> {
        let free = &self.observed * self.features(&DVector::from_column_slice(x));
        let forces = DVector::from_vec(self.contact_forces(x)?);
        Ok(match &self.contact {
            Some(contact) => free + &contact.reach * forces,
            None => free,
        })
    }

    /// Displacement (3n), mm, of the whole face at the unknowns `x` (n) with the stiffness of `fixed`.
    ///
    /// # Errors
    /// [`ContactError`] when no contact forces hold the face.
    pub fn displacement(&self, fixed: &FixedStiffness<'_>, x: &[f64]) -> Result<Vec<f64>, ContactError> {
        let mut u = fixed.displacement(&x[..self.muscles.len()], &self.contact_forces(x)?);
        let pose = self.pose(fixed.model().face(), x);
        if !pose.is_rest() {
            u.iter_mut().zip(fixed.lifted_by(&pose)).for_each(|(u, lift)| *u += lift);
        }
        Ok(u)
    }

    /// Where the jaw of `face` is at the unknowns `x` (n).
    pub fn pose(&self, face: &Face, x: &[f64]) -> Pose {
        let (Some([opening, forward, left]), Some(jaw)) = (self.jaw_mm(x), &face.jaw) else {
            return Pose::rest();
        };
        Pose::rest().with(&jaw.bone, jaw.motion(opening).then_by(Vec3::new(left, 0., forward)))
    }

    /// Force (N) of each contact that touches, gap (mm) of each that does not (c), at the features `xi`.
    pub(super) fn slacks(&self, piece: &TouchingPiece, xi: &DVector<f64>) -> DVector<f64> {
        let Some(contact) = &self.contact else { return DVector::zeros(0) };
        let forces = &piece.forces * xi;
        let mut slack = &contact.gaps * xi + piece.touching.opening(&contact.compliance, forces.as_slice());
        for (&i, &force) in piece.touching.contacts().iter().zip(forces.iter()) {
            slack[i] = force;
        }
        slack
    }

    /// The slack of contact `i` over the features (1 x w).
    pub(super) fn slack(&self, piece: &TouchingPiece, i: usize) -> DMatrix<f64> {
        let Some(contact) = &self.contact else { return DMatrix::zeros(1, self.observed.ncols()) };
        let held = piece.touching.contacts();
        match held.iter().position(|&h| h == i) {
            Some(k) => piece.forces.rows(k, 1).into_owned(),
            None => {
                let column = contact.compliance.column(i);
                let pull = DMatrix::from_iterator(1, held.len(), held.iter().map(|&h| column[h]));
                contact.gaps.rows(i, 1) + pull * &piece.forces
            }
        }
    }
}

impl TouchingPiece {
    /// What touches at the features `xi`.
    pub(super) fn touched(&self, xi: &DVector<f64>) -> Touched {
        let force_n = (&self.forces * xi).iter().map(|f| f.max(0.)).fold(0., |sum, f| sum + f);
        Touched { contacts: self.touching.contacts().len(), force_n }
    }
}

/// Its contacts, ascending.
pub(super) fn sorted(touching: &Touching) -> Vec<usize> {
    let mut contacts = touching.contacts().to_vec();
    contacts.sort_unstable();
    contacts
}

/// Displacements of the points (d) and changes of the gaps (c), mm.
type Moved = (DVector<f64>, DVector<f64>);

/// What the jaw's `sin t`, `1 - cos t`, protrusion and shift do: displacements of the points (d) and changes of the gaps (c), mm.
fn jaw_columns(jaw: &Jaw, freedom: &JawFreedom, fixed: &FixedStiffness<'_>, sites: &[Site]) -> Vec<Moved> {
    let opened = PROBES_MM.map(|q| fixed.moved_by(&Pose::opened(jaw, q), sites));
    let [(s1, v1), (s2, v2)] = PROBES_MM.map(|q| {
        let (sine, cosine) = (q / jaw.arm_mm()).sin_cos();
        (sine, 1. - cosine)
    });
    // u_k = s_k A + v_k B.
    let determinant = s1 * v2 - s2 * v1;
    let solve = |u1: &DVector<f64>, u2: &DVector<f64>| {
        [(u1 * v2 - u2 * v1) / determinant, (u2 * s1 - u1 * s2) / determinant]
    };
    let [sine, versine] = solve(&opened[0].0, &opened[1].0);
    let [gap_sine, gap_versine] = solve(&opened[0].1, &opened[1].1);
    let shift = |t: Vec3| fixed.moved_by(&Pose::rest().with(&jaw.bone, RigidMotion::translation(t)), sites);
    let forward = shift(Vec3::new(0., 0., freedom.protrusion_mm));
    let left = shift(Vec3::new(freedom.lateral_mm, 0., 0.));
    vec![(sine, gap_sine), (versine, gap_versine), forward, left]
}
