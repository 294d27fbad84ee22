//! Landmarks of the standard face, on its skin.

use super::grid::{Grid, Place};
use super::parameters::Parameters;
use super::relief::Relief;

/// Height of the gnathion: 64.6 below the subnasale.
const GNATHION_MM: f64 = -43.2;

/// A landmark's name without side, whether it is paired, and its place on the left half.
pub(super) struct Spot {
    pub(super) name: &'static str,
    pub(super) paired: bool,
    pub(super) place: Place,
    /// On the upper side of the slit, for places on it.
    pub(super) upper: bool,
}

/// Every landmark. Mid-line landmarks of the profile are read off it; the others stand where the
/// relief puts its features.
pub(super) fn spots(grid: &Grid, parameters: &Parameters, relief: &Relief) -> Vec<Spot> {
    let p = parameters;
    let half = relief.mouth_half();
    let mut spots = Vec::new();
    let mut add = |name, paired, place, upper| spots.push(Spot { name, paired, place, upper });
    let slit = grid.slit as f64;
    let node = |column: usize, row: f64| Place { column: column as f64, row, miss: 0.0 };
    add("stomion_superius", false, node(0, slit), true);
    add("stomion_inferius", false, node(0, slit), false);
    add("cheilion", true, node(grid.corner, slit), true);

    let upper = |x: f64| grid.locate(x, relief.slit(x) + relief.upper_vermilion(x));
    let lower = |x: f64| grid.locate(x, relief.slit(x) - relief.lower_vermilion(x));
    add("labiale_superius", false, upper(0.0), true);
    add("labiale_inferius", false, lower(0.0), false);
    add("crista_philtri", true, upper(0.5 * p.philtrum_width_mm), true);
    add("upper_lip_lateral", true, upper(0.5 * half), true);
    add("lower_lip_lateral", true, lower(0.5 * half), false);

    add("subnasale", false, grid.locate(0.0, p.upper_lip_mm), true);
    let shift = p.nose_shift();
    add("alar_base", true, grid.locate(18.5, 24.5 + shift), true);
    let (x, y) = p.moved(27.5, 11.5);
    add("nasolabial_fold", true, grid.locate(x, y), true);
    add("chin", true, grid.locate(8.0, -29.0), false);
    let profile = |from: f64, to: f64, most: fn(f64, f64) -> f64| {
        // The mid-line node furthest along (y, z) weights between two heights of the head.
        let at = |row: usize| grid.skin[row];
        let best = (0..grid.rows)
            .filter(|&row| (from..to).contains(&grid.base[row].y))
            .max_by(|&a, &b| most(at(a).y, at(a).z).total_cmp(&most(at(b).y, at(b).z)));
        node(0, best.unwrap_or(0) as f64)
    };
    add("pronasale", false, profile(28.0 + shift, 45.0 + shift, |_, z| z), true);
    add("nasion", false, node(0, (grid.rows - 1) as f64), false);
    add("sublabiale", false, profile(-25.0, -12.0, |_, z| -z), false);
    add("pogonion", false, profile(-42.0, -24.0, |_, z| z), false);
    // The lowest point of the chin's outline is ill defined on its round underside: its height is.
    let below = (1..grid.rows).find(|&row| grid.skin[row].y > GNATHION_MM).unwrap_or(1);
    let (low, high) = (grid.skin[below - 1].y, grid.skin[below].y);
    let share = ((GNATHION_MM - low) / (high - low)).clamp(0.0, 1.0);
    add("gnathion", false, node(0, (below - 1) as f64 + share), false);
    spots
}
