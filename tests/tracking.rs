//! From markers over time to activations: a movement that is known comes back, whatever the head does and the camera loses.

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use modiolus::face::{Face, Pose, Similarity, standard, standard::Resolution};
use modiolus::forward::Model;
use modiolus::mesh::Site;
use modiolus::recording::{
    FrameStatus, MarkerMap, Neutral, OffSkin, Recording, Subject, SubjectError, SubjectWarning,
};
use modiolus::study::{HeldStiffness, Track};
use modiolus::units::Vec3;
use nalgebra::Rotation3;

const FRAMES: usize = 150;
const RATE_HZ: f64 = 60.;
/// Where the stiffness is held, here and there.
const HELD: f64 = 0.2;
/// On the skull, above the face's mesh.
const SKULL: [(&str, [f64; 3]); 4] = [
    ("glabella", [0., 86., -5.]),
    ("forehead_l", [28., 98., -10.]),
    ("forehead_r", [-28., 98., -10.]),
    ("vertex", [3., 110., -40.]),
];
/// Frames in which the corners of the mouth are labelled as each other.
const SWAPPED: [usize; 2] = [40, 52];

fn coarse() -> Face {
    standard(&Resolution::COARSE)
}

/// Activations of some muscles and the jaw's opening at a time.
fn moved(face: &Face, time_s: f64) -> (Vec<f64>, f64) {
    let wave =
        |rate: f64, phase: f64| (0.5 - 0.5 * (std::f64::consts::TAU * (rate * time_s + phase)).cos()).powi(2);
    let mut a = vec![0.; face.muscles.len()];
    for (name, rate, most) in [
        ("zygomaticus_major_l", 0.8, 0.5),
        ("zygomaticus_major_r", 0.8, 0.3),
        ("depressor_labii_inferioris_l", 1.1, 0.4),
        ("mentalis_r", 0.6, 0.3),
    ] {
        a[face.muscle_index(name).expect("a muscle")] = most * wave(rate, 0.);
    }
    (a, 9. * wave(0.5, 0.1))
}

/// Neutral places and the recording of a head that turns, with gaps and swapped labels. The subject is 1.1 times as small as
/// the face.
fn recorded(face: &Face, times_s: &[f64]) -> (BTreeMap<String, Vec3>, Recording) {
    let model = Model::new(face, Vec::new()).expect("a model");
    let fixed = model.at(&vec![HELD; face.muscles.len()]).expect("a stiffness");
    let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
    let mut names: Vec<String> = face.landmarks.iter().map(|l| l.name.clone()).collect();
    let mut rest: Vec<Vec3> = sites.iter().map(|s| s.position).collect();
    for (name, at) in SKULL {
        names.push(name.to_owned());
        rest.push(Vec3::from(at));
    }
    let subject = |p: Vec3| p / 1.1 + Vec3::new(0., 1400., 20.);
    let corner = |side: &str| names.iter().position(|n| n == &format!("cheilion_{side}")).expect("a corner");
    let (left, right) = (corner("l"), corner("r"));
    let jaw = face.jaw.as_ref().expect("a jaw");
    let mut positions = Vec::new();
    for (frame, &t) in times_s.iter().enumerate() {
        let (a, opening_mm) = moved(face, t);
        let mut u = fixed.displacement(&a, &[]);
        u.iter_mut().zip(fixed.lifted_by(&Pose::opened(jaw, opening_mm))).for_each(|(u, lift)| *u += lift);
        let head = Similarity {
            scale: 1.,
            rotation: Rotation3::from_euler_angles(0.1 * (2. * t).sin(), 0.3 * t.sin(), 0.05 * t),
            translation: Vec3::new(30. * t, -5. * (3. * t).cos(), 12. * t),
        };
        let at = |k: usize| rest[k] + sites.get(k).map_or_else(Vec3::zeros, |s| s.displacement(&u));
        let mut row: Vec<Option<Vec3>> = (0..rest.len()).map(|k| Some(head.apply(subject(at(k))))).collect();
        if (SWAPPED[0]..=SWAPPED[1]).contains(&frame) {
            row.swap(left, right);
        }
        for (k, p) in row.iter_mut().enumerate() {
            if (7 * frame + 3 * k) % 20 == 0 {
                *p = None;
            }
        }
        positions.extend(row);
    }
    let neutral = names.iter().cloned().zip(rest.iter().map(|p| subject(*p))).collect();
    (neutral, Recording::new(names, times_s.to_vec(), positions).expect("whole"))
}

fn times() -> Vec<f64> {
    (0..FRAMES).map(|k| k as f64 / RATE_HZ).collect()
}

#[test]
fn a_known_movement_comes_back() {
    let face = coarse();
    let (neutral, recording) = recorded(&face, &times());
    // Markers that are sure leave no room for the wish to change little from frame to frame.
    let mut map = MarkerMap {
        neutral: Neutral::Positions(neutral),
        effort: 1e-7,
        sigma_mm: 0.02,
        ..MarkerMap::default()
    };
    let found =
        Track::new(&face, &recording, map.clone(), HeldStiffness::At(HELD), false).expect("a subject");
    let stable = &found.movement.head.stable;
    assert!(
        SKULL.iter().all(|(name, _)| stable.iter().any(|k| recording.names()[*k] == *name)),
        "{stable:?}"
    );
    // Skin near the nose moves a little with the muscles, and the head that is found with it.
    map.stable = SKULL.iter().map(|(name, _)| (*name).to_owned()).collect();
    let track = Track::new(&face, &recording, map, HeldStiffness::At(HELD), false).expect("a subject");
    assert!(track.movement.head.rms_mm < 1e-9, "{}", track.movement.head.rms_mm);
    assert!((track.subject.alignment.scale - 1.1).abs() < 1e-9 && track.subject.alignment_rms_mm < 1e-9);
    let swaps = &track.movement.swaps;
    assert_eq!(swaps.len(), 1, "{swaps:?}");
    assert!(
        swaps[0].labels.iter().all(|l| l.starts_with("cheilion")) && swaps[0].frames == SWAPPED,
        "{swaps:?}"
    );
    let left_out =
        track.subject.warnings.iter().any(|w| matches!(w, SubjectWarning::LeftOut(m) if m.len() == 4));
    assert!(left_out, "{:?}", track.subject.warnings);

    let frames = track.fit_all(|block| track.fit(block));
    assert_eq!(frames.len(), FRAMES);
    let (mut worst, mut worst_jaw) = (0_f64, 0_f64);
    for (frame, t) in frames.iter().zip(times()) {
        assert_eq!((frame.status, frame.outliers.len()), (FrameStatus::Ok, 0), "{t}");
        let (a, opening_mm) = moved(&face, t);
        for (found, true_value) in frame.unknowns.iter().zip(&a) {
            worst = worst.max((found - true_value).abs());
        }
        let jaw = track.mechanism.jaw_mm(&frame.unknowns).expect("a jaw");
        worst_jaw = worst_jaw.max((jaw[0] - opening_mm).abs());
    }
    assert!(worst < 0.03, "activation off by {worst:.4}");
    assert!(worst_jaw < 0.05, "jaw off by {worst_jaw:.3} mm");
    let summary = track.summary(&face, &frames);
    assert!(summary.all.explained.is_some_and(|e| e > 0.9999), "{:?}", summary.all);
    assert_eq!(summary.frames[&FrameStatus::Ok], FRAMES);
}

#[test]
fn a_marker_that_is_off_alone_is_named_and_does_not_count() {
    let face = coarse();
    let times = times();
    let (neutral, recording) = recorded(&face, &times);
    let chin = recording.names().iter().position(|n| n == "pogonion").expect("a marker");
    let mut positions: Vec<Option<Vec3>> = (0..FRAMES).flat_map(|f| recording.frame(f).to_vec()).collect();
    let m = recording.names().len();
    positions[70 * m + chin] = positions[70 * m + chin].map(|p| p + Vec3::new(0., 9., 6.));
    let recording = Recording::new(recording.names().to_vec(), times, positions).expect("whole");
    let map = MarkerMap { neutral: Neutral::Positions(neutral), ..MarkerMap::default() };
    let track = Track::new(&face, &recording, map, HeldStiffness::At(HELD), false).expect("a subject");
    let summary = track.summary(&face, &track.fit_all(|block| track.fit(block)));
    let named: Vec<(usize, &str)> = summary.outliers.iter().map(|o| (o.frame, o.marker.as_str())).collect();
    assert_eq!(named, [(70, "pogonion")]);
}

#[test]
fn threads_and_blocks_do_not_change_the_bytes() {
    let face = coarse();
    let times: Vec<f64> = (0..500).map(|k| f64::from(k) / RATE_HZ).collect();
    let (neutral, recording) = recorded(&face, &times);
    let map = MarkerMap { neutral: Neutral::Positions(neutral), ..MarkerMap::default() };
    let track = Track::new(&face, &recording, map, HeldStiffness::At(HELD), true).expect("a subject");
    let all = track.fit_all(|block| track.fit(block));
    let blocks = track.blocks();
    assert!(blocks.len() > 1);
    let last = track.fit(blocks[blocks.len() - 1].clone());
    assert_eq!(all[blocks[blocks.len() - 1].start..], last);
    assert!(all.iter().all(|f| f.status == FrameStatus::Ok));
    // Nothing shows where blocks meet: the step there is like those beside it.
    let step = |f: usize| {
        let pairs = all[f].unknowns.iter().zip(&all[f + 1].unknowns);
        pairs.map(|(a, b)| (a - b).abs()).fold(0., f64::max)
    };
    let seam = blocks[0].end - 1;
    assert!(
        step(seam) <= 2. * step(seam - 1).max(step(seam + 1)) + 1e-3,
        "{} {} {}",
        step(seam - 1),
        step(seam),
        step(seam + 1)
    );
}

#[test]
fn what_cannot_be_brought_to_the_face_is_told() {
    let face = coarse();
    let (neutral, recording) = recorded(&face, &times()[..2]);
    let map = || MarkerMap { neutral: Neutral::Positions(neutral.clone()), ..MarkerMap::default() };
    let told = |map: MarkerMap| {
        Subject::new(&recording, &map, &face).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let mut misspelt = map();
    misspelt.ignore.push("cheilion".into());
    assert!(told(misspelt).contains("`cheilion` is no marker of the recording; did you mean cheilion_l"));
    let mut far = map();
    far.off_skin = OffSkin::Refuse;
    let text = told(far);
    assert!(text.contains("4 markers farther than 5 mm off the skin: glabella ("), "{text}");
    let mut few = map();
    few.ignore = face.landmarks.iter().skip(2).map(|l| l.name.clone()).collect();
    assert!(told(few).contains("2 markers that are landmarks of the face"));
    let metres = |p: &Vec3| p / 1000.;
    let small = MarkerMap {
        neutral: Neutral::Positions(neutral.iter().map(|(k, p)| (k.clone(), metres(p))).collect()),
        ..MarkerMap::default()
    };
    assert!(matches!(Subject::new(&recording, &small, &face), Err(SubjectError::Scale { .. })));
    let mut crossed = neutral.clone();
    let (l, r) = (neutral["cheilion_l"], neutral["cheilion_r"]);
    crossed.extend([("cheilion_l".to_owned(), r), ("cheilion_r".to_owned(), l)]);
    let crossed = MarkerMap { neutral: Neutral::Positions(crossed), ..MarkerMap::default() };
    let subject = Subject::new(&recording, &crossed, &face).expect("a subject");
    assert!(
        subject
            .warnings
            .iter()
            .any(|w| matches!(w, SubjectWarning::Swapped { exchanged_mm, .. } if *exchanged_mm < 1.))
    );
}

/// The recording and its map in `folder`.
fn write(folder: &Path, face: &Face, frames: usize) {
    let times: Vec<f64> = (0..frames).map(|k| k as f64 / RATE_HZ).collect();
    let (neutral, recording) = recorded(face, &times);
    let mut rest = String::from("marker,x_mm,y_mm,z_mm\n");
    for (name, p) in &neutral {
        rest += &format!("{name},{},{},{}\n", p.x, p.y, p.z);
    }
    let mut table = String::from("time_s,marker,x_mm,y_mm,z_mm\n");
    for (frame, t) in times.iter().enumerate() {
        for (name, p) in recording.names().iter().zip(recording.frame(frame)) {
            if let Some(p) = p {
                table += &format!("{t},{name},{},{},{}\n", p.x, p.y, p.z);
            }
        }
    }
    for (name, text) in [
        ("rest.csv", rest),
        ("markers.csv", table),
        ("map.toml", "unit = \"mm\"\nneutral_file = \"rest.csv\"\n".into()),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
}

fn program(folder: &Path, out: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_modiolus"));
    command.current_dir(folder).args([
        "track",
        "markers.csv",
        "--map",
        "map.toml",
        "--face",
        "standard_coarse",
    ]);
    command.args(["--stiffness", "fixed=0.2", "--contact", "off", "--out", out]).stdout(Stdio::null());
    command
}

/// The files of a track, and its summary without what takes time.
fn result(folder: &Path) -> BTreeMap<String, String> {
    let files = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    let text = |path: &Path| {
        let text = String::from_utf8_lossy(&std::fs::read(path).expect("read")).into_owned();
        let Ok(mut json) = serde_json::from_str::<serde_json::Value>(&text) else { return text };
        json.as_object_mut().map(|o| o.remove("timings_s"));
        json.to_string()
    };
    files.map(|p| (p.file_name().expect("a name").to_string_lossy().into_owned(), text(&p))).collect()
}

#[test]
fn a_run_that_is_killed_goes_on_and_ends_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), &coarse(), 1200);
    assert!(program(folder.path(), "whole").status().expect("run").success());
    let whole = result(&folder.path().join("whole"));
    for name in ["activations.csv", "activations.sto", "frames.csv", "residuals.csv", "summary.json"] {
        assert!(whole.contains_key(name), "{name}");
    }
    let mut kept = 0;
    for k in 0..10 {
        let mut child = program(folder.path(), "killed").spawn().expect("run");
        std::thread::sleep(Duration::from_millis(150 + 130 * k));
        let _ = child.kill();
        child.wait().expect("ended");
        kept += usize::from(folder.path().join("killed/.blocks").exists());
    }
    assert!(program(folder.path(), "killed").status().expect("run").success());
    assert_eq!(result(&folder.path().join("killed")), whole);
    assert!(kept > 0, "killed too early each time");
}
