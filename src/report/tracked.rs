//! A recording fitted, as a motion.

use super::motion::{Motion, MotionKind, MotionState};
use crate::face::Face;
use crate::io::TrackFiles;
use crate::study::{HeldStiffness, Strain, TrackError, TrackedFace, TrackedMoment};

/// Frames that a page shows at most where it is not said otherwise: 5.5 MB on the standard face.
pub const MOST_FRAMES: usize = 80;

/// Every `every`th frame of `track` on `face`, whose muscles have the strength with which it was fitted; the answer is that of
/// them in which the muscles do most. `done` hears of each frame that was computed.
///
/// # Errors
/// [`TrackError`] for a face that cannot be solved.
pub fn tracked_motion(
    face: &Face,
    track: &TrackFiles,
    every: usize,
    done: impl Fn(usize) + Sync,
) -> Result<Motion, TrackError> {
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let held = |name: &String| track.summary.held_stiffness.get(name).copied().unwrap_or(0.);
    let held: Vec<f64> = muscles.iter().map(held).collect();
    let has_contact = track.summary.contact_mode != "off";
    let follows = track.summary.stiffness == HeldStiffness::Follow.text();
    let strain = Strain::parse(&track.summary.strain).unwrap_or_default();
    let tracked = TrackedFace::new(face, strain, (!follows).then_some(&held[..]), has_contact)?;
    let shown: Vec<usize> = (0..track.frames.len()).step_by(every.max(1)).collect();
    let rows: Vec<Vec<f64>> = shown.iter().map(|&k| track.activations.of(k, &muscles)).collect();
    let moments: Vec<TrackedMoment<'_>> = shown
        .iter()
        .zip(&rows)
        .map(|(&k, activation)| TrackedMoment { activation, jaw_mm: track.frames[k].jaw_mm })
        .collect();
    let fields = tracked.at(&moments, done)?;
    let states: Vec<MotionState> = shown
        .iter()
        .zip(rows)
        .zip(fields)
        .map(|((&k, activation), (displacement, pose))| {
            let time = track.activations.times_s[k];
            let status = match track.frames[k].status.as_str() {
                "ok" => String::new(),
                other => format!(", {}", other.replace('_', " ")),
            };
            let label = match track.frames[k].name.as_str() {
                "" => format!("frame {k}, {time:.2} s{status}"),
                name => format!("{name}{status}"),
            };
            MotionState {
                label,
                time,
                activation,
                displacement: Some(displacement),
                pressure_kpa: None,
                pose,
                residual_mm: track.residual_mm[k].clone(),
            }
        })
        .collect();
    let effort = |state: &MotionState| state.activation.iter().map(|a| a * a).sum::<f64>();
    let most =
        (0..states.len()).max_by(|a, b| effort(&states[*a]).total_cmp(&effort(&states[*b])).then(b.cmp(a)));
    let answer = match most {
        Some(k) => states[k].clone(),
        None => Motion::straight(face, MotionState::rest(face)).answer,
    };
    let all = track.frames.len();
    let told = match every {
        0 | 1 => format!("All {all} frames; straight from one to the next"),
        _ => format!(
            "Every {every}th of {all} frames, {} in all; straight from one to the next, so that what is quicker is not seen",
            states.len()
        ),
    };
    Ok(Motion { kind: MotionKind::Track, states, answer, tangent: Vec::new(), notes: vec![told] })
}
