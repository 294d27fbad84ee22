//! Results: of several targets at once, where they go, set against each other, and their programs for others to check.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use modiolus::face::{standard, standard::Resolution};
use modiolus::io::read_answer;
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
    let forward = || {
        let activate = ["forward", "--activate", "risorius=0.2", "--contact", "off"];
        run(modiolus(&dir).args(activate).args(["--face", "standard_coarse"]))
    };
    assert_eq!([forward().0, forward().0], [0, 0], "the same face anew");
    put(&dir, "forward.toml", "forward", 1.0, "");
    let (code, _, stderr) = fit("forward.toml");
    assert!(code == 2 && stderr.contains("out/standard_coarse/forward holds a result on"), "{stderr}");
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
    put(&dir, "c.toml", "two words", 1.0, "");
    put(&dir, "d.toml", "other", 1.0, "[[expected]]\nface = \"standard\"\nresidual_rms_mm = -1.0\n");
    fs::create_dir(dir.path().join("empty")).expect("made");
    for (arguments, parts) in [
        (&["verify", "empty"][..], &["empty: holds no target", ".toml"][..]),
        (&["verify", "none.toml"], &["none.toml"]),
        (&["verify", "a.toml", "b.toml"], &["a.toml and b.toml are both called corner"]),
        (&["fit", "a.toml", "c.toml", "d.toml"], &["c.toml:1", "two words", "d.toml:10", "tolerance_mm"]),
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

/// A result on the coarse face in the folder `name`.
fn result(dir: &TempDir, name: &str, arguments: &[&str]) {
    let mut command = modiolus(dir);
    command.args(arguments).args(["--face", "standard_coarse", "--contact", "off", "--out", name]);
    command.assert().success();
}

#[test]
fn two_results_are_compared_by_name_and_drawn_side_by_side() {
    let dir = tempfile::tempdir().expect("a folder");
    result(&dir, "a", &["forward", "--activate", "zygomaticus_major=0.2"]);
    result(&dir, "b", &["forward", "--activate", "zygomaticus_major_l=0.2,risorius_r=0.4"]);
    let compare = |arguments: &[&str]| run(modiolus(&dir).arg("compare").args(arguments));
    let (code, stdout, stderr) = compare(&["a", "b", "--json", "--out", "both.png"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(fs::read(dir.path().join("both.png")).expect("written").starts_with(b"\x89PNG"));
    let json: Value = serde_json::from_str(&stdout).expect("JSON");
    let of = |list: &str, name: &str| {
        let rows = json[list].as_array().expect("a list").iter();
        rows.clone().find(|row| row["name"] == name).expect("a row").clone()
    };
    assert_eq!(of("activations", "risorius_r")["change"], 0.4);
    assert_eq!(of("activations", "zygomaticus_major_r")["change"], -0.2);
    assert_eq!(of("activations", "zygomaticus_major_l")["change"], 0.0);
    let number = |value: &Value| value.as_f64().expect("a number");
    let [before, after] = ["a", "b"].map(|which| json[which]["symmetry"].clone());
    assert!(number(&before["landmarks_rms_mm"]) < 1e-6, "{before}");
    assert_eq!([&before["activations_rms"], &before["activations"]["zygomaticus_major"]], [0.0, 0.0]);
    assert!(number(&after["landmarks_rms_mm"]) > 0.2, "{after}");
    assert!((number(&after["activations"]["risorius"]) + 0.4).abs() < 1e-15, "{after}");
    // The difference of a landmark's movement, from the vectors told.
    let corner = of("landmarks", "cheilion_r");
    let [u, v] = ["a", "b"].map(|k| corner[format!("displacement_{k}_mm")].clone());
    let apart: f64 = (0..3).map(|k| (number(&v[k]) - number(&u[k])).powi(2)).sum::<f64>().sqrt();
    assert!((number(&corner["apart_mm"]) - apart).abs() < 1e-12, "{corner}");
    assert_eq!([&json["faces_differ"], &json["contact"]["a"]], [&Value::Bool(false), &Value::Null]);
    let (_, stdout, _) = compare(&["a", "b"]);
    for part in ["risorius_r", "+40", "-20", "landmarks rms, mm", "alike within"] {
        assert!(stdout.contains(part), "\"{part}\" is not in: {stdout}");
    }
    let (_, stdout, _) = compare(&["a", "a", "--json"]);
    let same: Value = serde_json::from_str(&stdout).expect("JSON");
    for row in same["landmarks"].as_array().expect("landmarks") {
        assert_eq!(row["apart_mm"], 0.0, "{row}");
    }
}

#[test]
fn faces_with_other_muscles_and_another_rest_are_compared() {
    let dir = tempfile::tempdir().expect("a folder");
    result(&dir, "a", &["forward", "--activate", "zygomaticus_major=0.2"]);
    let mut export = modiolus(&dir);
    export.args(["face", "export", "standard", "--resolution", "coarse", "--out", "face"]).assert().success();
    let index = dir.path().join("face/face.toml");
    let text = fs::read_to_string(&index).expect("written");
    let start = text.find("[[muscles]]\nname = \"risorius\"").expect("risorius");
    let end = start + 5 + text[start + 5..].find("[[").expect("the next");
    fs::write(&index, format!("{}{}", &text[..start], &text[end..])).expect("written");
    let mut command = modiolus(&dir);
    command.args(["forward", "--activate", "zygomaticus_major=0.2", "--face", "face/face.toml"]);
    command.args(["--contact", "off", "--out", "b"]).assert().success();
    let (code, stdout, stderr) = run(modiolus(&dir).args(["compare", "a", "b", "--json"]));
    assert_eq!(code, 0, "{stderr}");
    let json: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(json["only_a"], serde_json::json!(["risorius_l", "risorius_r"]));
    assert_eq!(json["only_b"], serde_json::json!([]));
    assert_eq!(json["faces_differ"], false, "what was exported is the face");
    // The face is another from here on.
    fs::write(&index, format!("{}\n# edited\n", fs::read_to_string(&index).expect("text"))).expect("written");
    let (code, _, stderr) = run(modiolus(&dir).args(["compare", "a", "b"]));
    assert!(
        code == 2 && stderr.contains("face/face.toml is not what the result was computed from"),
        "{stderr}"
    );
}

#[test]
fn what_cannot_be_compared_or_exported_is_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    result(&dir, "a", &["forward", "--activate", "zygomaticus_major=0.2"]);
    fs::create_dir(dir.path().join("empty")).expect("made");
    fs::create_dir(dir.path().join("other")).expect("made");
    fs::write(dir.path().join("other/solution.json"), "{\"targets\": []}").expect("written");
    let plan = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/setback/plan.toml");
    let mut operate = modiolus(&dir);
    operate.args([
        "surgery",
        plan,
        "--face",
        "standard_coarse",
        "--out",
        "operated",
        "--picture",
        "both.png",
    ]);
    let told = operate.assert().success().get_output().stdout.clone();
    let told = String::from_utf8(told).expect("UTF-8");
    assert!(
        told.contains("mandible_body  its middle goes 5.0 mm: 0.0 to the left, 0.0 up, -5.0 forward"),
        "{told}"
    );
    let both = fs::read(dir.path().join("both.png")).expect("written");
    let (width, height) = (
        u32::from_be_bytes(both[16..20].try_into().expect("four")),
        u32::from_be_bytes(both[20..24].try_into().expect("four")),
    );
    assert!(width > 3 * height, "before and after, front and profile: {width} x {height}");
    let text = fs::read_to_string(dir.path().join("operated/face.toml")).expect("written");
    assert!(text.contains("name = \"standard_coarse_setback"), "{text}");
    for (arguments, parts) in [
        (&["compare", "a", "none"][..], &["none: there is no such folder"][..]),
        (&["compare", "empty", "a"], &["solution.json: cannot be read"]),
        (&["compare", "a", "other"], &["other/solution.json", "`face`"]),
        (&["compare", "a", "operated"], &["operated: holds how the tissue follows moved bones"]),
        (&["compare", "a", "a", "--view", "profile"], &["--out"]),
        (&["compare", "a", "a", "--out", "x.gif"], &["written as PNG"]),
        (&["export", "a", "--to", "qps", "--out", "x.qps"], &["a: nothing was fitted there"]),
        (&["export", "a", "--to", "mps", "--out", "x"], &["--to", "qps", "npz"]),
        (&["export", "none", "--to", "qps", "--out", "x"], &["none: there is no such folder"]),
    ] {
        let (code, stdout, stderr) = run(modiolus(&dir).args(arguments));
        assert_eq!((code, stdout.as_str()), (2, ""), "{arguments:?}: {stderr}");
        for part in parts {
            assert!(stderr.contains(part), "{arguments:?}: \"{part}\" is not in: {stderr}");
        }
    }
    let vtu = dir.path().join("a/face.vtu");
    fs::write(&vtu, fs::read(&vtu).expect("there").split_last().expect("bytes").1).expect("written");
    let (code, _, stderr) = run(modiolus(&dir).args(["compare", "a", "a"]));
    assert!(code == 2 && stderr.contains("is not the file that was written with solution.json"), "{stderr}");
}

/// The numbers in the array `name` of the NPZ file `bytes`.
fn numbers(bytes: &[u8], name: &str) -> Vec<f64> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).expect("a zip");
    let mut npy = Vec::new();
    let mut entry = archive.by_name(&format!("{name}.npy")).expect("an array");
    std::io::Read::read_to_end(&mut entry, &mut npy).expect("read");
    npyz::NpyFile::new(&npy[..]).expect("npy").into_vec().expect("numbers")
}

#[test]
fn what_moves_without_a_fit_is_exported_as_arrays_too() {
    let dir = tempfile::tempdir().expect("a folder");
    result(&dir, "a", &["forward", "--activate", "zygomaticus_major_l=0.2"]);
    let (code, _, stderr) = run(modiolus(&dir).args(["export", "a", "--to", "npz", "--out", "a.npz"]));
    assert_eq!(code, 0, "{stderr}");
    let bytes = fs::read(dir.path().join("a.npz")).expect("written");
    let answer = read_answer(&dir.path().join("a")).expect("a result");
    assert_eq!(numbers(&bytes, "displacement"), answer.displacement);
    let face = standard(&Resolution::COARSE);
    let rows = numbers(&bytes, "landmark_displacement");
    for (landmark, row) in face.landmarks.iter().zip(rows.chunks(3)) {
        let u = landmark.site.displacement(&answer.displacement);
        assert_eq!([u.x, u.y, u.z], row, "{}", landmark.name);
    }
    let active: f64 = numbers(&bytes, "activation").iter().sum();
    assert_eq!(active, 0.2);
    assert!(numbers(&bytes, "marker_target").iter().all(|mm| mm.is_nan()), "nothing was asked");
}

/// A target that is met at rest: both fits end at once. The second run draws what is there.
#[test]
fn a_gallery_has_a_picture_of_both_strains_and_figures_of_each_target() {
    let dir = tempfile::tempdir().expect("a folder");
    let target = "name = \"still\"\ndescription = \"Nothing moves.\"\nprovenance = \"Posed.\"\nunit = \"mm\"\neffort = 1.0\n\
                  [[marker]]\nlandmark = \"cheilion_l\"\ndisplacement_mm = [0.0, 0.0, 0.0]\nsigma_mm = 1.0\n";
    fs::write(dir.path().join("still.toml"), target).expect("written");
    let gallery = |more: &[&str]| {
        let mut command = modiolus(&dir);
        command.args(["gallery", "still.toml", "--face", "standard_coarse", "--out", "drawn"]);
        run(command.args(["--answers", "answers"]).args(more))
    };
    let (code, list, stderr) = gallery(&[]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(list.lines().collect::<Vec<_>>(), ["drawn/still.png", "drawn/README.md"]);
    assert!(
        stderr.contains("still, finite strain, muscles 2.5 times as strong: fitted for at most 10 min"),
        "{stderr}"
    );
    let index = fs::read_to_string(dir.path().join("drawn/README.md")).expect("written");
    for part in [
        "| linear strain | solved | 0.00 | 0 | 0 |",
        "times as strong | solved | 0.00 | 0 | 0 |",
        "(still.png)",
    ] {
        assert!(index.contains(part), "\"{part}\" is not in: {index}");
    }
    let picture = fs::read(dir.path().join("drawn/still.png")).expect("written");
    let (code, _, stderr) = gallery(&[]);
    assert!(code == 0 && !stderr.contains("fitted for"), "{stderr}");
    assert_eq!(fs::read(dir.path().join("drawn/still.png")).expect("written"), picture);

    fs::write(dir.path().join("drawn/notes.txt"), "mine").expect("written");
    let (code, _, stderr) = gallery(&[]);
    assert!(
        code == 2 && stderr.contains("drawn holds files that are no figures, such as notes.txt"),
        "{stderr}"
    );
}

/// With a sparse effort the objective is that of the residuals and of the slopes that are exported with them.
#[test]
fn the_program_of_a_sparse_effort_has_its_slopes() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = put(&dir, "a.toml", "corner", 1.0, "");
    let text = fs::read_to_string(&path).expect("there");
    let text = text.replace("effort = 0.1", "effort = 0.1\neffort_norm = \"l1\"\neffort_by = \"force\"");
    fs::write(&path, text).expect("written");
    let mut command = modiolus(&dir);
    command.args(["fit", "a.toml", "--face", "standard_coarse", "--out", "fitted"]).assert().success();
    let (code, _, stderr) = run(modiolus(&dir).args(["export", "fitted", "--to", "npz", "--out", "a.npz"]));
    assert_eq!(code, 0, "{stderr}");
    let bytes = fs::read(dir.path().join("a.npz")).expect("written");
    let numbers = |name: &str| numbers(&bytes, name);
    let (x, q, r, v) = (numbers("x"), numbers("q"), numbers("residual_matrix"), numbers("residual_value"));
    let (slopes, parts, n) = (numbers("part_slope"), numbers("part_objective"), x.len());
    let own = |rows: &[f64], k: usize| rows.iter().skip(k).step_by(n).copied().collect::<Vec<f64>>();
    for (k, q) in q.iter().enumerate() {
        let pulled: f64 = own(&r, k).iter().zip(&v).map(|(r, v)| r * v).sum();
        let slope: f64 = own(&slopes, k).iter().sum();
        assert!((pulled + slope - q).abs() < 1e-9 * q.abs().max(1.), "{k}: {pulled} {slope} {q}");
    }
    // One marker, then the effort: of its force relative to the mean, so that muscles differ.
    let effort: f64 = slopes.iter().skip(n).zip(&x).map(|(slope, x)| slope * x).sum();
    assert!(
        parts.len() == 2 && effort > 0. && (parts[1] - effort).abs() < 1e-12 * effort,
        "{parts:?} {effort}"
    );
    let differ = slopes[n..].iter().filter(|slope| **slope > 0.).any(|slope| *slope != slopes[n]);
    assert!(differ && slopes[..n].iter().all(|slope| *slope == 0.), "{slopes:?}");
}

/// The program of a result, whose arrays `tests/interop/check_certificate.py` checks.
#[test]
fn the_program_of_a_result_is_exported_in_three_forms_and_only_of_what_it_was_fitted_from() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = put(&dir, "a.toml", "corner", 1.0, "");
    let mut command = modiolus(&dir);
    command.args(["fit", "a.toml", "--face", "standard_coarse", "--out", "fitted"]).assert().success();
    let export =
        |to: &str, out: &str| run(modiolus(&dir).args(["export", "fitted", "--to", to, "--out", out]));
    let (code, _, stderr) = export("npz", "a.npz");
    assert_eq!(code, 0, "{stderr}");
    let bytes = fs::read(dir.path().join("a.npz")).expect("written");
    let numbers = |name: &str| numbers(&bytes, name);
    let (x, p, q, r) = (numbers("x"), numbers("P"), numbers("q"), numbers("r")[0]);
    let n = x.len();
    let quadratic: f64 = (0..n * n).map(|k| 0.5 * x[k / n] * p[k] * x[k % n]).sum();
    let objective = quadratic + q.iter().zip(&x).map(|(q, x)| q * x).sum::<f64>() + r;
    let parts: f64 = numbers("part_objective").iter().sum();
    assert!((objective - parts).abs() < 1e-9 * objective.max(1.), "{objective} {parts}");
    assert!(numbers("part_slope").iter().all(|slope| *slope == 0.), "squares have no slope");
    let answer: Value =
        serde_json::from_slice(&fs::read(dir.path().join("fitted/solution.json")).expect("there"))
            .expect("JSON");
    let stated: Vec<f64> =
        answer["activations"].as_object().expect("activations").values().filter_map(Value::as_f64).collect();
    let mut found = x[..stated.len()].to_vec();
    let mut sorted = stated.clone();
    found.sort_by(f64::total_cmp);
    sorted.sort_by(f64::total_cmp);
    assert_eq!(found, sorted, "the variables are the activations first");
    for (to, parts) in [("qps", ["ROWS", "QUADOBJ", "ENDATA"]), ("qp", ["minimize", "subject to", "bounds"])]
    {
        assert_eq!(export(to, "a.txt").0, 0);
        let text = fs::read_to_string(dir.path().join("a.txt")).expect("written");
        for part in parts {
            assert!(text.lines().any(|line| line == part), "{to} has no {part}");
        }
    }
    let text = fs::read_to_string(&path).expect("there");
    fs::write(&path, text.replace("sigma_mm = 1.0", "sigma_mm = 1.1")).expect("written");
    let (code, _, stderr) = export("npz", "b.npz");
    assert!(code == 2 && stderr.contains("a.toml is not what the result was computed from"), "{stderr}");
    assert!(!dir.path().join("b.npz").exists());
}
