//! Labels without the name of their subject.

/// Takes off the `subject:` that all labels have.
pub(super) fn without_subject(labels: &mut [String]) {
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
