//! The quadratic program over size, and whole fits of the symmetric smile on the standard face.

use std::path::Path;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use modiolus::face::standard::{Resolution, standard};
use modiolus::forward::Model;
use modiolus::inverse::{ActivatedProblem, ContactMode, Observations};
use modiolus::io::read_target;
use modiolus::qp::{self, Link, Problem, Stage, StagedActiveSet, StagedProblem};
use nalgebra::{DMatrix, DVector};

/// A bounded least-squares program of `m` activations with `2m` observations and `m` inequality rows,
/// from a fixed sequence; about a third of the bounds hold.
fn program(m: usize) -> Problem {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let map = DMatrix::from_fn(2 * m, m, |_, _| next());
    let wanted = DVector::from_fn(m, |_, _| 0.5 + 1.5 * next());
    let mut problem = Problem::unconstrained(map.tr_mul(&map), -map.tr_mul(&(&map * wanted)));
    problem.lower.fill(0.);
    problem.upper.fill(1.);
    problem.inequality = DMatrix::from_fn(m, m, |_, _| next());
    problem.inequality_limit = DVector::from_element(m, 0.5);
    problem
}

fn programs(c: &mut Criterion) {
    let mut group = c.benchmark_group("qp");
    for m in [10, 20, 40, 80] {
        let problem = program(m);
        group.bench_function(BenchmarkId::from_parameter(m), |b| b.iter(|| qp::solve(&problem)));
    }
    group.finish();
}

/// A movement of 28 muscles over 60 frames: each frame's program alone, by Clarabel and by an active set begun from that of the frame
/// before, and all frames as one program in stages.
fn frames(c: &mut Criterion) {
    let alone: Vec<Problem> = (0..60)
        .map(|frame| {
            let mut problem = program(28);
            let turned = (f64::from(frame) * 0.1).cos();
            problem
                .linear
                .iter_mut()
                .enumerate()
                .for_each(|(k, q)| *q *= if k % 3 == 0 { turned } else { 1. });
            problem.hessian += DMatrix::identity(28, 28) * 0.1;
            problem
        })
        .collect();
    let stages: Vec<Stage> = alone
        .iter()
        .map(|problem| Stage {
            hessian: problem.hessian.clone(),
            linear: problem.linear.clone(),
            lower: problem.lower.clone(),
            upper: problem.upper.clone(),
            rows: problem.inequality.clone(),
            limits: problem.inequality_limit.clone(),
        })
        .collect();
    let mut group = c.benchmark_group("60 frames of 28 muscles");
    group.sample_size(10);
    group.bench_function("each alone, Clarabel", |b| {
        b.iter(|| alone.iter().filter(|problem| qp::solve(problem).is_ok()).count());
    });
    group.bench_function("each alone, active set", |b| {
        b.iter(|| {
            let mut active = StagedActiveSet::default();
            let solved = |stage: &Stage, active: &mut StagedActiveSet| {
                let problem = StagedProblem { stages: vec![stage.clone()], links: Vec::new() };
                qp::solve_staged(&problem, active).is_some_and(|s| s.passes())
            };
            stages.iter().filter(|stage| solved(stage, &mut active)).count()
        });
    });
    let link = Link { weight: DVector::from_element(28, 1.), rows: Vec::new() };
    let whole = StagedProblem { links: vec![link; stages.len() - 1], stages };
    group.bench_function("joined in time", |b| {
        b.iter(|| qp::solve_staged(&whole, &mut StagedActiveSet::default()).is_some_and(|s| s.passes()));
    });
    group.finish();
}

fn fits(c: &mut Criterion) {
    let mut group = c.benchmark_group("symmetric smile");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("targets/symmetric_smile.toml");
    let Ok(document) = read_target(&file) else { panic!("{} cannot be read", file.display()) };
    for (name, resolution) in [("coarse", Resolution::COARSE), ("standard", Resolution::STANDARD)] {
        let face = standard(&resolution);
        let found = Observations::resolve(&document.target, &face, |_| Err(f64::INFINITY));
        let (Ok(observations), Ok(model)) =
            (found, Model::new(&face, face.contact_pairs(Default::default())))
        else {
            panic!("the standard face has every landmark of the smile")
        };
        let mode = ContactMode::Reactions;
        let problem = ActivatedProblem::new(&model, &document.target, &observations, mode);
        let rest = DVector::zeros(model.muscles().len());
        let size = format!("{name}/{}", model.n_free());
        group.bench_function(BenchmarkId::new("fixed stiffness", &size), |b| {
            b.iter(|| problem.at_fixed_stiffness(0.5).map(|p| p.solve(mode)));
        });
        group.bench_function(BenchmarkId::new("stiffening, from rest", &size), |b| {
            b.iter(|| problem.solve(rest.clone(), |_| {}));
        });
    }
    group.finish();
}

criterion_group!(benches, programs, frames, fits);
criterion_main!(benches);
