//! Face files with one fault each, and how it is told: file, line, field, value and remedy.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::Path;

use modiolus::face::{Face, FaceError, FaceWarning};
use modiolus::io::{
    FaceDocument, FaceFileError, FaceFileErrorKind, FaceFileWarningKind, VtuData, read_face, write_vtu,
};
use modiolus::mesh::{Cell, CellKind, Mesh};
use modiolus::units::Vec3;
use tempfile::TempDir;

/// A block of 30 x 30 x 12 mm: behind (z = 0) the mucosa, whose rim is on bone; skin in front (z = 12).
fn block() -> Mesh {
    let n = [6usize, 6, 3];
    let id = |i: usize, j: usize, k: usize| (i * (n[1] + 1) + j) * (n[2] + 1) + k;
    let mut points = Vec::new();
    for i in 0..=n[0] {
        for j in 0..=n[1] {
            for k in 0..=n[2] {
                points.push(Vec3::new(5. * i as f64 - 15., 5. * j as f64 - 15., 4. * k as f64));
            }
        }
    }
    let mut cells = Vec::new();
    for i in 0..n[0] {
        for j in 0..n[1] {
            for k in 0..n[2] {
                let corner = |c: [usize; 3]| id(i + c[0], j + c[1], k + c[2]);
                let nodes =
                    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
                cells.push(Cell::new(CellKind::Hex8, &nodes.map(corner)));
            }
        }
    }
    Mesh::new(points, cells)
}

const FACE: &str = r#"name = "block"
unit = "mm"
mesh = "mesh.vtu"
node_sets = "sets.json"
fibres = "fibres.csv"
landmarks = "landmarks.csv"
skin = "skin"
mucosa = "inner"

[tissue]
young_kpa = 15.0
poisson = 0.49

[muscle_tissue]
rest_kpa = 6.2
active_kpa = 110.0
poisson = 0.49

[[supports]]
bone = "skull"
set = "bone"

[[teeth]]
arch = "upper"
file = "teeth.obj"

[[muscles]]
name = "lifter"
max_force_n = 2.0
radius_mm = 3.0
insertion_mm = 2.0
fibres = 3
width_mm = 6.0
"#;

const FIBRES: &str = "muscle,side,fibre,point,x_mm,y_mm,z_mm
lifter,l,1,0,5,-10,1
lifter,l,1,1,6,0,4
lifter,l,1,2,5,8,10
lifter,r,1,0,-5,-10,1
lifter,r,1,1,-6,0,4
lifter,r,1,2,-5,8,10
twin,l,1,0,5,-10,1
twin,l,1,1,6,0,4
twin,l,1,2,5,8,10
dot,,1,0,1,1,6
dot,,1,1,1,1,6
afar,,1,0,0,0,6
afar,,1,1,0,0,30
";

/// A box from z = -8 to z = -2, behind the block.
const TEETH: &str = "v -9 -9 -8\nv 9 -9 -8\nv 9 9 -8\nv -9 9 -8\nv -9 -9 -2\nv 9 -9 -2\nv 9 9 -2\nv -9 9 -2
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

const LANDMARKS: &str = "landmark,node,x_mm,y_mm,z_mm\nchin,0,0,-12,12\n";

struct Files {
    /// From face coordinates, mm, to those of the files.
    place: fn(Vec3) -> Vec3,
    face: String,
    fibres: String,
    teeth: String,
    landmarks: String,
}

impl Files {
    fn new() -> Self {
        let own = str::to_owned;
        Self {
            place: |p| p,
            face: own(FACE),
            fibres: own(FIBRES),
            teeth: own(TEETH),
            landmarks: own(LANDMARKS),
        }
    }

    /// The face file with `from` replaced by `to`.
    fn with(from: &str, to: &str) -> Self {
        let mut files = Self::new();
        assert!(files.face.contains(from), "{from}");
        files.face = files.face.replacen(from, to, 1);
        files
    }

    fn error(&self) -> FaceFileError {
        match self.read() {
            Ok(document) => panic!("read with the warnings {:?}", document.warnings),
            Err(error) => error,
        }
    }

    fn read(&self) -> Result<FaceDocument, FaceFileError> {
        let folder = TempDir::new().unwrap();
        let at = |name: &str| folder.path().join(name);
        let (mesh, mut placed) = (block(), block());
        placed.points.iter_mut().for_each(|p| *p = (self.place)(*p));
        write_vtu(&at("mesh.vtu"), &placed, &VtuData::default()).unwrap();
        let layer = |z: f64| -> Vec<usize> {
            (0..mesh.n_nodes()).filter(|k| (mesh.points[*k].z - z).abs() < 1e-9).collect()
        };
        let inner = layer(0.);
        let on_rim = |k: &usize| mesh.points[*k].x.abs() > 14. || mesh.points[*k].y.abs() > 9.;
        let bone: Vec<usize> = inner.iter().copied().filter(on_rim).collect();
        let sets = [("bone", bone), ("inner", inner), ("skin", layer(12.)), ("none", Vec::new())];
        let sets = serde_json::to_string(&std::collections::BTreeMap::from(sets)).unwrap();
        std::fs::write(at("sets.json"), sets).unwrap();
        std::fs::write(at("fibres.csv"), &self.fibres).unwrap();
        std::fs::write(at("teeth.obj"), &self.teeth).unwrap();
        std::fs::write(at("landmarks.csv"), &self.landmarks).unwrap();
        std::fs::write(at("face.toml"), &self.face).unwrap();
        read_face(&at("face.toml"), None)
    }
}

/// Reads the face with `from` replaced by `to`; checks that the error is told at the line of `to`.
fn refused(from: &str, to: &str) -> FaceFileError {
    let files = Files::with(from, to);
    let error = files.error();
    if to.is_empty() {
        return error;
    }
    let line =
        files.face[..files.face.find(to).unwrap()].lines().count() + usize::from(!to.starts_with('\n'));
    let told = error.location.line.unwrap();
    let lines = line..=line + to.trim().lines().count();
    assert!(lines.contains(&told) || told + 1 == line, "told line {told}, not {line}: {error}");
    assert!(error.location.file.ends_with("face.toml"), "{error}");
    error
}

fn refused_face(from: &str, to: &str) -> FaceError {
    match refused(from, to).kind {
        FaceFileErrorKind::Face(error) => error,
        other => panic!("{other}"),
    }
}

/// The fault of the fibres that the changed face file names, which is told at `line` of their file.
fn refused_fibre(from: &str, to: &str, line: usize) -> FaceError {
    let error = Files::with(from, to).error();
    assert!(error.location.file.ends_with("fibres.csv") && error.location.line == Some(line), "{error}");
    match error.kind {
        FaceFileErrorKind::Face(error) => error,
        other => panic!("{other}"),
    }
}

fn warned(files: &Files) -> Vec<FaceWarning> {
    let document = files.read().unwrap_or_else(|e| panic!("{e}"));
    let face = |w: modiolus::io::FaceFileWarning| match w.kind {
        FaceFileWarningKind::Face(warning) => Some(warning),
        _ => None,
    };
    document.warnings.into_iter().filter_map(face).collect()
}

#[test]
fn a_sound_face_is_read_without_a_word() {
    let FaceDocument { face, warnings, files } = Files::new().read().unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let names: Vec<&str> = face.muscles.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["lifter_l", "lifter_r"]);
    assert!(face.muscles.iter().all(|m| m.fibres.len() == 3));
    let middle = &face.muscles[0].fibres[1].points;
    assert!((middle[0] - Vec3::new(5., -10., 1.)).norm() < 1e-9);
    assert!(middle.windows(2).all(|p| (p[1] - p[0]).norm() <= 1. + 1e-9));
    assert_eq!((face.mucosa.len(), face.skin.len(), face.teeth.len()), (49, 49, 1));
    assert!((face.landmark("chin").unwrap().site.position - Vec3::new(0., -12., 12.)).norm() < 1e-9);
    assert_eq!(files.len(), 6);
}

#[test]
fn other_units_and_frames_give_the_same_face() {
    // Axes forwards, to the left and up (a rotation that is not its own inverse), in cm, about another origin.
    let place = |p: Vec3| Vec3::new(10. + p.z, 20. + p.x, 30. + p.y) / 10.;
    let turn = |text: &str, from: usize, to: usize, by: &str| -> String {
        let line = |line: &str| {
            let e: Vec<&str> = line.split(by).collect();
            let Ok(x) = e[from..to].iter().map(|v| v.parse()).collect::<Result<Vec<f64>, _>>() else {
                return line.replace("_mm", "");
            };
            let q = place(Vec3::new(x[0], x[1], x[2]));
            [&e[..from], &[q.x.to_string().as_str(), &q.y.to_string(), &q.z.to_string()]].concat().join(by)
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n")
    };
    let frame = "[frame]\naxes = [\"anterior\", \"left\", \"up\"]\norigin = [1, 2, 3]\n\n[tissue]";
    let mut files = Files::with("[tissue]", frame);
    files.face = files.face.replace("unit = \"mm\"", "unit = \"cm\"");
    files.place = place;
    files.fibres = turn(FIBRES, 4, 7, ",");
    files.landmarks = turn(LANDMARKS, 2, 5, ",");
    let faces: String = TEETH.lines().filter(|l| l.starts_with('f')).map(|l| format!("\n{l}")).collect();
    let vertices: Vec<&str> = TEETH.lines().filter(|l| l.starts_with('v')).collect();
    files.teeth = turn(&vertices.join("\n"), 1, 4, " ") + &faces;
    let (turned, sound) = (files.read().unwrap().face, Files::new().read().unwrap().face);
    let near =
        |a: &[Vec3], b: &[Vec3]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).norm() < 1e-6);
    assert!(near(&turned.mesh.points, &sound.mesh.points));
    assert!(near(&turned.teeth[0].surface.points, &sound.teeth[0].surface.points));
    assert!(near(&[turned.landmarks[0].site.position], &[sound.landmarks[0].site.position]));
    for (a, b) in turned.muscles.iter().zip(&sound.muscles) {
        assert!(a.fibres.iter().zip(&b.fibres).all(|(a, b)| near(&a.points, &b.points)), "{}", a.name);
    }
}

#[test]
fn a_unit_is_required_and_known() {
    let missing = refused("unit = \"mm\"\n", "");
    assert!(
        matches!(&missing.kind, FaceFileErrorKind::MissingField { field, .. } if field == "unit"),
        "{missing}"
    );
    assert!(missing.to_string().contains("unit = \"mm\""), "{missing}");
    let unknown = refused("unit = \"mm\"", "unit = \"inch\"");
    assert!(unknown.to_string().contains("mm, cm, m"), "{unknown}");
}

#[test]
fn metres_taken_for_millimetres_are_refused() {
    let error = refused("unit = \"mm\"", "unit = \"m\"");
    assert!(matches!(error.kind, FaceFileErrorKind::Mesh(_)), "{error}");
}

#[test]
fn an_unknown_key_offers_the_nearest() {
    let error = refused("young_kpa", "yuong_kpa");
    let FaceFileErrorKind::UnknownField { nearest, .. } = &error.kind else { panic!("{error}") };
    assert_eq!(nearest.as_deref(), Some("young_kpa"));
    assert_eq!(error.location.line, Some(11));
}

#[test]
fn an_unknown_set_muscle_bone_or_arch_offers_the_nearest() {
    for (from, to, offered) in [
        ("skin = \"skin\"", "skin = \"skinn\"", "skin"),
        ("name = \"lifter\"", "name = \"liftor\"", "lifter"),
        ("bone = \"skull\"", "bone = \"skul\"", "skull"),
        ("arch = \"upper\"", "arch = \"uper\"", "upper"),
    ] {
        let error = refused(from, to);
        assert!(error.to_string().contains(&format!("did you mean `{offered}`?")), "{error}");
    }
}

#[test]
fn poisson_ratios_at_or_beyond_the_limits_are_refused() {
    for value in ["0.5", "0.51", "-1.0", "-1.2", "nan"] {
        let error = refused_face("poisson = 0.49", &format!("poisson = {value}"));
        assert!(matches!(error, FaceError::Poisson { field: "tissue.poisson", .. }), "{error}");
    }
    let error = refused_face("active_kpa = 110.0\npoisson = 0.49", "active_kpa = 110.0\npoisson = 0.5");
    assert!(matches!(error, FaceError::Poisson { field: "muscle_tissue.poisson", .. }), "{error}");
}

#[test]
fn moduli_that_are_not_positive_are_refused() {
    for value in ["0.0", "-15.0", "nan", "inf"] {
        let error = refused_face("young_kpa = 15.0", &format!("young_kpa = {value}"));
        assert!(matches!(error, FaceError::Modulus { field: "tissue.young_kpa", .. }), "{error}");
        let error = refused_face("rest_kpa = 6.2", &format!("rest_kpa = {value}"));
        assert!(matches!(error, FaceError::Modulus { field: "muscle_tissue.rest_kpa", .. }), "{error}");
    }
    let error = refused_face("active_kpa = 110.0", "active_kpa = nan");
    assert!(matches!(error, FaceError::Modulus { field: "muscle_tissue.active_kpa", .. }), "{error}");
}

#[test]
fn muscle_tissue_that_loses_its_stiffness_is_refused_with_the_activation() {
    let error = refused_face("active_kpa = 110.0", "active_kpa = -6.2");
    let FaceError::UnstableMuscle { threshold, .. } = error else { panic!("{error}") };
    assert!((threshold - 0.5).abs() < 1e-12, "6.2 - 12.4 a is zero at one half, not {threshold}");
    let error = refused_face("active_kpa = 110.0", "active_kpa = 0.0");
    assert!(matches!(error, FaceError::UnstableMuscle { threshold, .. } if threshold == 1.), "{error}");
}

#[test]
fn muscle_tissue_that_softens_is_told() {
    let warnings = warned(&Files::with("active_kpa = 110.0", "active_kpa = 5.0"));
    assert!(matches!(warnings[..], [FaceWarning::SofterWhenActive { .. }]), "{warnings:?}");
}

#[test]
fn moduli_in_pascal_are_told() {
    for (from, to) in [("young_kpa = 15.0", "young_kpa = 15000.0"), ("young_kpa = 15.0", "young_kpa = 0.015")]
    {
        let warnings = warned(&Files::with(from, to));
        assert!(matches!(warnings[..], [FaceWarning::ImplausibleModulus { .. }]), "{warnings:?}");
        assert!(warnings[0].to_string().contains("Pa or MPa"), "{}", warnings[0]);
    }
}

#[test]
fn numbers_of_a_muscle_that_make_no_sense_are_refused() {
    for (field, good, bad) in [
        ("max_force_n", "2.0", &["0.0", "-1.0", "nan", "inf", "2e5"][..]),
        ("radius_mm", "3.0", &["0.0", "-3.0", "nan"]),
        ("insertion_mm", "2.0", &["-1.0", "nan"]),
    ] {
        for value in bad {
            let error = refused_face(&format!("{field} = {good}"), &format!("{field} = {value}"));
            assert!(matches!(error, FaceError::MuscleNumber { field: f, .. } if f == field), "{error}");
        }
    }
    for (from, to) in [("fibres = 3", "fibres = 0"), ("width_mm = 6.0", "width_mm = -6.0")] {
        assert!(matches!(refused(from, to).kind, FaceFileErrorKind::Value { .. }));
    }
}

#[test]
fn a_fibre_without_length_is_refused() {
    let error = refused_fibre("name = \"lifter\"", "name = \"dot\"\nsides = []", 11);
    assert!(matches!(error, FaceError::ZeroLength { fibre: 1, .. }), "{error}");
}

#[test]
fn a_path_outside_the_mesh_is_moved_when_near_and_refused_when_far() {
    let error = refused_fibre("name = \"lifter\"", "name = \"afar\"\nsides = []", 14);
    let FaceError::OutsideMesh { distance_mm, at, .. } = &error else { panic!("{error}") };
    assert!((distance_mm - 18.).abs() < 1e-9 && at[2] == 30., "{error}");
    assert!(error.to_string().contains("max_projection_mm"), "{error}");
    let mut files = Files::new();
    files.fibres = FIBRES.replace("lifter,l,1,2,5,8,10", "lifter,l,1,2,5,8,14");
    let warnings = warned(&files);
    let [FaceWarning::Projected { muscle, outside, largest_mm, .. }] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    assert!(muscle == "lifter_l" && *outside > 0 && (largest_mm - 2.).abs() < 0.1, "{warnings:?}");
}

#[test]
fn a_flipped_fibre_is_told_and_turned_on_request() {
    let flipped = Files::with("insertion_mm = 2.0", "insertion_mm = 2.0\norigin = \"last\"");
    let warnings = warned(&flipped);
    let [FaceWarning::FlippedFibres { fibres: 6, muscle }] = &warnings[..] else { panic!("{warnings:?}") };
    assert_eq!(muscle, "lifter_l and lifter_r");
    let first = flipped.read().unwrap().face.muscles[0].fibres[1].points[0];
    assert!((first - Vec3::new(5., 8., 10.)).norm() < 1e-9, "{first}");
    let error = refused("insertion_mm = 2.0", "insertion_mm = 2.0\norigin = [\"first\", \"last\"]");
    assert!(matches!(error.kind, FaceFileErrorKind::Value { .. }), "one polyline a side: {error}");
}

#[test]
fn a_muscle_that_reaches_no_element_is_refused_with_the_radius_that_would() {
    let error = refused_face("radius_mm = 3.0\n", "radius_mm = 0.0001\n");
    let FaceError::NoTissue { needed_mm, .. } = error else { panic!("{error}") };
    assert!(needed_mm > 0.0001 && needed_mm < 3., "{needed_mm}");
    let radius = format!("radius_mm = {}\n", needed_mm * (1. + 1e-9));
    assert!(Files::with("radius_mm = 3.0\n", &radius).read().is_ok() || needed_mm < 0.5);
}

#[test]
fn a_muscle_that_is_all_insertion_is_told() {
    let warnings = warned(&Files::with("insertion_mm = 2.0", "insertion_mm = 30.0"));
    assert!(matches!(warnings[0], FaceWarning::AllInsertion { .. }), "{warnings:?}");
}

#[test]
fn nodes_on_two_bones_are_told() {
    let jaw = "[[supports]]\nbone = \"mandible\"\nset = \"bone\"\n\n[[teeth]]";
    let warnings = warned(&Files::with("[[teeth]]", jaw));
    let [warning @ FaceWarning::TwoBones { first, second, support, node, nodes }] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    assert_eq!((first.as_str(), second.as_str(), *support), ("skull", "mandible", 1));
    assert_eq!((*node, *nodes), (0, 34));
    assert!(warning.to_string().contains("go where mandible goes"), "{warning}");
}

#[test]
fn muscles_of_one_name_are_refused_and_of_the_same_fibres_told() {
    let muscle = |name: &str| {
        format!(
            "[[muscles]]\nname = \"{name}\"\nsides = [\"l\"]\nmax_force_n = 1.0\nradius_mm = 3.0\nfibres = 3\n\
             width_mm = 6.0\n\n[[muscles]]\nname = \"lifter\""
        )
    };
    let error = refused_face("[[muscles]]\nname = \"lifter\"", &muscle("lifter"));
    assert!(matches!(&error, FaceError::DuplicateName { muscle } if muscle == "lifter_l"), "{error}");
    let warnings = warned(&Files::with("[[muscles]]\nname = \"lifter\"", &muscle("twin")));
    let [FaceWarning::SameFibres { first, second }] = &warnings[..] else { panic!("{warnings:?}") };
    assert_eq!((first.as_str(), second.as_str()), ("twin_l", "lifter_l"));
}

#[test]
fn a_radius_or_an_area_is_required() {
    let missing = refused("radius_mm = 3.0\n", "");
    assert!(matches!(missing.kind, FaceFileErrorKind::MissingField { .. }), "{missing}");
    let both = Files::with("radius_mm = 3.0", "radius_mm = 3.0\narea_mm2 = 20.0").read().unwrap().face;
    assert_eq!((both.muscles[0].radius_mm, both.muscles[0].area_mm2), (3.0, Some(20.0)));
    let none = refused("radius_mm = 3.0", "radius_mm = 3.0\narea_mm2 = -20.0");
    assert!(none.to_string().contains("positive"), "{none}");
    let area = Files::with("radius_mm = 3.0", "area_mm2 = 85.0").read().unwrap().face;
    let expect = (85. / (3. * std::f64::consts::PI)).sqrt();
    assert!((area.muscles[0].radius_mm - expect).abs() < 1e-12);
}

#[test]
fn a_face_without_support_is_refused() {
    let error = refused("set = \"bone\"", "set = \"none\"");
    assert!(error.to_string().contains("not empty"), "{error}");
}

#[test]
fn a_ring_with_a_gap_is_refused() {
    let mut files = Files::with("insertion_mm = 2.0", "ring = true");
    files.fibres = FIBRES.replace("r,1,0,-5,", "r,1,0,-9,");
    let error = files.error();
    assert!(matches!(error.kind, FaceFileErrorKind::OpenRing { gap_mm, .. } if gap_mm > 10.), "{error}");
}

#[test]
fn an_open_tooth_surface_is_refused_unless_it_is_to_be_capped() {
    let mut files = Files::new();
    files.teeth = TEETH.replace("f 5 6 7 8\n", "");
    let error = files.error();
    assert!(
        error.to_string().contains("open, 1 hole:") && error.to_string().contains("cap_holes"),
        "{error}"
    );
    assert_eq!(error.location.field.as_deref(), Some("teeth[0].file"));
    files.face = files.face.replace("file = \"teeth.obj\"", "file = \"teeth.obj\"\ncap_holes = true");
    let document = files.read().unwrap();
    assert!(matches!(document.warnings[0].kind, FaceFileWarningKind::Teeth(_)), "{:?}", document.warnings);
}

#[test]
fn tissue_inside_the_teeth_at_rest_is_told_with_its_depth() {
    let mut files = Files::new();
    files.teeth = TEETH.replace("-2\n", "0.5\n");
    let warnings = warned(&files);
    let [FaceWarning::RestOverlap(overlap)] = &warnings[..] else { panic!("{warnings:?}") };
    assert_eq!((overlap.nodes, overlap.inside), (49, 9));
    assert!((overlap.deepest_mm - 0.5).abs() < 1e-9, "{overlap:?}");
}

#[test]
fn faults_of_the_tables_are_told_with_their_line() {
    let cases = [
        ("lifter,l,1,1,6,0,4", "lifter,l,1,1,6,0", 3, "6 entries"),
        ("lifter,l,1,1,6,0,4", "lifter,l,1,1,6,0,nan", 3, "finite"),
        ("lifter,l,1,1,6,0,4", "lifter,l,1,2,6,0,4", 3, "in their order"),
        ("muscle,side", "muscles,side", 1, "did you mean `muscles`?"),
    ];
    for (from, to, line, text) in cases {
        let mut files = Files::new();
        files.fibres = FIBRES.replacen(from, to, 1);
        let error = files.error();
        assert_eq!(error.location.line, Some(line), "{error}");
        assert!(error.location.file.ends_with("fibres.csv") && error.to_string().contains(text), "{error}");
    }
}

#[test]
fn a_landmark_far_from_the_skin_or_twice_is_refused() {
    let mut files = Files::new();
    files.landmarks = LANDMARKS.replace("-12,12", "-12,19");
    let error = files.error();
    assert!(
        matches!(error.kind, FaceFileErrorKind::FarLandmark { distance_mm, .. } if distance_mm == 7.),
        "{error}"
    );
    files.landmarks = LANDMARKS.replace("-12,12", "-12,14");
    let warnings = files.read().unwrap().warnings;
    assert!(matches!(warnings[0].kind, FaceFileWarningKind::MovedLandmark { .. }), "{warnings:?}");
    let twice = refused("[tissue]", "[[points]]\nname = \"chin\"\nat_mm = [0, 0, 12]\n\n[tissue]");
    assert!(matches!(twice.kind, FaceFileErrorKind::Duplicate { .. }), "{twice}");
    assert!(twice.to_string().contains("points[0].name"), "{twice}");
    let nameless = refused("[tissue]", "[[points]]\nname = \" \"\nat_mm = [0, 0, 12]\n\n[tissue]");
    assert!(nameless.to_string().contains("points[0].name"), "{nameless}");
    assert!(nameless.to_string().contains("a name, by which targets call the point"), "{nameless}");
}

#[test]
fn selections_choose_by_place_and_direction() {
    let select = "[[select]]\nname = \"front\"\nwithin_mm = [[-15, -15, 0], [0, 15, 12]]\nfacing = [0, 0, 1]\n\n[tissue]";
    let files = Files {
        face: FACE.replace("[tissue]", select).replace("mucosa = \"inner\"", "mucosa = \"front\""),
        ..Files::new()
    };
    let face = files.read().unwrap().face;
    let faces_forward = |k: &usize| face.mesh.points[*k].z == 12. && face.mesh.points[*k].x <= 0.;
    assert_eq!(face.mucosa, (0..face.mesh.n_nodes()).filter(faces_forward).collect::<Vec<_>>());
    let error =
        refused("[tissue]", &select.replace("[[-15, -15, 0], [0, 15, 12]]", "[[0, 0, 0], [-1, 1, 1]]"));
    assert!(matches!(error.kind, FaceFileErrorKind::Value { .. }), "{error}");
    let error = refused("[tissue]", &select.replace("\"front\"", "\"skin\""));
    assert!(matches!(error.kind, FaceFileErrorKind::Duplicate { .. }), "{error}");
}

#[test]
fn a_left_handed_or_unknown_frame_is_refused() {
    let frame = |axes: &str| format!("[frame]\naxes = {axes}\n\n[tissue]");
    let error = refused("[tissue]", &frame(r#"["right", "up", "anterior"]"#));
    assert!(error.to_string().contains("right-handed"), "{error}");
    let error = refused("[tissue]", &frame(r#"["left", "upp", "anterior"]"#));
    assert!(error.to_string().contains("did you mean `up`?"), "{error}");
}

#[test]
fn a_file_that_is_missing_or_not_toml_is_refused() {
    let error = read_face(Path::new("no/such/face.toml"), None).unwrap_err();
    assert!(matches!(error.kind, FaceFileErrorKind::Unreadable(_)), "{error}");
    let error = refused("young_kpa = 15.0", "young_kpa = 15,0");
    assert!(matches!(error.kind, FaceFileErrorKind::Syntax { .. }), "{error}");
    let error = refused("mesh = \"mesh.vtu\"", "mesh = \"mush.vtu\"");
    assert!(matches!(error.kind, FaceFileErrorKind::Mesh(_)), "{error}");
}

const JAW: &str = "[jaw]\nbone = \"skull\"\ncondyles_mm = [[50, 30, -80], [-50, 30, -80]]\nincisor_mm = [0, 0, -4]\n\n[[teeth]]";

#[test]
fn a_jaw_that_cannot_turn_is_refused_by_its_field() {
    let jaw = Files::with("[[teeth]]", JAW).read().unwrap().face.jaw.unwrap();
    assert_eq!((jaw.condyles[0].x, jaw.incisor.z), (50., -4.));
    for (from, to, told) in [
        ("bone = \"skull\"\nc", "bone = \"mandible\"\nc", "no bone is called `mandible`; the face has skull"),
        ("[[50,", "[[-60,", "give the left one first"),
        ("[[50,", "[[nan,", "not finite"),
        ("[0, 0, -4]", "[0, 30, -79]", "10 to 250 mm away"),
        ("incisor_mm", "incisal_mm", "did you mean `incisor_mm`"),
    ] {
        assert!(JAW.contains(from), "{from}");
        let error = refused("[[teeth]]", &JAW.replacen(from, to, 1));
        assert!(error.to_string().contains(told), "{error}");
    }
}

#[test]
fn what_is_in_another_unit_or_elsewhere_is_refused_where_it_is_named() {
    let scaled = |text: &str, factor: f64, tag: &str| -> String {
        let number = |word: &str| word.parse::<f64>().map_or(word.to_owned(), |x| (x * factor).to_string());
        let line = |line: &str| match line.strip_prefix(tag) {
            Some(rest) => format!("{tag}{}", rest.split(' ').map(number).collect::<Vec<_>>().join(" ")),
            None => line.to_owned(),
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n")
    };
    for (factor, told) in [
        (1e-3, "the tooth surface measures 0.018 mm across where the mesh measures 30 mm: metres?"),
        (1e-2, "centimetres?"),
        (1e3, "micrometres?"),
        (1e160, "the tooth surface measures"),
    ] {
        let error = Files { teeth: scaled(TEETH, factor, "v "), ..Files::new() }.error();
        assert!(error.to_string().contains(told) && error.location.line.is_some(), "{error}");
    }
    let far = TEETH.replace("-8\n", "392\n").replace("-2\n", "398\n");
    let error = Files { teeth: far, ..Files::new() }.error();
    assert!(error.to_string().contains("lies 380 mm away from the mesh"), "{error}");
    let columns = |text: &str, from: usize, factor: f64| -> String {
        let line = |line: &str| {
            let cells = line.split(',').enumerate();
            let cell = |(k, word): (usize, &str)| match word.parse::<f64>() {
                Ok(x) if k >= from => (x * factor).to_string(),
                _ => word.to_owned(),
            };
            cells.map(cell).collect::<Vec<_>>().join(",")
        };
        text.lines().map(line).collect::<Vec<_>>().join("\n")
    };
    let error = Files { fibres: columns(FIBRES, 4, 1e-3), ..Files::new() }.error();
    assert!(error.to_string().contains("all fibres") && error.to_string().contains("metres?"), "{error}");
    let far = FIBRES.replacen("lifter,l,1,1,6,0,4", "lifter,l,1,1,6,1e12,4", 1);
    let error = Files { fibres: far, ..Files::new() }.error();
    assert_eq!(error.location.line, Some(3), "{error}");
    let points = "[[points]]\nname = \"a\"\nat_mm = [0.001, 0, 0.012]\n\n\
                  [[points]]\nname = \"b\"\nat_mm = [0.01, 0, 0.012]\n\n\
                  [[points]]\nname = \"c\"\nat_mm = [-0.01, 0, 0.012]\n\n[tissue]";
    let error = refused("[tissue]", points);
    assert!(error.to_string().contains("points") && error.to_string().contains("metres?"), "{error}");
    let select = "[[select]]\nname = \"s\"\nwithin_mm = [[0, 0, 0], [0.01, 0.01, 0.01]]\n\n[tissue]";
    assert!(refused("[tissue]", select).to_string().contains("metres?"));
    for (from, to, told) in [
        (
            "[[50, 30, -80], [-50, 30, -80]]\nincisor_mm = [0, 0, -4]",
            "[[0.05, 0.03, -0.08], [-0.05, 0.03, -0.08]]\nincisor_mm = [0, 0, -0.004]",
            "metres?",
        ),
        (
            "[[50, 30, -80], [-50, 30, -80]]",
            "[[50, 30, 60], [-50, 30, 60]]",
            "in front of the lower incisal point",
        ),
        ("[0, 0, -4]", "[0, -90, 30]", "away from the mesh"),
        ("[[50, 30, -80]", "[[5000, 30, -80]", "10 to 250 mm to the left"),
    ] {
        assert!(JAW.contains(from), "{from}");
        let error = refused("[[teeth]]", &JAW.replacen(from, to, 1));
        assert!(error.to_string().contains(told), "{error}");
        assert_eq!(error.to_string().matches("jaw.").count(), 1, "said once: {error}");
    }
}

#[test]
fn a_node_of_no_cell_in_a_set_is_refused() {
    let mut face = Files::new().read().unwrap().face;
    let orphan = face.mesh.n_nodes();
    face.mesh.points.push(Vec3::new(1e160, 0., 0.));
    face.mesh.node_ids.push(7);
    assert!(face.check().0.is_empty(), "without effect");
    let sets: [fn(&mut Face) -> &mut Vec<usize>; 4] =
        [|f| &mut f.skin, |f| &mut f.mucosa, |f| &mut f.upper_lip, |f| &mut f.supports[0].nodes];
    for set in sets {
        let mut face = face.clone();
        set(&mut face).push(orphan);
        let errors = face.check().0;
        assert!(matches!(&errors[..], [FaceError::OrphanNode { node: 7, .. }]), "{errors:?}");
    }
}

#[test]
fn an_arch_that_nothing_can_touch_is_told() {
    let beside = TEETH.replace("-8\n", "-28\n").replace("-2\n", "-22\n");
    for files in [Files { teeth: beside, ..Files::new() }, Files::with("mucosa = \"inner\"\n", "")] {
        let warnings = warned(&files);
        assert!(matches!(warnings[..], [FaceWarning::NoContact { arch: "upper", .. }]), "{warnings:?}");
    }
}

#[test]
fn bones_of_teeth_and_pieces_are_known() {
    let error = refused("arch = \"upper\"", "arch = \"upper\"\nbone = \"scull\"");
    assert!(error.to_string().contains("did you mean `skull`?"), "{error}");
    let error = refused("bone = \"skull\"", "bone = \"lefort\"\npart_of = \"maxila\"");
    assert!(error.to_string().contains("did you mean `maxilla`?"), "{error}");
    let error = refused("bone = \"skull\"", "bone = \"skull\"\npart_of = \"maxilla\"");
    assert!(error.to_string().contains("a name of its own"), "{error}");
    let piece =
        Files::with("bone = \"skull\"", "bone = \"lefort\"\npart_of = \"maxilla\"").read().unwrap().face;
    assert_eq!((piece.whole_of("lefort"), piece.teeth[0].bone.as_str()), (Some("maxilla"), "maxilla"));
}

#[test]
fn tables_of_spreadsheets_are_the_same_tables() {
    let plain = Files::new().read().unwrap().face;
    let semicolons = |text: &str| text.replace(',', ";");
    let commas =
        FIBRES.lines().map(|line| line.replace(',', ";").replace(";6;0;4", ";6,0;0,0;4,0") + "\n").collect();
    let quotes = |text: &str| {
        let quoted = |line: &str| line.split(',').map(|e| format!("\"{e}\"")).collect::<Vec<_>>().join(",");
        text.lines().map(quoted).collect::<Vec<_>>().join("\r\n")
    };
    for (what, fibres, landmarks) in [
        ("semicolons", semicolons(FIBRES), semicolons(LANDMARKS)),
        ("decimal commas", commas, semicolons(LANDMARKS).replace("-12;12", "-12,0;12,00")),
        ("quotes", quotes(FIBRES), quotes(LANDMARKS)),
        ("tabs", FIBRES.replace(',', "\t"), LANDMARKS.replace(',', " \t ")),
    ] {
        let face =
            Files { fibres, landmarks, ..Files::new() }.read().unwrap_or_else(|e| panic!("{what}: {e}")).face;
        assert_eq!(
            (face.muscles, face.landmarks),
            (plain.muscles.clone(), plain.landmarks.clone()),
            "{what}"
        );
    }
    let error = Files { fibres: FIBRES.replace("lifter,r,1,2", "\"lifter,r,1,2"), ..Files::new() }.error();
    assert!(error.to_string().contains("fibres.csv:7: a quote that begins here is not closed"), "{error}");
}

#[test]
fn names_of_any_signs_survive_an_export() {
    for name in
        ["li\"f,t;er", "\\back\\slash", "two\nlines", " blanks ", "tab\t", "a'b", "<&>", "#5", "muskel_ö"]
    {
        let quoted = format!("\"{}\"", name.replace('"', "\"\""));
        let toml = format!("{name:?}").replace("\\'", "'");
        let mut files = Files::with("name = \"lifter\"", &format!("name = {toml}"));
        files.fibres = FIBRES.replace("lifter", &quoted);
        files.landmarks = LANDMARKS.replace("chin", &quoted);
        files.face = files.face.replace("bone = \"skull\"", &format!("bone = {toml}\npart_of = \"skull\""));
        files.face = files.face.replace("arch = \"upper\"", &format!("arch = \"upper\"\nbone = {toml}"));
        let face = files.read().unwrap_or_else(|e| panic!("{name:?}: {e}")).face;
        assert_eq!(face.muscles[0].name, format!("{name}_l"));
        let folder = TempDir::new().unwrap();
        modiolus::io::write_face(folder.path(), &face).unwrap();
        let back = read_face(&folder.path().join("face.toml"), None);
        let back = back.unwrap_or_else(|e| panic!("{name:?}: {e}")).face;
        let names = |face: &Face| {
            let muscles = face.muscles.iter().map(|m| m.name.clone());
            let landmarks = face.landmarks.iter().map(|l| l.name.clone());
            muscles.chain(landmarks).chain(face.supports.iter().map(|s| s.bone.clone())).collect::<Vec<_>>()
        };
        assert_eq!(names(&back), names(&face), "{name:?}");
        assert_eq!(back.supports, face.supports, "{name:?}");
    }
}

#[test]
fn what_one_wrong_digit_asks_for_is_refused_at_once() {
    let start = std::time::Instant::now();
    let step = refused("skin = \"skin\"", "skin = \"skin\"\nfibre_step_mm = 1e-9");
    assert!(
        step.to_string().contains("fibre_step_mm: `0.000000001` is not accepted; give 0.01 mm or more"),
        "{step}"
    );
    let width = refused("width_mm = 6.0", "width_mm = 1e9");
    assert!(width.to_string().contains("a width in mm that the mesh, of 44 mm, can hold"), "{width}");
    let mut files = Files::new();
    files.fibres = FIBRES.replace("lifter,l,1,1,6,0,4", "lifter,l,1,1,1e12,0,4");
    let far = files.error();
    assert!(far.to_string().contains("lifter") || far.location.line == Some(3), "{far}");
    files.face = files.face.replace("name = \"lifter\"", "name = \"lifter\"\nsides = [\"l\"]");
    files.fibres = "muscle,side,fibre,point,x,y,z\n".to_owned();
    for k in 0..5_000 {
        files.fibres += &format!("lifter,l,1,{k},{},{},6\n", 10 * (k % 2), k % 7);
    }
    assert!(
        matches!(files.error().kind, FaceFileErrorKind::FibrePoints { most: 10_000, .. }),
        "{}",
        files.error()
    );
    let many = "[[muscles]]\nname = \"a\"\nmax_force_n = 1.0\n".repeat(1001);
    let many = Files { face: format!("{FACE}{many}"), ..Files::new() }.error();
    assert!(
        many.to_string().contains("`1002` is not accepted; give at most 1000 tables `[[muscles]]`"),
        "{many}"
    );
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn a_table_of_many_rows_takes_time_in_proportion() {
    let points: String =
        (0..40_000).map(|k| format!("[[points]]\nname = \"p{k}\"\nat_mm = [0, 0, 12]\n")).collect();
    let start = std::time::Instant::now();
    let face = Files { face: format!("{FACE}{points}"), ..Files::new() }.read().unwrap().face;
    assert_eq!(face.landmarks.len(), 40_001);
    // Each looked for in all the text before it, they took minutes.
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn sets_are_told_by_what_the_mesh_file_has() {
    let error = refused("skin = \"skin\"", "skin = \"pressure\"");
    assert!(error.to_string().contains("known are: bone, inner, none, skin"), "{error}");
    let case = Files::with("skin = \"skin\"", "skin = \"SKIN\"").read().unwrap().face;
    assert_eq!(case.skin.len(), 49);
    let mut files = Files::with("node_sets = \"sets.json\"\n", "");
    let none = files.error();
    assert!(
        none.to_string().contains("the mesh has none: mark nodes in the mesh file, or select them"),
        "{none}"
    );
    files.face = files.face.replace("mesh.vtu", "fields.vtu");
    let folder = TempDir::new().unwrap();
    let pressure = (0..block().n_nodes()).map(|k| k as f64 + 0.5).collect();
    let data = VtuData { point_scalars: [("pressure".into(), pressure)].into(), ..VtuData::default() };
    write_vtu(&folder.path().join("fields.vtu"), &block(), &data).unwrap();
    std::fs::write(folder.path().join("face.toml"), &files.face).unwrap();
    let error = read_face(&folder.path().join("face.toml"), None).unwrap_err().to_string();
    assert!(
        error.contains("in the mesh file, but no sets: pressure (its values are not all whole numbers)"),
        "{error}"
    );
    std::fs::write(
        folder.path().join("face.toml"),
        files.face.replace("skin = \"skin\"", "skin = \"pressure\""),
    )
    .unwrap();
    let error = read_face(&folder.path().join("face.toml"), None).unwrap_err().to_string();
    assert!(
        error.contains("`pressure`: the mesh file has it, but its values are not all whole numbers"),
        "{error}"
    );
}
