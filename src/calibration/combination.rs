//! Which combinations of parameters the data determine.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Information below this share of the greatest is none: what rounding leaves.
const NONE: f64 = 1e-10;
/// Share of the greatest weight from which a parameter is named.
const NAMED: f64 = 0.3;
/// Per cent up to which a combination is determined, and roughly.
const DETERMINED: [f64; 2] = [20., 50.];

/// A direction of the logarithms of the parameters: an eigenvector of the information of the data, without priors.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Weight of each parameter (p), the greatest 1 in size.
    pub weights: Vec<f64>,
    /// Information of the data about the unit vector along the weights: the eigenvalue.
    pub information: f64,
    /// Standard deviation of the logarithm of the parameter of the greatest weight when all change together along the
    /// weights; `None` where the data say nothing.
    pub spread: Option<f64>,
    /// The same in words.
    pub sentence: String,
}

impl Combination {
    /// Those of the parameters `chosen` of `names` (p) with the `information` (p x p) of the data, the best determined first.
    pub(super) fn all(names: &[&str], chosen: &[usize], information: &DMatrix<f64>) -> Vec<Self> {
        if chosen.is_empty() {
            return Vec::new();
        }
        let own = information.select_rows(chosen).select_columns(chosen);
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(own);
        let most = eigenvalues.amax();
        let mut order: Vec<usize> = (0..chosen.len()).collect();
        order.sort_by(|&i, &j| eigenvalues[j].total_cmp(&eigenvalues[i]).then(i.cmp(&j)));
        let (seen, unseen): (Vec<usize>, Vec<usize>) =
            order.into_iter().partition(|&k| most > 0. && eigenvalues[k] > NONE * most);
        let of = |vector: &DVector<f64>, information: f64| {
            let mut weights = vec![0.; names.len()];
            let first = vector.iter().position(|v| v.abs() >= vector.amax() * (1. - 1e-9)).unwrap_or(0);
            let unit = vector / vector[first];
            chosen.iter().zip(unit.iter()).for_each(|(&k, v)| weights[k] = *v);
            let spread = (information > 0.).then(|| vector.amax() / vector.norm() / information.sqrt());
            let sentence = sentence(names, &weights, spread);
            Self { weights, information, spread, sentence }
        };
        let mut all: Vec<Self> =
            seen.iter().map(|&k| of(&eigenvectors.column(k).into_owned(), eigenvalues[k])).collect();
        // Any basis will do where there is no information; one with many zeros can be read.
        let unseen: Vec<DVector<f64>> = unseen.iter().map(|&k| eigenvectors.column(k).into_owned()).collect();
        all.extend(sparse(unseen).iter().map(|vector| of(vector, 0.)));
        all
    }
}

/// The same space as that of `vectors`, each with zeros where another one leads (Gauss and Jordan).
fn sparse(mut vectors: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
    const ZERO: f64 = 1e-6;
    let mut k = 0;
    for row in 0..vectors.first().map_or(0, |vector| vector.len()) {
        let size = |i: usize| vectors[i][row].abs();
        let lead = (k..vectors.len()).max_by(|&i, &j| size(i).total_cmp(&size(j)).then(j.cmp(&i)));
        let Some(lead) = lead.filter(|&lead| size(lead) > ZERO) else { continue };
        vectors.swap(k, lead);
        let leader = &vectors[k] / vectors[k][row];
        for (_, vector) in vectors.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = vector[row];
            vector.axpy(-factor, &leader, 1.);
        }
        vectors[k] = leader;
        k += 1;
    }
    for vector in &mut vectors {
        let most = vector.amax();
        vector.iter_mut().filter(|v| v.abs() < ZERO * most).for_each(|v| *v = 0.);
    }
    vectors
}

fn sentence(names: &[&str], weights: &[f64], spread: Option<f64>) -> String {
    let ahead = |sign: f64| -> Vec<&str> {
        (0..names.len()).filter(|&k| sign * weights[k] >= NAMED).map(|k| names[k]).collect()
    };
    let (up, down) = (ahead(1.), ahead(-1.));
    let mut text = list(&up) + " up";
    if !down.is_empty() {
        text += &format!(", {} down", list(&down));
    }
    let together = if up.len() + down.len() > 1 { ", together" } else { "" };
    let per_cent = spread.map(per_cent);
    text + together
        + &match per_cent {
            None => ": changes nothing that was observed; only the priors say anything".to_owned(),
            Some(p) if p <= DETERMINED[0] => format!(": determined to {} %", shown(p)),
            Some(p) if p <= DETERMINED[1] => format!(": roughly determined, to {} %", shown(p)),
            Some(p) if p <= 1000. => format!(": not determined, {} % by the data alone", shown(p)),
            Some(_) => ": not determined, a factor of more than ten by the data alone".to_owned(),
        }
}

/// What a spread of a logarithm is in per cent of the value.
pub fn per_cent(spread: f64) -> f64 {
    100. * spread.exp_m1()
}

fn shown(per_cent: f64) -> String {
    if per_cent < 10. { format!("{per_cent:.1}") } else { format!("{per_cent:.0}") }
}

fn list(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two observations of three parameters, `x - y` and `z` alone: `x + y` is open.
    #[test]
    fn what_is_not_observed_is_told() {
        let rows = DMatrix::from_row_slice(2, 3, &[10., -10., 0., 0., 0., 5.]);
        let all = Combination::all(&["x", "y", "z"], &[0, 1, 2], &rows.tr_mul(&rows));
        // Along (1, -1) the observation goes 20 per unit: a spread of 1/20.
        assert!((all[0].spread.expect("seen") - 0.05).abs() < 1e-12, "{:?}", all[0]);
        assert_eq!(all[0].sentence, "x up, y down, together: determined to 5.1 %");
        assert_eq!(all[1].sentence, "z up: roughly determined, to 22 %");
        assert_eq!((all[2].weights.as_slice(), all[2].spread), ([1., 1., 0.].as_slice(), None));
        assert!(all[2].sentence.starts_with("x and y up, together: changes nothing"), "{:?}", all[2]);
        // What rounding leaves is no information either.
        let rounded = rows.tr_mul(&rows) + DMatrix::identity(3, 3) * 1e-9;
        assert_eq!(Combination::all(&["x", "y", "z"], &[0, 1, 2], &rounded)[2].sentence, all[2].sentence);
    }

    #[test]
    fn an_open_space_is_shown_by_few_parameters_each() {
        let [a, b] = [[1., 1., 1., 0.], [0., 0., 1., -1.]].map(|v| DVector::from_column_slice(&v));
        let mixed = sparse(vec![&a * 0.6 + &b * 0.8, &a * 0.8 - &b * 0.6]);
        let expected = [[1., 1., 0., 1.], [0., 0., 1., -1.]].map(|v| DVector::from_column_slice(&v));
        for (found, expected) in mixed.iter().zip(&expected) {
            assert!((found - expected).amax() < 1e-12, "{found} {expected}");
        }
    }
}
