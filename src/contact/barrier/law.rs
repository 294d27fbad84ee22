//! The barrier as a function of distance.

/// How surfaces push each other apart.
///
/// `b(d) = -kappa r (s - 1)^2 ln s` with `s = d / r` for distances `d` below the reach `r`, zero beyond; twice
/// continuously differentiable there. The pressure of two parallel surfaces is
/// `-b'(d) = kappa (2 (s - 1) ln s + (s - 1)^2 / s)`: `kappa` at 0.53 of the reach, and near `kappa r / d` far below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// Distance from which surfaces push each other, mm.
    pub reach_mm: f64,
    /// `kappa`: the pressure at 0.53 of the reach, N/mm².
    pub stiffness: f64,
}

/// Reach of edges over that of vertices: surfaces that lie flat on each other are held apart before edges are near.
const OF_EDGES: f64 = 0.25;

impl Barrier {
    pub(super) fn edge_reach_mm(&self) -> f64 {
        OF_EDGES * self.reach_mm
    }

    /// `b`, `b'` and `b''` at distance `d` (mm, positive) with the reach `reach_mm`.
    pub(super) fn at(&self, d: f64, reach_mm: f64) -> [f64; 3] {
        let s = d / reach_mm;
        if s >= 1. {
            return [0.; 3];
        }
        let (t, ln) = (s - 1., s.ln());
        [
            -self.stiffness * reach_mm * t * t * ln,
            -self.stiffness * (2. * t * ln + t * t / s),
            self.stiffness / reach_mm * (-2. * ln - 4. * t / s + t * t / (s * s)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BARRIER: Barrier = Barrier { reach_mm: 0.3, stiffness: 0.2 };

    #[test]
    fn its_derivatives_are_those_of_its_value() {
        for d in [0.001, 0.02, 0.15, 0.25, 0.299] {
            let h = 1e-4 * d;
            let (hi, lo) = (BARRIER.at(d + h, 0.3), BARRIER.at(d - h, 0.3));
            let here = BARRIER.at(d, 0.3);
            for k in 0..2 {
                let slope = (hi[k] - lo[k]) / (2. * h);
                assert!(
                    (slope - here[k + 1]).abs() < 1e-6 * here[k + 1].abs() + 1e-7,
                    "{d} {k}: {slope} {here:?}"
                );
            }
        }
    }

    #[test]
    fn it_starts_without_force_or_stiffness_and_never_ends() {
        assert_eq!(BARRIER.at(0.3, 0.3), [0.; 3]);
        let near = BARRIER.at(0.3 - 1e-7, 0.3);
        assert!(near.iter().all(|v| v.abs() < 1e-5), "{near:?}");
        assert!(BARRIER.at(0., 0.3)[0].is_infinite());
    }

    #[test]
    fn its_stiffness_is_the_pressure_at_just_over_half_of_the_reach() {
        let pressure = -BARRIER.at(0.53 * 0.3, 0.3)[1];
        assert!((pressure / 0.2 - 1.).abs() < 0.02, "{pressure}");
    }
}
