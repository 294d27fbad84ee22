//! Every shipped target is solved to its certificate and gives what its file states, or says that it does not.

use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;
use serde_json::Value;

fn targets() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("targets");
    let mut found: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    found.sort();
    assert_eq!(found.len(), 7, "{found:?}");
    found
}

/// Fits every target on `face` (a path or `standard`), whose name in the target files is `name`.
fn hold(face: &str, name: &str) {
    let out = tempfile::tempdir().unwrap();
    targets().par_iter().for_each(|target| {
        let is_stated = std::fs::read_to_string(target).unwrap().contains(&format!("face = \"{name}\""));
        let output = Command::new(env!("CARGO_BIN_EXE_modiolus"))
            .arg("fit")
            .arg(target)
            .args(["--face", face, "--json", "--out"])
            .arg(out.path().join(target.file_stem().unwrap()))
            .output()
            .unwrap();
        let what = format!("{} on {name}", target.file_stem().unwrap().to_string_lossy());
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        if !is_stated {
            // Where contact does not settle the fit says so, and calls nothing solved that overlaps.
            let is_apart = answer["contact"]["overlap_mm"].as_f64().unwrap() <= 0.1;
            let status = if is_apart { "solved" } else { "not_converged" };
            assert_eq!(answer["status"], status, "{what}: {}", answer["contact"]);
            return;
        }
        assert!(output.status.success(), "{what}: {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(answer["status"], "solved", "{what}");
        for residual in ["primal", "dual", "gap"] {
            assert!(answer["certificate"][residual].as_f64().unwrap() <= 1e-9, "{what}: {residual}");
        }
        assert!(answer["contact"]["max_penetration_mm"].as_f64().unwrap() <= 1e-6, "{what}");
        assert!(answer["contact"]["overlap_mm"].as_f64().unwrap() <= 0.1, "{what}");
        let activations = answer["activations"].as_object().unwrap();
        for (muscle, a) in activations {
            let a = a.as_f64().unwrap();
            assert!((0. ..=1.).contains(&a), "{what}: {muscle} {a}");
            // The face is its own mirror image to the bit, and so is every target but that of a palsy.
            let other = muscle.strip_suffix("_l").map_or(muscle.clone(), |stem| format!("{stem}_r"));
            let apart = (a - activations[&other].as_f64().unwrap()).abs();
            let is_symmetric = name == "standard" && !target.ends_with("asymmetric_smile.toml");
            assert!(!is_symmetric || apart <= 1e-9, "{what}: {muscle} {apart:e}");
        }
        let expected = &answer["expected"];
        assert_eq!(expected["met"], true, "{what}: {expected}");
    });
}

#[test]
fn the_standard_face_gives_what_the_targets_state() {
    hold("standard", "standard");
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn the_badin_face_gives_what_the_targets_state() {
    assert!(std::env::var_os("MODIOLUS_DATA").is_some(), "MODIOLUS_DATA names the data folder");
    let face = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/badin/face.toml");
    hold(face.to_str().unwrap(), "badin");
}
