//! Checks of a target that need no face but the names of its muscles.

use std::collections::BTreeMap;

use super::error::TargetError;
use super::spelling::nearest;
use super::target::{FeatureGoal, Goal, JawOpening, Loss, Target};
use crate::face::Jaw;

impl Target {
    /// Checks every number, label and muscle name against the face's `muscles` (m names).
    ///
    /// # Errors
    /// The first [`TargetError`], in the order of the file's fields.
    pub fn check(&self, muscles: &[String]) -> Result<(), TargetError> {
        self.check_markers()?;
        self.check_features()?;
        for (k, pair) in self.symmetry.iter().enumerate() {
            let field = format!("symmetry[{k}]");
            sigma(format!("{field}.sigma_mm"), pair.sigma_mm)?;
            if pair.left == pair.right {
                return Err(TargetError::SamePoint { field });
            }
        }
        if !(0.0..=Self::MOST_EFFORT).contains(&self.effort) {
            return Err(TargetError::Effort { field: "effort".into(), value: self.effort });
        }
        if let Loss::Huber(sigmas) = self.loss
            && !(Self::HUBER_SIGMAS[0]..=Self::HUBER_SIGMAS[1]).contains(&sigmas)
        {
            return Err(TargetError::Huber { field: "loss_sigmas".into(), value: sigmas });
        }
        unique("costs", self.costs.iter().map(|c| c.muscle.as_str()))?;
        for (k, cost) in self.costs.iter().enumerate() {
            muscle_index(muscles, &cost.muscle, || format!("costs[{k}].muscle"))?;
            if !(0.0..=Self::MOST_EFFORT).contains(&cost.factor) {
                return Err(TargetError::Effort { field: format!("costs[{k}].factor"), value: cost.factor });
            }
        }
        self.check_priors(muscles)?;
        self.check_bounds(muscles)?;
        self.check_jaw_opening()?;
        self.check_ties(muscles)?;
        if self.markers.is_empty()
            && self.features.is_empty()
            && self.symmetry.is_empty()
            && self.priors.is_empty()
            && self.effort == 0.0
        {
            return Err(TargetError::NothingAsked { field: "markers".into() });
        }
        Ok(())
    }

    fn check_markers(&self) -> Result<(), TargetError> {
        unique("markers", self.markers.iter().map(|m| m.name.as_str()))?;
        for (k, marker) in self.markers.iter().enumerate() {
            sigma(format!("markers[{k}].sigma_mm"), marker.sigma_mm)?;
            let (key, components) = match marker.goal {
                Goal::Displacement(d) => ("displacement_mm", d),
                Goal::Position(p) => ("position_mm", p),
            };
            if let Some(value) = components.into_iter().flatten().find(|v| !v.is_finite()) {
                return Err(TargetError::NotFinite { field: format!("markers[{k}].{key}"), value });
            }
        }
        Ok(())
    }

    fn check_features(&self) -> Result<(), TargetError> {
        unique("features", self.features.iter().map(|f| f.name.as_str()))?;
        for (k, feature) in self.features.iter().enumerate() {
            let field = format!("features[{k}]");
            sigma(format!("{field}.sigma_mm"), feature.sigma_mm)?;
            let (key, value) = match feature.goal {
                FeatureGoal::Value(value) => ("value_mm", value),
                FeatureGoal::Change(value) => ("change_mm", value),
            };
            if !value.is_finite() {
                return Err(TargetError::NotFinite { field: format!("{field}.{key}"), value });
            }
            if feature.axis.is_none() && key == "value_mm" && value < 0.0 {
                return Err(TargetError::NegativeDistance { field: format!("{field}.{key}"), value });
            }
            if feature.from == feature.to {
                return Err(TargetError::SamePoint { field });
            }
        }
        Ok(())
    }

    fn check_priors(&self, muscles: &[String]) -> Result<(), TargetError> {
        unique("priors", self.priors.iter().map(|p| p.muscle.as_str()))?;
        for (k, prior) in self.priors.iter().enumerate() {
            muscle_index(muscles, &prior.muscle, || format!("priors[{k}].muscle"))?;
            if !(0.0..=1.0).contains(&prior.activation) {
                let field = format!("priors[{k}].activation");
                return Err(TargetError::BoundOutside { field, value: prior.activation });
            }
            if !(Self::SIGMA[0]..=Self::SIGMA[1]).contains(&prior.sigma) {
                let field = format!("priors[{k}].sigma");
                return Err(TargetError::PriorSigma { field, value: prior.sigma });
            }
        }
        Ok(())
    }

    fn check_bounds(&self, muscles: &[String]) -> Result<(), TargetError> {
        unique("bounds", self.bounds.iter().map(|b| b.muscle.as_str()))?;
        for (k, bound) in self.bounds.iter().enumerate() {
            muscle_index(muscles, &bound.muscle, || format!("bounds[{k}].muscle"))?;
            for (key, value) in [("min", bound.min), ("max", bound.max)] {
                if !(0.0..=1.0).contains(&value) {
                    return Err(TargetError::BoundOutside { field: format!("bounds[{k}].{key}"), value });
                }
            }
            if bound.min > bound.max {
                let (muscle, min, max) = (bound.muscle.clone(), bound.min, bound.max);
                return Err(TargetError::BoundsCross { field: format!("bounds[{k}]"), muscle, min, max });
            }
        }
        Ok(())
    }

    fn check_jaw_opening(&self) -> Result<(), TargetError> {
        let field = |key: &str| format!("{}{key}", JawOpening::FIELD);
        let opening = |key: &str, value: f64| {
            let (field, most) = (field(key), Jaw::WIDEST_MM);
            match value {
                _ if !value.is_finite() => Err(TargetError::NotFinite { field, value }),
                _ if !(0.0..=most).contains(&value) => Err(TargetError::JawOpening { field, value, most }),
                _ => Ok(()),
            }
        };
        match self.jaw_opening {
            None => Ok(()),
            Some(JawOpening::Held(value)) => opening("", value),
            Some(JawOpening::Within(range)) => {
                opening(".min", range.min_mm)?;
                opening(".max", range.max_mm)?;
                if range.min_mm >= range.max_mm {
                    let (min, max) = (range.min_mm, range.max_mm);
                    return Err(TargetError::JawRange { field: field(""), min, max });
                }
                Ok(())
            }
        }
    }

    fn check_ties(&self, muscles: &[String]) -> Result<(), TargetError> {
        let bounds_of =
            |name: &str| self.bounds.iter().find(|b| b.muscle == name).map_or([0.0, 1.0], |b| [b.min, b.max]);
        for (k, [left, right]) in self.tied.iter().enumerate() {
            let field = format!("tied[{k}]");
            for (side, name) in [left, right].into_iter().enumerate() {
                muscle_index(muscles, name, || format!("{field}[{side}]"))?;
            }
            if left == right {
                return Err(TargetError::TiedToItself { field, muscle: left.clone() });
            }
            let (left_bounds, right_bounds) = (bounds_of(left), bounds_of(right));
            if left_bounds != right_bounds {
                let (left, right) = (left.clone(), right.clone());
                return Err(TargetError::TiedUnequal { field, left, right, left_bounds, right_bounds });
            }
        }
        Ok(())
    }
}

/// Position of the muscle called `name`.
pub(super) fn muscle_index(
    muscles: &[String],
    name: &str,
    field: impl Fn() -> String,
) -> Result<usize, TargetError> {
    muscles.iter().position(|m| m == name).ok_or_else(|| TargetError::UnknownMuscle {
        field: field(),
        name: name.to_string(),
        nearest: nearest(name, muscles.iter().map(String::as_str)),
    })
}

fn sigma(field: String, value: f64) -> Result<(), TargetError> {
    let [least, most] = Target::SIGMA_MM;
    if (least..=most).contains(&value) { Ok(()) } else { Err(TargetError::Sigma { field, value }) }
}

fn unique<'a>(list: &str, names: impl Iterator<Item = &'a str>) -> Result<(), TargetError> {
    let mut seen = BTreeMap::new();
    for (k, name) in names.enumerate() {
        if let Some(first) = seen.insert(name, k) {
            return Err(TargetError::Duplicate {
                field: format!("{list}[{k}]"),
                name: name.to_string(),
                first: format!("{list}[{first}]"),
            });
        }
    }
    Ok(())
}
