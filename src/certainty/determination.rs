//! What the data say about one unknown, in words.

use std::fmt;

use crate::face::JawRange;

/// Width of an interval, as a share of full activation, up to which an activation is called determined,
const DETERMINED: f64 = 0.2;
/// and up to which it is called roughly determined.
const ROUGHLY: f64 = 0.5;

/// How well the data determine an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Determination {
    /// The limits leave it one value.
    Held,
    /// To within 20 per cent of full activation.
    Determined,
    /// To within 50 per cent.
    Roughly,
    /// Hardly or not at all.
    Undetermined,
    /// It moves no observed point.
    Unseen,
}

impl Determination {
    pub(super) fn of(width: f64, seen: bool) -> Self {
        match width {
            _ if !seen => Self::Unseen,
            w if w <= DETERMINED => Self::Determined,
            w if w <= ROUGHLY => Self::Roughly,
            _ => Self::Undetermined,
        }
    }

    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Determined => "determined",
            Self::Roughly => "roughly",
            Self::Undetermined => "not_determined",
            Self::Unseen => "not_observed",
        }
    }
}

/// What the data say about one unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownCertainty {
    /// The muscle, or the jaw's opening.
    pub name: String,
    /// The openings between which the jaw's is counted in shares, where it is that.
    pub jaw: Option<JawRange>,
    /// The value of the answer, 0 to 1.
    pub value: f64,
    /// Least value whose misfit the noise allows.
    pub min: f64,
    /// Greatest value whose misfit the noise allows.
    pub max: f64,
    /// Mean of the posterior, which knows the noise and the limits and no effort.
    pub mean: f64,
    /// Standard deviation of the posterior.
    pub sd: f64,
    /// Share of what the limits leave open that the data decide: 1 - (variance / that of a uniform distribution).
    pub resolution: f64,
    /// How well it is determined.
    pub determination: Determination,
    /// Unknowns that change most from the least to the greatest value, the most first: what it trades against.
    pub trades: Vec<String>,
}

impl fmt::Display for UnknownCertainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = |x: f64| match self.jaw {
            Some(range) => format!("{:.1}", range.at(x) + 0.),
            None => percent(x),
        };
        let unit = if self.jaw.is_some() { "mm" } else { "%" };
        let Self { value, min, max, .. } = self;
        let interval = format!("{} {unit} ({} to {})", shown(*value), shown(*min), shown(*max));
        match self.determination {
            Determination::Held => write!(f, "held at {} {unit}", shown(*value))?,
            Determination::Determined => write!(f, "determined: {interval}")?,
            Determination::Roughly => write!(f, "roughly determined: {interval}")?,
            Determination::Undetermined => write!(f, "not determined: {interval}")?,
            Determination::Unseen => return f.write_str("not determined: moves no observed point"),
        }
        let is_open = matches!(self.determination, Determination::Roughly | Determination::Undetermined);
        if is_open && !self.trades.is_empty() {
            write!(f, "; trades against {}", self.trades.join(" and "))?;
        }
        Ok(())
    }
}

/// A share in whole per cent, without the sign of a zero.
pub fn percent(share: f64) -> String {
    format!("{:.0}", (100. * share).round() + 0.)
}
