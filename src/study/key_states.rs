//! States that stand for a recording.

use nalgebra::DVector;

/// Times that states are moved to the mean of what is nearest to them.
const MOVES: usize = 10;

/// At most `most` unknowns that, with those already `known`, stand for all that are `sampled` and farther than `near` from what
/// is known: means of clusters that begin far from each other (Gonzalez 1985, Theor Comput Sci 38:293) and move to the mean of
/// what is nearest to them (Lloyd 1982, IEEE Trans Inf Theory 28:129).
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
