//! The folder that a recording's fit was written to, read back.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{
    ActivationTable, ActivationTableError, TrackJson, WriteError, csv, input, parse_activations,
    settle_folder, sha256,
};
use crate::recording::JAW_UNKNOWNS;
use crate::units::Vec3;

/// What tells a folder of a track from one of an answer.
const SUMMARY: &str = "summary.json";
/// The tables of a track that are read.
const TABLES: [&str; 3] = ["activations.csv", "frames.csv", "residuals.csv"];

/// A recording fitted, as its folder holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackFiles {
    /// What it comes to.
    pub summary: TrackJson,
    /// Activations of each frame.
    pub activations: ActivationTable,
    /// Of each frame how it ended and where the jaw is.
    pub frames: Vec<FrameRow>,
    /// Labels of the markers (b) that are on the face.
    pub markers: Vec<String>,
    /// Of each frame the measured less the fitted displacement of each marker (b), mm; `None` where it was not seen.
    pub residual_mm: Vec<Vec<Option<Vec3>>>,
}

/// A row of `frames.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// Its name, where frames have names.
    pub name: String,
    /// How it ended.
    pub status: String,
    /// Root mean square of its residuals, mm; `None` where nothing was seen.
    pub rms_mm: Option<f64>,
    /// Opening, protrusion and shift to the left of the jaw, mm.
    pub jaw_mm: [f64; 3],
}

/// A folder that holds no track.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrackFileError {
    /// A file that is missing or cannot be read.
    #[error("{}: cannot be read: {reason}; give a folder that track wrote", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: std::io::Error,
    },
    /// A file of another run, or one that was changed since.
    #[error("{}: is not the file that was written with summary.json; track the recording again, or put its own files back", .0.display())]
    Foreign(PathBuf),
    /// The files that a process which ended had written cannot be put in place.
    #[error(transparent)]
    Unsettled(#[from] WriteError),
    /// A `summary.json` without what is needed.
    #[error("{}: {reason}; write it again with track", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        reason: serde_json::Error,
    },
    /// Activations that are none of the face's muscles.
    #[error(transparent)]
    Activations(#[from] ActivationTableError),
    /// A table that is not as track writes it.
    #[error("{}:{line}: {found}; write it again with track", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is there.
        found: String,
    },
}

impl TrackFiles {
    /// Whether `dir` holds a track rather than an answer.
    pub fn is_in(dir: &Path) -> bool {
        dir.join(SUMMARY).is_file() && !dir.join("solution.json").exists()
    }
}

/// The track in the folder `dir`: `summary.json` and the tables that were written with it.
///
/// # Errors
/// [`TrackFileError`] naming the file, and the line.
pub fn read_track(dir: &Path) -> Result<TrackFiles, TrackFileError> {
    settle_folder(dir)?;
    let read = |path: &Path| {
        input::read(path, input::TEXT_BYTES)
            .map_err(|reason| TrackFileError::Missing { path: path.to_owned(), reason })
    };
    let path = dir.join(SUMMARY);
    let summary: TrackJson = serde_json::from_slice(&read(&path)?)
        .map_err(|reason| TrackFileError::Json { path: path.clone(), reason })?;
    let mut texts = Vec::new();
    for name in TABLES {
        let path = dir.join(name);
        let bytes = read(&path)?;
        if summary.files.get(name).is_none_or(|known| sha256(&bytes) != *known) {
            return Err(TrackFileError::Foreign(path));
        }
        let text = String::from_utf8(bytes).map_err(|_| TrackFileError::Foreign(path.clone()))?;
        texts.push((path, text));
    }
    let muscles: Vec<String> = summary.held_stiffness.keys().cloned().collect();
    let activations = parse_activations(&texts[0].0, &texts[0].1, &muscles)?;
    let frames = frame_rows(&texts[1].0, &texts[1].1)?;
    if frames.len() != activations.rows.len() {
        return Err(TrackFileError::Foreign(texts[1].0.clone()));
    }
    let markers: Vec<String> = summary.markers.keys().cloned().collect();
    let residual_mm = residuals(&texts[2].0, &texts[2].1, frames.len(), &markers)?;
    Ok(TrackFiles { summary, activations, frames, markers, residual_mm })
}

/// The rows of a table with some columns of it, in the order of `columns`, each with its line.
fn columns<'a>(
    path: &Path,
    text: &str,
    columns: &[&'a str],
) -> Result<Vec<(usize, Vec<String>)>, TrackFileError> {
    let wrong = |line: usize, found: String| TrackFileError::Table { path: path.to_owned(), line, found };
    let records = csv::records(text).map_err(|line| wrong(line, "the quote is never closed".to_owned()))?;
    let Some((head, body)) = records.split_first() else {
        return Err(wrong(1, "it is empty".to_owned()));
    };
    let at = |name: &&'a str| {
        let found = head.entries.iter().position(|entry| entry == name);
        found.ok_or_else(|| wrong(head.line, format!("no column is called {name}")))
    };
    let at: Vec<usize> = columns.iter().map(at).collect::<Result<_, _>>()?;
    body.iter()
        .map(|record| match record.entries.len() == head.entries.len() {
            true => Ok((record.line, at.iter().map(|k| record.entries[*k].clone()).collect())),
            false => Err(wrong(record.line, format!("{} entries", record.entries.len()))),
        })
        .collect()
}

fn number(path: &Path, line: usize, entry: &str) -> Result<f64, TrackFileError> {
    csv::number(entry).filter(|x| x.is_finite()).ok_or_else(|| TrackFileError::Table {
        path: path.to_owned(),
        line,
        found: format!("{} is no number", csv::entry(entry)),
    })
}

fn frame_rows(path: &Path, text: &str) -> Result<Vec<FrameRow>, TrackFileError> {
    let jaw = JAW_UNKNOWNS.map(|name| format!("{name}_mm"));
    let wanted = ["name", "status", "rms_mm", &jaw[0], &jaw[1], &jaw[2]];
    let row = |(line, entries): (usize, Vec<String>)| {
        let number = |k: usize| number(path, line, &entries[k]);
        Ok(FrameRow {
            jaw_mm: [number(3)?, number(4)?, number(5)?],
            rms_mm: if entries[2].is_empty() { None } else { Some(number(2)?) },
            name: entries[0].clone(),
            status: entries[1].clone(),
        })
    };
    columns(path, text, &wanted)?.into_iter().map(row).collect()
}

fn residuals(
    path: &Path,
    text: &str,
    frames: usize,
    markers: &[String],
) -> Result<Vec<Vec<Option<Vec3>>>, TrackFileError> {
    let mut residuals = vec![vec![None; markers.len()]; frames];
    for (line, entries) in columns(path, text, &["frame", "marker", "dx_mm", "dy_mm", "dz_mm"])? {
        let number = |k: usize| number(path, line, &entries[k]);
        let frame = entries[0].parse::<usize>().ok().filter(|frame| *frame < frames);
        let Some((frame, marker)) = frame.zip(markers.iter().position(|m| *m == entries[1])) else {
            let found = format!("{} in frame {}", csv::entry(&entries[1]), csv::entry(&entries[0]));
            return Err(TrackFileError::Table { path: path.to_owned(), line, found });
        };
        residuals[frame][marker] = Some(Vec3::new(number(2)?, number(3)?, number(4)?));
    }
    Ok(residuals)
}
