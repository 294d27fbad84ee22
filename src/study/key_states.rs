//! States that stand for a recording.

use nalgebra::DVector;

/// Times that states are moved to the mean of what is nearest to them.
const MOVES: usize = 10;

/// At most `most` unknowns that, with those already `known`, stand for all that are `sampled` and farther than `near` from what
/// is known; where nothing is, their mean is the first. They are means of clusters that begin far from each other (Gonzalez 1985, Theor Comput Sci
/// 38:293) and move to the mean of what is nearest to them (Lloyd 1982, IEEE Trans Inf Theory 28:129).
pub(super) fn key_states(
    sampled: &[DVector<f64>],
    known: &[DVector<f64>],
    most: usize,
    near: f64,
) -> Vec<DVector<f64>> {
    let mut keys = known.to_vec();
    if keys.is_empty() {
        keys.extend(mean(sampled.iter()));
    }
    while keys.len() < known.len() + most {
        let farthest = sampled.iter().max_by(|a, b| nearest(a, &keys).1.total_cmp(&nearest(b, &keys).1));
        match farthest.filter(|x| nearest(x, &keys).1 > near) {
            Some(x) => keys.push(x.clone()),
            None => break,
        }
    }
    for _ in 0..MOVES {
        let of: Vec<usize> = sampled.iter().map(|x| nearest(x, &keys).0).collect();
        for (k, key) in keys.iter_mut().enumerate().skip(known.len()) {
            let members = sampled.iter().zip(&of).filter(|(_, own)| **own == k).map(|(x, _)| x);
            if let Some(centre) = mean(members) {
                *key = centre;
            }
        }
    }
    keys.split_off(known.len())
}

/// Which of `keys` is nearest to `x`, and how far it is.
pub(super) fn nearest(x: &DVector<f64>, keys: &[DVector<f64>]) -> (usize, f64) {
    let apart = keys.iter().map(|key| (x - key).norm()).enumerate();
    apart.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
}

fn mean<'a>(members: impl Iterator<Item = &'a DVector<f64>>) -> Option<DVector<f64>> {
    let mut count = 0.;
    let sum = members
        .inspect(|_| count += 1.)
        .fold(None, |sum: Option<DVector<f64>>, x| Some(sum.map_or_else(|| x.clone(), |sum| sum + x)));
    sum.map(|sum| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_a_line(values: &[f64]) -> Vec<DVector<f64>> {
        values.iter().map(|&v| DVector::from_element(1, v)).collect()
    }

    #[test]
    fn states_are_the_means_of_what_is_nearest_to_them() {
        let sampled = on_a_line(&[0., 0.1, 0.2, 1., 1.1, 5.]);
        let first = key_states(&sampled, &[], 1, 0.);
        assert!(first.len() == 1 && (first[0][0] - 7.4 / 6.).abs() < 1e-12, "{first:?}");
        let mut three: Vec<f64> = key_states(&sampled, &[], 3, 0.).iter().map(|x| x[0]).collect();
        three.sort_by(f64::total_cmp);
        let wanted = [0.1, 1.05, 5.];
        assert!(three.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{three:?}");
    }

    #[test]
    fn what_is_known_stays_and_what_is_near_it_gets_none() {
        let (sampled, known) = (on_a_line(&[0., 0.1, 3.]), on_a_line(&[0.05]));
        assert_eq!(key_states(&sampled, &known, 5, 0.2), on_a_line(&[3.]));
        assert!(key_states(&sampled, &on_a_line(&[0., 3.]), 5, 0.2).is_empty());
        assert_eq!(nearest(&sampled[1], &on_a_line(&[1., 0.])).0, 1);
        assert!(key_states(&[], &[], 5, 0.).is_empty());
    }
}
