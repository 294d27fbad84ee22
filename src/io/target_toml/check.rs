//! From the tables of a target file to a target, with every value checked.

use std::collections::BTreeMap;

use super::error::{TargetFileError, TargetWarning};
use super::file::{
    AxisName, BoundTable, Component, CostTable, EffortName, FeatureTable, LossName, MarkerTable, NormName,
    OpeningTable, OpeningValue, PlaceValue, PriorTable, SymmetryTable, TargetTable,
};
use super::lines::FieldLines;
use crate::face::{Jaw, JawRange};
use crate::inverse::{
    Axis, Bound, EffortMeasure, EffortNorm, Expected, Feature, FeatureGoal, Goal, JawOpening, Loss, Marker,
    MirroredPair, MuscleCost, Place, Prior, Target,
};
use crate::io::Location;
use crate::units::Vec3;

/// Skin never moves farther than this, mm: the widest jaw opening carries the chin about 60 mm.
const LARGEST_DISPLACEMENT_MM: f64 = 100.0;
/// When nothing moves farther than this, mm, the figures are in metres.
const SMALLEST_DISPLACEMENT_MM: f64 = 0.05;
/// No point of a head is farther from the stomion than this, mm.
const LARGEST_POSITION_MM: f64 = 500.0;
/// When several points all lie within this of the stomion, mm, the figures are in metres.
const SMALLEST_POSITION_MM: f64 = 0.5;

/// A point other than the stomion that is nearer to it than this, mm, along every axis is in metres.
const IN_METRES_MM: f64 = 0.1;

/// Longest name of a target or plan, bytes: file systems take 255.
const LONGEST_NAME: usize = 100;

type Checked<T> = Result<T, TargetFileError>;

/// Checks one file; keeps the lines for messages and collects the warnings.
pub(super) struct Checker<'a> {
    pub(super) lines: &'a FieldLines,
    pub(super) warnings: Vec<TargetWarning>,
    labels: BTreeMap<String, String>,
}

impl<'a> Checker<'a> {
    pub(super) fn new(lines: &'a FieldLines) -> Self {
        Self { lines, warnings: Vec::new(), labels: BTreeMap::new() }
    }

    pub(super) fn target(&mut self, table: TargetTable) -> Checked<Target> {
        self.named("name", &table.name)?;
        word(self.lines, "name", &table.name)?;
        let markers = self.each("markers", &table.markers, Self::marker)?;
        self.scale(&markers)?;
        let features = self.each("features", &table.features, Self::feature)?;
        self.feature_scale(&features)?;
        Ok(Target {
            markers,
            features,
            symmetry: self.each("symmetry", &table.symmetry, Self::symmetry)?,
            effort: self.effort(table.effort)?,
            effort_norm: match table.effort_norm {
                Some(NormName::L1) => EffortNorm::L1,
                None | Some(NormName::L2) => EffortNorm::L2,
            },
            effort_by: match table.effort_by {
                None | Some(EffortName::Activation) => EffortMeasure::Activation,
                Some(EffortName::Force) => EffortMeasure::Force,
                Some(EffortName::Volume) => EffortMeasure::Volume,
            },
            costs: self.costs(&table.costs)?,
            loss: self.loss(table.loss, table.loss_sigmas)?,
            priors: self.priors(&table.priors)?,
            bounds: self.bounds(&table.bounds)?,
            jaw_opening: table.jaw_opening_mm.map(|value| self.jaw_opening(value)).transpose()?,
            tied: self.each("tied", &table.tied, Self::tied)?,
            expected: self.each("expected", &table.expected, |check, at, e| {
                check.named(&format!("{at}.face"), &e.face)?;
                Ok(Expected {
                    face: e.face.clone(),
                    residual_rms_mm: check
                        .not_negative(&format!("{at}.residual_rms_mm"), e.residual_rms_mm)?,
                    tolerance_mm: check.positive(&format!("{at}.tolerance_mm"), e.tolerance_mm)?,
                })
            })?,
            name: table.name,
            description: table.description,
            provenance: table.provenance,
        })
    }

    fn each<T, U>(
        &mut self,
        list: &str,
        tables: &[T],
        one: impl Fn(&mut Self, &str, &T) -> Checked<U>,
    ) -> Checked<Vec<U>> {
        tables.iter().enumerate().map(|(i, table)| one(self, &format!("{list}[{i}]"), table)).collect()
    }

    fn marker(&mut self, at: &str, table: &MarkerTable) -> Checked<Marker> {
        let place = match (&table.landmark, table.point_mm) {
            (Some(_), Some(_)) => return Err(self.both(at, "landmark", "point_mm")),
            (None, None) => return Err(self.neither(at, "landmark", "point_mm")),
            (Some(name), None) => PlaceValue::Landmark(name.clone()),
            (None, Some(point)) => PlaceValue::Point(point),
        };
        let (key, name) = match (&table.name, &place) {
            (Some(name), _) => ("name", name.clone()),
            (None, PlaceValue::Landmark(name)) => ("landmark", name.clone()),
            (None, PlaceValue::Point(_)) => return Err(self.missing(at, "name", "a label for this point")),
        };
        self.label(&format!("{at}.{key}"), &name)?;
        let field = if matches!(place, PlaceValue::Landmark(_)) { "landmark" } else { "point_mm" };
        let marker_at = self.place(&format!("{at}.{field}"), &place)?;
        let goal = match (table.displacement_mm, table.position_mm) {
            (Some(_), Some(_)) => return Err(self.both(at, "displacement_mm", "position_mm")),
            (None, Some(p)) => Goal::Position(self.components(&format!("{at}.position_mm"), p)?),
            (Some(d), None) => {
                let field = format!("{at}.displacement_mm");
                let d = self.components(&field, d)?;
                if d == [Some(0.0); 3] {
                    let at = self.lines.location(&field);
                    self.warnings.push(TargetWarning::ZeroMarker { at, name: name.clone() });
                }
                Goal::Displacement(d)
            }
            (None, None) => Goal::Displacement([None; 3]),
        };
        if goal.observed().count() == 0 {
            let at = self.lines.location(at);
            self.warnings.push(TargetWarning::MissingMarker { at, name: name.clone() });
        }
        let sigma_mm = self.sigma(&format!("{at}.sigma_mm"), table.sigma_mm)?;
        Ok(Marker { name, at: marker_at, goal, sigma_mm })
    }

    fn feature(&mut self, at: &str, table: &FeatureTable) -> Checked<Feature> {
        let name = match &table.name {
            Some(name) => name.clone(),
            None => format!("{} to {}", table.from, table.to),
        };
        let key = if table.name.is_some() { "name" } else { "from" };
        self.label(&format!("{at}.{key}"), &name)?;
        let from = self.place(&format!("{at}.from"), &table.from)?;
        let to = self.place(&format!("{at}.to"), &table.to)?;
        self.differ(at, ("from", &table.from), ("to", &table.to))?;
        let axis = table.axis.map(|a| match a {
            AxisName::X => Axis::X,
            AxisName::Y => Axis::Y,
            AxisName::Z => Axis::Z,
        });
        let goal = match (table.value_mm, table.change_mm) {
            (Some(_), Some(_)) => return Err(self.both(at, "value_mm", "change_mm")),
            (None, None) => return Err(self.neither(at, "value_mm", "change_mm")),
            (Some(value), None) => {
                let field = format!("{at}.value_mm");
                self.length(&field, value)?;
                if axis.is_none() {
                    self.not_negative(&field, value)?;
                }
                FeatureGoal::Value(value)
            }
            (None, Some(change)) => FeatureGoal::Change(self.length(&format!("{at}.change_mm"), change)?),
        };
        let sigma_mm = self.sigma(&format!("{at}.sigma_mm"), table.sigma_mm)?;
        Ok(Feature { name, from, to, axis, goal, sigma_mm })
    }

    fn symmetry(&mut self, at: &str, table: &SymmetryTable) -> Checked<MirroredPair> {
        let left = self.place(&format!("{at}.left"), &table.left)?;
        let right = self.place(&format!("{at}.right"), &table.right)?;
        self.differ(at, ("left", &table.left), ("right", &table.right))?;
        let sigma_mm = self.sigma(&format!("{at}.sigma_mm"), table.sigma_mm)?;
        Ok(MirroredPair { left, right, sigma_mm })
    }

    fn loss(&self, name: Option<LossName>, sigmas: Option<f64>) -> Checked<Loss> {
        const USUAL: f64 = 3.;
        let sigmas = sigmas.map(|value| self.positive("loss_sigmas", value)).transpose()?;
        match (name, sigmas) {
            (Some(LossName::Huber), sigmas) => Ok(Loss::Huber(sigmas.unwrap_or(USUAL))),
            (_, None) => Ok(Loss::Squares),
            (_, Some(_)) => {
                let what = "\"huber\", whose turn loss_sigmas is".to_owned();
                Err(TargetFileError::MissingField { at: self.at("loss"), what })
            }
        }
    }

    /// Refuses two entries of `list` for one muscle.
    fn once_a_muscle<'t>(&self, list: &str, muscles: impl Iterator<Item = &'t String>) -> Checked<()> {
        let mut first: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, muscle) in muscles.enumerate() {
            let field = format!("{list}[{i}].muscle");
            self.named(&field, muscle)?;
            if let Some(before) = first.insert(muscle, i) {
                return Err(TargetFileError::Duplicate {
                    at: self.at(&field),
                    value: muscle.clone(),
                    first_line: self.first_line(&format!("{list}[{before}].muscle")),
                });
            }
        }
        Ok(())
    }

    fn costs(&mut self, tables: &[CostTable]) -> Checked<Vec<MuscleCost>> {
        self.once_a_muscle("costs", tables.iter().map(|table| &table.muscle))?;
        self.each("costs", tables, |check, at, table| {
            let factor = check.not_negative(&format!("{at}.factor"), table.factor)?;
            Ok(MuscleCost { muscle: table.muscle.clone(), factor })
        })
    }

    fn priors(&mut self, tables: &[PriorTable]) -> Checked<Vec<Prior>> {
        self.once_a_muscle("priors", tables.iter().map(|table| &table.muscle))?;
        self.each("priors", tables, |check, at, table| {
            let activation = check.fraction(&format!("{at}.activation"), table.activation)?;
            let sigma = check.positive(&format!("{at}.sigma"), table.sigma)?;
            Ok(Prior { muscle: table.muscle.clone(), activation, sigma })
        })
    }

    fn bounds(&mut self, tables: &[BoundTable]) -> Checked<Vec<Bound>> {
        self.once_a_muscle("bounds", tables.iter().map(|table| &table.muscle))?;
        self.each("bounds", tables, |check, at, table| {
            let min = check.fraction(&format!("{at}.min"), table.min.unwrap_or(0.0))?;
            let max = check.fraction(&format!("{at}.max"), table.max.unwrap_or(1.0))?;
            if min > max {
                let muscle = table.muscle.clone();
                return Err(TargetFileError::BoundsCrossed { at: check.at(at), muscle, min, max });
            }
            Ok(Bound { muscle: table.muscle.clone(), min, max })
        })
    }

    fn jaw_opening(&self, value: OpeningValue) -> Checked<JawOpening> {
        let opening = |key: &str, value: f64| {
            let field = format!("{}{key}", JawOpening::FIELD);
            self.finite(&field, value)?;
            let most = Jaw::WIDEST_MM;
            if 0.0 < value && value < SMALLEST_DISPLACEMENT_MM {
                let (at, problem) = (self.at(&field), "is less than a jaw opens");
                return Err(TargetFileError::Scale { at, value, problem });
            }
            if (0.0..=most).contains(&value) {
                return Ok(value);
            }
            Err(TargetFileError::JawOpening { at: self.at(&field), value, most })
        };
        match value {
            OpeningValue::Held(value) => Ok(JawOpening::Held(opening("", value)?)),
            OpeningValue::Within(OpeningTable { min, max }) => {
                let (min_mm, max_mm) = (opening(".min", min)?, opening(".max", max)?);
                if min > max {
                    let (at, muscle) = (self.at(JawOpening::FIELD), JawOpening::FIELD.to_owned());
                    return Err(TargetFileError::BoundsCrossed { at, muscle, min, max });
                }
                // Nothing is left unknown between equal bounds.
                Ok(if min == max {
                    JawOpening::Held(min)
                } else {
                    JawOpening::Within(JawRange { min_mm, max_mm })
                })
            }
        }
    }

    fn tied(&mut self, at: &str, [first, second]: &[String; 2]) -> Checked<[String; 2]> {
        self.named(&format!("{at}[0]"), first)?;
        self.named(&format!("{at}[1]"), second)?;
        if first == second {
            let (at, value) = (self.at(at), first.clone());
            return Err(TargetFileError::Same { at, first: "the first", second: "the second", value });
        }
        Ok([first.clone(), second.clone()])
    }

    /// Refuses markers whose size shows that the file is not in millimetres.
    fn scale(&self, markers: &[Marker]) -> Checked<()> {
        let sizes = |of: fn(&Goal) -> bool| -> Vec<(usize, f64)> {
            let chosen = markers.iter().enumerate().filter(|(_, m)| of(&m.goal));
            chosen.map(|(i, m)| (i, m.goal.observed().map(f64::abs).fold(0.0, f64::max))).collect()
        };
        let moves = sizes(|g| matches!(g, Goal::Displacement(_)));
        let stands = sizes(|g| matches!(g, Goal::Position(_)));
        let wrong = |i: usize, key: &str, value: f64, problem: &'static str| {
            Err(TargetFileError::Scale { at: self.at(&format!("markers[{i}].{key}")), value, problem })
        };
        if let Some(&(i, size)) = moves.iter().find(|(_, s)| *s > LARGEST_DISPLACEMENT_MM) {
            return wrong(i, "displacement_mm", size, "is more than the 100 mm that skin can move");
        }
        if let Some(&(i, size)) = stands.iter().find(|(_, s)| *s > LARGEST_POSITION_MM) {
            return wrong(i, "position_mm", size, "is more than the 500 mm of a head");
        }
        let largest = |sizes: &[(usize, f64)]| sizes.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((i, size)) = largest(&moves)
            && (0.0 < size && size < SMALLEST_DISPLACEMENT_MM)
        {
            return wrong(i, "displacement_mm", size, "is the largest displacement, under 0.05 mm");
        }
        if let Some((i, size)) = largest(&stands)
            && stands.len() > 1
            && (0.0 < size && size < SMALLEST_POSITION_MM)
        {
            return wrong(i, "position_mm", size, "is the largest coordinate, under 0.5 mm");
        }
        let rests = markers.iter().enumerate().filter_map(|(i, m)| match &m.at {
            Place::Point(p) => Some((i, p.amax())),
            Place::Landmark(_) => None,
        });
        let rests: Vec<(usize, f64)> = rests.collect();
        if let Some((i, size)) = largest(&rests)
            && rests.len() > 1
            && (0.0 < size && size < SMALLEST_POSITION_MM)
        {
            return wrong(i, "point_mm", size, "is the largest coordinate of a rest point, under 0.5 mm");
        }
        Ok(())
    }

    /// Refuses lengths so small that the file is not in millimetres.
    fn feature_scale(&self, features: &[Feature]) -> Checked<()> {
        let sizes = features.iter().enumerate().map(|(i, f)| match f.goal {
            FeatureGoal::Value(value) => (i, "value_mm", value),
            FeatureGoal::Change(change) => (i, "change_mm", change),
        });
        let Some((i, key, value)) = sizes.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs())) else {
            return Ok(());
        };
        if 0.0 < value.abs() && value.abs() < SMALLEST_DISPLACEMENT_MM {
            let (at, problem) =
                (self.at(&format!("features[{i}].{key}")), "is the largest length, under 0.05 mm");
            return Err(TargetFileError::Scale { at, value, problem });
        }
        Ok(())
    }

    fn place(&self, field: &str, value: &PlaceValue) -> Checked<Place> {
        match value {
            PlaceValue::Landmark(name) => {
                self.named(field, name)?;
                Ok(Place::Landmark(name.clone()))
            }
            PlaceValue::Point(point) => {
                for (k, &x) in point.iter().enumerate() {
                    self.length(&format!("{field}[{k}]"), x)?;
                }
                let point = Vec3::from(*point);
                let value = point.amax();
                if 0.0 < value && value < IN_METRES_MM {
                    let (at, problem) = (self.at(field), "is the largest coordinate of a rest point");
                    return Err(TargetFileError::Scale { at, value, problem });
                }
                Ok(Place::Point(point))
            }
        }
    }

    fn components(&self, field: &str, row: [Component; 3]) -> Checked<[Option<f64>; 3]> {
        for (k, component) in row.iter().enumerate() {
            if let Some(x) = component.0 {
                self.finite(&format!("{field}[{k}]"), x)?;
            }
        }
        Ok(row.map(|c| c.0))
    }

    fn label(&mut self, field: &str, name: &str) -> Checked<()> {
        self.named(field, name)?;
        match self.labels.insert(name.to_owned(), field.to_owned()) {
            None => Ok(()),
            Some(first) => Err(TargetFileError::Duplicate {
                at: self.at(field),
                value: name.to_owned(),
                first_line: self.first_line(&first),
            }),
        }
    }

    fn differ(
        &self,
        at: &str,
        a: (&'static str, &PlaceValue),
        b: (&'static str, &PlaceValue),
    ) -> Checked<()> {
        if a.1 != b.1 {
            return Ok(());
        }
        let (at, value) = (self.at(at), a.1.to_string());
        Err(TargetFileError::Same { at, first: a.0, second: b.0, value })
    }

    fn named(&self, field: &str, name: &str) -> Checked<()> {
        if name.trim().is_empty() {
            return Err(TargetFileError::EmptyName { at: self.at(field) });
        }
        Ok(())
    }

    fn finite(&self, field: &str, value: f64) -> Checked<f64> {
        if value.is_finite() {
            return Ok(value);
        }
        Err(TargetFileError::NotFinite { at: self.at(field), value })
    }

    fn length(&self, field: &str, value: f64) -> Checked<f64> {
        self.finite(field, value)?;
        if value.abs() > LARGEST_POSITION_MM {
            let (at, problem) = (self.at(field), "is more than the 500 mm of a head");
            return Err(TargetFileError::Scale { at, value, problem });
        }
        Ok(value)
    }

    fn positive(&self, field: &str, value: f64) -> Checked<f64> {
        self.finite(field, value)?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(TargetFileError::NotPositive { at: self.at(field), value })
    }

    fn sigma(&self, field: &str, value: f64) -> Checked<f64> {
        self.positive(field, value)?;
        let accepted = Target::SIGMA_MM;
        if (accepted[0]..=accepted[1]).contains(&value) {
            return Ok(value);
        }
        let (at, what) = (self.at(field), "mm, how far the value may be off");
        Err(TargetFileError::OutOfRange { at, value, accepted, what })
    }

    fn effort(&self, value: f64) -> Checked<f64> {
        self.not_negative("effort", value)?;
        let accepted = [0.0, Target::MOST_EFFORT];
        if value <= accepted[1] {
            return Ok(value);
        }
        let (at, what) = (self.at("effort"), "the weight of the activations");
        Err(TargetFileError::OutOfRange { at, value, accepted, what })
    }

    fn not_negative(&self, field: &str, value: f64) -> Checked<f64> {
        self.finite(field, value)?;
        if value >= 0.0 {
            return Ok(value);
        }
        Err(TargetFileError::Negative { at: self.at(field), value })
    }

    fn fraction(&self, field: &str, value: f64) -> Checked<f64> {
        self.finite(field, value)?;
        if (0.0..=1.0).contains(&value) {
            return Ok(value);
        }
        Err(TargetFileError::OutsideUnit { at: self.at(field), value })
    }

    fn both(&self, at: &str, first: &'static str, second: &'static str) -> TargetFileError {
        TargetFileError::Both { at: self.at(at), first, second }
    }

    fn neither(&self, at: &str, first: &'static str, second: &'static str) -> TargetFileError {
        TargetFileError::Neither { at: self.at(at), first, second }
    }

    fn missing(&self, at: &str, key: &str, what: &str) -> TargetFileError {
        TargetFileError::MissingField { at: self.at(&format!("{at}.{key}")), what: what.to_owned() }
    }

    fn at(&self, field: &str) -> Box<Location> {
        Box::new(self.lines.location(field))
    }

    fn first_line(&self, field: &str) -> usize {
        self.at(field).line.unwrap_or(0)
    }
}

/// Refuses a name that is not one word: it becomes the name of a folder.
pub(in crate::io) fn word(lines: &FieldLines, field: &str, name: &str) -> Checked<()> {
    let is_plain = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.len() <= LONGEST_NAME && name.chars().all(is_plain) {
        return Ok(());
    }
    let (at, most) = (Box::new(lines.location(field)), LONGEST_NAME);
    Err(TargetFileError::Name { at, value: name.chars().take(LONGEST_NAME).collect(), most })
}
