//! Units: mm, N, s inside; moduli in kPa at every interface.

use nalgebra::Vector3;

/// A point or vector in the face frame, mm: +x the subject's left, +y up, +z anterior.
pub type Vec3 = Vector3<f64>;

/// N/mm² in one kPa: moduli are kPa at every interface and N/mm² inside the elements.
pub const N_PER_MM2_PER_KPA: f64 = 1e-3;

/// The unit of length that a file states; every file must state one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetre, the unit inside.
    Millimetre,
    /// Centimetre.
    Centimetre,
    /// Metre.
    Metre,
}

impl LengthUnit {
    /// The names accepted in files.
    pub const NAMES: [&'static str; 3] = ["mm", "cm", "m"];

    /// The unit called `name` (`mm`, `cm` or `m`), or `None`.
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "mm" => Some(Self::Millimetre),
            "cm" => Some(Self::Centimetre),
            "m" => Some(Self::Metre),
            _ => None,
        }
    }

    /// Millimetres in one of this unit.
    pub fn in_mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
        }
    }
}

/// A number of things for messages: `1 cell`, `3 cells`, `2 entries`.
pub fn counted(n: usize, thing: &str) -> String {
    match (n, thing.strip_suffix('y')) {
        (1, _) => format!("1 {thing}"),
        (_, Some(stem)) => format!("{n} {stem}ies"),
        _ => format!("{n} {thing}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!(["cell", "entry"].map(|t| counted(1, t)), ["1 cell", "1 entry"]);
        assert_eq!(["cell", "entry"].map(|t| counted(0, t)), ["0 cells", "0 entries"]);
    }
}
