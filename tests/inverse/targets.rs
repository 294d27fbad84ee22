//! Every shipped target can be read, states its source, and says what its name says.

use std::path::PathBuf;

use modiolus::inverse::{Goal, Target};
use modiolus::io::read_target;

const NAMES: [&str; 7] =
    ["symmetric_smile", "asymmetric_smile", "lip_closure", "lip_press", "pucker", "snarl", "frown"];

fn read(name: &str) -> Target {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("targets/{name}.toml"));
    let doc = read_target(&path).expect("a target");
    assert!(doc.warnings.is_empty(), "{name}: {:?}", doc.warnings);
    doc.target
}

#[test]
fn every_target_file_is_listed_and_read() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("targets");
    let mut found: Vec<String> = std::fs::read_dir(folder)
        .expect("the folder")
        .filter_map(|entry| entry.expect("an entry").file_name().into_string().ok())
        .filter_map(|file| file.strip_suffix(".toml").map(str::to_owned))
        .collect();
    found.sort();
    let mut names = NAMES.map(str::to_owned);
    names.sort();
    assert_eq!(found, names);
    for name in NAMES {
        let target = read(name);
        assert_eq!(target.name, name);
        assert!(target.description.len() > 20, "{name}");
        assert!(target.provenance.len() > 40, "{name}");
        assert!(target.effort > 0.0, "{name}");
        assert!(target.markers.len() + target.features.len() > 0, "{name}");
    }
}

/// The smile's figures are excursions and angles from the horizontal, lateral and upward positive.
#[test]
fn the_smile_is_the_published_one() {
    let target = read("symmetric_smile");
    for (landmark, excursion_mm, angle_deg, error_mm) in [
        ("cheilion", 13.7, 52.2f64, 0.01),
        ("nasolabial_fold", 10.5, 56.3, 0.01),
        ("upper_lip_lateral", 10.1, 57.2, 0.01),
        ("lower_lip_lateral", 6.7, -12.7, 0.01),
        ("labiale_superius", 7.3, 88.1, 0.3),
        ("labiale_inferius", 5.9, -87.5, 0.3),
    ] {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        for (side, sign) in [("_l", 1.0), ("_r", -1.0)] {
            let name = if landmark.starts_with("labiale") {
                landmark.to_owned()
            } else {
                format!("{landmark}{side}")
            };
            let marker = target.markers.iter().find(|m| m.name == name).expect("the marker");
            let Goal::Displacement([Some(x), Some(y), None]) = marker.goal else {
                panic!("{name}: {:?}", marker.goal)
            };
            assert!((x - sign * excursion_mm * cos).abs() < error_mm, "{name} {x}");
            assert!((y - excursion_mm * sin).abs() < error_mm, "{name} {y}");
        }
    }
}

#[test]
fn the_asymmetric_smile_has_the_same_markers_and_a_capped_right_side() {
    let (both, capped) = (read("symmetric_smile"), read("asymmetric_smile"));
    assert_eq!(both.markers, capped.markers);
    assert_eq!(capped.bounds.len(), 1);
    assert_eq!((capped.bounds[0].muscle.as_str(), capped.bounds[0].max), ("*_r", 0.2));
    assert!(capped.symmetry.is_empty());
}
