//! From markers over time to activations: a movement that is known comes back, whatever the head does and the camera loses.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use crate::common::Random;
use modiolus::certainty::Discrepancy;
use modiolus::face::{Face, Pose, Similarity, standard, standard::Resolution};
use modiolus::forward::Model;
use modiolus::forward::finite::{FaceContact, FiniteModel};
use modiolus::io::{ReadOptions, read_mapped_recording};
use modiolus::mesh::Site;
use modiolus::recording::{
    FrameStatus, JawFreedom, MarkerMap, Mechanism, Neutral, OffSkin, Recording, Subject, SubjectError,
    SubjectWarning, TrackedFrame,
};
use modiolus::study::{
    FrameIntervals, HeldStiffness, Mechanics, Mover, Stiffness, Strain, Track, TrackedFace, TrackedMoment,
};
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
/// Noise of each coordinate of markers of another mesh.
const NOISE_MM: f64 = 0.25;
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
    let corner = |side: &str| names.iter().position(|n| n == &format!("cheilion_{side}")).expect("a corner");
    let (left, right) = (corner("l"), corner("r"));
    let jaw = face.jaw.as_ref().expect("a jaw");
    let mut positions = Vec::new();
    for (frame, &t) in times_s.iter().enumerate() {
        let (a, opening_mm) = moved(face, t);
        let mut u = fixed.displacement(&a, &[]);
        u.iter_mut().zip(fixed.lifted_by(&Pose::opened(jaw, opening_mm))).for_each(|(u, lift)| *u += lift);
        let head = head(t);
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

/// One after the other: muscles, what they do at most, and how far the jaw opens with them.
const GESTURES: [(&[(&str, f64)], f64); 3] = [
    (
        &[
            ("zygomaticus_major_l", 0.3),
            ("zygomaticus_major_r", 0.2),
            ("levator_labii_superioris_l", 0.2),
            ("levator_labii_superioris_r", 0.2),
        ],
        0.,
    ),
    (
        &[
            ("depressor_labii_inferioris_l", 0.25),
            ("depressor_labii_inferioris_r", 0.25),
            ("mentalis_r", 0.1),
        ],
        6.,
    ),
    (&[("depressor_anguli_oris_l", 0.3), ("depressor_anguli_oris_r", 0.3), ("risorius_l", 0.3)], 0.),
];
/// Shares of a gesture at which the other mesh is settled; between them its points move by the polynomial through these and rest.
const SETTLED: [f64; 3] = [0.4, 0.7, 1.];

/// What another mesh of the same face does: its points and their displacements in each settled state of each gesture, done as many
/// times as strongly as `size` says.
struct Other {
    size: f64,
    names: Vec<String>,
    rest: Vec<Vec3>,
    moved: Vec<[Vec<Vec3>; 3]>,
}

impl Other {
    /// Landmarks and as many other points of the skin as make 40, on `face`, displaced as `displaced` says.
    fn new(face: &Face, size: f64, displaced: impl Fn(&[f64], &Pose) -> Vec<f64>) -> Self {
        let mut names: Vec<String> = face.landmarks.iter().map(|l| l.name.clone()).collect();
        let mut sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
        let near = |p: &Vec3| p.x.abs() < 50. && p.y > -45. && p.y < 40. && p.z > -60.;
        let skin: Vec<Site> =
            face.skin.iter().map(|&node| Site::node(node, face.mesh.points[node])).collect();
        let skin: Vec<&Site> = skin.iter().filter(|s| near(&s.position)).collect();
        while sites.len() < 40 {
            let apart =
                |p: &Vec3| sites.iter().map(|q: &Site| (p - q.position).norm()).fold(f64::INFINITY, f64::min);
            let next = skin.iter().max_by(|a, b| apart(&a.position).total_cmp(&apart(&b.position)));
            names.push(format!("skin_{}", sites.len()));
            sites.push((*next.expect("skin")).clone());
        }
        let jaw = face.jaw.as_ref().expect("a jaw");
        let settled = |(muscles, opening_mm): &(&[(&str, f64)], f64)| {
            SETTLED.map(|share| {
                let mut a = vec![0.; face.muscles.len()];
                for (name, most) in *muscles {
                    a[face.muscle_index(name).expect("a muscle")] = share * size * most;
                }
                let u = displaced(&a, &Pose::opened(jaw, share * size * opening_mm));
                sites.iter().map(|s| s.displacement(&u)).collect()
            })
        };
        let moved = GESTURES.iter().map(settled).collect();
        let rest = sites.iter().map(|s| s.position).collect();
        Self { size, names, rest, moved }
    }

    /// Share of each gesture at a time.
    fn shares(time_s: f64) -> [f64; 3] {
        let each_s = FRAMES as f64 / RATE_HZ / 3.;
        [0., 1., 2.].map(|k| {
            let at = (time_s / each_s - k).clamp(0., 1.);
            (std::f64::consts::PI * at).sin().powi(2)
        })
    }

    /// Activations of the muscles of `face` at a time.
    fn activation(&self, face: &Face, time_s: f64) -> Vec<f64> {
        let mut a = vec![0.; face.muscles.len()];
        for ((muscles, _), share) in GESTURES.iter().zip(Self::shares(time_s)) {
            for (name, most) in *muscles {
                a[face.muscle_index(name).expect("a muscle")] += share * self.size * most;
            }
        }
        a
    }

    /// Displacement of a point at a time.
    fn displacement(&self, point: usize, time_s: f64) -> Vec3 {
        let nodes = [0.].iter().chain(&SETTLED).copied().collect::<Vec<f64>>();
        let mut u = Vec3::zeros();
        for (states, share) in self.moved.iter().zip(Self::shares(time_s)) {
            for (k, state) in states.iter().enumerate() {
                let own = nodes[k + 1];
                let others = nodes.iter().filter(|node| **node != own);
                u += state[point] * others.map(|node| (share - node) / (own - node)).product::<f64>();
            }
        }
        u
    }

    /// Neutral places and the recording: a head that moves, 0.25 mm of noise, 5 % gaps and the corners of the mouth exchanged.
    fn recorded(&self, times_s: &[f64]) -> (BTreeMap<String, Vec3>, Recording) {
        let mut random = Random(5);
        let names: Vec<String> =
            self.names.iter().cloned().chain(SKULL.iter().map(|(name, _)| (*name).to_owned())).collect();
        let rest: Vec<Vec3> =
            self.rest.iter().copied().chain(SKULL.iter().map(|(_, at)| Vec3::from(*at))).collect();
        let place = |name: &str| names.iter().position(|n| n == name).expect("a marker");
        let corners = [place("cheilion_l"), place("cheilion_r")];
        let mut positions = Vec::new();
        for (frame, &t) in times_s.iter().enumerate() {
            let head = head(t);
            let mut row: Vec<Option<Vec3>> = (0..rest.len())
                .map(|k| {
                    let u = if k < self.rest.len() { self.displacement(k, t) } else { Vec3::zeros() };
                    let noise = Vec3::from_fn(|_, _| NOISE_MM * random.normal());
                    (random.unit() > 0.05).then(|| head.apply(subject(rest[k] + u)) + noise)
                })
                .collect();
            if (SWAPPED[0]..=SWAPPED[1]).contains(&frame) {
                row.swap(corners[0], corners[1]);
            }
            positions.extend(row);
        }
        let neutral = names.iter().cloned().zip(rest.iter().map(|p| subject(*p))).collect();
        (neutral, Recording::new(names, times_s.to_vec(), positions).expect("whole"))
    }
}

/// Where the subject's face is, which is 1.1 times as small.
fn subject(p: Vec3) -> Vec3 {
    p / 1.1 + Vec3::new(0., 1400., 20.)
}

/// How the head moves.
fn head(t: f64) -> Similarity {
    Similarity {
        scale: 1.,
        rotation: Rotation3::from_euler_angles(0.1 * (2. * t).sin(), 0.3 * t.sin(), 0.05 * t),
        translation: Vec3::new(30. * t, -5. * (3. * t).cos(), 12. * t),
    }
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
        let jaw = track.mechanism().jaw_mm(&frame.unknowns).expect("a jaw");
        worst_jaw = worst_jaw.max((jaw[0] - opening_mm).abs());
    }
    assert!(worst < 0.03, "activation off by {worst:.4}");
    assert!(worst_jaw < 0.05, "jaw off by {worst_jaw:.3} mm");
    let summary = track.summary(&face, &frames);
    assert!(summary.all.explained.is_some_and(|e| e > 0.9999), "{:?}", summary.all);
    assert_eq!(summary.frames[&FrameStatus::Ok], FRAMES);
}

/// What was found of the activations of another mesh.
struct Found {
    /// Root mean square error of each muscle that the intervals of every tenth frame call determined: to 20 % on the mean.
    determined: BTreeMap<String, f64>,
    /// Share of all these intervals, of muscles at rest, too, that hold the truth.
    held: f64,
}

impl Found {
    fn of(face: &Face, other: &Other, truth: &Face, strain: Strain) -> Self {
        let times = times();
        let (neutral, recording) = other.recorded(&times);
        let map = MarkerMap {
            neutral: Neutral::Positions(neutral),
            stable: SKULL.iter().map(|(name, _)| (*name).to_owned()).collect(),
            sigma_mm: NOISE_MM,
            ..MarkerMap::default()
        };
        let mut track = Track::new(face, &recording, map, HeldStiffness::At(HELD), false).expect("a subject");
        if strain == Strain::Finite {
            track = track.at_finite_strain(|_| ()).expect("a face at rest");
        }
        let swaps = &track.movement.swaps;
        assert_eq!(swaps.len(), 1, "{swaps:?}");
        assert!(swaps[0].labels.iter().all(|l| l.starts_with("cheilion")), "{swaps:?}");
        // A corner that is out of sight may hide the first or the last frame.
        assert!(swaps[0].frames.iter().zip(SWAPPED).all(|(f, g)| f.abs_diff(g) <= 1), "{swaps:?}");
        let frames = track.fit_all(|block| track.fit(block));
        assert!(frames.iter().all(|f| f.status == FrameStatus::Ok));
        if strain == Strain::Finite {
            let checked = track.check(&frames, strain, |_| ()).expect("a face that moves");
            println!("{:?} {checked:?}", track.rounds());
            assert!(checked.failed.is_empty() && checked.frames.iter().all(|f| f.rms_mm < 0.1));
        }
        let intervals = track.intervals(&frames, 10, &Discrepancy::MESH);
        assert_eq!(intervals.len(), FRAMES / 10);
        let (mut determined, mut held, mut count) = (BTreeMap::new(), 0, 0);
        for (k, name) in track.mechanism().muscles.iter().enumerate() {
            let own = truth.muscle_index(name).expect("a muscle");
            let true_value = |frame: usize| other.activation(truth, times[frame])[own];
            let width = |f: &FrameIntervals| f.intervals.max[k] - f.intervals.min[k];
            let mean_width = intervals.iter().map(width).sum::<f64>() / intervals.len() as f64;
            let square = |f: usize| (frames[f].unknowns[k] - true_value(f)).powi(2);
            let rmse = ((0..FRAMES).map(square).sum::<f64>() / FRAMES as f64).sqrt();
            let holds = |f: &&FrameIntervals| {
                (f.intervals.min[k]..=f.intervals.max[k]).contains(&true_value(f.frame))
            };
            held += intervals.iter().filter(holds).count();
            count += intervals.len();
            if mean_width <= 0.2 {
                determined.insert(name.clone(), rmse);
            }
        }
        Self { determined, held: held as f64 / count as f64 }
    }

    /// Root mean square error over all muscles that are determined.
    fn rmse(&self) -> f64 {
        self.rmse_of(self.determined.keys())
    }

    /// Root mean square error over some of them.
    fn rmse_of<'a>(&self, muscles: impl Iterator<Item = &'a String>) -> f64 {
        let squares: Vec<f64> = muscles.map(|name| self.determined[name].powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    fn assert(&self) {
        println!("{:.3} of {:?}, {:.3} held", self.rmse(), self.determined, self.held);
        assert!(self.determined.len() >= 16, "{:?}", self.determined);
        assert!(self.rmse() <= 0.05, "{:.3} of {:?}", self.rmse(), self.determined);
        assert!(self.held >= 0.93, "{:.3}", self.held);
    }
}

#[test]
fn activations_of_another_mesh_come_back() {
    let (coarse, usual) = (coarse(), standard(&Resolution::STANDARD));
    let model = Model::new(&usual, Vec::new()).expect("a model");
    let fixed = model.at(&vec![HELD; usual.muscles.len()]).expect("a stiffness");
    let linear = Other::new(&usual, 1., |a, pose| {
        let mut u = fixed.displacement(a, &[]);
        u.iter_mut().zip(fixed.lifted_by(pose)).for_each(|(u, lift)| *u += lift);
        u
    });
    Found::of(&coarse, &linear, &usual, Strain::Linear).assert();
    let finite = FiniteModel::new(&coarse, None).expect("a model");
    let settled = |a: &[f64], pose: &Pose| finite.settle(a, pose).expect("at rest").displacement().to_vec();
    Found::of(&usual, &Other::new(&coarse, 1., settled), &coarse, Strain::Linear).assert();
}

/// Twice the gestures, which strain and turn the tissue so far that a linear model takes them for other activations.
#[test]
fn a_movement_at_finite_strain_comes_back_at_finite_strain() {
    let (coarse, usual) = (coarse(), standard(&Resolution::STANDARD));
    let model = FiniteModel::new(&usual, None).expect("a model");
    let settled = |a: &[f64], pose: &Pose| model.settle(a, pose).expect("at rest").displacement().to_vec();
    let other = Other::new(&usual, 3., settled);
    let [finite, linear] =
        [Strain::Finite, Strain::Linear].map(|strain| Found::of(&coarse, &other, &usual, strain));
    let both = || finite.determined.keys().filter(|name| linear.determined.contains_key(*name));
    println!("{:.3} of {:?}, {:.3} held", finite.rmse(), finite.determined, finite.held);
    println!(
        "linear {:.3}, {:.3} of the same; {:.3} held",
        linear.rmse(),
        linear.rmse_of(both()),
        linear.held
    );
    assert!(finite.rmse() <= 0.05, "{:.3}", finite.rmse());
    assert!(finite.held >= 0.95, "{:.3}", finite.held);
    assert!(both().count() >= 12, "{:?}", finite.determined);
    assert!(finite.rmse_of(both()) < 0.6 * linear.rmse_of(both()), "{:.3}", linear.rmse_of(both()));
}

/// About a face at rest, teeth and lips included, a mechanism goes on as the face does that is settled a little farther.
#[test]
fn a_mechanism_about_a_face_at_rest_goes_on_as_the_face_does() {
    const STEP: f64 = 2e-3;
    let face = coarse();
    let m = face.muscles.len();
    let contact = FaceContact::new(&face).expect("surfaces that are apart");
    let model = FiniteModel::new(&face, Some(contact)).expect("a model");
    let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
    let free = Model::new(&face, Vec::new()).expect("a model");
    let fixed = free.at(&vec![HELD; m]).expect("a stiffness");
    let linear = Mechanism::new(&fixed, &sites, Some(JawFreedom::default()));
    let mut x = vec![0.; m + 3];
    for (name, value) in [("zygomaticus_major_l", 0.5), ("zygomaticus_major_r", 0.4), ("risorius_l", 0.3)] {
        x[face.muscle_index(name).expect("a muscle")] = value;
    }
    (x[m], x[m + 1], x[m + 2]) = (0.3, 0.2, -0.3);
    let rest = model.settle(&x[..m], &linear.pose(&face, &x)).expect("at rest");
    assert!(rest.contact().is_some_and(|touched| !touched.points.is_empty()));
    let about = linear.about_rest(&model, &rest, &sites, &x).expect("a tangent");
    let observed = |u: &[f64]| -> Vec<f64> {
        sites.iter().flat_map(|site| <[f64; 3]>::from(site.displacement(u))).collect()
    };
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0., f64::max);
    let there = about.observed_mm(&x).expect("no contact of its own");
    assert!(apart(there.as_slice(), &observed(rest.displacement())) < 1e-9);
    let zygomaticus = face.muscle_index("zygomaticus_major_l").expect("a muscle");
    let orbicularis = face.muscle_index("orbicularis_oris_marginalis").expect("a muscle");
    for unknown in [zygomaticus, orbicularis, m, m + 1, m + 2] {
        let [ahead, behind] = [STEP, -STEP].map(|step| {
            let mut x = x.clone();
            x[unknown] += step;
            // The orbicularis rests, and a muscle does not push.
            x[unknown] = if unknown < m { x[unknown].max(0.) } else { x[unknown] };
            let anew = model.settle_from(&rest, &x[..m], &linear.pose(&face, &x)).expect("at rest");
            (observed(anew.displacement()), about.observed_mm(&x).expect("no contact of its own"))
        });
        let change = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let anew = change(&ahead.0, &behind.0);
        let told = change(ahead.1.as_slice(), behind.1.as_slice());
        let size = anew.iter().fold(0., |most: f64, u| most.max(u.abs()));
        println!("{unknown}: {:.1e} of {size:.3} mm", apart(&anew, &told));
        assert!(apart(&anew, &told) < 0.01 * size, "{unknown}: {:e} of {size}", apart(&anew, &told));
    }
}

/// The face settled under its own stiffness, muscle by muscle as it is active, is what a stiffness that follows is to describe.
#[test]
fn a_stiffness_that_follows_describes_the_face_that_stiffens() {
    let face = coarse();
    let mechanics = Mechanics { strain: Strain::Linear, stiffness: Stiffness::Activated, contact: false };
    let mover = Mover::new(&face, mechanics).expect("a face that moves");
    // Twice as much as the gestures, so that stiffness matters.
    let other = Other::new(&face, 1., |a, pose| {
        let a: Vec<f64> = a.iter().map(|a| 2. * a).collect();
        mover.settle(&a, pose).expect("at rest").displacement
    });
    let (neutral, recording) = other.recorded(&times());
    let map = MarkerMap {
        neutral: Neutral::Positions(neutral),
        stable: SKULL.iter().map(|(name, _)| (*name).to_owned()).collect(),
        sigma_mm: NOISE_MM,
        ..MarkerMap::default()
    };
    let [held, follows] = [HeldStiffness::Mean, HeldStiffness::Follow].map(|stiffness| {
        let track = Track::new(&face, &recording, map.clone(), stiffness, false).expect("a subject");
        let frames = track.fit_all(|block| track.fit(block));
        assert!(frames.iter().all(|f| f.status == FrameStatus::Ok));
        let told = AtomicUsize::new(0);
        let checked = track.check(&frames, Strain::Linear, |frames| _ = told.fetch_add(frames, Relaxed));
        let checked = checked.expect("a face that moves");
        assert_eq!(told.into_inner(), track.blocks().len());
        assert!(checked.failed.is_empty() && checked.frames.len() == 1, "{checked:?}");
        let strongest = checked.frames[0].frame;
        let x = &frames[strongest].unknowns;
        let field = track.displacements(&frames, &[strongest], |_| ()).expect("solved").remove(0);
        let pose = track.mechanism().pose(&face, x);
        let anew = mover.settle(&x[..face.muscles.len()], &pose).expect("at rest").displacement;
        let apart = |field: &[f64]| field.iter().zip(&anew).map(|(a, b)| (a - b).abs()).fold(0., f64::max);
        // As a page shows it, which knows the activations and the jaw alone.
        let m = face.muscles.len();
        let held = (stiffness != HeldStiffness::Follow).then_some(&track.held[..]);
        let shown = TrackedFace::new(&face, Strain::Linear, held, false).expect("a face that moves");
        let jaw_mm = track.mechanism().jaw_mm(x).expect("a jaw");
        let shown =
            shown.at(&[TrackedMoment { activation: &x[..m], jaw_mm }], |_| ()).expect("solved").remove(0).0;
        assert!((apart(&shown) - apart(&field)).abs() < 1e-9, "{:e} {:e}", apart(&shown), apart(&field));
        (checked.frames[0], apart(&field))
    });
    assert!(follows.0.rms_mm < 0.05, "{:?}", follows.0);
    assert!(follows.0.rms_mm < 0.3 * held.0.rms_mm, "{:?} {:?}", follows.0, held.0);
    // The whole face is shown at each frame's own stiffness.
    assert!(follows.1 < 1e-9 && held.1 > 0.1, "{:e} {:e}", follows.1, held.1);
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
fn every_frame_has_a_status() {
    let face = coarse();
    let times = times()[..60].to_vec();
    let (neutral, recording) = recorded(&face, &times);
    let m = recording.names().len();
    let on_face = m - SKULL.len();
    let mut positions: Vec<Option<Vec3>> = (0..60).flat_map(|f| recording.frame(f).to_vec()).collect();
    positions[20 * m..20 * m + on_face].fill(None);
    // 15 components of 28 muscles.
    positions[30 * m + 5..30 * m + on_face].fill(None);
    // The head is out of sight for longer than its place is interpolated.
    (40..58).for_each(|f| positions[f * m + on_face..(f + 1) * m].fill(None));
    let recording = Recording::new(recording.names().to_vec(), times, positions).expect("whole");
    let map = MarkerMap {
        neutral: Neutral::Positions(neutral),
        stable: SKULL.iter().map(|(name, _)| (*name).to_owned()).collect(),
        ..MarkerMap::default()
    };
    let track = Track::new(&face, &recording, map, HeldStiffness::At(HELD), false).expect("a subject");
    let frames = track.fit_all(|block| track.fit(block));
    assert_eq!(frames.len(), 60);
    for (f, frame) in frames.iter().enumerate() {
        let status = match f {
            20 | 40..58 => FrameStatus::NoData,
            30 => FrameStatus::Underdetermined,
            _ => FrameStatus::Ok,
        };
        assert_eq!(frame.status, status, "{f}");
        assert!(frame.unknowns.iter().all(|x| x.is_finite()), "{f}");
    }
    // Nothing is said of a frame in which nothing is seen.
    let intervals = track.intervals(&frames, 10, &Discrepancy::MESH);
    let with: Vec<usize> = intervals.iter().map(|i| i.frame).collect();
    assert_eq!(with, [0, 10, 30]);
    let width = |k: usize| {
        let i = &intervals[k].intervals;
        (&i.max - &i.min).rows(0, track.mechanism().muscles.len()).mean()
    };
    assert!(width(2) > 1.3 * width(1), "fewer markers say less: {:.2} {:.2}", width(2), width(1));
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
    let named = files.map(|p| (p.file_name().expect("a name").to_string_lossy().into_owned(), text(&p)));
    // A file that had no name yet when its process was killed stays beside the result, hidden, and is none of it.
    named.filter(|(name, _)| !name.ends_with(".tmp")).collect()
}

#[test]
fn a_run_that_is_killed_goes_on_and_ends_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), &coarse(), 900);
    let start = Instant::now();
    assert!(program(folder.path(), "whole").status().expect("run").success());
    let whole_run = start.elapsed();
    let whole = result(&folder.path().join("whole"));
    for name in ["activations.csv", "activations.sto", "frames.csv", "residuals.csv", "summary.json"] {
        assert!(whole.contains_key(name), "{name}");
    }
    let blocks = || std::fs::read_dir(folder.path().join("killed/.blocks")).map_or(0, Iterator::count);
    let (mut random, mut kept) = (Random(9), 0);
    for k in 0..10 {
        let before = blocks();
        let moment = whole_run.mul_f64(0.7 * random.unit());
        let mut child = program(folder.path(), "killed").spawn().expect("run");
        // At any moment, and every other time some way after a block was kept.
        let start = Instant::now();
        let is_due = || if k % 2 == 0 { start.elapsed() >= moment } else { blocks() > before };
        while child.try_wait().expect("a state").is_none() && !is_due() {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(random.below(20) as u64));
        let _ = child.kill();
        child.wait().expect("ended");
        kept += usize::from(blocks() > 0);
    }
    assert!(program(folder.path(), "killed").status().expect("run").success());
    assert_eq!(result(&folder.path().join("killed")), whole);
    assert!(kept > 0, "killed too early each time");
}

/// The real recording `name` on the standard face without contact, by the map of the examples in `folder`.
fn tracked(folder: &str, name: &str) -> (Track, Vec<TrackedFrame>, Recording) {
    let data = PathBuf::from(std::env::var_os("MODIOLUS_DATA").expect("MODIOLUS_DATA"));
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(folder);
    // The map names its neutral positions where the data are by default.
    let text = std::fs::read_to_string(examples.join("map.toml")).expect("a map");
    let here = data.canonicalize().expect("the data");
    let text = text.replace("../../../shared/data", &here.to_string_lossy());
    let copy = tempfile::tempdir().expect("a folder");
    let map = copy.path().join("map.toml");
    std::fs::write(&map, text).expect("written");
    let read = read_mapped_recording(&data.join(name), Some(&map), &ReadOptions::default()).expect("read");
    let recording = read.document.recording;
    let face = standard(&Resolution::STANDARD);
    let track = Track::new(&face, &recording, read.map, HeldStiffness::At(HELD), false).expect("a subject");
    let frames = track.fit_all(|block| track.fit(block));
    (track, frames, recording)
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn speech_is_tracked_alike_from_both_of_its_files() {
    let [(track, frames, _), (_, same, _)] =
        ["recording/speech.c3d", "recording/speech.trc"].map(|name| tracked("speech", name));
    assert_eq!((frames.len(), same.len()), (900, 900));
    let chin = track.subject.bound.iter().position(|b| b.label == "gnathion").expect("the chin");
    let (mut pairs, mut worst) = (Vec::new(), 0_f64);
    for (f, (one, other)) in frames.iter().zip(&same).enumerate() {
        assert_eq!((one.status, other.status), (FrameStatus::Ok, FrameStatus::Ok), "{f}");
        let apart = one.unknowns.iter().zip(&other.unknowns).map(|(a, b)| (a - b).abs());
        worst = apart.fold(worst, f64::max);
        let jaw = track.mechanism().jaw_mm(&one.unknowns).expect("a jaw");
        if let Some(u) = track.movement.frame(f)[chin] {
            pairs.push([jaw[0], u.norm()]);
        }
    }
    // The digits of the text are 0.001 mm.
    assert!(worst < 0.02, "{worst:.4}");
    let mean = |k: usize| pairs.iter().map(|p| p[k]).sum::<f64>() / pairs.len() as f64;
    let product = |i: usize, j: usize| {
        let (a, b) = (mean(i), mean(j));
        pairs.iter().map(|p| (p[i] - a) * (p[j] - b)).sum::<f64>()
    };
    let correlation = product(0, 1) / (product(0, 0) * product(1, 1)).sqrt();
    assert!(correlation > 0.95, "jaw and chin: {correlation:.3}");
    let summary = track.summary(&standard(&Resolution::STANDARD), &frames);
    assert!(summary.all.explained.is_some_and(|e| e > 0.85) && summary.regions.len() >= 5, "{summary:?}");
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn expressions_of_a_scan_come_in_by_a_table_and_a_map() {
    let (track, frames, recording) = tracked("ict", "ict_scan/expressions.csv");
    let names = recording.frame_names().expect("names");
    let stronger = |name: &str, left: &str, right: &str| {
        let frame = &frames[names.iter().position(|n| n == name).expect("an expression")];
        assert_eq!(frame.status, FrameStatus::Ok, "{name}");
        let of = |muscle: &str| {
            let k = track.mechanism().muscles.iter().position(|m| m == muscle).expect("a muscle");
            frame.unknowns[k]
        };
        of(left) > of(right) + 0.2
    };
    let (l, r) = ("zygomaticus_major_l", "zygomaticus_major_r");
    assert!(stronger("mouthSmile_L", l, r) && stronger("mouthSmile_R", r, l));
    let (l, r) = ("depressor_labii_inferioris_l", "depressor_labii_inferioris_r");
    assert!(stronger("mouthLowerDown_L", l, r) && stronger("mouthLowerDown_R", r, l));
}
