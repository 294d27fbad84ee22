//! Small linear bodies with the response of a face.

use modiolus::contact::PairKind;
use modiolus::forward::{ContactResponse, Response, contact_forces};
use modiolus::inverse::{Goal, Marker, Observations, Place, Target};
use modiolus::mesh::Site;
use modiolus::units::Vec3;
use nalgebra::{DMatrix, DVector};

use super::Random;

/// `K u = F a + G' lambda`, observed through `P`.
pub struct Body {
    pub inverse: DMatrix<f64>,
    pub forces: DMatrix<f64>,
    pub observe: DMatrix<f64>,
    pub normals: DMatrix<f64>,
    pub gap: DVector<f64>,
}

impl Body {
    /// `dofs` unknowns, `m` muscles, `points` observed points, `c` contacts.
    pub fn random(random: &mut Random, dofs: usize, m: usize, points: usize, c: usize) -> Self {
        let factor = random.matrix(dofs, dofs);
        let stiffness = factor.tr_mul(&factor) / dofs as f64 + DMatrix::identity(dofs, dofs) * 0.2;
        Self {
            inverse: stiffness.try_inverse().unwrap(),
            forces: random.matrix(dofs, m) * 2.0,
            observe: random.matrix(3 * points, dofs) / (dofs as f64).sqrt(),
            normals: random.matrix(c, dofs) / (dofs as f64).sqrt(),
            gap: DVector::from_fn(c, |_, _| if random.below(3) == 0 { 0.0 } else { random.unit() }),
        }
    }

    pub fn response(&self) -> Response {
        let c = self.gap.len();
        let compliance = &self.normals * &self.inverse * self.normals.transpose();
        Response {
            muscles: names(self.forces.ncols()),
            jaw: None,
            map: &self.observe * &self.inverse * &self.forces,
            offset: DVector::zeros(self.observe.nrows()),
            contact: (c > 0).then(|| ContactResponse {
                kinds: vec![PairKind::UpperTeeth; c],
                gap: self.gap.clone(),
                approach: &self.normals * &self.inverse * &self.forces,
                compliance: (&compliance + compliance.transpose()) / 2.0,
                reach: &self.observe * &self.inverse * self.normals.transpose(),
            }),
        }
    }
}

/// What is seen (d), mm, of random activations under the contact forces that they call up, with `noise` (standard
/// deviation, mm).
pub fn seen(random: &mut Random, response: &Response, noise: f64) -> DVector<f64> {
    let a = DVector::from_fn(response.map.ncols(), |_, _| random.unit());
    let contact = response.contact.as_ref().unwrap();
    let force = contact_forces(contact, &a).unwrap();
    &response.map * a + &contact.reach * force + random.vector(response.map.nrows()) * noise
}

pub fn names(m: usize) -> Vec<String> {
    (0..m).map(|k| format!("muscle_{k}")).collect()
}

/// `points` observed points somewhere, one for each marker.
pub fn observations(random: &mut Random, points: usize) -> Observations {
    let site = |node| Site::node(node, Vec3::new(random.normal(), random.normal(), random.normal()) * 20.0);
    let sites = (0..points).map(site).collect();
    Observations { sites, markers: (0..points).collect(), ..Observations::default() }
}

/// Markers at the displacements `d` (3p) with one standard deviation.
pub fn target(d: &DVector<f64>, sigma_mm: f64) -> Target {
    let marker = |k: usize| Marker {
        name: format!("marker_{k}"),
        at: Place::Landmark(format!("landmark_{k}")),
        goal: Goal::Displacement([Some(d[3 * k]), Some(d[3 * k + 1]), Some(d[3 * k + 2])]),
        sigma_mm,
    };
    Target { markers: (0..d.len() / 3).map(marker).collect(), ..Target::default() }
}
