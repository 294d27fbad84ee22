//! What each muscle of the standard face does, against its anatomical action; `docs/actions.md` is written
//! from the same figures.
//!
//! Half activation, the stiffness that of the activations, contact with the teeth and between the lips. After a change of the face, `MODIOLUS_BLESS=1 cargo test --release --test forward muscle_function` writes
//! the table anew.

use std::fmt::Write;
use std::path::PathBuf;
use std::sync::LazyLock;

use modiolus::contact::{Pair, PairKind};
use modiolus::face::standard::{Parameters, Resolution, parametric, standard};
use modiolus::face::{ContactReach, Face, Muscle};
use modiolus::forward::{Model, contact_forces};
use modiolus::inverse::{ActivatedProblem, Bound, ContactMode, MarkerFit, Observations, Solution, Status};
use modiolus::io::read_target;
use modiolus::mesh::Site;
use modiolus::units::Vec3;
use nalgebra::DVector;

/// Activation at which actions are looked at.
const HALF: f64 = 0.5;
/// Farthest from the anatomical action, degrees.
const FARTHEST_DEG: f64 = 45.0;
/// The other side moves at most this share.
const OTHER_SIDE: f64 = 1.0 / 3.0;

struct Action {
    /// A paired muscle's left side, or a ring.
    muscle: &'static str,
    unit: &'static str,
    landmark: &'static str,
    /// Anatomical direction of the left landmark's movement, of any length.
    direction: [f64; 3],
    meaning: &'static str,
}

const fn action(
    muscle: &'static str,
    unit: &'static str,
    landmark: &'static str,
    direction: [f64; 3],
    meaning: &'static str,
) -> Action {
    Action { muscle, unit, landmark, direction, meaning }
}

/// Directions are displacements of a scan's full-strength expressions where one of them is the muscle's
/// own action, and else run from insertion to origin on the public face model or, where it lacks the
/// muscle, between its bones.
const ACTIONS: [Action; 15] = [
    action(
        "zygomaticus_major",
        "12",
        "cheilion",
        [7.1, 10.5, -9.1],
        "draws the corner up and out (scan, smile)",
    ),
    action(
        "zygomaticus_minor",
        "11",
        "upper_lip_lateral",
        [18.0, 30.0, -16.0],
        "lifts the lateral upper lip",
    ),
    action("levator_labii_superioris", "10", "upper_lip_lateral", [8.0, 30.0, -13.0], "lifts the upper lip"),
    action(
        "levator_labii_superioris_alaeque_nasi",
        "9",
        "alar_base",
        [-2.0, 34.0, -10.0],
        "lifts the wing of the nose",
    ),
    action("levator_anguli_oris", "13", "cheilion", [-2.0, 32.0, -7.0], "lifts the corner"),
    action("risorius", "20", "cheilion", [6.6, -3.1, -7.0], "stretches the mouth (scan, stretch)"),
    action("buccinator", "14", "cheilion", [18.5, 9.5, -29.0], "draws the corner back along the teeth"),
    action("depressor_anguli_oris", "15", "cheilion", [-3.5, -25.5, -2.5], "lowers the corner"),
    action(
        "depressor_labii_inferioris",
        "16",
        "lower_lip_lateral",
        [0.0, -3.3, -1.0],
        "lowers the lower lip (scan, lower lip down)",
    ),
    action("mentalis", "17", "chin", [1.0, 13.0, -7.0], "lifts the skin of the chin"),
    action(
        "orbicularis_oris_peripheralis",
        "22, 23, 24, 28",
        "cheilion",
        [-4.6, 2.2, 9.8],
        "purses: the corners come together and forward (scan, pucker)",
    ),
    action(
        "orbicularis_oris_marginalis",
        "23, 24, 28",
        "cheilion",
        [-4.6, 2.2, 9.8],
        "purses: the corners come together and forward (scan, pucker)",
    ),
    action("incisivus_superior", "18", "cheilion", [-16.0, 14.0, 6.0], "draws the corner in and up"),
    action("incisivus_inferior", "18", "cheilion", [-16.0, -14.0, 4.0], "draws the corner in and down"),
    action("platysma", "21", "cheilion", [15.0, -26.0, -23.0], "draws the corner down and out"),
];

/// The standard face, its stiffness that of its activations, seen at its landmarks.
struct Bench {
    face: Face,
    model: Model,
    sites: Vec<Site>,
}

static BENCH: LazyLock<Bench> = LazyLock::new(|| {
    let face = standard(&Resolution::STANDARD);
    let model = Model::new(&face, face.contact_pairs(ContactReach::default())).expect("a model");
    let sites = face.landmarks.iter().map(|l| l.site.clone()).collect();
    Bench { face, model, sites }
});

impl Bench {
    /// Movement (mm) of every landmark under the muscles whose names start with one of `stems` at half
    /// activation, with the contacts that `keep` keeps.
    fn moved(&self, stems: &[&str], keep: impl Fn(PairKind) -> bool) -> DVector<f64> {
        let on = |name: &String| stems.iter().any(|stem| name.starts_with(stem));
        let muscles = self.model.muscles();
        let a: Vec<f64> = muscles.iter().map(|name| if on(name) { HALF } else { 0.0 }).collect();
        assert!(a.iter().any(|a| *a > 0.0), "no muscle {stems:?}");
        let kept: Vec<Pair> = self.model.pairs().iter().filter(|p| keep(p.kind)).cloned().collect();
        let response = self.model.at(&a).expect("a factor").response_with(&self.sites, &kept);
        let a = DVector::from_vec(a);
        let mut moved = &response.map * &a;
        if let Some(contact) = &response.contact {
            moved += &contact.reach * contact_forces(contact, &a).expect("contact forces");
        }
        moved
    }

    fn of(&self, moved: &DVector<f64>, landmark: &str) -> Vec3 {
        let k = self.face.landmarks.iter().position(|l| l.name == landmark);
        let k = k.unwrap_or_else(|| panic!("no landmark {landmark}"));
        Vec3::new(moved[3 * k], moved[3 * k + 1], moved[3 * k + 2])
    }

    /// Change of the distance between two landmarks along `axis`, mm.
    fn grown(&self, moved: &DVector<f64>, from: &str, to: &str, axis: usize) -> f64 {
        (self.of(moved, to) - self.of(moved, from))[axis]
    }

    fn width(&self, moved: &DVector<f64>) -> f64 {
        self.grown(moved, "cheilion_r", "cheilion_l", 0)
    }

    fn aperture(&self, moved: &DVector<f64>) -> f64 {
        self.grown(moved, "stomion_inferius", "stomion_superius", 1)
    }
}

/// What one muscle does: movement of its landmark, angle to its action, share of the other side.
struct Found {
    movement: Vec3,
    angle_deg: f64,
    other: Option<f64>,
}

fn found(action: &Action) -> Found {
    let ring = BENCH.face.muscle_index(action.muscle).is_some();
    let name = if ring { action.muscle.to_owned() } else { format!("{}_l", action.muscle) };
    let moved = BENCH.moved(&[name.as_str()], |_| true);
    let movement = BENCH.of(&moved, &format!("{}_l", action.landmark));
    let other = BENCH.of(&moved, &format!("{}_r", action.landmark));
    Found {
        movement,
        angle_deg: movement.angle(&Vec3::from(action.direction)).to_degrees(),
        other: (!ring).then(|| other.norm() / movement.norm()),
    }
}

#[test]
fn every_muscle_moves_its_landmark_the_anatomical_way_and_on_its_own_side() {
    for action in &ACTIONS {
        let Found { movement, angle_deg, other } = found(action);
        println!("{:40} {:6.2?} {angle_deg:4.0} deg {other:.2?}", action.muscle, movement.as_slice());
        assert!(movement.norm() > 0.3, "{}: {movement:.2?} mm", action.muscle);
        assert!(angle_deg <= FARTHEST_DEG, "{}: {angle_deg:.0} deg, {movement:.2?}", action.muscle);
        assert!(other.is_none_or(|o| o < OTHER_SIDE), "{}: other side {other:.2?}", action.muscle);
    }
}

#[test]
fn every_muscle_has_an_action() {
    for muscle in &BENCH.face.muscles {
        let stem = muscle.name.trim_end_matches("_l").trim_end_matches("_r");
        assert!(ACTIONS.iter().any(|a| a.muscle == stem), "{}", muscle.name);
    }
}

#[test]
fn zygomaticus_lifts_and_widens_the_corners() {
    let moved = BENCH.moved(&["zygomaticus_major"], |_| true);
    let corner = BENCH.of(&moved, "cheilion_l");
    assert!(corner.y > 1.0 && BENCH.width(&moved) > 1.0, "{corner:.2?} {:.2}", BENCH.width(&moved));
}

#[test]
fn risorius_stretches_the_mouth() {
    let moved = BENCH.moved(&["risorius"], |_| true);
    let corner = BENCH.of(&moved, "cheilion_l");
    assert!(BENCH.width(&moved) > 1.0 && corner.y.abs() < 0.3 * corner.x, "{corner:.2?}");
}

#[test]
fn depressor_labii_lowers_the_lower_lip() {
    let moved = BENCH.moved(&["depressor_labii"], |_| true);
    let (low, top) = (BENCH.of(&moved, "labiale_inferius"), BENCH.of(&moved, "labiale_superius"));
    assert!(low.y < -2.0 && top.y.abs() < 0.1 * low.y.abs(), "{low:.2?} {top:.2?}");
    assert!(BENCH.aperture(&moved) > 2.0, "{:.2}", BENCH.aperture(&moved));
}

#[test]
fn orbicularis_closes_parted_lips_and_narrows_the_mouth() {
    let parting = ["levator_labii_superioris_l", "levator_labii_superioris_r", "depressor_labii"];
    let parted = BENCH.moved(&parting, |_| true);
    for ring in ["orbicularis_oris_peripheralis", "orbicularis_oris_marginalis", "orbicularis_oris"] {
        let closing: Vec<&str> = parting.iter().copied().chain([ring]).collect();
        let closed = BENCH.moved(&closing, |_| true);
        let alone = BENCH.moved(&[ring], |_| true);
        let (aperture, width) = (BENCH.aperture(&closed), BENCH.width(&alone));
        println!("{ring}: aperture {:.2} to {aperture:.2} mm, width {width:.2}", BENCH.aperture(&parted));
        assert!(aperture < BENCH.aperture(&parted) - 0.5, "{ring}: {aperture:.2}");
        assert!(width < -0.5, "{ring}: {width:.2}");
    }
}

#[test]
fn teeth_stop_the_backward_movement_of_the_upper_lip() {
    for landmark in ["labiale_superius", "upper_lip_lateral_l"] {
        let back = |teeth: bool| {
            let moved = BENCH.moved(&["orbicularis_oris"], |kind| teeth || kind == PairKind::Lips);
            (-BENCH.of(&moved, landmark).z).max(0.0)
        };
        println!("{landmark}: back {:.2} mm without teeth, {:.2} with", back(false), back(true));
        assert!(back(false) > 1.0, "{landmark}: {:.2}", back(false));
        assert!(back(true) <= 0.1 * back(false), "{landmark}: {:.2} of {:.2}", back(true), back(false));
    }
}

/// A fit of the published mean smile, stiffness following the activations.
struct Smile {
    /// Muscle force per cross-section at full activation, N/mm2.
    stress: f64,
    /// Greatest activation allowed.
    most: f64,
    solution: Solution,
}

impl Smile {
    fn fitted(stress: f64, most: f64) -> Self {
        let parameters = Parameters { muscle_stress_n_mm2: stress, ..Parameters::default() };
        let face = parametric(&parameters, &Resolution::STANDARD).expect("a face");
        let model = Model::new(&face, face.contact_pairs(ContactReach::default())).expect("a model");
        let mut target = read_target("targets/symmetric_smile.toml".as_ref()).expect("a target").target;
        let bound = |muscle: &String| Bound { muscle: muscle.clone(), min: 0.0, max: most };
        target.bounds = model.muscles().iter().map(bound).collect();
        let points = Observations::resolve(&target, &face, |_| Err(f64::INFINITY)).expect("landmarks");
        let problem = ActivatedProblem::new(&model, &target, &points, ContactMode::Reactions);
        let linear = problem.at_fixed_stiffness(HALF).expect("a problem").solve(ContactMode::Reactions);
        let start = DVector::from_vec(linear.expect("an answer").activations.values);
        let solution = problem.solve(start, |_| ()).expect("an answer").solution;
        assert_eq!(solution.status, Status::Solved);
        Self { stress, most, solution }
    }

    /// Left muscles and rings as active as they may be.
    fn held(&self) -> Vec<&str> {
        let activations = &self.solution.activations;
        let names = activations.names.iter().zip(&activations.values);
        let held = names.filter(|(name, a)| **a > self.most - 1e-3 && !name.ends_with("_r"));
        held.map(|(name, _)| name.as_str()).collect()
    }
}

/// The smile at the default stress, with some of every muscle left over, and at the literature's highest stress.
static SMILES: LazyLock<[Smile; 3]> =
    LazyLock::new(|| [(0.1, 1.0), (0.1, 0.9), (0.25, 1.0)].map(|(stress, most)| Smile::fitted(stress, most)));

#[test]
fn the_published_smile_is_reached_to_3_mm_without_full_activation() {
    let [weak, spared, strong] = &*SMILES;
    for smile in [weak, spared, strong] {
        println!("{} N/mm2, {}: rms {:.2} mm", smile.stress, smile.most, smile.solution.residual.rms_mm);
    }
    assert!(spared.solution.residual.rms_mm < 3.0);
    assert!(weak.solution.residual.rms_mm < spared.solution.residual.rms_mm);
    assert!(strong.solution.residual.rms_mm < 1.0);
    assert!(strong.held().len() < weak.held().len());
}

#[test]
fn the_smile_draws_the_corner_back_as_far_as_the_scan_although_depth_was_not_asked_for() {
    let corner =
        SMILES[0].solution.markers.iter().find(|m| m.name == "cheilion_l").expect("the corner").model_mm;
    let scan = Vec3::new(7.1, 10.5, -9.1);
    assert!(corner.angle(&scan).to_degrees() < 20.0, "{corner:.1?}");
    assert!((corner.z - scan.z).abs() < 2.0, "{corner:.1?}");
}

/// The smile's markers on the left and the mid-line as a table.
fn smile_table() -> String {
    let mut text = String::from(
        "\n## The published mean smile\n\n\
         `targets/symmetric_smile.toml`, coronal plane, the stiffness of each muscle that of its own activation: x and y in\n\
         mm, and by how much each point misses, at two muscle stresses and with less than the whole of every muscle.\n\n\
         | point | published |",
    );
    for smile in &*SMILES {
        let _ = write!(text, " {:.2} N/mm², up to {:.1} | misses by |", smile.stress, smile.most);
    }
    text += "\n|---|---|---|---|---|---|---|---|\n";
    let markers = |smile: &'static Smile| smile.solution.markers.iter().filter(|m| !m.name.ends_with("_r"));
    let cell = |m: &MarkerFit| {
        format!(" {:.1}, {:.1} | {:.1} |", tenth(m.model_mm.x), m.model_mm.y, m.residual_mm.unwrap_or(0.0))
    };
    let [weak, spared, strong] = &*SMILES;
    for ((a, b), c) in markers(weak).zip(markers(spared)).zip(markers(strong)) {
        let [x, y, _] = a.target_mm.map(|t| t.unwrap_or(0.0));
        let _ = writeln!(text, "| {} | {x:.1}, {y:.1} |{}{}{}", a.name, cell(a), cell(b), cell(c));
    }
    let [a, b, c] = [weak, spared, strong].map(|smile| smile.solution.residual.rms_mm);
    let _ = writeln!(text, "| rms | | | {a:.1} | | {b:.1} | | {c:.1} |\n");
    for smile in &*SMILES {
        let held = smile.held();
        let held = if held.is_empty() { "none".to_owned() } else { held.join(", ") };
        let _ = writeln!(
            text,
            "As active as allowed, {:.2} N/mm² up to {:.1}: {held}.\n",
            smile.stress, smile.most
        );
    }
    text + "Force is what is missing at the low end: the literature's stresses run from 0.1 to 0.25 N/mm², and displacements\n\
            show only the ratio of force to stiffness.\n"
}

/// `x` to a tenth, without a minus sign on zero.
fn tenth(x: f64) -> f64 {
    (10.0 * x).round() / 10.0 + 0.0
}

#[test]
fn the_table_of_actions_is_published() {
    let mut text = String::from(
        "# What each muscle of the standard face does\n\n\
         Written by `MODIOLUS_BLESS=1 cargo test --release --test forward muscle_function`. Standard resolution, one muscle\n\
         (left side, or a ring) at half activation, the others at rest and soft, contact on. The angle is that between the\n\
         landmark's movement and the anatomical action; the last column is the movement of the landmark's mirror image as a\n\
         share. +x is the subject's left, +y up, +z forward.\n\n\
         | muscle | FACS unit | action | force N | area mm² | landmark | movement mm | angle | other side |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for action in &ACTIONS {
        let Found { movement, angle_deg, other } = found(action);
        let at = |m: &&Muscle| m.name == action.muscle || m.name == format!("{}_l", action.muscle);
        let muscle = BENCH.face.muscles.iter().find(at).expect("the muscle");
        let area = muscle.area_mm2.map_or(String::new(), |a| format!("{a:.0}"));
        let other = other.map_or("ring".to_owned(), |share| format!("{:.0} %", 100.0 * share));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.1} | {area} | {} | {:.1}, {:.1}, {:.1} | {angle_deg:.0}° | {other} |",
            action.muscle,
            action.unit,
            action.meaning,
            muscle.max_force_n,
            action.landmark,
            tenth(movement.x),
            tenth(movement.y),
            tenth(movement.z),
        );
    }
    text += &smile_table();
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/actions.md");
    if std::env::var_os("MODIOLUS_BLESS").is_some() {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(&path, &text).expect("written");
    }
    let published = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(published == text, "{} is out of date: run with MODIOLUS_BLESS=1", path.display());
}
