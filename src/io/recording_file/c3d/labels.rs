//! The names of the points of a C3D file.

use std::collections::HashSet;

use super::super::warning::RecordingFileWarning;
use super::parameters::Parameters;
use crate::io::text::listed;

/// Names of the `n` points: LABELS, then LABELS2, LABELS3, ..., of 255 at most each. A subject's name that all have before
/// a colon is taken off. Points without a label get their number.
pub(super) fn labels(
    parameters: &Parameters,
    n: usize,
    warnings: &mut Vec<RecordingFileWarning>,
) -> Vec<String> {
    let mut labels = Vec::new();
    for k in 1.. {
        let name = if k == 1 { "POINT:LABELS".to_owned() } else { format!("POINT:LABELS{k}") };
        let Some(parameter) = parameters.get(&name) else { break };
        labels.extend(parameter.texts());
    }
    let surplus = labels.split_off(n.min(labels.len()));
    let named: Vec<&str> = surplus.iter().map(String::as_str).filter(|label| !label.is_empty()).collect();
    if !named.is_empty() {
        let names = listed(named.iter().copied());
        warnings.push(RecordingFileWarning::Labels { count: named.len(), names });
    }
    labels.resize(n, String::new());
    without_subject(&mut labels);
    let taken: HashSet<String> = labels.iter().cloned().collect();
    let mut unlabelled = (0, 0);
    for (k, label) in labels.iter_mut().enumerate().filter(|(_, label)| label.is_empty()) {
        *label = format!("point_{}", k + 1);
        while taken.contains(label.as_str()) {
            label.push('_');
        }
        if unlabelled.1 == 0 {
            unlabelled.0 = k;
        }
        unlabelled.1 += 1;
    }
    if let (first, count @ 1..) = unlabelled {
        warnings.push(RecordingFileWarning::Unlabelled { count, first });
    }
    labels
}

/// Takes off the `subject:` that all labels have.
fn without_subject(labels: &mut [String]) {
    let mut named = labels.iter().filter(|label| !label.is_empty());
    let Some(subject) = named.next().and_then(|label| Some(&label[..=label.rfind(':')?])) else { return };
    let subject = subject.to_owned();
    if labels
        .iter()
        .all(|label| label.is_empty() || label.strip_prefix(&subject).is_some_and(|l| !l.is_empty()))
    {
        labels.iter_mut().for_each(|label| drop(label.drain(..subject.len().min(label.len()))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bare(labels: &[&str]) -> Vec<String> {
        let mut labels: Vec<String> = labels.iter().map(|l| (*l).to_string()).collect();
        without_subject(&mut labels);
        labels
    }

    #[test]
    fn one_subject_is_taken_off() {
        assert_eq!(bare(&["Ann:a", "Ann:b", ""]), ["a", "b", ""]);
        assert_eq!(bare(&["Ann:a", "Bob:a"]), ["Ann:a", "Bob:a"]);
        assert_eq!(bare(&["Ann:a", "b"]), ["Ann:a", "b"]);
        assert_eq!(bare(&["Ann:a", "Ann:"]), ["Ann:a", "Ann:"]);
        assert_eq!(bare(&[]), [""; 0]);
    }
}
