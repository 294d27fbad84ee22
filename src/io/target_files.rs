//! The target files that paths name.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{TargetDocument, TargetFileError, read_target};

/// Why paths are no suite of targets.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SuiteError {
    /// A folder that cannot be listed.
    #[error("{}: cannot be read: {reason}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why not.
        reason: std::io::Error,
    },
    /// A folder without target files.
    #[error("{}: holds no target, no file whose name ends in .toml; give target files, or their folder", .0.display())]
    Empty(PathBuf),
    /// A name of two targets.
    #[error(
        "{} and {} are both called {name}; give one of them another `name`, or fit them one by one", first.display(),
        second.display()
    )]
    SameName {
        /// The name.
        name: String,
        /// The file that has it first.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// Files that are no targets.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Targets(Vec<TargetFileError>),
}

/// The targets in the files and folders `paths`, each with its path: files as given, those of a folder by name, which are
/// the files in it that end in `.toml`.
///
/// # Errors
/// [`SuiteError`]; every file that is no target is told.
pub fn read_targets(paths: &[PathBuf]) -> Result<Vec<(PathBuf, TargetDocument)>, SuiteError> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() { files.extend(in_folder(path)?) } else { files.push(path.clone()) }
    }
    let (mut documents, mut errors) = (Vec::new(), Vec::new());
    for file in files {
        match read_target(&file) {
            Ok(document) => documents.push((file, document)),
            Err(error) => errors.push(error),
        }
    }
    if !errors.is_empty() {
        return Err(SuiteError::Targets(errors));
    }
    let mut named: BTreeMap<&str, &PathBuf> = BTreeMap::new();
    for (file, document) in &documents {
        let name = &document.target.name;
        if let Some(first) = named.insert(name, file) {
            let (first, second) = (first.clone(), file.clone());
            return Err(SuiteError::SameName { name: name.clone(), first, second });
        }
    }
    Ok(documents)
}

fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, SuiteError> {
    let refused = |reason| SuiteError::Folder { folder: folder.to_owned(), reason };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(refused)? {
        let path = entry.map_err(refused)?.path();
        if path.extension().is_some_and(|e| e == "toml") && !path.is_dir() {
            found.push(path);
        }
    }
    if found.is_empty() {
        return Err(SuiteError::Empty(folder.to_owned()));
    }
    found.sort();
    Ok(found)
}
