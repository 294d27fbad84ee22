//! The page of results: what it holds, that it lets nothing in, and what bad input gets.

use std::fs;
use std::io::Read;
use std::path::Path;

use assert_cmd::Command;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use modiolus::face::{Face, Pose, standard, standard::Resolution};
use modiolus::io::{AnswerFiles, TrackFileError, read_answer, read_track};
use modiolus::report::{Motion, MotionState, ReportError, ShownResult, Told, page, tracked_motion};
use modiolus::study::{Mechanics, Mover, Stiffness, Strain};
use modiolus::units::Vec3;
use serde_json::Value;
use tempfile::TempDir;

fn modiolus() -> Command {
    let mut command = Command::cargo_bin("modiolus").expect("the program");
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// Runs, and returns exit code and stderr.
fn run(command: &mut Command) -> (i32, String) {
    let output = command.output().expect("it runs");
    (output.status.code().expect("an exit code"), String::from_utf8(output.stderr).expect("UTF-8"))
}

/// The face under a one-sided smile, without contact, in `folder`.
fn result(folder: &TempDir, name: &str, more: &[&str]) -> String {
    let out = folder.path().join(name).display().to_string();
    let mut command = modiolus();
    command.args(["forward", "--face", "standard_coarse", "--contact", "off", "--out", &out]);
    if more.is_empty() {
        command.args(["--activate", "zygomaticus_major_l=0.4,mentalis=0.1"]);
    }
    let (code, stderr) = run(command.args(more));
    assert_eq!(code, 0, "{stderr}");
    out
}

/// The content of the element with this `id`.
fn element<'a>(html: &'a str, id: &str) -> &'a str {
    let from = html.find(&format!("id=\"{id}\">")).expect("the element") + id.len() + 6;
    let to = html[from..].find("</script>").expect("its end");
    &html[from..from + to]
}

/// The page's data and its block of numbers.
fn data(html: &str) -> (Value, Vec<u8>) {
    let json = serde_json::from_str(element(html, "data")).expect("JSON");
    let zlib = STANDARD.decode(element(html, "arrays")).expect("base64");
    let mut block = Vec::new();
    flate2::read::ZlibDecoder::new(&zlib[..]).read_to_end(&mut block).expect("zlib");
    (json, block)
}

/// The reals of an array.
fn reals(array: &Value, block: &[u8]) -> Vec<f64> {
    let of = |name: &str| array[name].as_u64().expect("a number") as usize;
    let (at, len, scale) = (of("at"), of("len"), array["scale"].as_f64().expect("a scale"));
    assert_eq!(array["kind"], "i16");
    let value = |k: usize| i16::from_le_bytes([block[at + 2 * k], block[at + 2 * k + 1]]);
    (0..len).map(|k| f64::from(value(k)) * scale).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0., |most: f64, v| most.max(v.abs()))
}

const LINEAR: Mechanics =
    Mechanics { strain: Strain::Linear, stiffness: Stiffness::Activated, contact: false };

fn smile(face: &Face, half: f64) -> Vec<f64> {
    let of = |name: &str| match name {
        "zygomaticus_major_l" => 0.4,
        "zygomaticus_major_r" => half,
        "levator_labii_superioris_l" => 0.2,
        _ => 0.,
    };
    face.muscles.iter().map(|m| of(&m.name)).collect()
}

/// The tangent is the derivative of where the face settles, with teeth and lips in the way and without.
#[test]
fn the_tangent_is_the_derivative_of_settling() {
    let face = standard(&Resolution::COARSE);
    let m = face.muscle_index("zygomaticus_major_r").expect("a muscle");
    // Between two steps of finite length contacts come and go, and normals turn, which the tangent leaves out.
    for (contact, step, tolerance) in [(false, 1e-3, 1e-4), (true, 2e-3, 0.1)] {
        let mover = Mover::new(&face, Mechanics { contact, ..LINEAR }).expect("a face");
        let at = |a: f64| mover.settle(&smile(&face, a), &Pose::rest()).expect("it settles").displacement;
        let tangent = mover.tangent(&smile(&face, 0.3), &Pose::rest()).expect("it settles");
        let [before, after] = [at(0.3 - step), at(0.3 + step)];
        let rate: Vec<f64> = before.iter().zip(&after).map(|(b, a)| (a - b) / (2. * step)).collect();
        let field = &tangent.fields[m];
        let off: f64 = field.iter().zip(&rate).map(|(t, r)| (t - r).powi(2)).sum();
        let size: f64 = rate.iter().map(|r| r * r).sum();
        assert!((off / size).sqrt() < tolerance, "contact {contact}: {}", (off / size).sqrt());
        assert_eq!(tangent.fields.len(), face.muscles.len());
        assert_eq!(tangent.moved.displacement, at(0.3));
    }
}

#[test]
fn the_page_holds_the_result_and_lets_nothing_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = result(&folder, "one", &[]);
    let out = folder.path().join("page.html");
    let report = |out: &Path| {
        let (code, stderr) = run(modiolus().args(["report", &one, "--parts", "2", "--out"]).arg(out));
        assert_eq!(code, 0, "{stderr}");
        fs::read_to_string(out).expect("a page")
    };
    let html = report(&out);
    assert_eq!(html, report(&folder.path().join("again.html")), "the same bytes again");
    assert!(html.len() < 6_000_000, "{} bytes", html.len());

    // Nothing is fetched, and the policy allows only what is in the page.
    let (head, _) = html.split_once("</head>").expect("a head");
    assert!(head.contains("default-src 'none'; script-src 'sha256-") && !head.contains("unsafe"));
    let markup = html.replace(element(&html, "data"), "").replace(element(&html, "arrays"), "");
    let script = markup.rsplit_once("<script>").expect("the script").1;
    let own = script.split_once("</script>").expect("its end").0;
    let markup = markup.replace(own, "");
    for outside in ["src=", "http:", "https:", "url(", " style=", "onclick", "@import"] {
        assert!(!markup.contains(outside), "{outside}");
    }

    let answer = read_answer(one.as_ref()).expect("a result");
    let face = standard(&Resolution::COARSE);
    let (json, block) = data(&html);
    let shown = &json["results"][0];
    assert_eq!(shown["kind"], "loading");
    let states = shown["states"].as_array().expect("states");
    let times: Vec<f64> = states.iter().filter_map(|s| s["time"].as_f64()).collect();
    assert_eq!((times, shown["answer"]["time"].as_f64()), (vec![0., 0.5], Some(1.)));
    assert_eq!(shown["tangent"].as_array().map(Vec::len), Some(face.muscles.len()));

    // Each carrier at a landmark's node moves as the stored field says, to the rounding of the array.
    let carriers = reals(&json["faces"][0]["carriers"], &block);
    let moved = reals(&shown["answer"]["displacement"], &block);
    let rounding = largest(&moved) / 65_000.;
    let mut seen = 0;
    for (node, p) in face.mesh.points.iter().enumerate() {
        let here = |k: &usize| (0..3).all(|c| (carriers[3 * k + c] - p[c]).abs() < 2e-3);
        let Some(k) = (0..carriers.len() / 3).find(here) else { continue };
        for c in 0..3 {
            assert!((moved[3 * k + c] - answer.displacement[3 * node + c]).abs() < rounding, "node {node}");
        }
        seen += 1;
        if seen == 200 {
            break;
        }
    }
    assert_eq!(seen, 200, "surface nodes are carriers");
}

#[test]
fn two_results_share_their_face_and_a_sequence_is_played_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = result(&folder, "one", &[]);
    let two = result(&folder, "two", &["--activate", "depressor_anguli_oris=0.3", "--jaw-opening", "4"]);
    let out = folder.path().join("page.html");
    let page = |arguments: &[&str]| {
        let (code, stderr) = run(modiolus().arg("report").args(arguments).arg("--out").arg(&out));
        assert_eq!(code, 0, "{stderr}");
        data(&fs::read_to_string(&out).expect("a page"))
    };
    let (pair, _) = page(&[&one, &two, "--parts", "1"]);
    assert_eq!(pair["faces"].as_array().map(Vec::len), Some(1));
    assert_eq!(pair["results"].as_array().map(Vec::len), Some(2));
    let teeth = pair["results"][1]["answer"]["teeth"].as_array().expect("teeth");
    let drop = |k: usize| teeth[k][0][1].as_f64().expect("a number");
    assert!((0..teeth.len()).any(|k| drop(k).abs() > 0.1), "the lower teeth go with the jaw");

    let (sequence, _) = page(&[&two, &one, &two, "--sequence"]);
    let shown = &sequence["results"][0];
    assert_eq!(shown["kind"], "sequence");
    assert_eq!(shown["states"].as_array().map(Vec::len), Some(3));

    let table = folder.path().join("frames.csv");
    fs::write(&table, "time_s,zygomaticus_major_l\n0,0\n0.5,1\n").expect("written");
    let (frames, _) = page(&[&one, "--frames", &table.display().to_string()]);
    let states = frames["results"][0]["states"].as_array().expect("states");
    assert_eq!(states.len(), 2);
    assert!(states.iter().all(|s| s["displacement"].is_null()), "the tangent gives them");
}

#[test]
fn names_stay_text() {
    let face = standard(&Resolution::COARSE);
    let folder = tempfile::tempdir().expect("a folder");
    let one = result(&folder, "one", &[]);
    let evil = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\u{202e}";
    let mut answer: AnswerFiles = read_answer(one.as_ref()).expect("a result");
    answer.warnings.push(evil.to_owned());
    answer.face = evil.to_owned();
    answer.markers[0].name = evil.to_owned();
    answer.markers[0].target_mm = [Some(1.), None, None];
    let state = MotionState {
        label: evil.to_owned(),
        time: 1.,
        activation: vec![0.; face.muscles.len()],
        displacement: Some(answer.displacement.clone()),
        pressure_kpa: None,
        pose: Pose::rest(),
        residual_mm: Vec::new(),
    };
    let shown =
        |motion: Motion| ShownResult { title: evil.to_owned(), told: Told::Answer(&answer), face: 0, motion };
    let html = page(&[&face], &[shown(Motion::straight(&face, state.clone()))]).expect("a page");
    assert!(!html.contains("<script>alert") && !html.contains("<img"));
    // In the data the script puts it into elements of their own, whose direction is theirs.
    assert!(!html.replace(element(&html, "data"), "").contains('\u{202e}'));
    assert_eq!(html.matches("</script>").count(), 3, "no element ends early");
    assert_eq!(data(&html).0["results"][0]["title"], evil);

    let short = MotionState { displacement: Some(vec![0.; 3]), ..state };
    let told = page(&[&face], &[shown(Motion::straight(&face, short))]);
    assert!(matches!(told, Err(ReportError::Length { found: 3, .. })));
    assert!(matches!(page(&[&face], &[]), Err(ReportError::Results { found: 0 })));
}

/// Frames of a second in which the left corner of the mouth goes up by `lift_mm` and half as far back.
const TRACKED: usize = 31;

fn lift_mm(frame: usize) -> f64 {
    5. * (std::f64::consts::PI * frame as f64 / (TRACKED - 1) as f64).sin()
}

/// Such a recording of the landmarks of `face` fitted in `folder`; in frame 7 the right corner is not seen.
fn track(face: &Face, folder: &TempDir, more: &[&str]) -> String {
    let mut text = String::from("time_s,marker,x_mm,y_mm,z_mm\n");
    for frame in 0..TRACKED {
        for landmark in &face.landmarks {
            let name = &landmark.name;
            let lift = if name == "cheilion_l" { lift_mm(frame) } else { 0. };
            let p = landmark.site.position + Vec3::new(0., lift, -0.5 * lift);
            if frame != 7 || name != "cheilion_r" {
                text += &format!("{},{name},{},{},{}\n", frame as f64 / 30., p.x, p.y, p.z);
            }
        }
    }
    let recording = folder.path().join("recording.csv").display().to_string();
    fs::write(&recording, text).expect("written");
    let out = folder.path().join("track").display().to_string();
    let (code, stderr) =
        run(modiolus().args(["track", &recording, "--face", "standard_coarse", "--out", &out]).args(more));
    assert_eq!(code, 0, "{stderr}");
    out
}

/// The face is moved again from the tables; what it does at a marker and the residual together are what was measured.
#[test]
fn a_track_is_played_as_it_was_fitted() {
    let face = standard(&Resolution::COARSE);
    let folder = tempfile::tempdir().expect("a folder");
    let out = track(&face, &folder, &[]);
    let files = read_track(out.as_ref()).expect("a track");
    let motion = tracked_motion(&face, &files, 3, |_| ()).expect("it moves");
    assert_eq!(motion.states.len(), TRACKED.div_ceil(3));
    let mut moved = 0_f64;
    for (k, state) in motion.states.iter().enumerate() {
        let u = state.displacement.as_ref().expect("a field");
        for (label, residual) in files.markers.iter().zip(&state.residual_mm) {
            let landmark = face.landmark(label).expect("a landmark");
            let lift = if label == "cheilion_l" { lift_mm(3 * k) } else { 0. };
            let fitted = landmark.site.displacement(u);
            let measured = fitted + residual.expect("seen");
            // The head is found from markers, some of which move, and tables have four digits.
            assert!((measured - Vec3::new(0., lift, -0.5 * lift)).norm() < 0.02, "{label} {k}: {measured:?}");
            moved = moved.max(fitted.norm());
        }
    }
    assert!(moved > 2., "the face follows: {moved} mm");
    assert_eq!(files.residual_mm[7].iter().filter(|r| r.is_none()).count(), 1);

    let page = folder.path().join("track.html").display().to_string();
    let (code, stderr) = run(modiolus().args(["report", &out, "--every", "7", "--out", &page]));
    assert_eq!(code, 0, "{stderr}");
    let html = fs::read_to_string(&page).expect("written");
    let (json, block) = data(&html);
    let result = &json["results"][0];
    assert_eq!(
        (result["kind"].as_str(), result["states"].as_array().map(Vec::len)),
        (Some("track"), Some(5))
    );
    assert_eq!(
        result["notes"][0].as_str().map(|note| note.starts_with("Every 7th of 31 frames, 5 in all")),
        Some(true)
    );
    let [seen, residuals] = [0, 1].map(|k| &result["states"][1]["residuals"][k]);
    let [at, len] = ["at", "len"].map(|name| seen[name].as_u64().expect("a number") as usize);
    assert_eq!(block[at..at + len].iter().filter(|seen| **seen == 0).count(), 1, "frame 7");
    let residuals = reals(residuals, &block);
    for (found, residual) in residuals.chunks(3).zip(&files.residual_mm[7]) {
        let residual = residual.unwrap_or_default();
        assert!((Vec3::new(found[0], found[1], found[2]) - residual).norm() < 1e-3);
    }
    for part in ["Activations over time", "Jaw", "31 from 0.00 to 1.00 s: 31 ok"] {
        assert!(html.contains(part), "{part}");
    }

    let one = self::result(&folder, "one", &[]);
    let (code, stderr) = run(modiolus().args(["report", &out, &one, "--out", &page]));
    assert!(code == 2 && stderr.contains("is a track, which is shown alone"), "{stderr}");
    let table = folder.path().join("track/residuals.csv");
    fs::write(&table, "frame,marker\n").expect("written");
    assert!(matches!(read_track(out.as_ref()), Err(TrackFileError::Foreign(path)) if path == table));
}

/// Where the stiffness follows, at finite strain too, each frame is shown as the face settles under its own activations.
#[test]
fn a_track_is_played_at_the_stiffness_of_its_frames() {
    let face = standard(&Resolution::COARSE);
    for strain in [Strain::Linear, Strain::Finite] {
        let folder = tempfile::tempdir().expect("a folder");
        let how = ["--strain", strain.name(), "--stiffness", "follow", "--contact", "off"];
        let out = track(&face, &folder, &how);
        let files = read_track(out.as_ref()).expect("a track");
        let motion = tracked_motion(&face, &files, 10, |_| ()).expect("it moves");
        let mover = Mover::new(&face, Mechanics { strain, ..LINEAR }).expect("a face that moves");
        let mut moved = 0_f64;
        for state in &motion.states {
            let settled = mover.settle(&state.activation, &state.pose).expect("at rest").displacement;
            let shown = state.displacement.as_ref().expect("a field");
            let apart = shown.iter().zip(&settled).map(|(a, b)| (a - b).abs()).fold(0., f64::max);
            assert!(apart < 1e-9, "{}: {apart:e}", state.label);
            moved = moved.max(largest(shown));
        }
        assert!(moved > 2., "the face follows: {moved} mm");
        // At finite strain how far the frames are from the face at rest is told without being asked for.
        let (settled, checked) = (&files.summary.settled, &files.summary.checked);
        // The mean of the frames alone tells nothing of those far from it.
        let rounds = if strain == Strain::Linear { 0..=0 } else { 2..=5 };
        assert!(rounds.contains(&settled.len()), "{settled:?}");
        assert_eq!(checked.is_none(), strain == Strain::Linear);
        for frame in checked.iter().flat_map(|checked| &checked.frames) {
            assert!(frame.rms_mm < 0.1, "{frame:?}");
        }
    }
}

#[test]
fn bad_input_is_refused_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = result(&folder, "one", &[]);
    let out = folder.path().join("page.html");
    let table = folder.path().join("frames.csv");
    fs::write(&table, "time_s,zygomaticus_major_left\n0,1\n").expect("written");
    let table = table.display().to_string();
    let nothing = folder.path().display().to_string();
    let page = out.display().to_string();
    let other = folder.path().join("other").display().to_string();
    let (code, stderr) = run(modiolus().args([
        "forward",
        "--contact",
        "off",
        "--activate",
        "mentalis=0.1",
        "--face",
        "standard",
        "--out",
        &other,
    ]));
    assert_eq!(code, 0, "{stderr}");
    let as_page = folder.path().join("folder.html");
    fs::create_dir(&as_page).expect("a folder");
    let cases: [(&[&str], &str); 9] = [
        (&["--out", &page], "RESULT"),
        (&[&one, "--out", "page.txt"], "name it page.html"),
        (&[&nothing, "--out", &page], "solution.json"),
        (&["no_such_folder", "--out", &page], "there is no such folder"),
        (&[&one, "--out", &page, "--parts", "0"], "--parts"),
        (&[&one, "--out", &page, "--frames", &table], "did you mean zygomaticus_major_l"),
        (&[&one, &other, "--out", &page, "--sequence"], "different faces"),
        (&[&one, &one, &one, "--out", &page], "one or 2 results, not 3"),
        (&[&one, "--out", &as_page.display().to_string()], "folder.html"),
    ];
    for (arguments, part) in cases {
        let (code, stderr) = run(modiolus().arg("report").args(arguments));
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "\"{part}\" is not in: {stderr}");
        assert!(!out.exists(), "{arguments:?} wrote a page");
    }
}

/// The JSON and the binary chunk of a GLB file.
fn chunks(glb: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes([glb[at], glb[at + 1], glb[at + 2], glb[at + 3]]) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    let json = word(12);
    assert_eq!((&glb[16..20], &glb[24 + json..28 + json]), (&b"JSON"[..], &b"BIN\0"[..]));
    (serde_json::from_slice(&glb[20..20 + json]).expect("JSON"), &glb[28 + json..])
}

#[test]
fn exports_hold_the_answer() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = result(&folder, "one", &[]);
    let answer = read_answer(one.as_ref()).expect("a result");
    let export = |form: &str| {
        let out = folder.path().join(format!("x.{form}"));
        let (code, stderr) = run(modiolus().args(["export", &one, "--to", form, "--out"]).arg(&out));
        assert_eq!(code, 0, "{stderr}");
        fs::read(out).expect("written")
    };
    let text = |form: &str| String::from_utf8(export(form)).expect("text");

    // The superposition of all targets in the animation's last weights is the answer.
    let glb = export("glb");
    let (json, binary) = chunks(&glb);
    let reals = |accessor: &Value| -> Vec<f64> {
        let accessor = &json["accessors"][accessor.as_u64().expect("an index") as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
        let of = |name: &str| view[name].as_u64().expect("a number") as usize;
        let bytes = &binary[of("byteOffset")..of("byteOffset") + of("byteLength")];
        bytes.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect()
    };
    let skin = &json["meshes"][0];
    let names: Vec<&str> =
        skin["extras"]["targetNames"].as_array().expect("names").iter().filter_map(Value::as_str).collect();
    let face = standard(&Resolution::COARSE);
    assert!(face.muscles.iter().zip(&names).all(|(m, name)| m.name == **name));
    assert_eq!((names.len(), names.last()), (face.muscles.len() + 1, Some(&"remainder")));
    let weights = reals(&json["animations"][0]["samplers"][0]["output"]);
    let weights = &weights[names.len()..];
    for (muscle, weight) in names.iter().zip(weights).take(face.muscles.len()) {
        assert!((answer.activations[*muscle] - weight).abs() < 1e-6, "{muscle}");
    }
    let base = reals(&skin["primitives"][0]["attributes"]["POSITION"]);
    let mut moved = vec![0.; base.len()];
    for (target, weight) in skin["primitives"][0]["targets"].as_array().expect("targets").iter().zip(weights)
    {
        moved.iter_mut().zip(reals(&target["POSITION"])).for_each(|(m, u)| *m += weight * u);
    }
    let scene = modiolus::render::Scene::new(&face);
    for (k, site) in scene.surface().sites.iter().enumerate() {
        let u = site.displacement(&answer.displacement);
        for c in 0..3 {
            assert!((1e3 * base[3 * k + c] - site.position[c]).abs() < 1e-4);
            assert!((1e3 * moved[3 * k + c] - u[c]).abs() < 1e-4, "vertex {k}");
        }
    }

    let csv = text("csv");
    let (head, last) = (csv.lines().next().expect("a head"), csv.lines().last().expect("a row"));
    assert!(head.starts_with("time_s,") && last.starts_with("1,"));
    for (muscle, a) in head.split(',').zip(last.split(',')).skip(1) {
        assert_eq!(a.parse::<f64>().ok(), answer.activations.get(muscle).copied(), "{muscle}");
    }
    assert!(text("sto").contains("\nendheader\ntime\t"));
    assert_eq!(text("pvd").matches("<DataSet ").count(), 5);
    assert!(folder.path().join("x_004.vtu").exists());
    assert!(text("obj").matches("\nf ").count() > 10_000);

    let plot = folder.path().join("a.svg");
    let (code, stderr) = run(modiolus().args(["plot", &one, "--kind", "activations", "--out"]).arg(&plot));
    assert_eq!(code, 0, "{stderr}");
    let svg = fs::read_to_string(&plot).expect("a plot");
    assert!(svg.starts_with("<svg xmlns=") && svg.contains("zygomaticus major") && svg.ends_with("</svg>\n"));

    let lengths = folder.path().join("lengths.svg");
    let (code, stderr) = run(modiolus().args(["plot", &one, "--kind", "length", "--out"]).arg(&lengths));
    assert_eq!(code, 0, "{stderr}");
    let svg = fs::read_to_string(&lengths).expect("a plot");
    // Three muscles of two names act, each with its curve, each name with that at activation 0; the legend has both names and
    // that line.
    assert_eq!(svg.matches("<polyline ").count(), (3 + 2) + (2 + 1));
    assert!(svg.contains("zygomaticus major") && svg.contains("force along the muscle, N"));

    let own = Path::new(&one).join("face.vtu").display().to_string();
    let before = fs::read(&own).expect("the answer's own");
    let cases: [(&[&str], &str); 4] = [
        (&["export", &one, "--to", "glb", "--out", "x.gltf"], "name it x.glb"),
        (&["export", &one, "--to", "vtu", "--out", &own], "would be replaced"),
        (&["plot", &one, "--kind", "symmetry", "--out", "x.svg"], "nothing of that kind"),
        (&["plot", &one, "--kind", "time", "--out", "x.svg"], "--frames"),
    ];
    for (arguments, part) in cases {
        let (code, stderr) = run(modiolus().args(arguments));
        assert!(code == 2 && stderr.contains(part), "{arguments:?}: {stderr}");
    }
    assert_eq!(fs::read(&own).expect("the answer's own"), before);
}
