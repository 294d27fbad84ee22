//! The linear response of observed points and contacts at one fixed stiffness.

use nalgebra::{DMatrix, DVector};

use crate::contact::PairKind;
use crate::face::JawRange;

/// What activations and contact forces do to the observed points and to the gaps, at one fixed
/// stiffness `K`: `P u = offset + map a + reach lambda`, with contact
/// `g = gap + approach a + compliance lambda`.
///
/// The columns are those of the unknowns: the `m` activations, and after them the jaw's opening, in shares of
/// its range, where the model was asked for it ([`Model::at_opening`](super::Model::at_opening)): `x` of them.
///
/// Shapes: `m` muscles, `x` unknowns, `p` observed points (`d = 3p` rows, point-major xyz), `c` contacts.
#[derive(Clone, Debug)]
pub struct Response {
    /// Names of the `m` muscles.
    pub muscles: Vec<String>,
    /// The openings between which the jaw's is an unknown, if it is one.
    pub jaw: Option<JawRange>,
    /// `P K^-1 F`, (d x x), mm per unit of each unknown.
    pub map: DMatrix<f64>,
    /// `P u` without activation and contact forces (d), mm: zero unless bones are moved or the model was
    /// linearised about a deformed state.
    pub offset: DVector<f64>,
    /// Contact rows; `None` when contact is off.
    pub contact: Option<ContactResponse>,
}

/// The contact rows of a [`Response`].
#[derive(Clone, Debug, PartialEq)]
pub struct ContactResponse {
    /// What each of the `c` contacts keeps apart.
    pub kinds: Vec<PairKind>,
    /// Gap without activation and contact forces (c), mm: with bones at rest `g0`, not negative.
    pub gap: DVector<f64>,
    /// `V = G K^-1 F`, (c x x), mm per unit of each unknown.
    pub approach: DMatrix<f64>,
    /// `S = G K^-1 G'`, (c x c), mm/N, symmetric positive semidefinite.
    pub compliance: DMatrix<f64>,
    /// `P K^-1 G'`, (d x c), mm/N.
    pub reach: DMatrix<f64>,
}
