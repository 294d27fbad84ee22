//! The nearest of some known names, for messages.

/// The name closest to `name` by edit distance, when it is close enough to be a slip of the pen; a
/// name without its ending, `sigma` for `sigma_mm`, is close.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (name.chars().count() / 2).max(2);
    let slip = |k: &str| if !name.is_empty() && k.starts_with(name) { 1 } else { distance(name, k) };
    known
        .into_iter()
        .map(|k| (slip(k), k))
        .filter(|&(d, k)| d <= limit && !k.is_empty() && !name.is_empty())
        .min_by_key(|&(d, _)| d)
        .map(|(_, k)| k)
}

/// Levenshtein distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitution = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitution.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_insertions_deletions_and_substitutions() {
        for (a, b, d) in [("", "", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("sigma", "sigma_mm", 3)] {
            assert_eq!(distance(a, b), d, "{a} {b}");
            assert_eq!(distance(b, a), d, "{b} {a}");
        }
    }

    #[test]
    fn offers_a_slip_of_the_pen_and_nothing_far() {
        let known = ["cheilion_l", "cheilion_r", "pronasale"];
        assert_eq!(nearest("chelion_l", known), Some("cheilion_l"));
        assert_eq!(nearest("prona", known), Some("pronasale"));
        assert_eq!(nearest("xyz", known), None);
    }
}
