//! A face whose tissue has moved for good.

use super::{Face, Fibre, Landmark, Muscle};
use crate::mesh::{Locator, Site};
use crate::units::Vec3;

impl Face {
    /// The face whose tissue rests where the displacement `u` (3n, mm) brings it: the mesh, and with it the fibres of
    /// muscles and the landmarks. Points outside the mesh follow the nearest of its boundary. Teeth and jaw stay.
    ///
    /// # Panics
    /// If `u` has not three values a node.
    #[must_use]
    pub fn with_tissue_moved(&self, u: &[f64]) -> Self {
        let locator = Locator::new(&self.mesh);
        let follow = |p: &Vec3| match locator.locate(*p) {
            Some(found) => p + found.site.displacement(u),
            None => *p,
        };
        let fibre = |f: &Fibre| Fibre { points: f.points.iter().map(follow).collect(), closed: f.closed };
        let muscle = |m: &Muscle| Muscle { fibres: m.fibres.iter().map(fibre).collect(), ..m.clone() };
        let landmark = |l: &Landmark| {
            let position = l.site.position + l.site.displacement(u);
            Landmark { name: l.name.clone(), site: Site { position, weights: l.site.weights.clone() } }
        };
        let mut mesh = self.mesh.clone();
        for (node, p) in mesh.points.iter_mut().enumerate() {
            *p += Vec3::new(u[3 * node], u[3 * node + 1], u[3 * node + 2]);
        }
        Self {
            mesh,
            muscles: self.muscles.iter().map(muscle).collect(),
            landmarks: self.landmarks.iter().map(landmark).collect(),
            ..self.clone()
        }
    }
}
