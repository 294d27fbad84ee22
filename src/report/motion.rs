//! How a result is moved on the page.

use crate::face::{Face, Pose};
use crate::study::{Mechanics, Mover, StudyError};
use crate::units::Vec3;

/// What the states of a motion are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// The way from rest to an answer.
    Loading,
    /// Answers or frames, one after the other.
    Sequence,
    /// Frames of a recording, with the markers of each.
    Track,
}

/// A face at one moment.
#[derive(Clone, Debug)]
pub struct MotionState {
    /// What it is called.
    pub label: String,
    /// When it is, s; on the way to an answer the share of the activations, 0 to 1.
    pub time: f64,
    /// Activations (m).
    pub activation: Vec<f64>,
    /// Displacement (3n), mm; `None` where the tangent at the answer is to give it.
    pub displacement: Option<Vec<f64>>,
    /// Contact pressure of the nodes (n), kPa; `None` where it is not known.
    pub pressure_kpa: Option<Vec<f64>>,
    /// Where the bones are.
    pub pose: Pose,
    /// Measured less modelled displacement of each marker that is shown, mm, `None` where it was not seen; empty where markers
    /// are those of the answer alone.
    pub residual_mm: Vec<Option<Vec3>>,
}

impl MotionState {
    /// `face` at rest.
    pub fn rest(face: &Face) -> Self {
        Self {
            label: "rest".to_owned(),
            time: 0.,
            activation: vec![0.; face.muscles.len()],
            displacement: Some(vec![0.; 3 * face.mesh.n_nodes()]),
            pressure_kpa: None,
            pose: Pose::rest(),
            residual_mm: Vec::new(),
        }
    }
}

/// A face that moves: an answer, what each muscle adds there, and states in the order of their times.
#[derive(Clone, Debug)]
pub struct Motion {
    /// What the states are.
    pub kind: MotionKind,
    /// Those before the answer on the way to it, or all of a sequence.
    pub states: Vec<MotionState>,
    /// The answer, whose displacement is given.
    pub answer: MotionState,
    /// `du/da_m` at the answer (m x 3n), mm per unit activation; none where there is no tangent.
    pub tangent: Vec<Vec<f64>>,
    /// How the states came about, and what is odd about them.
    pub notes: Vec<String>,
}

/// Distance between the stored and the settled answer that is told, mm.
const TOLD_MM: f64 = 0.05;

impl Motion {
    /// The way of `face` from rest to the state `answer`: the face settled by `mechanics` at `steps - 1` equal parts of its
    /// activations and of its pose, the answer itself as it was stored, and the tangent there.
    ///
    /// A part at which the face does not settle is left out, and told.
    ///
    /// # Errors
    /// [`StudyError`] when the face cannot be moved by `mechanics`.
    pub fn loading(
        face: &Face,
        mechanics: Mechanics,
        answer: MotionState,
        steps: usize,
    ) -> Result<Self, StudyError> {
        let mover = Mover::new(face, mechanics)?;
        let mut motion = Self::straight(face, answer);
        let end = motion.answer.clone();
        let mut missing: Vec<String> = Vec::new();
        for step in 1..steps {
            let share = step as f64 / steps as f64;
            let activation: Vec<f64> = end.activation.iter().map(|a| share * a).collect();
            let pose = Pose::rest().towards(&end.pose, share);
            match mover.settle(&activation, &pose) {
                Ok(moved) => motion.states.push(MotionState {
                    label: format!("{:.0} % of the activations", 100. * share),
                    time: share,
                    activation,
                    displacement: Some(moved.displacement),
                    pressure_kpa: moved.contact.map(|contact| contact.load.pressure_kpa),
                    pose,
                    residual_mm: Vec::new(),
                }),
                Err(_) => missing.push(format!("{:.0} %", 100. * share)),
            }
        }
        motion.notes.clear();
        let computed = motion.states.len() - 1;
        motion.notes.push(format!(
            "Rest and answer as stored, {computed} computed {} between; straight from one to the next",
            if computed == 1 { "state" } else { "states" }
        ));
        if !missing.is_empty() {
            motion
                .notes
                .push(format!("The face does not settle at {} of the activations", missing.join(", ")));
        }
        match mover.tangent(&end.activation, &end.pose) {
            Ok(found) => {
                let stored = end.displacement.iter().flatten();
                let off =
                    stored.zip(&found.moved.displacement).map(|(a, b)| (a - b).abs()).fold(0., f64::max);
                if off > TOLD_MM {
                    motion.notes.push(format!(
                        "The tangent is taken where the face settles from rest, up to {off:.1} mm from the stored answer"
                    ));
                }
                motion.tangent = found.fields;
            }
            Err(error) => motion.notes.push(format!("No tangent at the answer: {error}")),
        }
        Ok(motion)
    }

    /// The straight way of `face` from rest to the state `answer`, with no tangent.
    pub fn straight(face: &Face, answer: MotionState) -> Self {
        let pressure_kpa = answer.pressure_kpa.as_ref().map(|p| vec![0.; p.len()]);
        let rest = MotionState { pressure_kpa, ..MotionState::rest(face) };
        let notes = vec!["Straight from rest to the stored answer; nothing between was computed".to_owned()];
        let answer = MotionState { time: 1., ..answer };
        Self { kind: MotionKind::Loading, states: vec![rest], answer, tangent: Vec::new(), notes }
    }

    /// The same answer and tangent with other `states`, one after the other.
    pub fn with_sequence(self, states: Vec<MotionState>) -> Self {
        let mut notes = self.notes;
        if let Some(note) = notes.first_mut() {
            let superposed = states.iter().filter(|state| state.displacement.is_none()).count();
            *note = match superposed {
                0 => format!("{} answers as stored; straight from one to the next", states.len()),
                _ => format!("{} frames, by superposition of the tangent at the answer", states.len()),
            };
        }
        Self { kind: MotionKind::Sequence, states, notes, ..self }
    }
}
