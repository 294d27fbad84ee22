//! The format of a recording, by its content.

use std::fmt;

use crate::io::text::without_bom;

/// A format of recordings that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingFormat {
    /// C3D.
    C3d,
    /// TRC, of tabs or commas.
    Trc,
    /// A table with a row a frame.
    WideTable,
    /// A table with a row a marker and frame.
    LongTable,
    /// Face landmarks of MediaPipe, in JSON or a table.
    MediaPipe,
}

impl RecordingFormat {
    /// All of them, for messages.
    pub(super) const READ: &'static str = "C3D, TRC, CSV, MediaPipe's JSON";
}

impl fmt::Display for RecordingFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::C3d => "C3D",
            Self::Trc => "TRC",
            Self::WideTable => "table, a row a frame",
            Self::LongTable => "table, a row a marker",
            Self::MediaPipe => "MediaPipe",
        })
    }
}

/// What the first bytes tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    C3d,
    Trc,
    Json,
    Table,
}

impl Kind {
    /// What `bytes` are; a table is what is text and nothing else.
    pub(super) fn of(bytes: &[u8]) -> Self {
        let text = without_bom(bytes);
        // The second byte of a C3D file is its key; text has no zero bytes, and a header of 512 bytes has many.
        if bytes.get(1) == Some(&0x50) && bytes[..bytes.len().min(512)].contains(&0) {
            return Self::C3d;
        }
        let first = text.trim_ascii_start();
        if first.len() >= 12 && first[..12].eq_ignore_ascii_case(b"PathFileType") {
            return Self::Trc;
        }
        match first.first() {
            Some(b'{' | b'[') => Self::Json,
            _ => Self::Table,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_decides() {
        let mut c3d = [0; 512];
        c3d[..2].copy_from_slice(&[2, 0x50]);
        for (bytes, expected) in [
            (&c3d[..], Kind::C3d),
            (b"xPos,yPos\n", Kind::Table),
            (b"\xEF\xBB\xBFPathFileType\t4\t(X/Y/Z)\ta.trc\n", Kind::Trc),
            (b"time_s,a_x_mm\n", Kind::Table),
            (b"\n [[", Kind::Json),
        ] {
            assert_eq!(Kind::of(bytes), expected, "{}", String::from_utf8_lossy(bytes));
        }
    }
}
