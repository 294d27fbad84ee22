//! Input files: their text and their fingerprints.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{input, sha256};

/// A file that was read, with the fingerprint of the bytes that were parsed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputFile {
    /// The file.
    pub path: PathBuf,
    /// SHA-256 of its bytes, 64 lower-case hexadecimal digits.
    pub sha256: String,
}

impl InputFile {
    /// The file `path` that held `bytes`.
    pub fn new(path: &Path, bytes: &[u8]) -> Self {
        Self { path: path.to_owned(), sha256: sha256(bytes) }
    }
}

/// Why a file of text cannot be read, and what to do.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnreadableText {
    /// Nothing of that name.
    #[error("there is no such file; check the path")]
    Missing,
    /// A folder.
    #[error("is a folder; name a file in it")]
    Folder,
    /// Bytes that are no text.
    #[error("is not UTF-8 text (byte {byte}); save it as UTF-8, or name the right file")]
    NotText {
        /// Where the first such byte is, from 0.
        byte: usize,
    },
    /// What need not end, or has no end in sight.
    #[error("{reason}; name the right file")]
    Unfit {
        /// What it is, or how large.
        reason: String,
    },
    /// Anything else.
    #[error("cannot be read: {reason}; check its permissions")]
    Io {
        /// What the system says.
        reason: String,
    },
}

/// The text of the regular file `path`, of at most [`input::TEXT_BYTES`], a byte-order mark included.
pub(super) fn read_text(path: &Path) -> Result<String, UnreadableText> {
    let bytes = input::read(path, input::TEXT_BYTES).map_err(|e| match e.kind() {
        io::ErrorKind::NotFound => UnreadableText::Missing,
        io::ErrorKind::IsADirectory => UnreadableText::Folder,
        io::ErrorKind::InvalidInput | io::ErrorKind::FileTooLarge => {
            UnreadableText::Unfit { reason: e.to_string() }
        }
        _ => UnreadableText::Io { reason: e.to_string() },
    })?;
    String::from_utf8(bytes).map_err(|e| UnreadableText::NotText { byte: e.utf8_error().valid_up_to() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_a_missing_file_and_bytes_that_are_no_text_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(read_text(folder.path()), Err(UnreadableText::Folder));
        let path = folder.path().join("t.toml");
        assert_eq!(read_text(&path), Err(UnreadableText::Missing));
        std::fs::write(&path, b"name = \"\xFF\"").expect("written");
        assert_eq!(read_text(&path), Err(UnreadableText::NotText { byte: 8 }));
    }
}
