//! Files that are either complete or absent.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::WriteError;

/// Writes `bytes` to `path` through a temporary file in the same folder and a rename, so that a crash or
/// a full disk leaves the old file, or none, but never half of one. Of a link the file that it leads to is
/// replaced.
///
/// # Errors
/// [`WriteError`]: what is no regular file is not replaced, and what the file system reports; the temporary file is
/// removed.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    WriteError::check_regular(path)?;
    let written = (|| {
        let path = if path.is_symlink() { &fs::canonicalize(path)? } else { path };
        if path.file_name().is_none() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"));
        }
        // A name of no process: numbers of processes come again, and what a killed one left must not block.
        let number = RandomState::new().hash_one(path);
        let temporary = path.with_file_name(format!(".modiolus-{number:016x}.tmp"));
        let written = write_new(&temporary, bytes).and_then(|()| rename(&temporary, path));
        if written.is_err() {
            let _ = fs::remove_file(&temporary);
        }
        written
    })();
    written.map_err(|reason| WriteError::new(path, reason))
}

/// Writes `bytes` to the new file `path`, down to the disk.
pub(super) fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create_new(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Renames a file: the step at which a test may end the process.
pub(super) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fault::step();
    fs::rename(from, to)
}

/// Removes a file that may be there: such a step too.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    fault::step();
    match fs::remove_file(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        done => done,
    }
}

/// Makes what was renamed in `folder` last, where the system lets a folder be opened.
pub(super) fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// `path` itself, or the folder for an empty one.
pub(super) fn or_here(path: &Path) -> PathBuf {
    if path.as_os_str().is_empty() { PathBuf::from(".") } else { path.to_owned() }
}

#[cfg(not(test))]
mod fault {
    pub(super) fn step() {}
}

/// Ends the process before the step whose number, from 0, the environment states.
#[cfg(test)]
pub(super) mod fault {
    use std::sync::atomic::{AtomicUsize, Ordering};

    pub(in crate::io) const VARIABLE: &str = "MODIOLUS_TEST_ABORT_AT";

    static STEPS: AtomicUsize = AtomicUsize::new(0);

    pub(super) fn step() {
        let at = std::env::var(VARIABLE).ok().and_then(|text| text.parse().ok());
        if at == Some(STEPS.fetch_add(1, Ordering::SeqCst)) {
            std::process::abort();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::WriteErrorKind;

    #[test]
    fn replaces_the_file_and_leaves_nothing_else() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"one")?;
        write_atomically(&path, b"two")?;
        assert_eq!(fs::read(&path)?, b"two");
        assert_eq!(fs::read_dir(folder.path())?.count(), 1);
        let longest = folder.path().join("n".repeat(255));
        write_atomically(&longest, b"one")?;
        assert_eq!(fs::read(longest)?, b"one");
        Ok(())
    }

    #[test]
    fn what_is_no_regular_file_stays_and_is_named() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("taken");
        fs::create_dir_all(path.join("inside"))?;
        let kind = |path: &Path| write_atomically(path, b"one").map_err(|e| e.kind);
        assert!(matches!(kind(&path), Err(WriteErrorKind::NotRegular { what: "a folder" })));
        assert!(matches!(kind(Path::new("/")), Err(WriteErrorKind::NotRegular { .. })));
        assert!(matches!(kind(&folder.path().join("n".repeat(256))), Err(WriteErrorKind::NameTooLong)));
        assert_eq!(fs::read_dir(folder.path())?.count(), 1);
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn devices_stay_and_links_keep_leading_to_their_file() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let kind = |path: &Path| write_atomically(path, b"one").map_err(|e| e.kind);
        assert!(matches!(kind(Path::new("/dev/null")), Err(WriteErrorKind::NotRegular { .. })));
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::os::unix::fs::symlink(&file, &link)?;
        assert!(matches!(kind(&link), Err(WriteErrorKind::NotRegular { what: "a link to nothing" })));
        fs::write(&file, b"old")?;
        write_atomically(&link, b"new")?;
        assert!(link.is_symlink() && fs::read(&file)? == b"new");
        Ok(())
    }
}
