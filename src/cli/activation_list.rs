//! Activations by name, as `--activate` gives them.

use super::error::CliError;

/// `NAME=VALUE`: an activation from 0 to 1 of one muscle, or of both sides when the name has none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assignment {
    pub(crate) name: String,
    pub(crate) value: f64,
}

pub(crate) fn parse_assignment(text: &str) -> Result<Assignment, String> {
    let (name, value) =
        text.split_once('=').ok_or("write NAME=VALUE, such as zygomaticus_major_l=0.5".to_owned())?;
    if name.trim().is_empty() {
        return Err(
            "there is no name before the =; write NAME=VALUE, such as zygomaticus_major_l=0.5".to_owned()
        );
    }
    let number: f64 =
        value.trim().parse().map_err(|_| format!("{value} is not a number; write {name}=0.5"))?;
    if !(0.0..=1.0).contains(&number) {
        return Err(format!("{value} is outside 0 to 1; activations are fractions, not per cent"));
    }
    Ok(Assignment { name: name.trim().to_owned(), value: number })
}

/// The activations (m) of the face's `muscles`; those not named are 0.
pub(crate) fn resolve(assignments: &[Assignment], muscles: &[String]) -> Result<Vec<f64>, CliError> {
    let mut values: Vec<Option<f64>> = vec![None; muscles.len()];
    for Assignment { name, value } in assignments {
        let sides = [name.clone(), format!("{name}_l"), format!("{name}_r")];
        let named: Vec<usize> = (0..muscles.len()).filter(|&k| sides.contains(&muscles[k])).collect();
        if named.is_empty() {
            return Err(CliError::UnknownMuscle { name: name.clone(), known: muscles.join(", ") });
        }
        for k in named {
            if values[k].replace(*value).is_some() {
                return Err(CliError::ActivatedTwice { name: muscles[k].clone() });
            }
        }
    }
    Ok(values.into_iter().map(Option::unwrap_or_default).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn muscles() -> Vec<String> {
        ["risorius_l", "risorius_r", "orbicularis_oris"].map(str::to_owned).into()
    }

    fn values(texts: &[&str]) -> Result<Vec<f64>, CliError> {
        let list: Vec<_> = texts.iter().map(|t| parse_assignment(t).expect("an assignment")).collect();
        resolve(&list, &muscles())
    }

    #[test]
    fn a_name_without_side_is_both_sides() {
        assert_eq!(values(&["risorius=0.5"]).expect("known"), [0.5, 0.5, 0.0]);
        assert_eq!(values(&["risorius_r=1", "orbicularis_oris=0.25"]).expect("known"), [0.0, 1.0, 0.25]);
    }

    #[test]
    fn unknown_and_repeated_names_are_refused() {
        assert!(matches!(values(&["risorio=0.5"]), Err(CliError::UnknownMuscle { .. })));
        assert!(matches!(values(&["risorius=0.5", "risorius_l=1"]), Err(CliError::ActivatedTwice { .. })));
    }

    #[test]
    fn values_are_fractions() {
        for bad in ["risorius", "risorius=", "risorius=50%", "risorius=50", "risorius=-0.1", "risorius=nan"] {
            assert!(parse_assignment(bad).is_err(), "{bad}");
        }
    }
}
