//! Patterns of muscle names with one star: `*_r` is every muscle of the subject's right.

use super::error::TargetFileError;
use super::{FieldLines, TargetDocument};

impl TargetDocument {
    /// The same target with the patterns in its bounds, costs, priors and tied pairs replaced by the muscles that
    /// they name.
    ///
    /// An entry by name wins over one by pattern, and a later pattern over an earlier one. In a tied
    /// pair both names carry a star, which stands for the same text: `["*_l", "*_r"]`.
    ///
    /// # Errors
    /// [`TargetFileError::Pattern`] when a pattern has several stars, matches no muscle, or has no
    /// counterpart to tie.
    pub fn expand_patterns(&self, muscles: &[String]) -> Result<Self, TargetFileError> {
        let mut expanded = self.clone();
        expanded.target.bounds = self.expand(
            muscles,
            "bounds",
            &self.target.bounds,
            |bound| &mut bound.muscle,
            &mut expanded.lines,
        )?;
        expanded.target.costs =
            self.expand(muscles, "costs", &self.target.costs, |cost| &mut cost.muscle, &mut expanded.lines)?;
        expanded.target.priors = self.expand(
            muscles,
            "priors",
            &self.target.priors,
            |prior| &mut prior.muscle,
            &mut expanded.lines,
        )?;
        self.expand_tied(muscles, &mut expanded)?;
        Ok(expanded)
    }

    /// The entries of `list`, those whose `muscle` is a pattern once for each muscle that it names.
    fn expand<T: Clone>(
        &self,
        muscles: &[String],
        list: &str,
        entries: &[T],
        muscle: impl Fn(&mut T) -> &mut String,
        lines: &mut FieldLines,
    ) -> Result<Vec<T>, TargetFileError> {
        let name = |entry: &T| muscle(&mut entry.clone()).clone();
        let of_pattern = |entry: &T| name(entry).contains('*');
        let mut chosen: Vec<(usize, String, T)> = Vec::new();
        for (i, entry) in entries.iter().enumerate().filter(|(_, entry)| !of_pattern(entry)) {
            chosen.push((i, name(entry), entry.clone()));
        }
        let by_name: Vec<String> = chosen.iter().map(|(_, name, _)| name.clone()).collect();
        for (i, entry) in entries.iter().enumerate().filter(|(_, entry)| of_pattern(entry)) {
            let (field, pattern) = (format!("{list}[{i}].muscle"), name(entry));
            let matched: Vec<&String> = muscles.iter().filter(|m| star(&pattern, m).is_some()).collect();
            if matched.is_empty() {
                return Err(self.bad_pattern(&field, &pattern, "matches no muscle", muscles));
            }
            for named in matched.into_iter().filter(|m| !by_name.contains(m)) {
                chosen.retain(|(_, name, _)| name != named);
                let mut entry = entry.clone();
                muscle(&mut entry).clone_from(named);
                chosen.push((i, named.clone(), entry));
            }
        }
        lines.forget(list);
        for (k, (i, ..)) in chosen.iter().enumerate() {
            lines.copy(&self.lines, &format!("{list}[{i}]"), &format!("{list}[{k}]"));
        }
        Ok(chosen.into_iter().map(|(.., entry)| entry).collect())
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
