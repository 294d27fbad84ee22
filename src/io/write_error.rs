//! Why a file cannot be written.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file or folder that cannot be written; what was there before stays.
#[derive(Debug, Error)]
#[error("{}: {kind}", path.display())]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// Why not.
    #[source]
    pub kind: WriteErrorKind,
}

/// Why not, and what to do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteErrorKind {
    /// A device, pipe, folder or dangling link of this name.
    #[error("is {what} and is not replaced; name a file")]
    NotRegular {
        /// `a folder`, `a device` ...
        what: &'static str,
    },
    /// A file of this name where a folder is needed.
    #[error("is no folder; give another one")]
    NotAFolder,
    /// A name that the file system does not take.
    #[error("the name is too long for the file system; shorten it")]
    NameTooLong,
    /// No room.
    #[error("the disk is full; make room, or write to another one")]
    DiskFull,
    /// Permissions.
    #[error("cannot be written: permission denied; give a place that you may write to")]
    Denied,
    /// Anything else.
    #[error("cannot be written: {0}; give another place")]
    Io(io::Error),
}

impl WriteError {
    /// What `reason` means for `path`.
    pub fn new(path: &Path, reason: io::Error) -> Self {
        use io::ErrorKind as E;
        let kind = match reason.kind() {
            E::InvalidFilename => WriteErrorKind::NameTooLong,
            E::StorageFull | E::QuotaExceeded => WriteErrorKind::DiskFull,
            E::PermissionDenied | E::ReadOnlyFilesystem => WriteErrorKind::Denied,
            E::NotADirectory | E::AlreadyExists => WriteErrorKind::NotAFolder,
            _ => WriteErrorKind::Io(reason),
        };
        Self { path: path.to_owned(), kind }
    }

    /// Whether a file can come to stand at `path`, as far as can be seen before it is written: what is there is a regular
    /// file or nothing, and so is no folder above it.
    ///
    /// # Errors
    /// [`WriteError`] that says what stands in the way.
    pub fn check(path: &Path) -> Result<(), Self> {
        let above = path.ancestors().skip(1).find(|folder| folder.exists());
        match above {
            Some(file) if !file.is_dir() => {
                Err(Self { path: file.to_owned(), kind: WriteErrorKind::NotAFolder })
            }
            _ => Self::check_regular(path),
        }
    }

    /// `path` may be written: it is absent or a regular file, or a link to one.
    pub(super) fn check_regular(path: &Path) -> Result<(), Self> {
        let not = |what| Err(Self { path: path.to_owned(), kind: WriteErrorKind::NotRegular { what } });
        match std::fs::metadata(path) {
            Ok(there) if there.is_file() => Ok(()),
            Ok(there) if there.is_dir() => not("a folder"),
            Ok(_) => not("a device or a pipe"),
            Err(e) if e.kind() == io::ErrorKind::NotFound && path.is_symlink() => not("a link to nothing"),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
            Err(e) => Err(Self::new(path, e)),
        }
    }
}
