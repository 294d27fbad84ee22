//! The program as its users script it: exit codes, messages, files.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

fn modiolus() -> Command {
    let mut command = Command::cargo_bin("modiolus").expect("the program");
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn run(command: &mut Command) -> (i32, String, String) {
    let output = command.output().expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("an exit code"), text(output.stdout), text(output.stderr))
}

/// Runs, expects exit code 2, silence on stdout, every one of `parts` on stderr and nothing in `out`.
fn refused(command: &mut Command, out: &Path, parts: &[&str]) {
    let (code, stdout, stderr) = run(command);
    assert_eq!(code, 2, "{stderr}");
    assert_eq!(stdout, "");
    for part in parts {
        assert!(stderr.contains(part), "\"{part}\" is not in: {stderr}");
    }
    assert!(!out.exists(), "{} was written", out.display());
}

fn target(folder: &TempDir, text: &str) -> PathBuf {
    let path = folder.path().join("t.toml");
    fs::write(&path, text).expect("written");
    path
}

const LEFT_CORNER: &str = r#"name = "left_corner_up"
unit = "mm"
effort = 0.1

[[marker]]
landmark = "cheilion_l"
displacement_mm = [3.0, 4.0, nan]
sigma_mm = 1.2

[[bounds]]
muscle = "*_r"
max = 0.0
"#;

/// `solution.json` without its wall times.
fn timeless(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("solution.json");
    let start = text.find("\"timings_s\"").expect("timings");
    let end = start + text[start..].find('}').expect("their end");
    text[..start].to_owned() + &text[end..]
}

#[test]
fn a_fit_prints_a_table_and_writes_both_files() {
    let dir = folder();
    let out = dir.path().join("out");
    let path = target(&dir, LEFT_CORNER);
    let (code, stdout, stderr) = run(modiolus().arg("fit").arg(&path).arg("--out").arg(&out));
    assert_eq!(code, 0, "{stderr}");
    for part in
        ["left_corner_up on the standard face: solved", "zygomaticus_major", "subject's left", "Contact"]
    {
        assert!(stdout.contains(part), "\"{part}\" is not in: {stdout}");
    }
    assert!(stderr.contains("wrote solution.json and face.vtu"), "{stderr}");
    let json: Value =
        serde_json::from_str(&fs::read_to_string(out.join("solution.json")).expect("written")).expect("JSON");
    assert_eq!(json["status"], "solved");
    assert!(json["residual_mm"]["rms"].as_f64().expect("a number") < 2.0);
    for residual in ["primal", "dual", "gap"] {
        assert!(json["certificate"][residual].as_f64().expect("a number") <= 1e-9, "{residual}");
    }
    assert_eq!(json["markers"][0]["target_mm"], serde_json::json!([3.0, 4.0, null]));
    let hash = json["inputs"].as_object().expect("inputs").values().next().expect("one").as_str();
    assert_eq!(hash, Some(modiolus::io::sha256(LEFT_CORNER.as_bytes()).as_str()));
    for (name, a) in json["activations"].as_object().expect("activations") {
        let a = a.as_f64().expect("a number");
        assert!((0.0..=1.0).contains(&a), "{name} {a}");
        assert!(!name.ends_with("_r") || a == 0.0, "{name} {a}");
    }
    assert!(fs::read(out.join("face.vtu")).expect("written").starts_with(b"<?xml"));
}

/// One corner of the mouth is lifted: the sides differ by more than is allowed, and table, map and picture say so.
#[test]
fn one_sided_movement_fails_a_limit_of_asymmetry() {
    let dir = folder();
    let path = target(&dir, LEFT_CORNER);
    let out = dir.path().join("out");
    let sides = |most_mm: &str| {
        let mut command = modiolus();
        command.arg("symmetry").arg(&path).args(["--face", "standard_coarse", "--max-asymmetry-mm", most_mm]);
        run(command.arg("--out").arg(&out))
    };
    assert_eq!(sides("100").0, 0);
    let (code, stdout, stderr) = sides("1");
    assert_eq!(code, 1, "{stderr}");
    assert!(stdout.contains("cheilion") && stderr.contains("symmetry.png"), "{stdout}{stderr}");
    let json: Value =
        serde_json::from_str(&fs::read_to_string(out.join("symmetry.json")).expect("written")).expect("JSON");
    let pair = json["pairs"].as_array().and_then(|all| all.iter().find(|pair| pair["name"] == "cheilion"));
    let pair = pair.expect("the corners of the mouth");
    let moved = |side: &str, axis: usize| pair[side][axis].as_f64().expect("a number");
    let difference = [-1., 1., 1.].iter().enumerate().map(|(axis, sign)| {
        let apart = moved("left_mm", axis) - sign * moved("right_mm", axis);
        apart * apart
    });
    let (told, expected) =
        (pair["difference_mm"].as_f64().expect("a number"), difference.sum::<f64>().sqrt());
    assert!((told - expected).abs() < 1e-9 && told > 2., "{told} {expected}");
    assert!(fs::read(out.join("symmetry.png")).expect("written").starts_with(b"\x89PNG"));
    assert!(fs::read_to_string(out.join("symmetry.vtu")).expect("written").contains("asymmetry_mm"));
}

#[test]
fn the_same_input_gives_the_same_bytes_whatever_the_threads() {
    let dir = folder();
    let path = target(&dir, LEFT_CORNER);
    let mut answers = Vec::new();
    for (run_name, threads) in [("a", "1"), ("b", "2")] {
        let out = dir.path().join(run_name);
        modiolus()
            .env("RAYON_NUM_THREADS", threads)
            .arg("fit")
            .arg(&path)
            .arg("--out")
            .arg(&out)
            .assert()
            .success();
        answers
            .push((timeless(&out.join("solution.json")), fs::read(out.join("face.vtu")).expect("written")));
    }
    assert!(answers[0].0 == answers[1].0, "solution.json differs");
    assert!(answers[0].1 == answers[1].1, "face.vtu differs");
}

#[test]
fn json_is_the_file_alone() {
    let dir = folder();
    let out = dir.path().join("out");
    let mut command = modiolus();
    command.args([
        "forward",
        "--activate",
        "zygomaticus_major=0.5,mentalis_l=1",
        "--contact",
        "off",
        "--json",
    ]);
    let (code, stdout, _) = run(command.arg("--out").arg(&out));
    assert_eq!(code, 0);
    assert_eq!(stdout, fs::read_to_string(out.join("solution.json")).expect("written"));
    let json: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(json["activations"]["zygomaticus_major_l"], 0.5);
    assert_eq!(json["activations"]["zygomaticus_major_r"], 0.5);
    assert_eq!(json["activations"]["mentalis_l"], 1.0);
    assert_eq!(json["activations"]["mentalis_r"], 0.0);
    assert_eq!(json["contact"], Value::Null);
    let corner = json["markers"].as_array().expect("points").iter().find(|m| m["name"] == "cheilion_l");
    let model: Vec<f64> = corner.expect("cheilion_l")["model_mm"]
        .as_array()
        .expect("xyz")
        .iter()
        .filter_map(Value::as_f64)
        .collect();
    assert!(model[1] > 0.5 && model[2] < 0.0, "the corner goes up and back: {model:?}");
}

/// The map times the activations is what `forward` does without contact.
#[test]
fn the_map_is_the_forward_model() {
    let dir = folder();
    let (npz, out) = (dir.path().join("map.npz"), dir.path().join("out"));
    modiolus().args(["map", "--out"]).arg(&npz).assert().success();
    let mut command = modiolus();
    command.args([
        "forward",
        "--activate",
        "risorius_l=0.5,buccinator=0.25",
        "--stiffness",
        "fixed=0.5",
        "--contact",
        "off",
        "--json",
        "--out",
    ]);
    let (_, stdout, _) = run(command.arg(&out));
    let json: Value = serde_json::from_str(&stdout).expect("JSON");

    let bytes = fs::read(&npz).expect("written");
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes[..])).expect("a zip");
    let mut entry = |name: &str| {
        let mut npy = Vec::new();
        std::io::Read::read_to_end(&mut archive.by_name(name).expect("an entry"), &mut npy).expect("read");
        npy
    };
    let muscles: Vec<String> =
        npyz::NpyFile::new(&entry("muscles.npy")[..]).expect("npy").into_vec().expect("names");
    let npy = entry("displacement.npy");
    let file = npyz::NpyFile::new(&npy[..]).expect("npy");
    let shape = file.shape().to_vec();
    assert_eq!((shape[0], shape[2]), (muscles.len() as u64, 3));
    let map: Vec<f64> = file.into_vec().expect("numbers");
    let stiffness: Vec<f64> =
        npyz::NpyFile::new(&entry("stiffness.npy")[..]).expect("npy").into_vec().expect("one");
    assert_eq!(stiffness, [0.5]);

    let rows = 3 * shape[1] as usize;
    let mut u = vec![0.0; rows];
    for (muscle, column) in muscles.iter().zip(map.chunks(rows)) {
        let a = json["activations"][muscle].as_f64().expect("a number");
        u.iter_mut().zip(column).for_each(|(u, c)| *u += a * c);
    }
    let face = modiolus::face::standard(&modiolus::face::standard::Resolution::STANDARD);
    for marker in json["markers"].as_array().expect("points") {
        let landmark = face.landmark(marker["name"].as_str().expect("a name")).expect("a landmark");
        let mapped = landmark.site.displacement(&u);
        for axis in 0..3 {
            let direct = marker["model_mm"][axis].as_f64().expect("a number");
            assert!((mapped[axis] - direct).abs() < 1e-9, "{} {axis}", landmark.name);
        }
    }
}

#[test]
fn a_face_is_checked_and_exported_and_read_again() {
    let dir = folder();
    let out = dir.path().join("face");
    let (code, stdout, _) = run(modiolus().args(["face", "check", "standard"]));
    assert_eq!(code, 0);
    assert!(stdout.contains("usable") && stdout.contains("muscles"), "{stdout}");
    let mut command = modiolus();
    command.args(["face", "export", "standard", "--resolution", "coarse", "--out"]);
    command.arg(&out).assert().success();
    let (code, stdout, stderr) = run(modiolus().args(["face", "check"]).arg(out.join("face.toml")));
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("usable"), "{stdout}");
}

#[test]
fn tied_muscles_with_different_bounds_are_refused_at_their_line() {
    let dir = folder();
    let path = target(
        &dir,
        &LEFT_CORNER
            .replace("effort = 0.1\n", "effort = 0.1\ntied = [[\"mentalis_l\", \"mentalis_r\"]]\n")
            .replace("max = 0.0\n", "max = 0.0\n\n[[bounds]]\nmuscle = \"mentalis_l\"\nmin = 0.5\n"),
    );
    let out = dir.path().join("out");
    let (code, _, stderr) = run(modiolus().arg("fit").arg(&path).arg("--out").arg(&out));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("t.toml:4") && stderr.contains("mentalis_r"), "{stderr}");
    assert!(!out.exists());
}

#[test]
fn a_target_without_observation_is_no_data() {
    let dir = folder();
    let path = target(&dir, &LEFT_CORNER.replace("[3.0, 4.0, nan]", "[nan, nan, nan]"));
    let out = dir.path().join("out");
    let (code, stdout, _) = run(modiolus().arg("fit").arg(&path).arg("--json").arg("--out").arg(&out));
    assert_eq!(code, 1);
    let json: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(json["status"], "no_data");
    assert_eq!(json["residual_mm"], serde_json::json!({"rms": null, "max": null}));
    assert!(json["warnings"].to_string().contains("no observed component"));
}

#[test]
fn a_target_of_symmetry_or_effort_alone_is_no_data() {
    let dir = folder();
    let wishes = "name = \"still\"\nunit = \"mm\"\neffort = 0.1\n";
    let pair = "\n[[symmetry]]\nleft = \"cheilion_l\"\nright = \"cheilion_r\"\nsigma_mm = 1.0\n";
    for text in [wishes.to_owned(), format!("{wishes}{pair}")] {
        let (path, out) = (target(&dir, &text), dir.path().join("out"));
        let (code, stdout, _) = run(modiolus().arg("fit").arg(&path).arg("--out").arg(&out));
        assert_eq!(code, 1, "{stdout}");
        assert!(stdout.contains("still on the standard face: no data"), "{stdout}");
    }
}

#[test]
fn too_few_observations_without_effort_are_underdetermined() {
    let dir = folder();
    let path = target(&dir, &LEFT_CORNER.replace("effort = 0.1\n", ""));
    let out = dir.path().join("out");
    let mut command = modiolus();
    command.arg("fit").arg(&path).args(["--json", "--stiffness", "fixed=0.5", "--contact", "off", "--out"]);
    let (code, stdout, stderr) = run(command.arg(&out));
    assert_eq!(code, 1, "{stderr}");
    let json: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(json["status"], "underdetermined");
    assert!(json["warnings"].to_string().contains("others fit as well"), "{}", json["warnings"]);
    assert!(json["activations"].as_object().is_some_and(|a| !a.is_empty()), "one of the answers is given");
}

#[test]
fn an_answer_replaces_the_old_one_whole() {
    let dir = folder();
    let out = dir.path().join("out");
    let mut command = modiolus();
    command.args(["forward", "--activate", "risorius=0.5", "--contact", "off", "--out"]).arg(&out);
    command.assert().success();
    let json: Value =
        serde_json::from_slice(&fs::read(out.join("solution.json")).expect("written")).expect("JSON");
    let vtu = fs::read(out.join("face.vtu")).expect("written");
    assert_eq!(json["files"], serde_json::json!({"face.vtu": modiolus::io::sha256(&vtu)}));
    let path = target(&dir, &LEFT_CORNER.replace("[3.0, 4.0, nan]", "[nan, nan, nan]"));
    modiolus().arg("fit").arg(&path).arg("--out").arg(&out).assert().code(1);
    assert!(!out.join("face.vtu").exists(), "the displacement of another run stayed");
    assert_eq!(fs::read_dir(&out).expect("a folder").count(), 1);
}

#[test]
fn no_input_is_written_over() {
    let dir = folder();
    let face = dir.path().join("face");
    let index = face.join("face.toml");
    let mut command = modiolus();
    command.args(["face", "export", "standard", "--resolution", "coarse", "--out"]).arg(&face);
    command.assert().success();
    let plan = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/setback/plan.toml");
    let before = fs::read(&index).expect("written");
    let mut command = modiolus();
    command.args(["surgery", plan, "--face"]).arg(&index).arg("--out").arg(dir.path().join("x/../face"));
    fs::create_dir(dir.path().join("x")).expect("made");
    let (code, _, stderr) = run(&mut command);
    assert!(code == 2 && stderr.contains("would be replaced, but is read"), "{stderr}");
    assert_eq!(fs::read(&index).expect("there"), before);
    fs::rename(face.join("mesh.vtu"), face.join("face.vtu")).expect("renamed");
    let text = String::from_utf8(before).expect("text").replace("mesh.vtu", "face.vtu");
    fs::write(&index, text).expect("written");
    let mut command = modiolus();
    command.args(["forward", "--activate", "risorius=0.5", "--face"]).arg(&index).arg("--out").arg(&face);
    let (code, _, stderr) = run(&mut command);
    assert!(code == 2 && stderr.contains("face.vtu would be replaced"), "{stderr}");
}

#[test]
fn a_misspelt_standard_face_and_a_folder_are_told_as_such() {
    let (code, _, stderr) = run(modiolus().args(["face", "check", "Standrd"]));
    assert!(code == 2 && stderr.contains("did you mean `standard`?"), "{stderr}");
    let (code, _, stderr) = run(modiolus().args(["face", "check", "examples"]));
    assert!(code == 2 && stderr.contains("examples: is a folder"), "{stderr}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_stdout_without_room_is_an_error_and_a_closed_pipe_is_none() {
    for verb in [&["face", "check", "standard"][..], &["--help"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("the full device");
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("modiolus"));
        let output = command.args(verb).stdout(full).output().expect("it runs");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && stderr.contains("stdout cannot be written"), "{stderr}");
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let status = command.stdout(writer).status().expect("it runs");
        assert_eq!(status.code(), Some(0));
    }
}

#[test]
fn the_built_in_face_has_no_warning() {
    let (_, stdout, _) = run(modiolus().args(["face", "check", "standard"]));
    assert!(!stdout.contains("Warnings"), "{stdout}");
}

#[test]
fn an_unknown_landmark_names_its_line_and_the_nearest() {
    let dir = folder();
    let path = target(&dir, &LEFT_CORNER.replace("cheilion_l", "chelion_l"));
    let out = dir.path().join("out");
    let parts = ["t.toml:6", "markers[0].landmark", "chelion_l", "cheilion_l"];
    refused(modiolus().arg("fit").arg(&path).arg("--out").arg(&out), &out, &parts);
}

#[test]
fn an_unknown_muscle_in_a_bound_names_its_line() {
    let dir = folder();
    let path = target(&dir, &LEFT_CORNER.replace("\"*_r\"", "\"risorio_r\""));
    let out = dir.path().join("out");
    let parts = ["t.toml:11", "bounds[0].muscle", "risorio_r", "risorius_r"];
    refused(modiolus().arg("fit").arg(&path).arg("--out").arg(&out), &out, &parts);
}

#[test]
fn a_point_off_the_face_names_its_line() {
    let dir = folder();
    let path = target(
        &dir,
        &LEFT_CORNER.replace("landmark = \"cheilion_l\"", "name = \"p\"\npoint_mm = [0.0, 0.0, 90.0]"),
    );
    let out = dir.path().join("out");
    let parts = ["t.toml:7", "markers[0].point_mm", "from the face"];
    refused(modiolus().arg("fit").arg(&path).arg("--out").arg(&out), &out, &parts);
}

#[test]
fn a_bad_target_writes_nothing() {
    let dir = folder();
    let out = dir.path().join("out");
    let path = target(&dir, &LEFT_CORNER.replace("\"mm\"", "\"inch\""));
    let parts = ["error: ", "t.toml:2: unit", "\"inch\"", "unit = \"mm\""];
    refused(modiolus().arg("fit").arg(&path).arg("--out").arg(&out), &out, &parts);
    let missing = dir.path().join("none.toml");
    refused(modiolus().arg("fit").arg(&missing).arg("--out").arg(&out), &out, &["none.toml", "no such file"]);
}

#[test]
fn a_missing_face_file_is_refused() {
    let dir = folder();
    let (out, path) = (dir.path().join("out"), target(&dir, LEFT_CORNER));
    let mut command = modiolus();
    command.arg("fit").arg(&path).args(["--face", "no/face.toml", "--out"]).arg(&out);
    refused(&mut command, &out, &["no/face.toml", "no such file"]);
}

#[test]
fn bad_arguments_name_the_flag_and_the_remedy() {
    let dir = folder();
    let out = dir.path().join("out");
    for (arguments, parts) in [
        (
            &["map", "--out", "m.npz", "--stiffness", "activated"][..],
            &["--stiffness", "linear only at a held stiffness", "fixed=0.5"][..],
        ),
        (&["fit", "t.toml", "--stiffness", "0.5"], &["--stiffness", "activated", "fixed=0.5"]),
        (&["fit", "t.toml", "--contact", "soft"], &["--contact", "reactions", "kinematic", "off"]),
        (&["forward", "--activate", "zygomaticus_major_l=50"], &["--activate", "fractions"]),
        (&["forward", "--activate", "zygomaticus"], &["--activate", "NAME=VALUE"]),
        (&["forward", "--activate", "zygomatic=0.5"], &["--activate", "zygomatic", "zygomaticus_major_l"]),
        (&["forward", "--activate", "risorius=0.5,risorius_l=0.5"], &["risorius_l", "twice"]),
        (
            &["forward", "--activate", "risorius=1", "--contact", "kinematic"],
            &["--contact", "reactions or off"],
        ),
        (
            &["face", "export", "standard", "--resolution", "huge"],
            &["--resolution", "coarse, standard, fine"],
        ),
        (&["forward"], &["--activate"]),
        (&["forward", "--jaw-opening", "0.004"], &["--jaw-opening", "metres?"]),
        (&["map"], &["--out", "written as NPZ", "out.npz"]),
        (&["render", "standard"], &["--out", "written as PNG", "out.png"]),
    ] {
        refused(modiolus().args(arguments).arg("--out").arg(&out), &out, parts);
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_refused() {
    let dir = folder();
    let taken = dir.path().join("taken");
    fs::write(&taken, "a file").expect("written");
    let mut command = modiolus();
    command.args(["forward", "--activate", "risorius=0.5", "--contact", "off", "--out"]).arg(&taken);
    let (code, stdout, stderr) = run(&mut command);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    assert!(stderr.contains("taken") && stderr.contains("--out"), "{stderr}");
}

#[test]
fn a_file_where_the_folder_of_a_result_goes_is_told_before_the_work() {
    let dir = folder();
    let (path, file) =
        (target(&dir, &LEFT_CORNER.replace("cheilion_l", "nowhere")), dir.path().join("taken"));
    fs::write(&file, "mine").expect("written");
    // The target cannot be fitted either, which only the work finds out.
    let (code, _, stderr) = run(modiolus().arg("fit").arg(&path).arg("--out").arg(&file));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("is no folder"), "{stderr}");
    assert_eq!(fs::read_to_string(&file).expect("there"), "mine");
}

#[test]
fn only_the_frames_of_a_track_can_be_left_out_of_a_page() {
    let dir = folder();
    let page = dir.path().join("page.html");
    let mut command = modiolus();
    command.args(["report", "nowhere", "--every", "3", "--out"]).arg(&page);
    refused(&mut command, &page, &["--every: nowhere is no track"]);
}

#[test]
fn version_and_help_go_to_stdout() {
    let (code, stdout, _) = run(modiolus().arg("--version"));
    assert_eq!((code, stdout.as_str()), (0, concat!("modiolus ", env!("CARGO_PKG_VERSION"), "\n")));
    let (code, stdout, _) = run(modiolus().args(["fit", "--help"]));
    assert_eq!(code, 0);
    assert!(stdout.contains("--stiffness") && stdout.contains("--contact"), "{stdout}");
}

#[test]
fn strains_have_names_and_finite_strain_no_held_stiffness() {
    let dir = folder();
    let out = dir.path().join("out");
    for (arguments, parts) in [
        (["--strain", "finit", "--stiffness", "activated"], ["--strain", "did you mean finite?"]),
        (["--strain", "finite", "--stiffness", "fixed=0.5"], ["fixed=0.5", "linear strain"]),
        (["--strain", "finite", "--strength", "0"], ["--strength", "above 0"]),
    ] {
        let mut command = modiolus();
        command.args(["forward", "--activate", "risorius=0.5"]).args(arguments).arg("--out").arg(&out);
        refused(&mut command, &out, &parts);
    }
    let mut command = modiolus();
    command.args(["track", "nowhere.c3d", "--strain", "finite", "--stiffness", "mean", "--out"]).arg(&out);
    refused(&mut command, &out, &["--stiffness mean", "follows the activations", "--strain linear"]);
}

const KNOWN_SMILE: &str = r#"name = "known_smile"
unit = "mm"

[[marker]]
landmark = "cheilion_l"
displacement_mm = [2.0, 6.0, -3.0]
sigma_mm = 0.5

[[marker]]
landmark = "cheilion_r"
displacement_mm = [-2.0, 6.0, -3.0]
sigma_mm = 0.5

[[prior]]
muscle = "zygomaticus_major_*"
activation = 0.4
sigma = 0.04
"#;

#[test]
fn a_face_is_calibrated_and_used_again() {
    let dir = folder();
    let path = target(&dir, KNOWN_SMILE);
    let calibrate = |threads: &str, out: &Path| {
        let mut command = modiolus();
        command.env("RAYON_NUM_THREADS", threads).arg("calibrate").arg(&path);
        run(command.args(["--face", "standard_coarse", "--out"]).arg(out))
    };
    let (one, two) = (dir.path().join("one"), dir.path().join("two"));
    let (code, stdout, stderr) = calibrate("1", &one);
    assert_eq!(code, 0, "{stderr}");
    for part in [
        "Calibration of the coarse standard face by 1 expression: solved",
        "\nzygomaticus_major           1.",
        "active in no expression or where nothing was observed; they keep their priors: zygomaticus_minor, ",
        "changes nothing that was observed",
        "trades against",
    ] {
        assert!(stdout.contains(part), "\"{part}\" is not in: {stdout}");
    }
    assert_eq!(calibrate("2", &two).0, 0);
    let untimed = |out: &Path| timeless(&out.join("calibration.json"));
    assert!(untimed(&one) == untimed(&two), "calibration.json differs");
    for file in ["face.toml", "mesh.vtu", "fibres.csv"] {
        assert!(
            fs::read(one.join(file)).expect("written") == fs::read(two.join(file)).expect("written"),
            "{file}"
        );
    }
    let json: Value =
        serde_json::from_str(&fs::read_to_string(one.join("calibration.json")).expect("written"))
            .expect("JSON");
    assert_eq!(json["contact_mode"], "reactions");
    assert!(json["expressions"][0]["overlap_mm"].as_f64().expect("a number") <= 0.01, "{json}");
    let text = fs::read_to_string(one.join("face.toml")).expect("written");
    let young = json["moduli"]["tissue_young_kpa"].as_f64().expect("a number");
    assert!(text.contains("name = \"standard_coarse_calibrated\""), "{text}");
    assert!(text.contains(&format!("young_kpa = {young:?}")), "{text}");
    modiolus().args(["face", "check"]).arg(one.join("face.toml")).assert().success();
}

#[test]
fn what_cannot_be_calibrated_is_told() {
    let dir = folder();
    let out = dir.path().join("out");
    let refuse = |text: &str, more: &[&str], parts: &[&str]| {
        let path = target(&dir, text);
        let mut command = modiolus();
        command.arg("calibrate").arg(path).args(["--face", "standard_coarse", "--out"]).arg(&out).args(more);
        refused(&mut command, &out, parts);
    };
    refuse(LEFT_CORNER, &[], &["left_corner_up", "[[prior]]", "electromyography"]);
    let unmarked =
        &KNOWN_SMILE.replace("displacement_mm = [2.0, 6.0, -3.0]", "displacement_mm = [nan, nan, nan]");
    let unmarked =
        &unmarked.replace("displacement_mm = [-2.0, 6.0, -3.0]", "displacement_mm = [nan, nan, nan]");
    refuse(unmarked, &[], &["known_smile", "nothing is observed", "[[marker]]"]);
    refuse(KNOWN_SMILE, &["--prior", "stress=1:0.1"], &["stress", "muscle_stress", "zygomaticus_major"]);
    refuse(KNOWN_SMILE, &["--prior", "muscle_stress=2.5"], &["--prior", "muscle_stress=2.5:0.3"]);
    refuse(KNOWN_SMILE, &["--prior", "muscle_stress=-1:0.1"], &["muscle_stress", "median"]);
    let open = format!("jaw_opening_mm = 4.0\n{KNOWN_SMILE}");
    refuse(&open, &[], &["known_smile", "the jaw is open"]);
}
