//! Whether a fit is what its target file states.

use crate::inverse::{Expected, Solution, Status};

/// What a fit says to the statement of its target file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is solved, and its residual is within the tolerance of the stated one.
    AsStated,
    /// It is not.
    NotAsStated,
    /// The file states nothing for this face and these mechanics.
    NotStated,
}

/// Root mean square of the residuals of all observed markers and features, mm: what target files state. 0 without any.
pub fn residual_rms_mm(solution: &Solution) -> f64 {
    let features = solution.features.iter().map(|f| (f.model_mm - f.target_mm).abs());
    let all: Vec<f64> = solution.markers.iter().filter_map(|m| m.residual_mm).chain(features).collect();
    (all.iter().fold(0., |sum, r| sum + r * r) / all.len().max(1) as f64).sqrt()
}

impl Verdict {
    /// What a fit that ended as `status` with the residual `rms_mm` says to what is `stated`.
    pub fn of(status: Status, rms_mm: f64, stated: Option<&Expected>) -> Self {
        let Some(Expected { residual_rms_mm, tolerance_mm, .. }) = stated else { return Self::NotStated };
        if status == Status::Solved && (rms_mm - residual_rms_mm).abs() <= *tolerance_mm {
            Self::AsStated
        } else {
            Self::NotAsStated
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statement_holds_within_its_tolerance_and_for_solved_fits_only() {
        let stated = Expected { face: "f".into(), residual_rms_mm: 2., tolerance_mm: 0.5 };
        let of = |status, rms| Verdict::of(status, rms, Some(&stated));
        for (status, rms, verdict) in [
            (Status::Solved, 2.5, Verdict::AsStated),
            (Status::Solved, 1.5, Verdict::AsStated),
            (Status::Solved, 2.51, Verdict::NotAsStated),
            (Status::Solved, 1.49, Verdict::NotAsStated),
            (Status::Solved, f64::NAN, Verdict::NotAsStated),
            (Status::NotConverged, 2., Verdict::NotAsStated),
            (Status::Underdetermined, 2., Verdict::NotAsStated),
        ] {
            assert_eq!(of(status, rms), verdict, "{status} {rms}");
        }
        assert_eq!(Verdict::of(Status::Solved, 2., None), Verdict::NotStated);
    }
}
