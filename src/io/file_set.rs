//! Files that replace those of the same names together, or not at all.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::atomic::{or_here, remove, rename, sync_folder, write_atomically, write_new};
use super::sha256::sha256;
use super::{WriteError, WriteErrorKind, input};

/// The list of what is being replaced; from the moment it is there the new files count.
const JOURNAL: &str = ".modiolus-commit.json";

/// Files of one folder that belong together, such as an answer and its fields.
///
/// All are first written beside the old ones. Then a list of them is put down in one step: before it the old set
/// stands, after it the new one, which [`settle_folder`] puts in place even where the process that wrote it ended.
/// Whoever reads such a set settles its folder first.
#[derive(Debug)]
pub struct FileSet {
    folder: PathBuf,
    files: BTreeMap<String, Vec<u8>>,
    stale: Vec<String>,
}

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Journal {
    replace: Vec<String>,
    remove: Vec<String>,
}

impl FileSet {
    /// An empty set for `folder`, which need not be there yet.
    pub fn new(folder: &Path) -> Self {
        Self { folder: or_here(folder), files: BTreeMap::new(), stale: Vec::new() }
    }

    /// Adds the file `name` with its `bytes`.
    pub fn put(&mut self, name: &str, bytes: Vec<u8>) {
        self.files.insert(name.to_owned(), bytes);
    }

    /// The file `name` of an older set goes, unless this one has it.
    pub fn without(&mut self, name: &str) {
        self.stale.push(name.to_owned());
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The names of the files, in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    /// SHA-256 of each file, by its name.
    pub fn sha256(&self) -> BTreeMap<String, String> {
        self.files.iter().map(|(name, bytes)| (name.clone(), sha256(bytes))).collect()
    }

    /// Puts all files in place of those of their names; returns their paths, in alphabetical order.
    ///
    /// # Errors
    /// [`WriteError`]; then the old files stand, unless the new set counts already and [`settle_folder`] will put it in
    /// place.
    pub fn write(&self) -> Result<Vec<PathBuf>, WriteError> {
        let folder = &self.folder;
        fs::create_dir_all(folder).map_err(|e| WriteError::new(folder, e))?;
        let _held = hold(folder);
        settle(folder)?;
        let paths: Vec<PathBuf> = self.files.keys().map(|name| folder.join(name)).collect();
        let journal = Journal {
            replace: self.files.keys().cloned().collect(),
            remove: self.stale.iter().filter(|name| !self.files.contains_key(*name)).cloned().collect(),
        };
        for path in
            paths.iter().chain(&journal.remove.iter().map(|name| folder.join(name)).collect::<Vec<_>>())
        {
            WriteError::check_regular(path)?;
        }
        let staged = self.files.iter().try_for_each(|(name, bytes)| {
            let path = folder.join(staged(name));
            // What a killed process left here never counted.
            remove(&path)
                .and_then(|()| write_new(&path, bytes))
                .map_err(|e| WriteError::new(&folder.join(name), e))
        });
        let counts = staged.and_then(|()| {
            let list = serde_json::to_vec(&journal)
                .map_err(|e| WriteError::new(&folder.join(JOURNAL), io::Error::other(e)))?;
            write_atomically(&folder.join(JOURNAL), &list)
        });
        if let Err(error) = counts {
            for name in self.files.keys() {
                let _ = fs::remove_file(folder.join(self::staged(name)));
            }
            return Err(error);
        }
        settle(folder)?;
        Ok(paths)
    }
}

/// Puts the files of `folder` in place that a process which ended on the way had written whole; where there are
/// none, nothing is touched.
///
/// # Errors
/// [`WriteError`] when they cannot be put in place.
pub fn settle_folder(folder: &Path) -> Result<(), WriteError> {
    let folder = or_here(folder);
    if !folder.join(JOURNAL).exists() {
        return Ok(());
    }
    let _held = hold(&folder);
    settle(&folder)
}

fn settle(folder: &Path) -> Result<(), WriteError> {
    let at = folder.join(JOURNAL);
    let list = match input::read(&at, input::TEXT_BYTES) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        read => read.map_err(|e| WriteError::new(&at, e))?,
    };
    let no_journal = |reason: String| {
        let kind = WriteErrorKind::Io(io::Error::new(io::ErrorKind::InvalidData, reason));
        WriteError { path: at.clone(), kind }
    };
    let journal: Journal = serde_json::from_slice(&list).map_err(|e| no_journal(e.to_string()))?;
    // A folder from elsewhere must not reach out of itself.
    if let Some(name) = journal.replace.iter().chain(&journal.remove).find(|name| !is_plain(name)) {
        return Err(no_journal(format!("`{name}` is no name of a file of this folder; remove this list")));
    }
    for name in &journal.replace {
        let (from, to) = (folder.join(staged(name)), folder.join(name));
        match rename(&from, &to) {
            // Put in place already.
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            done => done.map_err(|e| WriteError::new(&to, e))?,
        }
    }
    for path in journal.remove.iter().map(|name| folder.join(name)) {
        remove(&path).map_err(|e| WriteError::new(&path, e))?;
    }
    sync_folder(folder);
    remove(&at).map_err(|e| WriteError::new(&at, e))
}

/// Where the file `name` waits for its set.
fn staged(name: &str) -> String {
    format!(".{name}.new")
}

fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(std::path::Component::Normal(part)), None) if part == name)
}

/// Keeps other processes from writing a set to `folder`, where the system can lock one; the end of the process, of
/// whatever kind, lets go.
fn hold(folder: &Path) -> Option<File> {
    let folder = File::open(folder).ok()?;
    folder.lock().ok().map(|()| folder)
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::io::atomic::fault;

    /// Folder of the child process.
    const FOLDER: &str = "MODIOLUS_TEST_FOLDER";

    fn old(folder: &Path) -> FileSet {
        let mut set = FileSet::new(folder);
        for name in ["a", "b", "gone"] {
            set.put(name, format!("old {name}").into_bytes());
        }
        set
    }

    fn new(folder: &Path) -> FileSet {
        let mut set = FileSet::new(folder);
        for name in ["a", "b", "c"] {
            set.put(name, format!("new {name}").into_bytes());
        }
        set.without("gone");
        set
    }

    fn files(folder: &Path) -> BTreeMap<String, String> {
        let text = |path: PathBuf| fs::read_to_string(path).expect("text");
        let entries = fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
        entries.map(|p| (p.file_name().expect("a name").to_string_lossy().into_owned(), text(p))).collect()
    }

    fn as_written(set: &FileSet) -> BTreeMap<String, String> {
        let text = |bytes: &Vec<u8>| String::from_utf8_lossy(bytes).into_owned();
        set.files.iter().map(|(name, bytes)| (name.clone(), text(bytes))).collect()
    }

    #[test]
    fn a_set_replaces_the_old_one_and_leaves_what_is_not_its_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path().join("deep/er");
        old(&at).write().expect("written");
        fs::write(at.join("mine"), "own").expect("written");
        let paths = new(&at).write().expect("written");
        assert_eq!(paths, ["a", "b", "c"].map(|name| at.join(name)));
        let mut expected = as_written(&new(&at));
        expected.insert("mine".to_owned(), "own".to_owned());
        assert_eq!(files(&at), expected);
    }

    #[test]
    fn a_device_a_folder_or_a_foreign_list_changes_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        old(at).write().expect("written");
        fs::create_dir(at.join("c")).expect("made");
        let error = new(at).write().expect_err("a folder is in the way");
        assert!(error.to_string().contains("c: is a folder"), "{error}");
        fs::remove_dir(at.join("c")).expect("removed");
        assert_eq!(files(at), as_written(&old(at)));
        fs::write(at.join(JOURNAL), r#"{"replace": [], "remove": ["../a"]}"#).expect("written");
        let error = settle_folder(at).expect_err("it reaches out");
        assert!(error.to_string().contains("`../a` is no name"), "{error}");
        File::create(at.join(JOURNAL)).and_then(|list| list.set_len(1 << 40)).expect("a hole");
        let error = settle_folder(at).expect_err("it is no list");
        assert!(error.to_string().contains("are read"), "{error}");
    }

    /// The child of the test below; by itself it does nothing.
    #[test]
    fn child_that_writes_the_new_set() {
        if let Some(folder) = std::env::var_os(FOLDER) {
            new(Path::new(&folder)).write().expect("written");
        }
    }

    #[test]
    fn a_process_that_ends_at_any_step_leaves_the_old_set_or_the_new_one() {
        let own = std::env::current_exe().expect("this test");
        let (mut ended, mut new_ones) = (0, 0);
        for step in 0.. {
            let folder = tempfile::tempdir().expect("a folder");
            let at = folder.path();
            old(at).write().expect("written");
            let name = "io::file_set::tests::child_that_writes_the_new_set";
            let child = Command::new(&own)
                .args(["--exact", name, "--test-threads=1"])
                .env(FOLDER, at)
                .env(fault::VARIABLE, step.to_string())
                .output()
                .expect("it runs");
            settle_folder(at).expect("settled");
            let mut found = files(at);
            // What never counted waits to be replaced.
            found.retain(|name, _| !name.starts_with('.'));
            let is_new = found == as_written(&new(at));
            assert!(is_new || found == as_written(&old(at)), "step {step}: {found:?}");
            assert!(is_new || new_ones == 0, "step {step} went back");
            new_ones += usize::from(is_new);
            new(at).write().expect("nothing blocks the next");
            let mut found = files(at);
            found.retain(|name, _| !name.ends_with(".tmp"));
            assert_eq!(found, as_written(&new(at)), "step {step}");
            if child.status.success() {
                break;
            }
            ended += 1;
        }
        assert!(ended > 6 && new_ones > 3, "{ended} ends, {new_ones} of them with the new set");
    }
}
