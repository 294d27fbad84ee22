//! The program killed while it writes a result: every reader finds the whole old one or the whole new one.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::block_face::block_face;
use modiolus::io::{read_answer, write_face};

/// `forward` of a small face, with `activate`, into `out`.
fn forward(folder: &Path, activate: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_modiolus"));
    command.args(["forward", "--activate", activate, "--face"]);
    command.arg(folder.join("face/face.toml")).arg("--out").arg(folder.join("out"));
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Names and first bytes of the files of `folder`, hidden ones too.
fn look(folder: &Path) -> BTreeMap<String, u64> {
    use std::os::unix::fs::MetadataExt;
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    let known = entries.filter_map(|e| Some((e.file_name().into_string().ok()?, e.metadata().ok()?.ino())));
    known.collect()
}

#[test]
fn a_program_killed_at_any_step_leaves_the_old_result_or_the_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let out = at.join("out");
    write_face(&at.join("face"), &block_face([6, 5, 2])).unwrap();
    let whole = |activate: &str| {
        assert!(forward(at, activate).wait().unwrap().success());
        read_answer(&out).unwrap()
    };
    let (old, new) = ("zygomaticus_major=0.2", "zygomaticus_major=0.7");
    let [old_answer, new_answer] = [old, new].map(whole);
    assert_ne!(old_answer.displacement, new_answer.displacement);

    // What can be seen from outside as a set is written, in this order.
    type Seen<'a> = &'a dyn Fn(&BTreeMap<String, u64>, &BTreeMap<String, u64>) -> bool;
    let replaced = |name: &'static str| {
        move |before: &BTreeMap<String, u64>, now: &BTreeMap<String, u64>| before.get(name) != now.get(name)
    };
    let is_there = |name: &'static str| {
        move |_: &BTreeMap<String, u64>, now: &BTreeMap<String, u64>| now.contains_key(name)
    };
    let steps: [Seen<'_>; 6] = [
        &is_there(".face.vtu.new"),
        &is_there(".solution.json.new"),
        &|_, now| now.keys().any(|name| name.ends_with(".tmp")),
        &is_there(".modiolus-commit.json"),
        &replaced("face.vtu"),
        &replaced("solution.json"),
    ];
    let (mut killed, mut left) = (0, [0; 2]);
    for (round, step) in (0..).zip(steps.iter().cycle()).take(60) {
        whole(old);
        let before = look(&out);
        let mut child = forward(at, new);
        while child.try_wait().unwrap().is_none() && !step(&before, &look(&out)) {}
        // Some way into the step.
        let start = Instant::now();
        while start.elapsed() < Duration::from_micros(40 * (round / steps.len() as u64)) {}
        child.kill().unwrap();
        killed += usize::from(child.wait().unwrap().code().is_none());
        let found = read_answer(&out).unwrap();
        assert!(found == old_answer || found == new_answer, "round {round}: {:?}", look(&out));
        left[usize::from(found == new_answer)] += 1;
        // What a reader finds stays, and nothing blocks the next run.
        assert_eq!(read_answer(&out).unwrap(), found);
        assert_eq!(whole(new), new_answer);
        let names: Vec<String> = look(&out).into_keys().filter(|name| !name.ends_with(".tmp")).collect();
        assert_eq!(names, ["face.vtu", "solution.json"], "round {round}");
    }
    assert!(killed > 20 && left.iter().all(|n| *n > 5), "{killed} killed, {left:?} left old and new");
}
