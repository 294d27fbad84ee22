//! The tables of a recording fitted.

use std::fmt::Write;

use super::csv::entry;
use super::sto::sto_text;
use crate::recording::{JAW_UNKNOWNS, TrackedFrame};
use crate::study::Track;

/// Columns and rows of the unknowns over time: activations 0 to 1, then the jaw's opening, protrusion and shift to the left
/// in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackTable {
    /// Names of the columns (n).
    pub columns: Vec<String>,
    /// Times of the rows (f), s.
    pub times_s: Vec<f64>,
    /// Values (f of n).
    pub rows: Vec<Vec<f64>>,
}

impl TrackTable {
    /// That of the `frames` of `track`.
    pub fn of(track: &Track, frames: &[TrackedFrame]) -> Self {
        let mechanism = &track.mechanism;
        let jaw = JAW_UNKNOWNS.iter().filter(|_| mechanism.jaw().is_some()).map(|name| format!("{name}_mm"));
        let columns = mechanism.muscles.iter().cloned().chain(jaw).collect();
        let row = |frame: &TrackedFrame| {
            let m = mechanism.muscles.len();
            let jaw = mechanism.jaw_mm(&frame.unknowns);
            frame.unknowns[..m].iter().copied().chain(jaw.into_iter().flatten()).collect()
        };
        Self { columns, times_s: track.times_s().to_vec(), rows: frames.iter().map(row).collect() }
    }

    /// As OpenSim reads it.
    pub fn sto(&self) -> String {
        let rows = self.times_s.iter().zip(&self.rows).map(|(t, row)| (*t, row.as_slice()));
        sto_text("activations", &self.columns, rows)
    }

    /// As CSV: `time_s` and the columns.
    pub fn csv(&self) -> String {
        let mut text = String::from("time_s");
        for column in &self.columns {
            text.push(',');
            text.push_str(&entry(column));
        }
        text.push('\n');
        for (time_s, row) in self.times_s.iter().zip(&self.rows) {
            let _ = write!(text, "{time_s}");
            for value in row {
                let _ = write!(text, ",{value}");
            }
            text.push('\n');
        }
        text
    }
}

/// `frames.csv`: what became of each frame.
pub fn frames_csv(track: &Track, frames: &[TrackedFrame], names: Option<&[String]>) -> String {
    let mut text =
        String::from("frame,name,time_s,status,markers,rms_mm,outliers,touching,contact_force_n\n");
    for (k, (frame, time_s)) in frames.iter().zip(track.times_s()).enumerate() {
        let counted = |b: &usize| !frame.outliers.contains(b);
        let squares: Vec<f64> = (0..frame.residual_mm.len())
            .filter(counted)
            .filter_map(|b| frame.residual_mm[b].map(|r| r.norm_squared()))
            .collect();
        let rms = match squares.len() {
            0 => String::new(),
            n => (squares.iter().sum::<f64>() / n as f64).sqrt().to_string(),
        };
        let outliers: Vec<&str> =
            frame.outliers.iter().map(|&b| track.subject.bound[b].label.as_str()).collect();
        let name = names.map_or("", |names| names[k].as_str());
        let _ = writeln!(
            text,
            "{k},{},{time_s},{},{},{rms},{},{},{}",
            entry(name),
            frame.status.name(),
            squares.len(),
            entry(&outliers.join(" ")),
            frame.touching,
            frame.contact_force_n
        );
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
