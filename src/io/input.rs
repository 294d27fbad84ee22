//! Files as bytes: regular ones, up to a size.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Most bytes of a mesh or surface file that are read: 512 MiB.
pub(super) const MESH_BYTES: u64 = 1 << 29;
/// Most bytes of a table, a face, a target or another file that people write that are read: 64 MiB.
pub(super) const TEXT_BYTES: u64 = 1 << 26;

/// The bytes of the regular file `path`, of which there are at most `most`.
///
/// # Errors
/// What the system reports, or that it is a folder, a device or another thing that need not end, or larger.
pub(super) fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    // Asked before it is opened: to open a pipe waits for its writer.
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, and a file is needed"));
    }
    if !metadata.is_file() {
        let reason = "it is a device or a pipe, and a regular file is needed";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    let mut bytes = Vec::new();
    if metadata.len() <= most {
        // The length is asked for again in what is read: a file may grow, and some say 0 and are not empty.
        File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 <= most {
            return Ok(bytes);
        }
    }
    let size = metadata.len().max(bytes.len() as u64);
    let reason = format!("it has {size} bytes or more, and at most {most} are read");
    Err(io::Error::new(io::ErrorKind::FileTooLarge, reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_up_to_the_limit() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("a");
        fs::write(&path, b"abcdef")?;
        assert_eq!(read(&path, 6)?, b"abcdef");
        let says = |e: io::Result<Vec<u8>>| e.err().map(|e| e.to_string()).unwrap_or_default();
        assert_eq!(says(read(&path, 5)), "it has 6 bytes or more, and at most 5 are read");
        assert!(says(read(folder.path(), 5)).contains("it is a folder"));
        if Path::new("/dev/zero").exists() {
            assert!(says(read(Path::new("/dev/zero"), 5)).contains("it is a device"));
        }
        Ok(())
    }
}
