//! The names of the points of a C3D file.

use std::collections::HashSet;

use super::super::subject::without_subject;
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
