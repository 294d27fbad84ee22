//! Surgical plans: what is cut, what moves, and the face that comes out.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::block_face::jaw_block;
use modiolus::contact::Solid;
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{About, Cut, CutBy, Face, Motion, Move, PlanError, Pose, SurgicalPlan};
use modiolus::forward::{Model, OperationError, operate};
use modiolus::io::{parse_plan, read_face, read_plan, write_face};
use modiolus::mesh::Quality;
use modiolus::units::Vec3;

fn setback() -> SurgicalPlan {
    read_plan(&Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/setback/plan.toml")).unwrap().plan
}

fn moved(bone: &str, translation: Vec3, rotation_deg: f64) -> Move {
    Move { bone: bone.into(), motion: Motion { translation, rotation_deg, about: About::Condyles } }
}

fn plan(cuts: Vec<Cut>, moves: Vec<Move>) -> SurgicalPlan {
    SurgicalPlan { name: "plan".into(), cuts, moves }
}

/// Bytes of every file of a face.
fn files(face: &Face) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let name = |p: &Path| p.file_name().unwrap().to_string_lossy().into_owned();
    write_face(folder.path(), face).unwrap().iter().map(|p| (name(p), std::fs::read(p).unwrap())).collect()
}

#[test]
fn a_plan_without_moves_gives_the_same_face_to_the_byte() {
    let face = standard(&Resolution::COARSE);
    let done = operate(&plan(Vec::new(), Vec::new()), &face).unwrap();
    assert!(done.face == face && files(&done.face) == files(&face));
    assert!(done.movement.equilibrium.displacement.iter().all(|u| *u == 0.));
    let nowhere = plan(Vec::new(), vec![moved("mandible", Vec3::zeros(), 0.)]);
    assert_eq!(files(&operate(&nowhere, &face).unwrap().face), files(&face));
}

#[test]
fn a_translation_of_every_bone_shifts_the_whole_face() {
    let face = standard(&Resolution::COARSE);
    let t = Vec3::new(2., -1., 3.);
    let done =
        operate(&plan(Vec::new(), vec![moved("skull", t, 0.), moved("mandible", t, 0.)]), &face).unwrap();
    let all = |f: &Face| -> Vec<Vec3> {
        let fibres = f.muscles.iter().flat_map(|m| &m.fibres).flat_map(|f| f.points.clone());
        let teeth = f.teeth.iter().flat_map(|t| t.surface.points.clone());
        let jaw = f.jaw.as_ref().unwrap();
        let marks = f.landmarks.iter().map(|l| l.site.position);
        f.mesh
            .points
            .iter()
            .copied()
            .chain(fibres)
            .chain(teeth)
            .chain(marks)
            .chain(jaw.condyles)
            .chain([jaw.incisor])
            .collect()
    };
    let worst = all(&face).iter().zip(all(&done.face)).map(|(a, b)| (a + t - b).norm()).fold(0., f64::max);
    assert!(worst < 1e-8, "{worst:e}");
    assert_eq!(done.face.supports, face.supports);
}

#[test]
fn a_cut_takes_the_side_of_its_normal_with_its_teeth_and_moves_alone() {
    let face = standard(&Resolution::COARSE);
    let done = operate(&setback(), &face).unwrap();
    let new = &done.face;
    let nodes = |f: &Face, bone: &str| f.supports.iter().find(|s| s.bone == bone).unwrap().nodes.clone();
    let (ramus, body) = (nodes(new, "mandible"), nodes(new, "mandible_body"));
    let mut both = [ramus.clone(), body.clone()].concat();
    both.sort_unstable();
    assert_eq!(both, nodes(&face, "mandible"));
    assert!(
        body.iter().all(|&n| face.mesh.points[n].z > -58.)
            && ramus.iter().all(|&n| face.mesh.points[n].z <= -58.)
    );
    let step = |n: usize| new.mesh.points[n] - face.mesh.points[n];
    let firm = |n: &&usize| (face.mesh.points[**n].z + 58.).abs() >= 10.;
    assert!(body.iter().filter(firm).all(|&n| (step(n) - Vec3::new(0., 0., -5.)).norm() < 1e-12));
    assert!(ramus.iter().filter(firm).chain(&nodes(&face, "skull")).all(|&n| step(n).norm() == 0.));
    assert_eq!((new.teeth[0].bone.as_str(), new.teeth[1].bone.as_str()), ("skull", "mandible_body"));
    assert_eq!(new.teeth[0], face.teeth[0]);
    let (jaw, old) = (new.jaw.as_ref().unwrap(), face.jaw.as_ref().unwrap());
    assert_eq!(jaw.condyles, old.condyles);
    assert!((jaw.incisor - old.incisor - Vec3::new(0., 0., -5.)).norm() < 1e-12);
    // The jaw of the new face opens as one piece.
    let u = new.bone_displacement(&Pose::opened(jaw, 4.));
    assert!(body.iter().chain(&ramus).all(|&n| u[3 * n..3 * n + 3].iter().any(|x| *x != 0.)));
}

#[test]
fn pieces_of_a_piece_stay_parts_of_the_jaw() {
    let face = jaw_block([10, 8, 4]);
    let cut = |bone: &str, piece: &str, x: f64, stripped_mm: f64| Cut {
        bone: bone.into(),
        piece: piece.into(),
        by: CutBy::Plane { point: Vec3::new(x, 3., 1.), normal: Vec3::new(2., 0., 0.), stripped_mm },
        teeth: Vec::new(),
    };
    let cuts = vec![cut("mandible", "body", -10., 7.), cut("body", "chin", 10., 0.)];
    let lower = face.supports[1].nodes.clone();
    let x = |n: usize| face.mesh.points[n].x;
    let prepared = plan(cuts.clone(), vec![moved("mandible", Vec3::y(), 0.)]).prepare(&face).unwrap();
    let near: BTreeSet<usize> = lower.iter().copied().filter(|&n| (x(n) + 10.).abs() < 7.).collect();
    assert!(!near.is_empty() && prepared.stripped == near, "{:?}", prepared.stripped);
    let of = |bone: &str| -> BTreeSet<usize> {
        let own = prepared.face.supports.iter().find(|s| s.bone == bone).unwrap();
        own.nodes.iter().copied().collect()
    };
    let between = |min: f64, max: f64| -> BTreeSet<usize> {
        lower.iter().copied().filter(|&n| min < x(n) && x(n) <= max).collect()
    };
    assert_eq!(of("mandible"), between(-99., -10.));
    assert_eq!(of("body"), between(-10., 10.));
    assert_eq!(of("chin"), between(10., 99.));
    // Moved, opened and opening, the three are the bone that they were.
    let opened = Pose::opened(face.jaw.as_ref().unwrap(), 5.);
    assert_eq!(prepared.face.bone_displacement(&opened), face.bone_displacement(&opened));
    assert_eq!(prepared.face.bone_slope(5.), face.bone_slope(5.));
    let u = prepared.face.bone_displacement(&prepared.pose);
    assert!(lower.iter().all(|&n| u[3 * n..3 * n + 3] == [0., 1., 0.]));
    // A piece that is moved itself leaves the others.
    let chin = plan(cuts, vec![moved("chin", Vec3::x(), 0.)]).prepare(&face).unwrap();
    let u = chin.face.bone_displacement(&chin.pose);
    assert!(lower.iter().all(|&n| u[3 * n] == f64::from(u8::from(x(n) > 10.))));
}

#[test]
fn a_motion_turns_about_its_axis_and_then_shifts() {
    let face = jaw_block([10, 8, 4]);
    let (t, o) = (Vec3::new(1., -2., 0.5), Vec3::new(3., 7., -4.));
    let (sin, cos) = 6f64.to_radians().sin_cos();
    let about_x = |p: Vec3, o: Vec3| {
        let arm = p - o;
        o + Vec3::new(arm.x, cos * arm.y - sin * arm.z, sin * arm.y + cos * arm.z) + t
    };
    let about_z = |p: Vec3, o: Vec3| {
        let arm = p - o;
        o + Vec3::new(cos * arm.x - sin * arm.y, sin * arm.x + cos * arm.y, arm.z) + t
    };
    let condyle = face.jaw.as_ref().unwrap().condyles[1];
    let line = |direction: Vec3| About::Line { point: o, direction };
    type Turned<'a> = &'a dyn Fn(Vec3) -> Vec3;
    let cases: [(About, Turned<'_>); 3] = [
        (About::Condyles, &|p| about_x(p, condyle)),
        (line(3. * Vec3::x()), &|p| about_x(p, o)),
        (line(0.1 * Vec3::z()), &|p| about_z(p, o)),
    ];
    for (about, wanted) in cases {
        let step =
            Move { bone: "mandible".into(), motion: Motion { translation: t, rotation_deg: 6., about } };
        let prepared = plan(Vec::new(), vec![step]).prepare(&face).unwrap();
        let u = prepared.face.bone_displacement(&prepared.pose);
        for &n in &face.supports[1].nodes {
            let p = face.mesh.points[n];
            let to = p + Vec3::new(u[3 * n], u[3 * n + 1], u[3 * n + 2]);
            assert!((to - wanted(p)).norm() < 1e-12, "{about:?} {p}: {to}");
        }
        assert!(face.supports[0].nodes.iter().all(|&n| u[3 * n..3 * n + 3] == [0.; 3]));
    }
}

#[test]
fn a_setback_draws_chin_and_lower_lip_back_and_leaves_a_sound_face() {
    let face = standard(&Resolution::STANDARD);
    let done = operate(&setback(), &face).unwrap();
    let back = |name: &str| {
        let at = |f: &Face| f.landmark(name).unwrap().site.position.z;
        at(&face) - at(&done.face)
    };
    println!(
        "back, mm: pogonion {:.2}, gnathion {:.2}, sublabiale {:.2}, labiale inferius {:.2}, labiale superius {:.2}, subnasale {:.2}",
        back("pogonion"),
        back("gnathion"),
        back("sublabiale"),
        back("labiale_inferius"),
        back("labiale_superius"),
        back("subnasale")
    );
    assert!((0.85..=1.05).contains(&(back("pogonion") / 5.)), "{}", back("pogonion"));
    assert!((0.5..=1.05).contains(&(back("labiale_inferius") / 5.)), "{}", back("labiale_inferius"));
    assert!(back("labiale_superius").abs() < 1. && back("subnasale").abs() < 0.2);
    let mesh = &done.face.mesh;
    let worst = mesh.cells.iter().map(|c| Quality::new(c, &mesh.points).scaled_jacobian).fold(1., f64::min);
    println!("least scaled Jacobian {worst:.3}");
    assert!(worst > 0.05, "{worst}");
    // Lips and cheeks were pushed, not passed through: no mucosa node is deeper in the teeth than before.
    let depth = |f: &Face| {
        let solids: Vec<Solid> = f.teeth.iter().map(|t| Solid::new(&t.surface)).collect();
        let of = |n: &usize| {
            solids
                .iter()
                .filter_map(|s| s.project(f.mesh.points[*n]))
                .map(|p| -p.distance_mm)
                .fold(0., f64::max)
        };
        f.mucosa.iter().map(of).fold(0., f64::max)
    };
    println!(
        "depth in teeth {:.3} before, {:.3} after, settled {}",
        depth(&face),
        depth(&done.face),
        done.movement.settled
    );
    assert!(depth(&done.face) < depth(&face) + 0.2, "{} {}", depth(&face), depth(&done.face));
    // It is read back and computes.
    let folder = tempfile::tempdir().unwrap();
    write_face(folder.path(), &done.face).unwrap();
    let back = read_face(&folder.path().join("face.toml"), None).unwrap().face;
    assert_eq!(
        (&back.supports, &back.jaw, &back.teeth),
        (&done.face.supports, &done.face.jaw, &done.face.teeth)
    );
    Model::new(&back, Vec::new()).unwrap().at(&vec![0.5; back.muscles.len()]).unwrap();
}

#[test]
fn turning_a_bone_is_told_when_it_is_too_far_and_refused_when_it_tears() {
    let face = standard(&Resolution::COARSE);
    let turned =
        |degrees: f64| operate(&plan(Vec::new(), vec![moved("mandible", Vec3::zeros(), degrees)]), &face);
    assert!(turned(4.).unwrap().large_turns.is_empty());
    let far = turned(11.).unwrap().large_turns;
    assert!(far[0].to_string().contains("mandible turns by 11.0 degrees"), "{far:?}");
    let torn = operate(&plan(Vec::new(), vec![moved("mandible", Vec3::new(0., 60., 0.), 0.)]), &face);
    assert!(matches!(torn, Err(OperationError::Inverted { .. })), "{:?}", torn.map(|_| ()));
}

#[test]
fn what_does_not_fit_the_face_is_refused_by_its_field() {
    let face = standard(&Resolution::COARSE);
    let refused = |plan: &SurgicalPlan| match operate(plan, &face) {
        Err(OperationError::Plan(error)) => error,
        other => panic!("{:?}", other.map(|_| ())),
    };
    let good = setback();
    let cut = |change: &dyn Fn(&mut Cut)| {
        let mut plan = good.clone();
        change(&mut plan.cuts[0]);
        refused(&plan)
    };
    let plane = |z: f64, normal: Vec3| CutBy::Plane { point: Vec3::new(0., 0., z), normal, stripped_mm: 0. };
    for (error, field) in [
        (cut(&|c| c.bone = "mandibel".into()), "cut[0].bone"),
        (cut(&|c| c.piece = "skull".into()), "cut[0].piece"),
        (cut(&|c| c.by = plane(100., Vec3::z())), "cut[0]"),
        (cut(&|c| c.by = plane(-150., Vec3::z())), "cut[0]"),
        (cut(&|c| c.by = plane(0., Vec3::zeros())), "cut[0].plane"),
        (cut(&|c| c.by = CutBy::Set("nodes".into())), "cut[0].set"),
        (cut(&|c| c.teeth = vec![true]), "cut[0].teeth"),
    ] {
        assert_eq!(error.field(), field, "{error}");
    }
    let mut plan = good.clone();
    plan.moves[0].bone = "chin".into();
    let error = refused(&plan);
    assert!(
        matches!(&error, PlanError::UnknownBone { known, .. } if known.iter().any(|k| k == "mandible_body")),
        "{error}"
    );
    plan = good.clone();
    plan.moves.push(plan.moves[0].clone());
    assert_eq!(refused(&plan).field(), "move[1].bone");
    let in_metres = |change: &dyn Fn(&mut SurgicalPlan), field: &str, told: &str| {
        let mut plan = good.clone();
        change(&mut plan);
        let error = refused(&plan);
        assert!(error.field() == field && error.to_string().contains(told), "{error}");
    };
    in_metres(
        &|plan| {
            plan.moves[0].motion = Motion { translation: Vec3::new(0., 0., -0.005), ..plan.moves[0].motion }
        },
        "move[0].translation_mm",
        "metres",
    );
    in_metres(
        &|plan| plan.moves[0].motion.translation.x = 400.,
        "move[0].translation_mm",
        "more than a bone",
    );
    in_metres(
        &|plan| plan.moves[0].motion.rotation_deg = 42570.,
        "move[0].rotation_deg",
        "at most 180 degrees",
    );
    let plane = |plan: &mut SurgicalPlan, z: f64, stripped: f64| {
        let (point, normal) = (Vec3::new(0., 0., z), Vec3::z());
        plan.cuts[0].by = CutBy::Plane { point, normal, stripped_mm: stripped };
    };
    in_metres(&|plan| plane(plan, -0.058, 0.), "cut[0].plane.point_mm", "metres");
    in_metres(&|plan| plane(plan, -58000., 0.), "cut[0].plane.point_mm", "away from the mesh");
    in_metres(&|plan| plane(plan, -58., 0.01), "cut[0].plane.stripped_mm", "metres");
}

const GOOD: &str = r#"name = "tilt"
unit = "mm"

[[cut]]
bone = "mandible"
piece = "chin"
plane = { point_mm = [0, -30, 0], normal = [0, -1, 0] }

[[move]]
bone = "chin"
rotation_deg = 3.0
axis = { point_mm = [0, -30, -20], direction = [1, 0, 0] }
"#;

#[test]
fn faults_of_a_plan_file_are_told_with_their_line() {
    let parse = |text: &str| parse_plan(text, Path::new("p.toml"));
    let plan = parse(GOOD).unwrap().plan;
    assert_eq!(plan.moves[0].motion.rotation_deg, 3.);
    assert!(matches!(plan.moves[0].motion.about, About::Line { .. }));
    let condylar = GOOD.replace("{ point_mm = [0, -30, -20], direction = [1, 0, 0] }", "\"condylar\"");
    assert_eq!(parse(&condylar).unwrap().plan.moves[0].motion.about, About::Condyles);
    for (from, to, parts) in [
        ("unit = \"mm\"\n", "", ["p.toml", "unit"]),
        ("unit = \"mm\"", "unit = \"cm\"", ["p.toml:2", "cm"]),
        ("piece = ", "peace = ", ["p.toml:6", "piece"]),
        ("plane = ", "# ", ["p.toml:4", "`plane` or `set`"]),
        ("[0, -30, 0]", "[0, -30]", ["p.toml:7", "3"]),
        ("axis = ", "# ", ["p.toml:9", "condylar"]),
        ("direction", "along", ["p.toml:12", "direction"]),
        ("rotation_deg = 3.0", "rotation_deg = \"3\"", ["p.toml:11", "rotation_deg"]),
    ] {
        assert!(GOOD.contains(from), "{from}");
        let text = parse(&GOOD.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{from}: {text}");
    }
}

#[test]
fn a_jaw_turns_about_its_incisal_point_as_a_cephalometric_table_says() {
    let face = standard(&Resolution::COARSE);
    let text = |motion: &str| {
        format!(
            "name = \"ceph\"\nunit = \"mm\"\n[[cut]]\nbone = \"skull\"\npiece = \"le_fort\"\nplane = {{ point_mm = [0.0, 30.0, 0.0], \
             normal = [0.0, -1.0, 0.0] }}\nteeth = [\"upper\"]\n[[move]]\nbone = \"le_fort\"\n{motion}\n"
        )
    };
    let motion = |given: &str| {
        let plan = parse_plan(&text(given), Path::new("p.toml")).unwrap().plan;
        let prepared = plan.prepare(&face).unwrap();
        prepared.pose.motion(&prepared.face, "le_fort")
    };
    // The edge of the standard's upper incisors: 3.2 mm below the line of the lips, but for notch and groove.
    let incisor = Vec3::new(0., -3.2, -5.);
    let all = motion(
        "incisor = { anterior_mm = 4.0, superior_mm = 2.0, left_mm = 1.0, pitch_deg = 5.0, yaw_deg = -2.0 }",
    );
    assert!(
        (all.displacement(incisor) - Vec3::new(1., 2., 4.)).norm() < 0.4,
        "{:?}",
        all.displacement(incisor)
    );
    let same = [
        (
            "axis = \"pitch\"\nrotation_deg = 5.0\ntranslation_mm = [0.0, 2.0, 4.0]",
            "incisor = { anterior_mm = 4.0, superior_mm = 2.0, pitch_deg = 5.0 }",
        ),
        ("axis = \"yaw\"\nrotation_deg = -3.0", "incisor = { yaw_deg = -3.0 }"),
        ("axis = \"roll\"\nrotation_deg = 4.0", "incisor = { roll_deg = 4.0 }"),
    ];
    for (named, table) in same {
        let far = Vec3::new(20., 10., -40.);
        assert!((motion(named).apply(far) - motion(table).apply(far)).norm() < 1e-9, "{named}");
    }
    // Signs: pitch lowers the front, roll raises the left, yaw turns the front to the left.
    let turned = |given: &str, p: Vec3| motion(given).displacement(incisor + p);
    assert!(turned("incisor = { pitch_deg = 5.0 }", Vec3::z()).y < 0.);
    assert!(turned("incisor = { roll_deg = 5.0 }", Vec3::new(30., 0., 0.)).y > 2.);
    assert!(turned("incisor = { yaw_deg = 5.0 }", Vec3::new(0., 0., -30.)).x < -2.);
    let twice = parse_plan(
        &text("rotation_deg = 1.0\naxis = \"roll\"\nincisor = { yaw_deg = 1.0 }"),
        Path::new("p.toml"),
    );
    assert!(twice.unwrap_err().to_string().contains("leave out"));
}
