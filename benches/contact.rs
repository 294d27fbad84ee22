//! Contact compliance, forward contact and one inverse with contact of the standard face, over size.

use std::path::Path;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use modiolus::face::ContactReach;
use modiolus::face::standard::{Resolution, standard};
use modiolus::forward::{Model, contact_forces};
use modiolus::inverse::{ContactMode, Observations, Problem};
use modiolus::io::read_target;
use modiolus::mesh::Locator;
use nalgebra::DVector;

/// The resolutions swept; `MODIOLUS_BENCH=fine` adds the largest, which takes minutes.
fn names() -> Vec<String> {
    let extra = std::env::var("MODIOLUS_BENCH").unwrap_or_default();
    let extra = extra.split(',').filter(|name| !name.is_empty()).map(str::to_owned);
    ["coarse", "standard"].map(str::to_owned).into_iter().chain(extra).collect()
}

fn contact(c: &mut Criterion) {
    let mut group = c.benchmark_group("contact");
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("targets/symmetric_smile.toml");
    for name in names() {
        let Some(resolution) = Resolution::parse(&name) else { continue };
        let face = standard(&resolution);
        let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
        let Ok(Ok(document)) = read_target(&path).map(|d| d.expand_patterns(&muscles)) else { continue };
        let locator = Locator::new(&face.mesh);
        let site = |p| locator.locate(p).map(|found| found.site).ok_or(f64::INFINITY);
        let Ok(observations) = Observations::resolve(&document.target, &face, site) else { continue };
        let Ok(model) = Model::new(&face, face.contact_pairs(ContactReach::default())) else { continue };
        let Ok(stiff) = model.at(&vec![0.5; muscles.len()]) else { continue };
        let size = format!("{name}/{} contacts", model.pairs().len());

        group.bench_function(BenchmarkId::new("compliance", &size), |b| b.iter(|| stiff.response(&[])));
        let response = stiff.response(&observations.sites);
        let Some(rows) = &response.contact else { continue };
        let a = DVector::from_element(muscles.len(), 0.5);
        group.bench_function(BenchmarkId::new("forces", &size), |b| b.iter(|| contact_forces(rows, &a)));
        let Ok(problem) = Problem::new(&document.target, &observations, &response) else { continue };
        group.bench_function(BenchmarkId::new("inverse", &size), |b| {
            b.iter(|| problem.solve(ContactMode::Reactions));
        });
    }
    group.finish();
}

criterion_group!(benches, contact);
criterion_main!(benches);
