//! A named point of the face.

use crate::mesh::Site;

/// A named point of the face, carried by the tissue.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Farkas' name in full words, lower case: `cheilion_l`.
    pub name: String,
    /// Where it is and which nodes carry it.
    pub site: Site,
}
