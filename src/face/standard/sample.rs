//! Standard faces of many people.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

use super::Parameters;

/// Draws beyond this many standard deviations are drawn again.
const FARTHEST_SD: f64 = 2.;

/// Proportions of `count` people: each of [`Parameters::PROPORTIONS`] normally distributed about the standard face's with its
/// published spread, independent of the others, within two standard deviations and what can be built. The same `seed` gives the same people, and
/// more of them begin with the same.
pub fn sample(count: usize, seed: u64) -> Vec<Parameters> {
    let mut bits = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut uniform = || ((bits.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    // Box and Muller, one number of each pair: what a draw costs does not matter here.
    let mut normal = || loop {
        let value = (-2. * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
        if value.abs() <= FARTHEST_SD {
            return value;
        }
    };
    let drawn = Parameters::default();
    (0..count)
        .map(|_| {
            let mut person = drawn.clone();
            for proportion in &Parameters::PROPORTIONS {
                proportion.set(&mut person, proportion.of(&drawn) + normal() * proportion.sd_mm);
            }
            person
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_differ_as_published_and_are_the_same_again() {
        let people = sample(2000, 11);
        assert_eq!(people[..7], sample(7, 11)[..]);
        assert_ne!(people[0], sample(1, 12)[0]);
        // The standard deviation of a normal distribution cut at two of its own.
        let cut = 0.8796;
        for proportion in &Parameters::PROPORTIONS {
            let values: Vec<f64> = people.iter().map(|p| proportion.of(p)).collect();
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
            let drawn = proportion.of(&Parameters::default());
            assert!((mean - drawn).abs() < 0.15 * proportion.sd_mm, "{} {mean}", proportion.name);
            assert!((sd / proportion.sd_mm - cut).abs() < 0.15, "{} {sd}", proportion.name);
        }
    }
}
