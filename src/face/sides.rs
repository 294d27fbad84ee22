//! Names of one side, and warnings that both sides of a muscle share, said once.

use super::FaceWarning;

/// The name of a muscle or landmark without its side: `risorius` of `risorius_l`; one without a side as it is.
pub fn without_side(name: &str) -> &str {
    name.strip_suffix("_l").or(name.strip_suffix("_r")).unwrap_or(name)
}

impl FaceWarning {
    /// This warning and the same of the muscle's other side as one; `None` where they are not that.
    pub fn with_other_side(&self, other: &Self) -> Option<Self> {
        use FaceWarning as W;
        let both = |a: &String, b: &String| {
            (a != b && without_side(a) == without_side(b)).then(|| format!("{a} and {b}"))
        };
        Some(match (self, other) {
            (W::FlippedFibres { muscle: a, fibres: n }, W::FlippedFibres { muscle: b, fibres: m }) => {
                W::FlippedFibres { muscle: both(a, b)?, fibres: n + m }
            }
            (W::AllInsertion { muscle: a, length_mm: x }, W::AllInsertion { muscle: b, length_mm: y }) => {
                W::AllInsertion { muscle: both(a, b)?, length_mm: x.min(*y) }
            }
            (
                W::Projected { muscle: a, outside: n, points: p, largest_mm: x },
                W::Projected { muscle: b, outside: m, points: q, largest_mm: y },
            ) => W::Projected { muscle: both(a, b)?, outside: n + m, points: p + q, largest_mm: x.max(*y) },
            _ => return None,
        })
    }

    /// `warnings` with those that both sides of a muscle share joined, in the order of the first of them.
    pub fn join_sides<T>(warnings: Vec<T>, join: impl Fn(&T, &T) -> Option<T>) -> Vec<T> {
        let mut joined: Vec<T> = Vec::with_capacity(warnings.len());
        for warning in warnings {
            match joined.iter_mut().find_map(|known| join(known, &warning).map(|both| (known, both))) {
                Some((known, both)) => *known = both,
                None => joined.push(warning),
            }
        }
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sides_of_one_muscle_are_one_warning() {
        let flipped = |muscle: &str| FaceWarning::FlippedFibres { muscle: muscle.to_owned(), fibres: 2 };
        let told = ["a_l", "b_l", "a_r", "c"].map(flipped).to_vec();
        let joined = FaceWarning::join_sides(told, FaceWarning::with_other_side);
        let both = FaceWarning::FlippedFibres { muscle: "a_l and a_r".to_owned(), fibres: 4 };
        assert_eq!(joined, [both, flipped("b_l"), flipped("c")]);
    }
}
