//! Several targets at once, what their files state, and where their results go.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

fn modiolus(folder: &TempDir) -> Command {
    let mut command = Command::cargo_bin("modiolus").expect("the program");
    command.current_dir(folder.path());
    command
}

fn run(command: &mut Command) -> (i32, String, String) {
    let output = command.output().expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("an exit code"), text(output.stdout), text(output.stderr))
}

/// A target that moves one corner up, with what it states.
fn put(folder: &TempDir, file: &str, name: &str, up_mm: f64, expected: &str) -> PathBuf {
    let path = folder.path().join(file);
    let text = format!(
        "name = \"{name}\"\nunit = \"mm\"\neffort = 0.1\n\n[[marker]]\nlandmark = \"cheilion_l\"\n\
         displacement_mm = [0.5, {up_mm:?}, nan]\nsigma_mm = 1.0\n\n{expected}"
    );
    fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    fs::write(&path, text).expect("written");
    path
}

fn stated(face: &str, rms_mm: f64) -> String {
    format!("[[expected]]\nface = \"{face}\"\nresidual_rms_mm = {rms_mm:?}\ntolerance_mm = 0.05\n")
}

/// The text without its wall times.
fn timeless(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("solution.json");
    let start = text.find("\"timings_s\"").expect("timings");
    let end = start + text[start..].find('}').expect("their end");
    text[..start].to_owned() + &text[end..]
}

#[test]
fn targets_together_give_the_bytes_of_one_by_one_and_the_verdicts_of_their_files() {
    let dir = tempfile::tempdir().expect("a folder");
    put(&dir, "suite/a.toml", "met", 1.0, &stated("standard_coarse", 0.02));
    put(&dir, "suite/b.toml", "missed", 1.5, &stated("standard_coarse", 3.0));
    put(&dir, "suite/c.toml", "of_another", 0.5, &stated("standard", 0.02));
    fs::write(dir.path().join("suite/notes.md"), "no target").expect("written");
    let all = ["verify", "suite", "--fast", "--json", "--junit", "report.xml", "--out", "together"];
    let (code, stdout, stderr) = run(modiolus(&dir).args(all).env("RAYON_NUM_THREADS", "2"));
    assert_eq!(code, 1, "{stderr}");
    let suite: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!([&suite["passed"], &suite["failed"], &suite["skipped"]], [1, 1, 1], "{stdout}");
    let of = |k: usize| ["name", "verdict", "passed"].map(|key| suite["targets"][k][key].clone());
    assert_eq!(of(0), ["met".into(), "as_stated".into(), Value::Bool(true)]);
    assert_eq!(of(1), ["missed".into(), "not_as_stated".into(), Value::Bool(false)]);
    assert_eq!(of(2), ["of_another".into(), "not_stated".into(), Value::Null]);
    assert_eq!(suite["targets"][2]["remark"], "the file states no result for standard_coarse");

    let report = fs::read_to_string(dir.path().join("report.xml")).expect("written");
    let report = roxmltree::Document::parse(&report).expect("XML");
    let attribute = |tag: &str, name: &str| {
        let node = report.descendants().find(|n| n.has_tag_name(tag)).expect("an element");
        node.attribute(name).expect("an attribute").to_owned()
    };
    let counts = ["tests", "failures", "errors", "skipped"].map(|name| attribute("testsuite", name));
    assert_eq!(counts, ["3", "1", "0", "1"]);
    assert!(attribute("failure", "message").starts_with("solved: "), "{}", attribute("failure", "message"));
    assert_eq!(attribute("skipped", "message"), "the file states no result for standard_coarse");

    for (file, name) in [("a", "met"), ("b", "missed"), ("c", "of_another")] {
        let mut command = modiolus(&dir);
        command.args(["fit", &format!("suite/{file}.toml"), "--face", "standard_coarse", "--out", "alone"]);
        command.env("RAYON_NUM_THREADS", "1").assert().success();
        let [alone, together] = ["alone".to_owned(), format!("together/{name}")].map(|f| dir.path().join(f));
        assert!(
            timeless(&alone.join("solution.json")) == timeless(&together.join("solution.json")),
            "{name}"
        );
        let field = |folder: &Path| fs::read(folder.join("face.vtu")).expect("written");
        assert!(field(&alone) == field(&together), "{name}");
    }
}

#[test]
fn results_of_a_built_in_face_are_not_those_of_a_file_and_nothing_stated_is_no_success() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = put(&dir, "a.toml", "corner", 1.0, &stated("standard_coarse", 0.02));
    let mut export = modiolus(&dir);
    export.args(["face", "export", "standard", "--resolution", "coarse", "--out", "mine"]).assert().success();
    let index = dir.path().join("mine/face.toml");
    let text = fs::read_to_string(&index).expect("written");
    assert!(text.contains("name = \"standard_coarse_exported\""), "{text}");
    let face = ["--face", "mine/face.toml"];
    let (code, stdout, stderr) = run(modiolus(&dir).arg("verify").arg(&path).args(face));
    assert_eq!(code, 1, "{stderr}");
    assert!(stdout.contains("corner: the file states no result for standard_coarse_exported"), "{stdout}");
    assert!(stderr.contains("nothing was verified"), "{stderr}");
    fs::write(&index, text.replace("standard_coarse_exported", "standard_coarse")).expect("written");
    let (code, stdout, _) = run(modiolus(&dir).arg("verify").arg(&path).args(face));
    assert_eq!(code, 1);
    assert!(stdout.contains("stated for the built-in standard_coarse; give the face file"), "{stdout}");
}

#[test]
fn the_default_folder_keeps_the_result_of_another_target() {
    let dir = tempfile::tempdir().expect("a folder");
    let fit =
        |file: &str| run(modiolus(&dir).args(["fit", file, "--face", "standard_coarse", "--contact", "off"]));
    put(&dir, "a.toml", "corner", 1.0, "");
    put(&dir, "b/a.toml", "corner", 2.0, "");
    let (code, _, stderr) = fit("a.toml");
    assert!(code == 0 && stderr.contains("out/standard_coarse/corner"), "{stderr}");
    assert_eq!(fit("./a.toml").0, 0, "the same target anew");
    let written = fs::read(dir.path().join("out/standard_coarse/corner/solution.json")).expect("written");
    let (code, stdout, stderr) = fit("b/a.toml");
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    assert!(
        stderr.contains("holds the result of ./a.toml on standard_coarse; give another place"),
        "{stderr}"
    );
    let kept = fs::read(dir.path().join("out/standard_coarse/corner/solution.json")).expect("there");
    assert!(kept == written);
}

#[test]
fn what_is_no_suite_is_refused_before_anything_is_computed() {
    let dir = tempfile::tempdir().expect("a folder");
    put(&dir, "a.toml", "corner", 1.0, "");
    put(&dir, "b.toml", "corner", 1.0, "");
    put(&dir, "c.toml", "metres", 0.001, "");
    put(&dir, "d.toml", "other", 1.0, "[[expected]]\nface = \"standard\"\nresidual_rms_mm = -1.0\n");
    fs::create_dir(dir.path().join("empty")).expect("made");
    for (arguments, parts) in [
        (&["verify", "empty"][..], &["empty: holds no target", ".toml"][..]),
        (&["verify", "none.toml"], &["none.toml"]),
        (&["verify", "a.toml", "b.toml"], &["a.toml and b.toml are both called corner"]),
        (&["fit", "a.toml", "c.toml", "d.toml"], &["c.toml:", "metres", "d.toml:10", "tolerance_mm"]),
        (&["verify", "a.toml", "--junit", "a.toml"], &["--junit", "JUnit reports are XML"]),
        (&["verify", "a.toml", "--fast", "--face", "standard"], &["--fast", "--face"]),
        (&["verify"], &["TARGET.toml"]),
    ] {
        let (code, stdout, stderr) = run(modiolus(&dir).args(arguments));
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments:?}: {stderr}");
        for part in parts {
            assert!(stderr.contains(part), "{arguments:?}: \"{part}\" is not in: {stderr}");
        }
    }
    assert!(!dir.path().join("out").exists());
}
