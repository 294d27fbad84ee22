//! Regions of the face, for tables.

use crate::face::{Face, without_side};
use crate::units::Vec3;

/// Landmarks by region: the first part of their names.
const REGIONS: [(&str, &[&str]); 6] = [
    ("upper_lip", &["stomion_superius", "labiale_superius", "crista_philtri", "upper_lip"]),
    ("lower_lip", &["stomion_inferius", "labiale_inferius", "lower_lip", "sublabiale"]),
    ("mouth_corners", &["cheilion"]),
    ("nose", &["subnasale", "alar", "pronasale", "nasion", "ala_"]),
    ("cheeks", &["nasolabial", "cheek", "zygion", "malar"]),
    ("chin", &["chin", "pogonion", "gnathion", "menton", "gonion"]),
];

/// The region of `face` in which the point at rest `p` (mm) lies: that of the nearest landmark, by its name.
pub(super) fn region(face: &Face, p: Vec3) -> String {
    let near = |l: &&crate::face::Landmark| (l.site.position - p).norm();
    let Some(nearest) = face.landmarks.iter().min_by(|a, b| near(a).total_cmp(&near(b))) else {
        return "face".to_owned();
    };
    let name = nearest.name.as_str();
    let known = REGIONS.iter().find(|(_, stems)| stems.iter().any(|stem| name.starts_with(stem)));
    known.map_or(without_side(name), |(region, _)| region).to_owned()
}
