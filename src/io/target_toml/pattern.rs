//! Patterns of muscle names with one star: `*_r` is every muscle of the subject's right.

use super::TargetDocument;
use super::error::TargetFileError;
use crate::inverse::Bound;

impl TargetDocument {
    /// The same target with the patterns in its bounds and tied pairs replaced by the muscles that
    /// they name.
    ///
    /// A bound by name wins over one by pattern, and a later pattern over an earlier one. In a tied
    /// pair both names carry a star, which stands for the same text: `["*_l", "*_r"]`.
    ///
    /// # Errors
    /// [`TargetFileError::Pattern`] when a pattern has several stars, matches no muscle, or has no
    /// counterpart to tie.
    pub fn expand_patterns(&self, muscles: &[String]) -> Result<Self, TargetFileError> {
        let mut expanded = self.clone();
        self.expand_bounds(muscles, &mut expanded)?;
        self.expand_tied(muscles, &mut expanded)?;
        Ok(expanded)
    }

    fn expand_bounds(&self, muscles: &[String], expanded: &mut Self) -> Result<(), TargetFileError> {
        let mut chosen: Vec<(usize, Bound)> = Vec::new();
        for (i, bound) in self.target.bounds.iter().enumerate().filter(|(_, b)| !b.muscle.contains('*')) {
            chosen.push((i, bound.clone()));
        }
        let by_name: Vec<String> = chosen.iter().map(|(_, b)| b.muscle.clone()).collect();
        for (i, bound) in self.target.bounds.iter().enumerate().filter(|(_, b)| b.muscle.contains('*')) {
            let field = format!("bounds[{i}].muscle");
            let matched: Vec<&String> = muscles.iter().filter(|m| star(&bound.muscle, m).is_some()).collect();
            if matched.is_empty() {
                return Err(self.bad_pattern(&field, &bound.muscle, "matches no muscle", muscles));
            }
            for muscle in matched.into_iter().filter(|m| !by_name.contains(m)) {
                chosen.retain(|(_, b)| b.muscle != *muscle);
                chosen.push((i, Bound { muscle: muscle.clone(), ..bound.clone() }));
            }
        }
        expanded.lines.forget("bounds");
        for (k, (i, _)) in chosen.iter().enumerate() {
            expanded.lines.copy(&self.lines, &format!("bounds[{i}]"), &format!("bounds[{k}]"));
        }
        expanded.target.bounds = chosen.into_iter().map(|(_, b)| b).collect();
        Ok(())
    }

    fn expand_tied(&self, muscles: &[String], expanded: &mut Self) -> Result<(), TargetFileError> {
        let mut chosen: Vec<(usize, [String; 2])> = Vec::new();
        for (i, pair) in self.target.tied.iter().enumerate() {
            if pair.iter().all(|p| !p.contains('*')) {
                chosen.push((i, pair.clone()));
                continue;
            }
            let field = format!("tied[{i}]");
            let before = chosen.len();
            for muscle in muscles {
                let Some(stem) = star(&pair[0], muscle) else { continue };
                let other = pair[1].replacen('*', stem, 1);
                if !pair[1].contains('*') || !muscles.contains(&other) {
                    let problem = format!("has no counterpart of {muscle}");
                    return Err(self.bad_pattern(&field, &pair[1], &problem, muscles));
                }
                chosen.push((i, [muscle.clone(), other]));
            }
            if chosen.len() == before {
                return Err(self.bad_pattern(&field, &pair[0], "matches no muscle", muscles));
            }
        }
        expanded.lines.forget("tied");
        for (k, (i, _)) in chosen.iter().enumerate() {
            expanded.lines.copy(&self.lines, &format!("tied[{i}]"), &format!("tied[{k}]"));
        }
        expanded.target.tied = chosen.into_iter().map(|(_, t)| t).collect();
        Ok(())
    }

    fn bad_pattern(&self, field: &str, pattern: &str, problem: &str, muscles: &[String]) -> TargetFileError {
        TargetFileError::Pattern {
            at: Box::new(self.lines.location(field)),
            pattern: pattern.to_owned(),
            problem: problem.to_owned(),
            known: muscles.join(", "),
        }
    }
}

/// The text that the star of `pattern` stands for in `name`; `None` when it does not match.
fn star<'a>(pattern: &str, name: &'a str) -> Option<&'a str> {
    let (prefix, suffix) = pattern.split_once('*')?;
    if suffix.contains('*') {
        return None;
    }
    name.strip_prefix(prefix)?.strip_suffix(suffix)
}

#[cfg(test)]
mod tests {
    use super::star;

    #[test]
    fn the_star_stands_for_any_text() {
        assert_eq!(star("*_r", "risorius_r"), Some("risorius"));
        assert_eq!(star("levator_*_l", "levator_anguli_oris_l"), Some("anguli_oris"));
        assert_eq!(star("*", "mentalis_l"), Some("mentalis_l"));
        assert_eq!(star("*_r", "risorius_l"), None);
        assert_eq!(star("ab*ba", "aba"), None);
        assert_eq!(star("*_*", "risorius_l"), None);
    }
}
