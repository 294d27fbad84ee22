//! Contact of the standard face over size: the compliance `S = G K^-1 G'` by half-solves against full solves,
//! forward contact on planes and on the true surfaces, and the inverse with contact. One thread.

use std::path::Path;
use std::time::{Duration, Instant};

use modiolus::contact::Pair;
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, ContactSearch};
use modiolus::forward::{Cholesky, Model, SparseColumn, contact_forces};
use modiolus::inverse::{ActivatedProblem, ContactFit, ContactMode, Observations, Problem, Status};
use modiolus::io::read_target;
use nalgebra::{DMatrix, DVector};

type Failure = Box<dyn std::error::Error>;

/// Contact rows of which the compliance is compared.
const ROWS: usize = 600;
/// A measurement is repeated up to this often, as long as all of them take less than
const SAMPLES: usize = 9;
/// this.
const BUDGET: Duration = Duration::from_secs(8);

/// Between the standard and the fine face: of the latter 3,612 nodes may touch, which takes 15 GB to condense and a
/// minute for one inverse at fixed stiffness, of which a fit solves dozens.
const MEDIUM: Resolution = Resolution {
    mouth_columns: 16,
    cheek_columns: 22,
    rows_above: [7, 7, 9, 12],
    rows_below: [7, 6, 18],
    layers: 4,
};

/// What is measured on one face, s.
struct Row {
    name: String,
    n_free: usize,
    n_pairs: usize,
    n_rows: usize,
    half: f64,
    full: f64,
    forces: f64,
    settle: f64,
    rounds: usize,
    inverse: f64,
    fit: f64,
}

/// Median times of `works`, s, taken in turns so that what else the machine does slows all of them alike.
fn medians<const N: usize>(mut works: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut times: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
    let begin = Instant::now();
    for sample in 0..SAMPLES {
        if sample > 0 && begin.elapsed() * (sample as u32 + 1) / sample as u32 > BUDGET {
            break;
        }
        for (work, times) in works.iter_mut().zip(&mut times) {
            let start = Instant::now();
            work();
            times.push(start.elapsed().as_secs_f64());
        }
    }
    times.map(|mut t| {
        t.sort_by(f64::total_cmp);
        (t[(t.len() - 1) / 2] + t[t.len() / 2]) / 2.
    })
}

fn column(pair: &Pair) -> SparseColumn {
    pair.row.iter().flat_map(|(n, g)| (0..3).map(move |axis| (3 * n + axis, g[axis]))).collect()
}

/// `G K^-1 G'` through the displacements of every column.
fn by_full_solves(cholesky: &Cholesky, pairs: &[Pair], forces: &[Vec<f64>]) -> DMatrix<f64> {
    let u = cholesky.displacements(forces);
    DMatrix::from_fn(pairs.len(), pairs.len(), |i, j| pairs[i].change_mm(&u[j]))
}

/// Times of half-solves and of full solves for the compliance of `pairs`, which are the same.
fn compliance(model: &Model, cholesky: &Cholesky, pairs: &[Pair]) -> Result<[f64; 2], Failure> {
    let columns: Vec<SparseColumn> = pairs.iter().map(column).collect();
    let dense = |column: &SparseColumn| {
        let mut force = vec![0.; model.n_dofs()];
        column.iter().for_each(|&(dof, value)| force[dof] += value);
        force
    };
    let forces: Vec<Vec<f64>> = columns.iter().map(dense).collect();
    let (mut half, mut full) = (DMatrix::zeros(0, 0), DMatrix::zeros(0, 0));
    let times = medians([&mut || half = cholesky.gram(&columns), &mut || {
        full = by_full_solves(cholesky, pairs, &forces);
    }]);
    let difference = (&half - &full).amax() / full.amax();
    if difference > 1e-10 {
        return Err(format!("half and full solves differ by {difference:e}").into());
    }
    Ok(times)
}

fn measure(name: &str, resolution: &Resolution) -> Result<Row, Failure> {
    let face = standard(resolution);
    let search = ContactSearch::new(&face, ContactReach::default());
    let model = Model::new(&face, search.rest().to_vec())?;
    let muscles = model.muscles();
    let stiff = model.at(&vec![0.5; muscles.len()])?;

    let all = model.pairs();
    let n_rows = ROWS.min(all.len());
    let spread: Vec<Pair> = (0..n_rows).map(|k| all[k * all.len() / n_rows].clone()).collect();
    let [half, full] = compliance(&model, stiff.cholesky(), &spread)?;

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("targets/symmetric_smile.toml");
    let target = read_target(&path)?.expand_patterns(muscles)?.target;
    let observations = Observations::resolve(&target, &face, |_| Err(f64::INFINITY))?;
    let response = stiff.response(&observations.sites);
    let contact = response.contact.as_ref().ok_or("no contact")?;
    let uniform = DVector::from_element(muscles.len(), 0.5);
    let [forces] = medians([&mut || drop(contact_forces(contact, &uniform))]);

    let smile = |n: &String| if n.starts_with("zygomaticus") || n.starts_with("risorius") { 0.7 } else { 0. };
    let activation: Vec<f64> = muscles.iter().map(smile).collect();
    let smiling = model.at(&activation)?;
    let mut settled = None;
    let [settle] = medians([&mut || settled = smiling.settle(&face, &search, &activation, None).ok()]);
    let settled = settled.filter(|s| s.settled).ok_or("the smile does not settle")?;

    let mode = ContactMode::Reactions;
    let problem = Problem::new(&target, &observations, &response)?;
    let mut first = None;
    let [inverse] = medians([&mut || first = problem.solve(mode).ok()]);
    let first = first.filter(|s| s.status == Status::Solved).ok_or("the inverse is not solved")?;

    let (model, target, observations) = (&model, &target, &observations);
    let whole = ContactFit { face: &face, search: Some(&search), model, target, observations, mode };
    let start = ActivatedProblem::new(model, target, observations, mode).start(&first);
    let mut fitted = None;
    let [fit] = medians([&mut || fitted = whole.activated(start.as_slice(), |_| {}).ok()]);
    fitted.filter(|f| f.solution.status == Status::Solved).ok_or("the fit is not solved")?;

    let (n_free, n_pairs, rounds) = (model.n_free(), all.len(), settled.rounds);
    Ok(Row { name: name.into(), n_free, n_pairs, n_rows, half, full, forces, settle, rounds, inverse, fit })
}

fn main() -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    println!(
        "Medians of at most {SAMPLES} samples on one thread; compliance of {ROWS} contact rows, or of all."
    );
    println!(
        "{:>9} {:>7} {:>6} {:>5} {:>9} {:>9} {:>6} {:>9} {:>9} {:>7} {:>9} {:>8}",
        "face",
        "free",
        "pairs",
        "rows",
        "half, ms",
        "full, ms",
        "ratio",
        "forces ms",
        "settle, s",
        "rounds",
        "inverse s",
        "fit, s"
    );
    for (name, resolution) in
        [("coarse", Resolution::COARSE), ("standard", Resolution::STANDARD), ("medium", MEDIUM)]
    {
        let r = pool.install(|| measure(name, &resolution).map_err(|e| e.to_string()))?;
        println!(
            "{:>9} {:>7} {:>6} {:>5} {:>9.1} {:>9.1} {:>6.3} {:>9.2} {:>9.3} {:>7} {:>9.3} {:>8.2}",
            r.name,
            r.n_free,
            r.n_pairs,
            r.n_rows,
            1e3 * r.half,
            1e3 * r.full,
            r.half / r.full,
            1e3 * r.forces,
            r.settle,
            r.rounds,
            r.inverse,
            r.fit
        );
    }
    Ok(())
}
