//! The tables of a recording fitted.

use std::fmt::Write;

use super::ActivationTable;
use super::csv::entry;
use crate::recording::{JAW_UNKNOWNS, TrackedFrame};
use crate::study::{FrameIntervals, Track};

/// Activations of the `frames` of `track` over time.
pub fn tracked_activations(track: &Track, frames: &[TrackedFrame]) -> ActivationTable {
    let muscles = track.mechanism().muscles.clone();
    let row = |frame: &TrackedFrame| frame.unknowns[..muscles.len()].to_vec();
    let rows = frames.iter().map(row).collect();
    ActivationTable { times_s: track.times_s().to_vec(), rows, muscles }
}

/// `frames.csv`: what became of each frame, the share of its movement that is explained, and where the jaw is, mm.
pub fn frames_csv(track: &Track, frames: &[TrackedFrame], names: Option<&[String]>) -> String {
    let mut text =
        String::from("frame,name,time_s,status,markers,rms_mm,explained,outliers,touching,contact_force_n");
    for name in JAW_UNKNOWNS {
        let _ = write!(text, ",{name}_mm");
    }
    text.push('\n');
    for (k, (frame, time_s)) in frames.iter().zip(track.times_s()).enumerate() {
        let counted = |b: &usize| !frame.outliers.contains(b);
        let squares: Vec<f64> = (0..frame.residual_mm.len())
            .filter(counted)
            .filter_map(|b| frame.residual_mm[b].map(|r| r.norm_squared()))
            .collect();
        let sum: f64 = squares.iter().sum();
        let moved: f64 = (0..frame.residual_mm.len())
            .filter(counted)
            .filter_map(|b| track.movement.frame(k)[b].map(|u| u.norm_squared()))
            .sum();
        let rms = match squares.len() {
            0 => String::new(),
            n => (sum / n as f64).sqrt().to_string(),
        };
        let explained = if moved > 0. { (1. - sum / moved).to_string() } else { String::new() };
        let outliers: Vec<&str> =
            frame.outliers.iter().map(|&b| track.subject.bound[b].label.as_str()).collect();
        let name = names.map_or("", |names| names[k].as_str());
        let touched =
            frame.touched.map(|touched| (touched.contacts.to_string(), touched.force_n.to_string()));
        let (touching, force_n) = touched.unwrap_or_default();
        let _ = write!(
            text,
            "{k},{},{time_s},{},{},{rms},{explained},{},{touching},{force_n}",
            entry(name),
            frame.status.name(),
            squares.len(),
            entry(&outliers.join(" "))
        );
        for jaw_mm in track.mechanism().jaw_mm(&frame.unknowns).unwrap_or([0.; 3]) {
            let _ = write!(text, ",{jaw_mm}");
        }
        text.push('\n');
    }
    text
}

/// `intervals.csv`: value, least and greatest value of each activation, and of each movement of the jaw, mm, in the frames that
/// have intervals.
pub fn intervals_csv(track: &Track, frames: &[TrackedFrame], intervals: &[FrameIntervals]) -> String {
    let mut text = String::from("frame,time_s,noise_factor,unknown,value,min,max\n");
    let muscles = &track.mechanism().muscles;
    let names = muscles.iter().cloned().chain(JAW_UNKNOWNS.iter().map(|name| format!("{name}_mm")));
    let names: Vec<String> = names.map(|name| entry(&name).into_owned()).collect();
    for FrameIntervals { frame, intervals } in intervals {
        let shown = |x: &[f64]| -> Vec<f64> {
            let jaw = track.mechanism().jaw_mm(x);
            x[..muscles.len()].iter().copied().chain(jaw.into_iter().flatten()).collect()
        };
        let (value, min, max) = (
            shown(&frames[*frame].unknowns),
            shown(intervals.min.as_slice()),
            shown(intervals.max.as_slice()),
        );
        let (time_s, factor) = (track.times_s()[*frame], intervals.noise_factor);
        for (k, name) in names.iter().take(value.len()).enumerate() {
            let _ = writeln!(text, "{frame},{time_s},{factor},{name},{},{},{}", value[k], min[k], max[k]);
        }
    }
    text
}

/// `residuals.csv`: measured less fitted displacement of each marker that was seen, mm on the face.
pub fn residuals_csv(track: &Track, frames: &[TrackedFrame]) -> String {
    let mut text = String::from("frame,time_s,marker,dx_mm,dy_mm,dz_mm,counted\n");
    for (k, (frame, time_s)) in frames.iter().zip(track.times_s()).enumerate() {
        for (b, residual) in frame.residual_mm.iter().enumerate() {
            let Some(r) = residual else { continue };
            let label = entry(&track.subject.bound[b].label);
            let counted = u8::from(!frame.outliers.contains(&b));
            let _ = writeln!(text, "{k},{time_s},{label},{:.4},{:.4},{:.4},{counted}", r.x, r.y, r.z);
        }
    }
    text
}
