//! What a face has on both sides.

/// The left and the right one of a pair.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mirrored<T> {
    /// Name without side.
    pub(super) stem: String,
    pub(super) left: T,
    pub(super) right: T,
}

/// The pairs `NAME_l` and `NAME_r` of a list, in the order of its left ones.
pub(super) fn mirrored_pairs<T: Copy>(list: &[(String, T)]) -> impl Iterator<Item = Mirrored<T>> {
    list.iter().filter_map(|(name, left)| {
        let stem = name.strip_suffix("_l")?;
        let other = |n: &String| n.strip_suffix("_r") == Some(stem);
        let right = list.iter().find(|(n, _)| other(n))?.1;
        Some(Mirrored { stem: stem.to_owned(), left: *left, right })
    })
}
