//! Faces of people, as users get them: matched to a scan, drawn from a population, operated on.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use modiolus::face::{Face, standard, standard::Resolution};
use modiolus::mesh::Surface;
use serde_json::Value;

use crate::common::surfaces::{bone, obj, skin};

fn run(arguments: &[&str]) -> (i32, String) {
    let mut command = Command::cargo_bin("modiolus").expect("the program");
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().expect("it runs");
    let stderr = String::from_utf8(output.stderr).expect("UTF-8");
    (output.status.code().expect("an exit code"), stderr)
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("written")).expect("JSON")
}

/// All files below `folder`, with what they hold.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("below").display().to_string();
                found.push((name, fs::read(&path).expect("read")));
            }
        }
    }
    found.sort();
    found
}

/// The scan, the landmarks and the bones of a patient in `folder`.
fn patient(face: &Face, folder: &Path) {
    let mut landmarks = String::from("landmark,x_mm,y_mm,z_mm\n");
    for landmark in &face.landmarks {
        let p = landmark.site.position;
        landmarks += &format!("{},{},{},{}\n", landmark.name, p.x, p.y, p.z);
    }
    let metres = |surface: &Surface| Surface {
        points: surface.points.iter().map(|p| p / 1000.).collect(),
        triangles: surface.triangles.clone(),
    };
    let skull = bone(face, "skull", 1.5);
    for (name, text) in [
        ("scan.obj", obj(&skin(face, 0))),
        ("landmarks.csv", landmarks),
        ("skull.obj", obj(&skull)),
        ("skull_m.obj", obj(&metres(&skull))),
        ("mandible.obj", obj(&bone(face, "mandible", 1.5))),
    ] {
        fs::write(folder.join(name), text).expect("written");
    }
}

#[test]
fn a_scan_and_its_bones_give_a_face_that_every_verb_takes() {
    let folder = tempfile::tempdir().expect("a folder");
    patient(&standard(&Resolution::COARSE), folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (scan, landmarks, out) = (at("scan.obj"), at("landmarks.csv"), at("out"));
    let register = |skull: &str| {
        let arguments =
            ["register", &scan, "--landmarks", &landmarks, "--face", "standard_coarse", "--out", &out];
        run(&[&arguments[..], &["--skull", &at(skull), "--mandible", &at("mandible.obj")]].concat())
    };
    let (code, stderr) = register("skull_m.obj");
    assert!(code == 2 && stderr.contains("skull") && stderr.contains("differ in unit or axes"), "{stderr}");
    assert!(!Path::new(&out).exists(), "nothing was written");

    let (code, stderr) = register("skull.obj");
    assert_eq!(code, 0, "{stderr}");
    let told = json(&folder.path().join("out/registration.json"));
    let inputs = told["inputs"].as_object().expect("inputs");
    for name in ["scan.obj", "landmarks.csv", "skull.obj", "mandible.obj"] {
        assert!(inputs.keys().any(|input| input.ends_with(name)), "{name} is not in {inputs:?}");
    }
    let (code, stderr) = run(&["face", "check", &at("out/face.toml")]);
    assert_eq!(code, 0, "{stderr}");
    let (face, forward) = (at("out/face.toml"), at("forward"));
    let (code, stderr) = run(&["forward", "--face", &face, "--activate", "risorius=0.3", "--out", &forward]);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn people_are_drawn_alike_from_one_seed() {
    let folder = tempfile::tempdir().expect("a folder");
    let sample = |seed: &str, name: &str| {
        let out = folder.path().join(name).display().to_string();
        let how = ["--count", "2", "--seed", seed, "--resolution", "coarse", "--out", &out];
        let (code, stderr) = run(&[&["face", "sample"], &how[..]].concat());
        assert_eq!(code, 0, "{stderr}");
        files(out.as_ref())
    };
    let (first, again, other) = (sample("3", "first"), sample("3", "again"), sample("4", "other"));
    assert_eq!(first, again);
    let faces: Vec<&String> =
        first.iter().map(|(name, _)| name).filter(|name| name.ends_with("face.toml")).collect();
    assert_eq!(faces.len(), 2, "{faces:?}");
    assert!(first.iter().zip(&other).any(|(a, b)| a.1 != b.1), "another seed gives other people");
    for face in faces {
        let (code, stderr) =
            run(&["face", "check", &folder.path().join("first").join(face).display().to_string()]);
        assert_eq!(code, 0, "{stderr}");
    }
}

#[test]
fn bones_are_moved_at_finite_strain() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("setback").display().to_string();
    let plan = "examples/setback/plan.toml";
    let (code, stderr) =
        run(&["surgery", plan, "--face", "standard_coarse", "--strain", "finite", "--out", &out]);
    assert_eq!(code, 0, "{stderr}");
    let (code, stderr) = run(&["face", "check", &format!("{out}/face.toml")]);
    assert_eq!(code, 0, "{stderr}");
    let (code, stderr) = run(&["surgery", plan, "--face", &format!("{out}/face.toml"), "--out", &out]);
    assert!(code == 2 && !stderr.is_empty(), "over its own face: {stderr}");
}
