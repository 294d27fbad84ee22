//! How finely the standard face is meshed.

use super::parameters::ParameterError;

/// How finely the standard face is meshed: cells along each stretch of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Columns from the mid-line to the corner of the mouth.
    pub mouth_columns: usize,
    /// Columns from the corner of the mouth to the side edge, graded.
    pub cheek_columns: usize,
    /// Rows above the slit: vermilion, lip, lower nose, upper nose and cheek.
    pub rows_above: [usize; 4],
    /// Rows below the slit: vermilion, lip, chin and its underside.
    pub rows_below: [usize; 3],
    /// Cells through the thickness.
    pub layers: usize,
}

impl Resolution {
    /// About 10 000 degrees of freedom: previews and tests.
    pub const COARSE: Self = Self {
        mouth_columns: 9,
        cheek_columns: 7,
        rows_above: [4, 4, 4, 3],
        rows_below: [4, 4, 5],
        layers: 3,
    };
    /// About 30 000 degrees of freedom: the default.
    pub const STANDARD: Self = Self {
        mouth_columns: 11,
        cheek_columns: 15,
        rows_above: [5, 5, 6, 8],
        rows_below: [5, 4, 12],
        layers: 3,
    };
    /// About 200 000 degrees of freedom: the standard grid halved in every direction.
    pub const FINE: Self = Self {
        mouth_columns: 22,
        cheek_columns: 30,
        rows_above: [10, 10, 12, 16],
        rows_below: [10, 8, 24],
        layers: 6,
    };
    /// The names accepted at interfaces.
    pub const NAMES: [&'static str; 3] = ["coarse", "standard", "fine"];
    /// The names of the built-in faces: no face that is read from a file is one of them.
    pub const FACES: [&'static str; 3] = ["standard_coarse", "standard", "standard_fine"];

    /// The resolution called `name` (`coarse`, `standard` or `fine`), or `None`.
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "coarse" => Some(Self::COARSE),
            "standard" => Some(Self::STANDARD),
            "fine" => Some(Self::FINE),
            _ => None,
        }
    }

    /// The resolution of the built-in face called `face`, one of [`FACES`](Self::FACES), or `None`.
    pub fn of_face(face: &str) -> Option<Self> {
        Self::FACES.iter().position(|name| *name == face).and_then(|k| Self::parse(Self::NAMES[k]))
    }

    /// The name of the built-in face of this resolution; `None` of one that is not built in.
    pub fn face_name(&self) -> Option<&'static str> {
        Self::FACES.into_iter().find(|name| Self::of_face(name).as_ref() == Some(self))
    }

    /// Whether a face can be built so finely: every stretch has cells, lips three layers, and the
    /// mesh fewer than some ten million degrees of freedom.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let [vermilion, lip, nose, top] = self.rows_above;
        let [lower_vermilion, lower_lip, chin] = self.rows_below;
        for (name, cells, least, most) in [
            ("mouth_columns", self.mouth_columns, 5, 90),
            ("cheek_columns", self.cheek_columns, 5, 120),
            ("rows_above", vermilion.min(lip).min(nose).min(top), 2, 65),
            ("rows_above", vermilion.max(lip).max(nose).max(top), 2, 65),
            ("rows_below", lower_vermilion.min(lower_lip).min(chin), 2, 100),
            ("rows_below", lower_vermilion.max(lower_lip).max(chin), 2, 100),
            ("layers", self.layers, 2, 24),
        ] {
            if !(least..=most).contains(&cells) {
                return Err(ParameterError::Cells { name, cells, least, most });
            }
        }
        Ok(())
    }
}

impl Default for Resolution {
    fn default() -> Self {
        Self::STANDARD
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_resolutions_are_accepted() {
        for name in Resolution::NAMES {
            assert_eq!(Resolution::parse(name).map(|r| r.check()), Some(Ok(())));
        }
        assert_eq!(Resolution::parse("finest"), None);
    }

    #[test]
    fn an_empty_stretch_is_refused() {
        let none = Resolution { rows_below: [5, 0, 12], ..Resolution::STANDARD };
        assert!(matches!(none.check(), Err(ParameterError::Cells { name: "rows_below", cells: 0, .. })));
    }
}
