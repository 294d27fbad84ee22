//! Pictures as their users script them: what is refused, what is written, and that it is the same every time.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use modiolus::face::{Pose, standard, standard::Resolution};
use modiolus::io::read_face;
use modiolus::mesh::Mesh;
use modiolus::render::{Drawing, Image, RenderError, Scene, Show, View, muscle_stems};
use modiolus::study::{Mechanics, Mover};
use tempfile::TempDir;

fn modiolus() -> Command {
    let mut command = Command::cargo_bin("modiolus").expect("the program");
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Runs, expects exit code 2, silence on stdout, every one of `parts` on stderr and no file `out`.
fn refused(arguments: &[&str], out: &Path, parts: &[&str]) {
    let output = modiolus().arg("render").args(arguments).arg("--out").arg(out).output().expect("it runs");
    let stderr = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(output.stdout.is_empty());
    for part in parts {
        assert!(stderr.contains(part), "\"{part}\" is not in: {stderr}");
    }
    assert!(!out.exists(), "{} was written", out.display());
}

fn small<'a>() -> Drawing<'a> {
    Drawing { size: (160, 140), ..Drawing::default() }
}

/// Pixels of `image` that `is` holds for.
fn count(image: &Image, is: impl Fn([i32; 3]) -> bool) -> usize {
    image.pixels.iter().filter(|p| is(p.map(i32::from))).count()
}

fn inked(image: &Image) -> usize {
    count(image, |p| p != [255; 3])
}

#[test]
fn bad_arguments_are_refused_with_what_would_do() {
    let dir = folder();
    let out = dir.path().join("x.png");
    refused(
        &["standard", "--view", "frnt"],
        &out,
        &["--view", "frnt", "three-quarter", "did you mean front?"],
    );
    refused(&["standard", "--view", "top"], &out, &["--view", "front, profile, three-quarter"]);
    refused(&["standard", "--size", "0x100"], &out, &["--size", "0x100", "from 16 to 4096"]);
    refused(&["standard", "--size", "100"], &out, &["--size", "WIDTHxHEIGHT"]);
    refused(&["standard", "--size", "99999x10"], &out, &["--size", "from 16 to 4096"]);
    refused(&["standard", "--show", "skin,muscle"], &out, &["--show", "muscle", "did you mean muscles?"]);
    refused(&["standard", "--show", "displacement"], &out, &["--show displacement", "--activate"]);
    refused(&["standard", "--activate", "risorio=1"], &out, &["--activate", "risorio", "risorius_l"]);
    refused(&["face.toml"], &out, &["face.toml"]);
}

#[test]
fn a_folder_that_holds_no_answer_is_refused() {
    let dir = folder();
    let out = dir.path().join("x.png");
    let at = |name: &str| dir.path().join(name).display().to_string();
    refused(&[&at("none")], &out, &["none", "no such folder", "fit or forward"]);
    let answer = dir.path().join("answer");
    fs::create_dir(&answer).expect("made");
    refused(&[&at("answer")], &out, &["solution.json", "cannot be read"]);
    fs::write(answer.join("solution.json"), "{\"activations\": {}}").expect("written");
    refused(&[&at("answer")], &out, &["solution.json", "`face`", "write it again"]);
    let index = |face: &str, sha256: &str| {
        let files = if sha256.is_empty() { String::new() } else { format!("\"face.vtu\": \"{sha256}\"") };
        let text = format!("{{\"face\": \"{face}\", \"activations\": {{}}, \"files\": {{{files}}}}}");
        fs::write(answer.join("solution.json"), text).expect("written");
    };
    index("standard", "");
    refused(&[&at("answer")], &out, &["solution.json", "no displacement"]);
    index("standard", "00");
    refused(&[&at("answer")], &out, &["face.vtu", "cannot be read"]);

    let face = standard(&Resolution::COARSE);
    let write = |mesh: &Mesh, name: &str| {
        let u = vec![0.5; 3 * mesh.n_nodes()];
        let data =
            modiolus::io::VtuData { point_vectors: [(name.to_owned(), u)].into(), ..Default::default() };
        modiolus::io::write_vtu(&answer.join("face.vtu"), mesh, &data).expect("written");
        modiolus::io::sha256(&fs::read(answer.join("face.vtu")).expect("written"))
    };
    let other = write(&face.mesh, "velocity");
    refused(&[&at("answer")], &out, &["face.vtu", "is not the file that was written with"]);
    index("standard", &other);
    refused(&[&at("answer")], &out, &["face.vtu", "a point array called displacement"]);
    let own = write(&face.mesh, "displacement");
    index("standard", &own);
    refused(&[&at("answer")], &out, &["face.vtu", "displacement has", "compute it again"]);
    index("gone/face.toml", &own);
    refused(&[&at("answer")], &out, &["gone/face.toml", "from the folder where"]);
}

#[test]
fn an_answer_is_drawn_as_it_was_computed() {
    let dir = folder();
    let answer = dir.path().join("answer");
    let activate = ["--activate", "depressor_labii_inferioris=1", "--contact", "off"];
    modiolus().arg("forward").args(activate).arg("--out").arg(&answer).assert().success();
    let (again, directly) = (dir.path().join("again.png"), dir.path().join("directly.png"));
    let size = ["--size", "120x110"];
    modiolus().arg("render").arg(&answer).args(size).arg("--out").arg(&again).assert().success();
    let standard = modiolus()
        .args(["render", "standard"])
        .args(activate)
        .args(size)
        .arg("--out")
        .arg(&directly)
        .assert();
    standard.success().stdout(format!("{}\n", directly.display()));
    let read = |path: &Path| fs::read(path).expect("written");
    assert!(read(&again).starts_with(b"\x89PNG"));
    assert!(read(&again) == read(&directly), "the folder holds all that the picture needs");
    let twice = ["render", "--activate", "risorius=1"];
    modiolus().args(twice).arg(&answer).arg("--out").arg(dir.path().join("x.png")).assert().code(2);
}

#[test]
fn an_operated_face_is_drawn_with_its_teeth_moved() {
    let dir = folder();
    let (operated, before) = (dir.path().join("operated"), dir.path().join("before"));
    modiolus().args(["surgery", "examples/setback/plan.toml", "--out"]).arg(&operated).assert().success();
    let draw = |what: &Path, name: &str| {
        let out = dir.path().join(name);
        let options = ["--show", "teeth", "--view", "profile", "--size", "120x110"];
        modiolus().arg("render").arg(what).args(options).arg("--out").arg(&out).assert().success();
        fs::read(out).expect("written")
    };
    let teeth = draw(&operated, "teeth.png");
    let mut face = standard(&Resolution::STANDARD);
    face.teeth = read_face(&operated.join("face.toml"), None).expect("the operated face").face.teeth;
    let show = Show { teeth: true, ..Show::default() };
    let drawing = Drawing { show, view: View::Profile, size: (120, 110), ..Drawing::default() };
    let expected = Scene::new(&face).draw(&drawing).expect("drawn").to_png().expect("encoded");
    assert!(teeth == expected, "those of the face that was written");
    assert!(teeth != draw(Path::new("standard"), "standard.png"), "the lower ones moved");
    // A face that the answer does not lead to has no say.
    modiolus()
        .args(["forward", "--activate", "risorius=0.1", "--contact", "off", "--out"])
        .arg(&before)
        .assert()
        .success();
    fs::copy(before.join("face.vtu"), operated.join("face.vtu")).expect("copied");
    fs::copy(before.join("solution.json"), operated.join("solution.json")).expect("copied");
    assert!(draw(&operated, "other.png") == draw(&before, "before.png"), "a face of another answer");
}

#[test]
fn the_same_face_gives_the_same_bytes_whatever_the_threads() {
    let face = standard(&Resolution::COARSE);
    let show = Show { skin: true, teeth: true, muscles: true, forces: true, displacement: false };
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let drawing = Drawing { show, view: View::ThreeQuarter, ..small() };
        pool.install(|| Scene::new(&face).draw(&drawing).expect("drawn").to_png().expect("encoded"))
    };
    let one = draw(1);
    assert!(draw(2) == one && draw(7) == one && draw(1) == one);
}

#[test]
fn the_front_is_a_mirror_image_but_for_the_light() {
    let face = standard(&Resolution::COARSE);
    let drawing = Drawing { legend: false, ..small() };
    let image = Scene::new(&face).draw(&drawing).expect("drawn");
    let covered = |x: usize, y: usize| image.pixels[y * image.width + x] != [255; 3];
    let odd = (0..140)
        .flat_map(|y| (0..160).map(move |x| (x, y)))
        .filter(|&(x, y)| covered(x, y) != covered(159 - x, y));
    assert_eq!(odd.count(), 0);
    assert!(inked(&image) > 8000, "{}", inked(&image));
}

#[test]
fn each_part_shows() {
    let face = standard(&Resolution::COARSE);
    let scene = Scene::new(&face);
    let draw = |show: Show, activation: Option<&[f64]>, u: Option<&[f64]>| {
        let drawing = Drawing { show, activation, displacement: u, legend: false, ..small() };
        scene.draw(&drawing).expect("drawn")
    };
    let none = Show::default();
    assert_eq!(inked(&draw(none, None, None)), 0, "nothing shown is a white picture");
    let lips = count(&draw(Show::FACE, None, None), |[r, g, b]| r - g > 65 && g - b < 20);
    assert!((100..2000).contains(&lips), "{lips} pixels of lip");
    let teeth = draw(Show { teeth: true, ..none }, None, None);
    assert!(inked(&teeth) > 500);
    let mut only_left = vec![0.; face.muscles.len()];
    only_left[face.muscle_index("zygomaticus_major_l").expect("a muscle")] = 1.;
    // Arrows are thinner than a millimetre: they need pixels to be blue.
    let show = Show { forces: true, ..none };
    let drawing =
        Drawing { size: (480, 420), show, activation: Some(&only_left), legend: false, ..Drawing::default() };
    let forces = scene.draw(&drawing).expect("drawn");
    let blue = |p: [i32; 3]| p[2] > p[0] + 40;
    assert!(count(&forces, blue) > 50, "{}", count(&forces, blue));
    let left = |image: &Image| {
        let half = |k: &usize| k % image.width < image.width / 2;
        (0..image.pixels.len()).filter(half).any(|k| image.pixels[k] != [255; 3])
    };
    assert!(!left(&forces), "the subject's left is on the right of the picture");
    let far = vec![2.; 3 * face.mesh.n_nodes()];
    let moved = draw(Show { displacement: true, skin: true, ..none }, None, Some(&far));
    assert!(inked(&moved) > 8000);
    assert_eq!(muscle_stems(&face).len(), 15);
}

/// A length is shown as a displacement of that length is; where it is none the skin is as it is.
#[test]
fn a_length_is_shown_by_the_colours_of_displacements() {
    let face = standard(&Resolution::COARSE);
    let (scene, n) = (Scene::new(&face), face.mesh.n_nodes());
    let lifted: Vec<f64> = (0..n).flat_map(|_| [0., 3., 4.]).collect();
    let (five, none) = (vec![5.; n], vec![f64::NAN; n]);
    let draw = |show: Show, length: Option<&[f64]>| {
        let drawing = Drawing { show, displacement: Some(&lifted), length_mm: length, ..small() };
        scene.draw(&Drawing { legend: false, ..drawing }).expect("drawn").pixels
    };
    let coloured = Show { displacement: true, ..Show::FACE };
    let plain = draw(Show::FACE, None);
    assert!(draw(coloured, Some(&none)) == plain);
    let (length, displacement) = (draw(coloured, Some(&five)), draw(coloured, None));
    assert!(displacement != plain);
    let apart = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(length.iter().zip(&displacement).all(|(a, b)| apart(a, b) <= Some(2)), "another colour");
}

#[test]
fn a_field_of_another_face_is_refused() {
    let face = standard(&Resolution::COARSE);
    let scene = Scene::new(&face);
    let short = [1., 2., 3.];
    let wrong = scene.draw(&Drawing { displacement: Some(&short), ..small() });
    assert!(matches!(wrong, Err(RenderError::Length { what: "displacement", found: 3, .. })));
    let mut nan = vec![0.; face.muscles.len()];
    nan[4] = f64::NAN;
    let wrong = scene.draw(&Drawing { length_mm: Some(&short), ..small() });
    assert!(matches!(wrong, Err(RenderError::Length { what: "length", .. })), "{wrong:?}");
    let wrong = scene.draw(&Drawing { activation: Some(&nan), ..small() });
    assert_eq!(wrong, Err(RenderError::NotFinite { what: "activation", index: 4 }));
    for size in [(0, 100), (100, 0), (100, 100_000)] {
        assert!(
            matches!(scene.draw(&Drawing { size, ..small() }), Err(RenderError::Size { .. })),
            "{size:?}"
        );
    }
}

/// White pixels that are not joined to the border by others: where a picture is seen through.
fn holes(image: &Image) -> usize {
    let (width, height) = (image.width, image.height);
    let is_white = |k: usize| image.pixels[k] == [255; 3];
    let on_border = |k: &usize| {
        let (x, y) = (k % width, k / width);
        x == 0 || x + 1 == width || y == 0 || y + 1 == height
    };
    let mut reached = vec![false; width * height];
    let mut next: Vec<usize> = (0..width * height).filter(|k| on_border(k) && is_white(*k)).collect();
    while let Some(k) = next.pop() {
        if reached[k] || !is_white(k) {
            continue;
        }
        reached[k] = true;
        let (x, y) = (k % width, k / width);
        next.extend((x > 0).then(|| k - 1).into_iter().chain((x + 1 < width).then_some(k + 1)));
        next.extend((y > 0).then(|| k - width).into_iter().chain((y + 1 < height).then_some(k + width)));
    }
    (0..width * height).filter(|k| is_white(*k) && !reached[*k]).count()
}

#[test]
fn an_open_mouth_is_not_seen_through() {
    let face = standard(&Resolution::COARSE);
    let jaw = face.jaw.as_ref().expect("a jaw");
    let mover = Mover::new(&face, Mechanics::default()).expect("a face");
    let pose = Pose::opened(jaw, 15.);
    let moved = mover.settle(&vec![0.; face.muscles.len()], &pose).expect("it rests");
    let scene = Scene::new(&face);
    for view in [View::Front, View::ThreeQuarter] {
        let open = Drawing {
            view,
            displacement: Some(&moved.displacement),
            pose: pose.clone(),
            legend: false,
            ..small()
        };
        let without = Drawing { show: Show { teeth: false, ..Show::FACE }, ..open.clone() };
        assert_eq!(holes(&scene.draw(&open).expect("drawn")), 0, "{view:?}");
        assert!(holes(&scene.draw(&without).expect("drawn")) > 20, "without teeth there is no mouth");
    }
}
