//! Blocks of a recording that are fitted already, so that a run that was stopped goes on.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::WriteError;
use super::atomic::write_atomically;
use crate::recording::{FrameStatus, Touched, TrackedFrame};
use crate::units::Vec3;

/// Where blocks are kept in the folder of a result until it is whole.
const FOLDER: &str = ".blocks";

/// The blocks of one run in a folder.
#[derive(Clone, Debug)]
pub struct TrackBlocks {
    folder: PathBuf,
    key: String,
}

#[derive(Debug, Serialize, Deserialize)]
struct BlockJson {
    key: String,
    start: usize,
    frames: Vec<FrameJson>,
}

#[derive(Debug, Serialize, Deserialize)]
struct FrameJson {
    status: usize,
    unknowns: Vec<f64>,
    residual_mm: Vec<Option<[f64; 3]>>,
    outliers: Vec<usize>,
    /// Contacts that touch and their forces together, N.
    touched: Option<(usize, f64)>,
    /// Infinite where nothing was found, for which JSON has no number.
    certificate: Option<f64>,
}

impl TrackBlocks {
    /// Those in the folder `out` of the run that `key` names: everything that its blocks depend on.
    pub fn new(out: &Path, key: &str) -> Self {
        Self { folder: out.join(FOLDER), key: key.to_owned() }
    }

    /// The frames of `block`, if they were kept by the same run.
    pub fn load(&self, block: &Range<usize>) -> Option<Vec<TrackedFrame>> {
        let BlockJson { key, start, frames } =
            serde_json::from_slice(&fs::read(self.path(block)).ok()?).ok()?;
        let is_it = key == self.key && start == block.start && frames.len() == block.len();
        is_it.then(|| frames.into_iter().map(FrameJson::frame).collect()).flatten()
    }

    /// Keeps the `frames` of `block`.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn save(&self, block: &Range<usize>, frames: &[TrackedFrame]) -> Result<(), WriteError> {
        fs::create_dir_all(&self.folder).map_err(|e| WriteError::new(&self.folder, e))?;
        let frames = frames.iter().map(FrameJson::of).collect();
        let json = BlockJson { key: self.key.clone(), start: block.start, frames };
        let path = self.path(block);
        let bytes = serde_json::to_vec(&json).map_err(|e| WriteError::new(&path, e.into()))?;
        write_atomically(&path, &bytes)
    }

    /// Forgets all blocks; where that fails they do no harm.
    pub fn remove(&self) {
        let _ = fs::remove_dir_all(&self.folder);
    }

    fn path(&self, block: &Range<usize>) -> PathBuf {
        self.folder.join(format!("{:08}.json", block.start))
    }
}

impl FrameJson {
    fn of(frame: &TrackedFrame) -> Self {
        Self {
            status: FrameStatus::ALL.iter().position(|s| *s == frame.status).unwrap_or(0),
            unknowns: frame.unknowns.clone(),
            residual_mm: frame.residual_mm.iter().map(|r| r.map(Into::into)).collect(),
            outliers: frame.outliers.clone(),
            touched: frame.touched.map(|touched| (touched.contacts, touched.force_n)),
            certificate: frame.certificate.is_finite().then_some(frame.certificate),
        }
    }

    fn frame(self) -> Option<TrackedFrame> {
        Some(TrackedFrame {
            status: *FrameStatus::ALL.get(self.status)?,
            unknowns: self.unknowns,
            residual_mm: self.residual_mm.into_iter().map(|r| r.map(Vec3::from)).collect(),
            outliers: self.outliers,
            touched: self.touched.map(|(contacts, force_n)| Touched { contacts, force_n }),
            certificate: self.certificate.unwrap_or(f64::INFINITY),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_comes_back_as_it_was_to_the_same_run() {
        let folder = tempfile::tempdir().expect("a folder");
        let frame = TrackedFrame {
            status: FrameStatus::Underdetermined,
            unknowns: vec![0.1, 1. / 3.],
            residual_mm: vec![None, Some(Vec3::new(0.1, -2e-17, 3.))],
            outliers: vec![1],
            touched: Some(Touched { contacts: 7, force_n: 0.3 }),
            certificate: f64::INFINITY,
        };
        let (blocks, block) = (TrackBlocks::new(folder.path(), "a"), 240..241);
        assert_eq!(blocks.load(&block), None);
        blocks.save(&block, std::slice::from_ref(&frame)).expect("written");
        assert_eq!(blocks.load(&block), Some(vec![frame]));
        assert_eq!(TrackBlocks::new(folder.path(), "b").load(&block), None);
        assert_eq!(blocks.load(&(240..242)), None);
        fs::write(blocks.path(&block), b"{").expect("written");
        assert_eq!(blocks.load(&block), None);
        blocks.remove();
        assert!(!folder.path().join(FOLDER).exists());
    }
}
