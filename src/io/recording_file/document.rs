//! A recording as its file states it, with what is odd about it.

use super::{RecordingFileWarning, RecordingFormat};
use crate::io::InputFile;
use crate::recording::Recording;

/// A recording with what was odd about its file.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingDocument {
    /// The recording, mm and s.
    pub recording: Recording,
    /// The format of its file.
    pub format: RecordingFormat,
    /// The unit of length of the file, as a message names it: `mm`, or what stands for it.
    pub unit: String,
    /// What the user should look at.
    pub warnings: Vec<RecordingFileWarning>,
    /// The files that were read, the recording's first.
    pub files: Vec<InputFile>,
}
