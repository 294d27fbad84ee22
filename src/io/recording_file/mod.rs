//! Recordings of markers, in whatever format they are.

mod c3d;
mod cell;
mod column;
mod displacement;
mod document;
mod draft;
mod error;
mod format;
mod headed;
mod landmarks;
mod long;
mod mediapipe;
mod mediapipe_json;
mod options;
mod reader;
mod subject;
mod table;
mod trc;
mod unit;
mod warning;
mod wide;
mod writer;

pub use document::RecordingDocument;
pub use error::{RecordingFileError, RecordingFileErrorKind};
pub use format::RecordingFormat;
pub use options::{ImageScale, ReadOptions};
pub use reader::{parse_recording, read_recording};
pub use warning::RecordingFileWarning;
pub use writer::recording_csv;
