//! Which points of MediaPipe's face mesh are landmarks.

/// Points that are landmarks of the face after Farkas, by their index in MediaPipe's canonical face model (468 points, 478
/// with both irises; `canonical_face_model_uv_visualization` of its face geometry module, and the contours that
/// `face_mesh_connections` names). `_r` is the subject's right, which is on the left of an image that is not mirrored.
const LANDMARKS: [(usize, &str); 23] = [
    (0, "labiale_superius"),
    (1, "pronasale"),
    (2, "subnasale"),
    (9, "glabella"),
    (13, "stomion_superius"),
    (14, "stomion_inferius"),
    (17, "labiale_inferius"),
    (33, "exocanthion_r"),
    (37, "crista_philtri_r"),
    (61, "cheilion_r"),
    (98, "alar_base_r"),
    (133, "endocanthion_r"),
    (152, "gnathion"),
    (168, "nasion"),
    (199, "pogonion"),
    (200, "sublabiale"),
    (263, "exocanthion_l"),
    (267, "crista_philtri_l"),
    (291, "cheilion_l"),
    (327, "alar_base_l"),
    (362, "endocanthion_l"),
    // Centres of the irises.
    (468, "pupil_r"),
    (473, "pupil_l"),
];

/// What point `index` is called: a landmark, or `p` and its index.
pub(super) fn name(index: usize) -> String {
    let known = LANDMARKS.iter().find(|(k, _)| *k == index);
    known.map_or_else(|| format!("p{index}"), |(_, name)| (*name).to_owned())
}

/// The index of the point that [`name`] calls `name`, or that is called `p` and its index.
pub(super) fn index(name: &str) -> Option<usize> {
    let known = LANDMARKS.iter().find(|(_, n)| *n == name).map(|(k, _)| *k);
    known.or_else(|| name.strip_prefix('p')?.parse().ok())
}
