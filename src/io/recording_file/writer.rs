//! A recording as a table that is read back.

use crate::io::csv::entry;
use crate::recording::Recording;

/// `recording` as CSV with a row a frame, `time_s,LAB_x_mm,LAB_y_mm,LAB_z_mm,...`, or `pose` first where frames have names;
/// blank where a marker was not seen. Every number is read back as it is.
pub fn recording_csv(recording: &Recording) -> String {
    let poses = recording.frame_names();
    let mut text = if poses.is_some() { "pose".to_owned() } else { "time_s".to_owned() };
    for name in recording.names() {
        for axis in ["x", "y", "z"] {
            text.push(',');
            text += &entry(&format!("{name}_{axis}_mm"));
        }
    }
    text.push('\n');
    for frame in 0..recording.n_frames() {
        text += &match poses {
            Some(poses) => entry(&poses[frame]).into_owned(),
            None => recording.times_s()[frame].to_string(),
        };
        for position in recording.frame(frame) {
            match position {
                Some(p) => text += &format!(",{},{},{}", p.x, p.y, p.z),
                None => text += ",,,",
            }
        }
        text.push('\n');
    }
    text
}
