//! What every fuzz target does with its bytes: reads them, and looks at what was read as the program would.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use modiolus::contact::closed_surface;
use modiolus::io::{
    ReadOptions, parse_marker_map, parse_mesh, parse_plan, parse_recording, parse_surface, parse_target, read_face,
    recording_csv,
};
use modiolus::mesh::{Locator, validate_shape};
use modiolus::units::LengthUnit::Millimetre;

/// A volume mesh in a file called `name`.
pub fn mesh(name: &str, bytes: &[u8]) {
    if let Ok(document) = parse_mesh(bytes, Path::new(name), Millimetre)
        && validate_shape(&document.mesh).is_ok()
    {
        let _ = Locator::new(&document.mesh).locate(document.mesh.points[0]);
    }
}

/// A tooth surface in a file called `name`.
pub fn surface(name: &str, bytes: &[u8]) {
    if let Ok(surface) = parse_surface(bytes, Path::new(name), Millimetre) {
        let _ = closed_surface(&surface, true);
    }
}

/// A recording of markers in a file called `name`; what is read is written and read again.
pub fn recording(name: &str, bytes: &[u8]) {
    let neutral = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/marker_csv/long.csv");
    let size = ReadOptions { rate_hz: Some(30.), image: Some([640., 480.]), ..ReadOptions::default() };
    for options in [ReadOptions::default(), size, ReadOptions { neutral: Some(&neutral), ..ReadOptions::default() }] {
        if let Ok(document) = parse_recording(bytes, Path::new(name), &options) {
            for warning in &document.warnings {
                let _ = warning.to_string();
            }
            let text = recording_csv(&document.recording);
            let _ = parse_recording(text.as_bytes(), Path::new("b.csv"), &ReadOptions::default());
        }
    }
}

/// The face file or the fibres of a cube, as `name`, beside the others of the corpus.
pub fn face(name: &str, bytes: &[u8]) {
    let others =
        [("a.vtu", "vtu/ascii.vtu"), ("face.toml", "face/face.toml"), ("fibres.csv", "face/fibres.csv")];
    let _ = read_face(&beside(name, bytes, &others).join("face.toml"), None);
}

/// The nodes or the elements of a TetGen mesh, as `name`, beside the other of the corpus.
pub fn tetgen(name: &str, bytes: &[u8]) {
    let others = [("a.node", "tetgen/a.node"), ("a.ele", "tetgen/a.ele")];
    let folder = beside(name, bytes, &others);
    if let Ok(document) = parse_mesh(bytes, &folder.join(name), Millimetre) {
        let _ = validate_shape(&document.mesh);
    }
}

/// A folder of this process with `bytes` as `name` and the `others`, each with its place in the corpus.
fn beside(name: &str, bytes: &[u8], others: &[(&str, &str)]) -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("modiolus-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    });
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for (own, from) in others.iter().filter(|(own, _)| *own != name) {
        std::fs::copy(corpus.join(from), folder.join(own)).expect("the corpus");
    }
    std::fs::write(folder.join(name), bytes).expect("a file");
    folder
}

/// A target.
pub fn target(bytes: &[u8]) {
    let _ = parse_target(&String::from_utf8_lossy(bytes), Path::new("a.toml"));
}

/// A marker map.
pub fn map(bytes: &[u8]) {
    let _ = parse_marker_map(&String::from_utf8_lossy(bytes), Path::new("a.toml"));
}

/// A surgical plan.
pub fn plan(bytes: &[u8]) {
    let _ = parse_plan(&String::from_utf8_lossy(bytes), Path::new("a.toml"));
}
