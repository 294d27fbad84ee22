//! What the standard face is built from.

use super::curve::step;

/// Anthropometric and mechanical parameters of the standard face.
///
/// Defaults are adult means after Farkas' landmarks, tooth and tissue figures measured on public
/// head models; lengths mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Cheilion to cheilion; adult mean 50.7, s.d. 3.9.
    pub mouth_width_mm: f64,
    /// Stomion to labiale superius.
    pub upper_vermilion_mm: f64,
    /// Stomion to labiale inferius.
    pub lower_vermilion_mm: f64,
    /// Crest to crest of the philtrum at the vermilion border.
    pub philtrum_width_mm: f64,
    /// Stomion to subnasale, along y.
    pub upper_lip_mm: f64,
    /// Opening of the slit mouth at the mid-line; it tapers to nothing at the corners.
    pub slit_gap_mm: f64,
    /// Depth of the upper incisors' front face behind the stomion.
    pub upper_incisor_depth_mm: f64,
    /// Depth of the lower incisors' front face behind the stomion.
    pub lower_incisor_depth_mm: f64,
    /// Half width of the upper arch, outer faces.
    pub upper_arch_half_width_mm: f64,
    /// Depth of the upper arch from incisors to last molars.
    pub upper_arch_depth_mm: f64,
    /// Half width of the lower arch, outer faces.
    pub lower_arch_half_width_mm: f64,
    /// Depth of the lower arch.
    pub lower_arch_depth_mm: f64,
    /// Side of Bonwill's triangle between the condyles and the lower incisal point, equilateral: four inches
    /// (Bonwill 1858; skulls from 97 to 110).
    pub bonwill_side_mm: f64,
    /// Balkwill's angle between that triangle and the occlusal plane, degrees: 20 to 25 (Koerber, Zahnaerztliche
    /// Prothetik, 1985).
    pub balkwill_angle_deg: f64,
    /// Clearance between mucosa and teeth at rest.
    pub mucosa_gap_mm: f64,
    /// Muscle force per cross-section at full activation, N/mm2; the literature runs from 0.1 to 0.25.
    pub muscle_stress_n_mm2: f64,
    /// Whether each ring of the orbicularis is four muscles, `..._upper_l` to `..._lower_r`, that meet at
    /// the mid-line and beside the corners, instead of one.
    pub orbicularis_quadrants: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            mouth_width_mm: 50.7,
            upper_vermilion_mm: 10.1,
            lower_vermilion_mm: 10.2,
            philtrum_width_mm: 14.6,
            upper_lip_mm: 21.4,
            slit_gap_mm: 0.15,
            upper_incisor_depth_mm: 5.0,
            lower_incisor_depth_mm: 7.0,
            upper_arch_half_width_mm: 30.0,
            upper_arch_depth_mm: 47.0,
            lower_arch_half_width_mm: 28.3,
            lower_arch_depth_mm: 45.0,
            bonwill_side_mm: 101.6,
            balkwill_angle_deg: 22.5,
            mucosa_gap_mm: 0.5,
            muscle_stress_n_mm2: 0.1,
            orbicularis_quadrants: false,
        }
    }
}

/// A proportion of the visible face that differs from person to person.
#[derive(Clone, Copy, Debug)]
pub struct Proportion {
    /// The field of [`Parameters`].
    pub name: &'static str,
    /// Standard deviation among adults, mm.
    pub sd_mm: f64,
    field: fn(&mut Parameters) -> &mut f64,
}

impl Proportion {
    /// Its value in `parameters`, mm.
    pub fn of(&self, parameters: &Parameters) -> f64 {
        *(self.field)(&mut parameters.clone())
    }

    /// Sets it to `value` (mm), or to the nearest that can be built.
    pub fn set(&self, parameters: &mut Parameters, value: f64) {
        let range = parameters.ranges().into_iter().find(|(name, ..)| *name == self.name);
        let (least, most) = range.map_or((value, value), |(_, _, least, most)| (least, most));
        *(self.field)(parameters) = value.clamp(least, most);
    }
}

impl Parameters {
    /// The proportions that are seen on the skin, with their spread: width of the mouth and vermilion heights of 300 men
    /// (Pietruski and Majak, Aesthet. Surg. J. 42 (2022) 1130), height of the upper lip of both sexes
    /// (10.1186/s40902-019-0191-7, table 9); that of the width of the philtrum is a tenth of it, as of the others.
    pub const PROPORTIONS: [Proportion; 5] = [
        Proportion { name: "mouth_width_mm", sd_mm: 3.74, field: |p| &mut p.mouth_width_mm },
        Proportion { name: "upper_vermilion_mm", sd_mm: 1.62, field: |p| &mut p.upper_vermilion_mm },
        Proportion { name: "lower_vermilion_mm", sd_mm: 1.88, field: |p| &mut p.lower_vermilion_mm },
        Proportion { name: "philtrum_width_mm", sd_mm: 1.5, field: |p| &mut p.philtrum_width_mm },
        Proportion { name: "upper_lip_mm", sd_mm: 2.0, field: |p| &mut p.upper_lip_mm },
    ];
}

/// A parameter with which the standard face cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// A proportion outside its range, or not finite.
    #[error("`{name}` is {value}: give a number from {least} to {most}")]
    OutOfRange {
        /// The field of [`Parameters`].
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value accepted.
        least: f64,
        /// Largest value accepted.
        most: f64,
    },
    /// A stretch of the grid with too few cells, or too many.
    #[error("`{name}` has {cells} cells: give from {least} to {most}")]
    Cells {
        /// The field of [`Resolution`](super::Resolution).
        name: &'static str,
        /// Its value.
        cells: usize,
        /// Fewest cells accepted.
        least: usize,
        /// Most cells accepted.
        most: usize,
    },
}

impl Parameters {
    /// Every field with its name and the range accepted: about three standard deviations of adults
    /// for proportions.
    fn ranges(&self) -> [(&'static str, f64, f64, f64); 15] {
        [
            ("mouth_width_mm", self.mouth_width_mm, 40.0, 62.0),
            ("upper_vermilion_mm", self.upper_vermilion_mm, 6.0, 13.0),
            ("lower_vermilion_mm", self.lower_vermilion_mm, 6.0, 13.0),
            ("philtrum_width_mm", self.philtrum_width_mm, 10.0, 19.0),
            ("upper_lip_mm", self.upper_lip_mm, 18.0, 25.0),
            ("slit_gap_mm", self.slit_gap_mm, 0.05, 1.0),
            ("upper_incisor_depth_mm", self.upper_incisor_depth_mm, 4.0, 7.0),
            ("lower_incisor_depth_mm", self.lower_incisor_depth_mm, 5.0, 9.0),
            ("upper_arch_half_width_mm", self.upper_arch_half_width_mm, 27.0, 33.0),
            ("upper_arch_depth_mm", self.upper_arch_depth_mm, 42.0, 52.0),
            ("lower_arch_half_width_mm", self.lower_arch_half_width_mm, 25.0, 31.0),
            ("lower_arch_depth_mm", self.lower_arch_depth_mm, 40.0, 50.0),
            ("bonwill_side_mm", self.bonwill_side_mm, 90.0, 115.0),
            ("balkwill_angle_deg", self.balkwill_angle_deg, 15.0, 30.0),
            ("mucosa_gap_mm", self.mucosa_gap_mm, 0.2, 1.0),
        ]
    }

    /// Whether a face can be built with these.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let stress = ("muscle_stress_n_mm2", self.muscle_stress_n_mm2, 1e-3, 1.0);
        for (name, value, least, most) in self.ranges().into_iter().chain([stress]) {
            if !(least..=most).contains(&value) {
                return Err(ParameterError::OutOfRange { name, value, least, most });
            }
        }
        Ok(())
    }

    /// How much higher than drawn the nose stands, mm.
    pub(super) fn nose_shift(&self) -> f64 {
        self.upper_lip_mm - Self::default().upper_lip_mm
    }

    /// Where the point drawn at `(x, y)` on the default face is on this one: courses follow the
    /// corners of the mouth and the upper lip.
    pub(super) fn moved(&self, x: f64, y: f64) -> (f64, f64) {
        let drawn = Self::default();
        let half = 0.5 * drawn.mouth_width_mm;
        let wider = 0.5 * self.mouth_width_mm - half;
        let beside = (x / half).clamp(-1.0, 1.0) * (1.0 - step(x.abs(), 30.0, 60.0));
        let over = (y / drawn.upper_lip_mm).clamp(0.0, 1.0) * (1.0 - step(y, 30.0, 58.0));
        (x + wider * beside, y + self.nose_shift() * over)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_accepted_and_leave_courses_in_place() {
        let p = Parameters::default();
        assert_eq!(p.check(), Ok(()));
        assert_eq!(p.moved(29.0, 11.0), (29.0, 11.0));
    }

    #[test]
    fn what_cannot_be_built_is_refused_by_name() {
        for value in [f64::NAN, f64::INFINITY, 0.0, 500.0] {
            let p = Parameters { mouth_width_mm: value, ..Parameters::default() };
            assert!(matches!(p.check(), Err(ParameterError::OutOfRange { name: "mouth_width_mm", .. })));
        }
    }
}
