//! A recording with its marker map, and the neutral positions that the map names.

use std::path::Path;

use thiserror::Error;

use super::input_file::InputFile;
use super::{
    MarkerMapError, ReadOptions, RecordingDocument, RecordingFileError, RecordingFileErrorKind,
    read_marker_map, read_recording,
};
use crate::recording::{MarkerMap, Neutral};

/// A recording and how its markers are to be read.
#[derive(Clone, Debug)]
pub struct MappedRecording {
    /// The recording.
    pub document: RecordingDocument,
    /// How its markers are to be read.
    pub map: MarkerMap,
    /// All files that were read.
    pub files: Vec<InputFile>,
}

/// Why a recording or its map was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MappedRecordingError {
    /// A recording.
    #[error(transparent)]
    Recording(#[from] RecordingFileError),
    /// The map.
    #[error(transparent)]
    Map(#[from] MarkerMapError),
}

/// Reads the recording in `path`, of which `stated` says what its file does not, with the `map`; without one labels are names
/// of landmarks, and the first frame is neutral.
///
/// # Errors
/// [`MappedRecordingError`]: it names the file, the place, the value and the remedy.
pub fn read_mapped_recording(
    path: &Path,
    map: Option<&Path>,
    stated: &ReadOptions,
) -> Result<MappedRecording, MappedRecordingError> {
    let mut files = Vec::new();
    let (mut markers, mut neutral_file) = (MarkerMap::default(), None);
    if let Some(path) = map {
        let document = read_marker_map(path)?;
        files.push(InputFile { path: path.to_owned(), sha256: document.sha256 });
        (markers, neutral_file) = (document.map, document.neutral_file);
    }
    if let Some(path) = &neutral_file {
        let RecordingDocument { recording, files: read, .. } =
            read_recording(path, &ReadOptions { neutral: None, ..*stated })?;
        files.extend(read);
        let seen = recording.names().iter().zip(recording.frame(0));
        markers.neutral =
            Neutral::Positions(seen.filter_map(|(label, p)| Some((label.clone(), (*p)?))).collect());
    }
    let document = match read_recording(path, stated) {
        // The displacements of a table count from where the markers rest.
        Err(error)
            if matches!(error.kind, RecordingFileErrorKind::AbsentNeutral { .. })
                && neutral_file.is_some() =>
        {
            read_recording(path, &ReadOptions { neutral: neutral_file.as_deref(), ..*stated })?
        }
        read => read?,
    };
    files.extend(document.files.iter().cloned());
    Ok(MappedRecording { document, map: markers, files })
}
