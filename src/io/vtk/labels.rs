//! Which arrays are labels, and the sets that they make.

use std::collections::BTreeMap;

use super::array::Values;

/// Most distinct values of an array that become sets: an array of numbers is no set.
const MAX_LABELS: usize = 64;

/// The label of each entry of an array, or why it has none.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Labels {
    /// Distinct values, and for each entry the position of its own.
    Of { distinct: Vec<i64>, codes: Vec<u8> },
    /// Why the array makes no sets.
    No(String),
}

impl Labels {
    /// The labels of an array of one number an entry.
    pub(super) fn new(values: &Values) -> Self {
        match values {
            Values::Int(values) => Self::of(values.iter().map(|v| Some(*v))),
            // Many programs store every array as floats.
            Values::Float(values) => {
                let whole = |v: &f64| (v.fract() == 0. && v.abs() < 1e15).then_some(*v as i64);
                Self::of(values.iter().map(whole))
            }
        }
    }

    fn of(values: impl Iterator<Item = Option<i64>>) -> Self {
        let (mut distinct, mut codes): (Vec<i64>, Vec<u8>) = (Vec::new(), Vec::new());
        let mut code_of: BTreeMap<i64, u8> = BTreeMap::new();
        for value in values {
            let Some(value) = value else {
                return Self::No("its values are not all whole numbers".to_owned());
            };
            let next = distinct.len();
            let code = *code_of.entry(value).or_insert(next as u8);
            if usize::from(code) == next {
                distinct.push(value);
            }
            if distinct.len() > MAX_LABELS {
                return Self::No(format!("it has more than {MAX_LABELS} different values"));
            }
            codes.push(code);
        }
        Self::Of { distinct, codes }
    }

    /// Adds the labels of the next piece of the file.
    pub(super) fn append(&mut self, other: Self) {
        match (&mut *self, other) {
            (Self::No(_), _) => {}
            (_, no @ Self::No(_)) => *self = no,
            (Self::Of { distinct, codes }, Self::Of { distinct: others, codes: more }) => {
                let values = codes.iter().map(|c| distinct[usize::from(*c)]);
                let more = more.iter().map(|c| others[usize::from(*c)]);
                *self = Self::of(values.chain(more).map(Some).collect::<Vec<_>>().into_iter());
            }
        }
    }

    /// The sets of the array `name`: one of its name where all is zeros and ones, else `name=value` for each value.
    /// Entries are numbered from 0.
    pub(super) fn sets(&self, name: &str) -> Vec<(String, Vec<usize>)> {
        let Self::Of { distinct, codes } = self else { return Vec::new() };
        let flags = distinct.iter().all(|v| *v == 0 || *v == 1);
        let mut members = vec![Vec::new(); distinct.len()];
        for (k, code) in codes.iter().enumerate() {
            members[usize::from(*code)].push(k);
        }
        if flags {
            let ones = distinct.iter().position(|v| *v == 1).map(|k| std::mem::take(&mut members[k]));
            return vec![(name.to_owned(), ones.unwrap_or_default())];
        }
        distinct.iter().zip(members).map(|(value, members)| (format!("{name}={value}"), members)).collect()
    }
}
