//! Some thousand damaged files a reader: none may panic, hang, or fill the memory. `fuzz/` has the same readers as
//! targets for a fuzzer, and the corpus.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use modiolus::contact::closed_surface;
use modiolus::io::{
    ReadOptions, parse_marker_map, parse_mesh, parse_plan, parse_recording, parse_surface, parse_target,
    read_face, recording_csv,
};
use modiolus::mesh::{Locator, validate_shape};
use modiolus::units::LengthUnit::Millimetre;

/// How many files each reader gets, or as `MODIOLUS_FUZZ` says.
const ROUNDS: usize = 1500;
/// A file of a few hundred bytes that takes longer than this does something that it should not.
const LONGEST: Duration = Duration::from_secs(10);

fn corpus(reader: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(reader);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

/// Numerical Recipes' linear congruential generator: the same files in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// Words that readers choke on.
const WORDS: [&str; 20] = [
    "-1",
    "0",
    "1",
    "4294967295",
    "18446744073709551617",
    "1e308",
    "1e-9",
    "nan",
    "inf",
    ",",
    "\n",
    "\"",
    "*",
    "$",
    "<",
    "\r\n",
    "2147483647",
    "*NSET, NSET=a, GENERATE\n1,2147483647,1\n",
    "100000000",
    "1e12",
];

fn damaged(files: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = files[random.below(files.len())].clone();
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len() + 1);
        let to = (at + random.below(40)).min(bytes.len());
        match random.below(7) {
            0 if at < bytes.len() => bytes[at] = random.below(256) as u8,
            1 => drop(bytes.drain(at..to)),
            2 => {
                let copy = bytes[at..to].to_vec();
                let place = random.below(bytes.len() + 1);
                bytes.splice(place..place, copy);
            }
            3 => bytes.truncate(at),
            4 => {
                let other = &files[random.below(files.len())];
                bytes.truncate(at);
                bytes.extend(&other[random.below(other.len())..]);
            }
            5 => {
                // A number becomes another one.
                let digits = |b: &u8| b.is_ascii_digit();
                let start = bytes[at..].iter().position(digits).map_or(bytes.len(), |k| at + k);
                let end = start + bytes[start..].iter().take_while(|b| digits(b)).count();
                bytes.splice(start..end, WORDS[random.below(WORDS.len())].bytes());
            }
            _ => drop(bytes.splice(at..at, WORDS[random.below(WORDS.len())].bytes())),
        }
    }
    bytes
}

fn smoke(reader: &str, share: usize, read: impl Fn(&[u8])) {
    let files = corpus(reader);
    for file in &files {
        read(file);
    }
    let rounds = std::env::var("MODIOLUS_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(ROUNDS) / share;
    let mut random = Random(reader.bytes().map(u64::from).sum());
    for round in 0..rounds {
        let bytes = damaged(&files, &mut random);
        let start = Instant::now();
        let read = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| read(&bytes)));
        let (took, shown) = (start.elapsed(), String::from_utf8_lossy(&bytes));
        assert!(read.is_ok(), "{reader}, round {round} panicked on:\n{shown}");
        assert!(took < LONGEST, "{reader}, round {round} took {took:?} on:\n{shown}");
    }
}

fn mesh(reader: &str, name: &str) {
    smoke(reader, 1, |bytes| {
        if let Ok(document) = parse_mesh(bytes, Path::new(name), Millimetre)
            && validate_shape(&document.mesh).is_ok()
        {
            Locator::new(&document.mesh).locate(document.mesh.points[0]);
        }
    });
}

fn surface(reader: &str) {
    smoke(reader, 1, |bytes| {
        if let Ok(surface) = parse_surface(bytes, &Path::new("a").with_extension(reader), Millimetre) {
            let _ = closed_surface(&surface, true);
        }
    });
}

#[test]
fn abaqus() {
    mesh("inp", "a.inp");
}

#[test]
fn gmsh() {
    mesh("msh", "a.msh");
}

#[test]
fn vtk_xml() {
    mesh("vtu", "a.vtu");
    surface("vtp");
}

#[test]
fn vtk_legacy() {
    mesh("vtk", "a.vtk");
}

#[test]
fn febio() {
    mesh("feb", "a.feb");
}

#[test]
fn tetgen() {
    let folder = tempfile::tempdir().unwrap();
    let files = corpus("tetgen");
    for (file, name) in files.iter().zip(["a.ele", "a.node"]) {
        std::fs::write(folder.path().join(name), file).unwrap();
    }
    for name in ["a.ele", "a.node"] {
        let path = folder.path().join(name);
        smoke("tetgen", 2, |bytes| drop(parse_mesh(bytes, &path, Millimetre)));
    }
}

#[test]
fn surfaces() {
    for reader in ["obj", "stl", "ply"] {
        surface(reader);
    }
}

#[test]
fn recordings() {
    let stated = ReadOptions { rate_hz: Some(30.), image: Some([640., 480.]), ..ReadOptions::default() };
    for (reader, share) in [("c3d", 1), ("trc", 1), ("marker_csv", 1), ("mediapipe", 5)] {
        smoke(reader, share, |bytes| {
            if let Ok(document) = parse_recording(bytes, Path::new("a"), &stated) {
                drop(document.warnings.iter().map(ToString::to_string).collect::<Vec<_>>());
                recording_csv(&document.recording);
            }
        });
    }
}

#[test]
fn targets_maps_and_plans() {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    smoke("target", 3, |bytes| drop(parse_target(&text(bytes), Path::new("a.toml"))));
    smoke("map", 4, |bytes| drop(parse_marker_map(&text(bytes), Path::new("a.toml"))));
    smoke("plan", 3, |bytes| drop(parse_plan(&text(bytes), Path::new("a.toml"))));
}

#[test]
fn faces_and_their_tables() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let [face, fibres] = &corpus("face")[..] else { panic!("a face and its fibres") };
    put("a.vtu", &corpus("vtu")[0]);
    let tables = corpus("fibres");
    let tables = tables.iter().map(|table| ("fibres.csv", table));
    for (name, whole) in [("face.toml", face)].into_iter().chain(tables) {
        put("face.toml", face);
        put("fibres.csv", fibres);
        put(name, whole);
        read_face(&folder.path().join("face.toml"), None).unwrap_or_else(|e| panic!("{e}"));
        let mut random = Random(7);
        for round in 0..ROUNDS / 5 {
            let bytes = damaged(std::slice::from_ref(whole), &mut random);
            put(name, &bytes);
            let start = Instant::now();
            let _ = read_face(&folder.path().join("face.toml"), None);
            let shown = String::from_utf8_lossy(&bytes);
            assert!(start.elapsed() < LONGEST, "round {round} took {:?} on:\n{shown}", start.elapsed());
        }
    }
}
