//! Assembly, factorisation, activation map and contact response of the standard face, over size.

use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use modiolus::face::Face;
use modiolus::face::standard::{Resolution, standard};
use modiolus::forward::{Cholesky, Model, SymbolicFactor, assemble};
use modiolus::mesh::Site;

/// The resolutions swept; `MODIOLUS_BENCH=fine` adds the largest, which takes minutes.
fn faces() -> Vec<(String, Face)> {
    let extra = std::env::var("MODIOLUS_BENCH").unwrap_or_default();
    ["coarse", "standard"]
        .into_iter()
        .chain(extra.split(',').filter(|name| !name.is_empty()))
        .filter_map(|name| Some((name.to_owned(), standard(&Resolution::parse(name)?))))
        .collect()
}

fn forward(c: &mut Criterion) {
    let mut group = c.benchmark_group("forward");
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    for (name, face) in faces() {
        let pairs = face.contact_pairs(Default::default());
        let model = match Model::new(&face, pairs) {
            Ok(model) => model,
            Err(error) => panic!("{name}: {error}"),
        };
        let activation = vec![0.5; face.muscles.len()];
        let sites: Vec<Site> = face.landmarks.iter().map(|l| l.site.clone()).collect();
        let size = format!("{name}/{}", model.n_free());

        group.bench_function(BenchmarkId::new("assembly", &size), |b| {
            b.iter(|| assemble(&face.mesh, face.tissue, face.muscle_tissue, &face.muscles));
        });
        let fixed: Vec<bool> = {
            let mut fixed = vec![true; model.n_dofs()];
            model.symbolic().free().iter().for_each(|&dof| fixed[dof] = false);
            fixed
        };
        group.bench_function(BenchmarkId::new("ordering and analysis", &size), |b| {
            b.iter(|| SymbolicFactor::new(model.stiffness().pattern(), &fixed));
        });
        let values = model.stiffness().at(&activation);
        group.bench_function(BenchmarkId::new("numeric factorisation", &size), |b| {
            b.iter(|| Cholesky::new(Arc::clone(model.symbolic()), &values));
        });
        let Ok(stiff) = model.at(&activation) else { continue };
        group.bench_function(BenchmarkId::new("full map", &size), |b| b.iter(|| stiff.map()));
        let label = format!("{size}/{} contacts", model.pairs().len());
        group.bench_function(BenchmarkId::new("response with contact", label), |b| {
            b.iter(|| stiff.response(&sites));
        });
    }
    group.finish();
}

criterion_group!(benches, forward);
criterion_main!(benches);
