//! Recordings of markers, in whatever format they are.

mod c3d;
mod cell;
mod column;
mod displacement;
mod document;
mod draft;
mod error;
mod format;
mod long;
mod options;
mod reader;
mod table;
mod trc;
mod unit;
mod warning;

pub use document::RecordingDocument;
pub use error::{RecordingFileError, RecordingFileErrorKind};
pub use format::RecordingFormat;
pub use options::ReadOptions;
pub use reader::{parse_recording, read_recording};
pub use warning::RecordingFileWarning;
