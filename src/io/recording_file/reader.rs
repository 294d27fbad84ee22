//! Reads recordings, in whatever format they are.

use std::path::Path;

use super::document::RecordingDocument;
use super::draft::Draft;
use super::error::{RecordingFileError, RecordingFileErrorKind};
use super::format::{Kind, RecordingFormat};
use super::options::ReadOptions;
use super::{c3d, mediapipe_json, table, trc, unit};
use crate::io::text::without_bom;
use crate::io::{InputFile, Location, input};

type Result<T> = std::result::Result<T, RecordingFileError>;

/// The recording in `path`, in mm and s. The content decides the format: C3D, TRC, a table with a row a frame or a row a
/// marker, or the face landmarks of MediaPipe; `docs/formats.md` says what is read of each.
///
/// # Errors
/// With file, line or byte, field, value and fix, whenever the file is no such recording, or lacks what `options` could
/// state.
pub fn read_recording(path: &Path, options: &ReadOptions) -> Result<RecordingDocument> {
    let bytes = input::read(path, input::MESH_BYTES).map_err(|e| {
        let kind = RecordingFileErrorKind::Io { reason: e.to_string() };
        RecordingFileError::new(Location::file(path), kind)
    })?;
    parse_recording(&bytes, path, options)
}

/// The recording in `bytes`; `path` is only named in messages.
///
/// # Errors
/// As [`read_recording`].
pub fn parse_recording(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<RecordingDocument> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(RecordingFileError::new(Location::file(path), RecordingFileErrorKind::Empty));
    }
    let mut files = vec![InputFile::new(path, bytes)];
    let draft = match Kind::of(bytes) {
        Kind::C3d => c3d::parse(path, bytes, options)?,
        Kind::Trc => trc::parse(path, &text(path, bytes)?, options)?,
        Kind::Json => mediapipe_json::parse(path, without_bom(bytes), options)?,
        Kind::Table => {
            let text = text(path, bytes)?;
            table::parse(path, &text, options, &mut files)?
        }
    };
    let format = draft.format;
    let unit = match format {
        RecordingFormat::MediaPipe => "shares of the image".to_owned(),
        _ => unit::name(draft.unit).to_owned(),
    };
    let (recording, warnings) = Draft::finish(draft, path)?;
    Ok(RecordingDocument { recording, format, unit, warnings, files })
}

/// `bytes` as text; letters of old 8-bit encodings become replacement marks.
fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<std::borrow::Cow<'a, str>> {
    let control = |b: &u8| *b < 0x20 && !b.is_ascii_whitespace() && *b != 0x1A;
    match bytes.iter().position(control) {
        Some(at) => {
            let kind = RecordingFileErrorKind::NotText { value: bytes[at], formats: RecordingFormat::READ };
            Err(RecordingFileError::new(Location::file(path).at_byte(at), kind))
        }
        None => Ok(String::from_utf8_lossy(without_bom(bytes))),
    }
}
