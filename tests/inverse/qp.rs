//! VERIFICATION 20, 21 and 23: certificates, independent oracles, proofs; and the programs that solvers
//! get wrong without saying so.

#![allow(clippy::unwrap_used)] // A test that unwraps fails where it should.

use crate::common::Random;
use modiolus::qp::{self, Answer, Certificate, Data, Point, Problem, ProblemError, Solution};
use nalgebra::{DMatrix, DVector};

fn solved(problem: &Problem) -> Solution {
    match qp::solve(problem).unwrap() {
        Answer::Solved(solution) => solution,
        other => panic!("{other:?}"),
    }
}

/// A feasible convex program with some rank-deficient curvature, redundant rows and fixed variables.
fn random_program(random: &mut Random) -> Problem {
    let n = 1 + random.below(12);
    let rank = 1 + random.below(n + 2);
    let factor = random.matrix(rank, n);
    let x0 = random.vector(n);
    let mut problem = Problem::unconstrained(factor.tr_mul(&factor), DVector::zeros(n));
    // A gradient in the range of P keeps the program bounded where nothing else does.
    problem.linear = factor.tr_mul(&random.vector(rank));
    problem.constant = random.normal();
    let p = random.below(n);
    problem.equality = random.matrix(p, n);
    if p > 1 && random.below(3) == 0 {
        let copy = problem.equality.row(0) * 2.0;
        problem.equality.row_mut(p - 1).copy_from(&copy);
    }
    problem.equality_value = &problem.equality * &x0;
    let g = random.below(2 * n + 1);
    problem.inequality = random.matrix(g, n);
    if g > 1 && random.below(3) == 0 {
        let copy = problem.inequality.row(0).into_owned();
        problem.inequality.row_mut(g - 1).copy_from(&copy);
    }
    let slack = DVector::from_fn(g, |_, _| if random.below(3) == 0 { 0.0 } else { random.unit() });
    problem.inequality_limit = &problem.inequality * &x0 + slack;
    for j in 0..n {
        match random.below(5) {
            0 => problem.lower[j] = x0[j] - random.unit(),
            1 => problem.upper[j] = x0[j] + random.unit(),
            2 => {
                problem.lower[j] = x0[j];
                problem.upper[j] = x0[j];
            }
            3 => {
                problem.lower[j] = x0[j] - random.unit();
                problem.upper[j] = x0[j] + random.unit();
            }
            _ => {}
        }
    }
    problem
}

/// Diagonal factors `x = D x^`, of both sorts of rows and of the objective.
struct Units {
    variable: DVector<f64>,
    equality: DVector<f64>,
    inequality: DVector<f64>,
    objective: f64,
}

impl Units {
    fn random(random: &mut Random, problem: &Problem, decades: f64) -> Self {
        let mut factors =
            |n: usize| DVector::from_fn(n, |_, _| 10_f64.powf(random.within(-decades, decades)));
        Self {
            variable: factors(problem.n_variables()),
            equality: factors(problem.equality.nrows()),
            inequality: factors(problem.inequality.nrows()),
            objective: factors(1)[0].powi(2),
        }
    }

    fn apply(&self, base: &Problem) -> Problem {
        let mut problem = base.clone();
        let d = &self.variable;
        problem.hessian =
            DMatrix::from_fn(d.len(), d.len(), |i, j| self.objective * base.hessian[(i, j)] / (d[i] * d[j]));
        problem.linear = base.linear.component_div(d) * self.objective;
        problem.constant *= self.objective;
        for j in 0..d.len() {
            for i in 0..self.equality.len() {
                problem.equality[(i, j)] *= self.equality[i] / d[j];
            }
            for i in 0..self.inequality.len() {
                problem.inequality[(i, j)] *= self.inequality[i] / d[j];
            }
        }
        problem.equality_value.component_mul_assign(&self.equality);
        problem.inequality_limit.component_mul_assign(&self.inequality);
        problem.lower.component_mul_assign(d);
        problem.upper.component_mul_assign(d);
        problem
    }

    fn undo(&self, point: &Point) -> Point {
        let c = self.objective;
        Point {
            x: point.x.component_div(&self.variable),
            equality: point.equality.component_mul(&self.equality) / c,
            inequality: point.inequality.component_mul(&self.inequality) / c,
            lower: point.lower.component_mul(&self.variable) / c,
            upper: point.upper.component_mul(&self.variable) / c,
        }
    }
}

/// Largest KKT residual of `point`, written without the library's certificate: every condition one by
/// one, complementarity product by product, against the size of `x` and of the multipliers.
fn kkt(problem: &Problem, point: &Point) -> f64 {
    let size = 1.0 + point.x.amax();
    let force = 1.0 + point.equality.amax().max(point.inequality.amax()).max(problem.linear.amax()) + size;
    let mut worst = 0.0_f64;
    for i in 0..problem.equality.nrows() {
        let value: f64 = (0..point.x.len()).map(|j| problem.equality[(i, j)] * point.x[j]).sum();
        worst = worst.max((value - problem.equality_value[i]).abs() / size);
    }
    for i in 0..problem.inequality.nrows() {
        let value: f64 = (0..point.x.len()).map(|j| problem.inequality[(i, j)] * point.x[j]).sum();
        let slack = problem.inequality_limit[i] - value;
        worst = worst.max(-slack / size).max(-point.inequality[i] / force);
        worst = worst.max((slack * point.inequality[i]).abs() / (size * force));
    }
    for j in 0..point.x.len() {
        for (slack, z) in
            [(point.x[j] - problem.lower[j], point.lower[j]), (problem.upper[j] - point.x[j], point.upper[j])]
        {
            worst = worst.max(-slack / size).max(-z / force);
            let product = if slack.is_finite() { slack * z } else { z };
            worst = worst.max(product.abs() / (size * force));
        }
        let mut slope = problem.linear[j] - point.lower[j] + point.upper[j];
        slope += (0..point.x.len()).map(|i| problem.hessian[(j, i)] * point.x[i]).sum::<f64>();
        slope +=
            (0..problem.equality.nrows()).map(|i| problem.equality[(i, j)] * point.equality[i]).sum::<f64>();
        slope += (0..problem.inequality.nrows())
            .map(|i| problem.inequality[(i, j)] * point.inequality[i])
            .sum::<f64>();
        worst = worst.max(slope.abs() / force);
    }
    worst
}

#[test]
fn every_answer_called_solved_satisfies_kkt() {
    let mut random = Random(20);
    let (mut worst, mut missed) = (0.0_f64, 0);
    for trial in 0..1500 {
        let base = random_program(&mut random);
        let decades = [0.0, 2.0, 4.0][trial % 3];
        let units = Units::random(&mut random, &base, decades);
        let problem = units.apply(&base);
        match qp::solve(&problem).unwrap() {
            Answer::Solved(solution) => {
                assert!(solution.certificate.passes());
                let residual = kkt(&base, &units.undo(&solution.point));
                assert!(residual <= 1e-9, "program {trial}: {residual:e} with {:?}", solution.certificate);
                worst = worst.max(residual);
            }
            Answer::NotConverged(_) => missed += 1,
            other => panic!("program {trial} is feasible and bounded, not {other:?}"),
        }
    }
    eprintln!("worst residual {worst:e}, not converged {missed} of 1500");
    assert!(missed <= 15, "{missed} of 1500 not converged");
}

/// The optimum of a strictly convex program by trying every active set.
fn exhaustive(problem: &Problem) -> DVector<f64> {
    let n = problem.n_variables();
    let g = problem.inequality.nrows();
    let p = problem.equality.nrows();
    let mut best: Option<(f64, DVector<f64>)> = None;
    for code in 0..3_usize.pow(n as u32) << g {
        let (rows, mut holds) = (code & ((1 << g) - 1), code >> g);
        let mut equations: Vec<(DVector<f64>, f64)> =
            (0..p).map(|i| (problem.equality.row(i).transpose(), problem.equality_value[i])).collect();
        for i in (0..g).filter(|i| rows >> i & 1 == 1) {
            equations.push((problem.inequality.row(i).transpose(), problem.inequality_limit[i]));
        }
        for j in 0..n {
            let bound = [None, Some(problem.lower[j]), Some(problem.upper[j])][holds % 3];
            holds /= 3;
            if let Some(bound) = bound {
                let mut unit = DVector::zeros(n);
                unit[j] = 1.0;
                equations.push((unit, bound));
            }
        }
        if equations.len() > n || equations.iter().any(|(_, v)| v.is_infinite()) {
            continue;
        }
        let k = n + equations.len();
        let mut matrix = DMatrix::zeros(k, k);
        let mut value = DVector::zeros(k);
        matrix.view_mut((0, 0), (n, n)).copy_from(&problem.hessian);
        value.rows_mut(0, n).copy_from(&-&problem.linear);
        for (i, (row, limit)) in equations.iter().enumerate() {
            matrix.view_mut((0, n + i), (n, 1)).copy_from(row);
            matrix.view_mut((n + i, 0), (1, n)).copy_from(&row.transpose());
            value[n + i] = *limit;
        }
        let Some(x) = matrix.full_piv_lu().solve(&value).map(|v| v.rows(0, n).into_owned()) else { continue };
        let feasible = (&problem.equality * &x - &problem.equality_value).iter().all(|r| r.abs() < 1e-8)
            && (&problem.inequality * &x - &problem.inequality_limit).iter().all(|r| *r < 1e-8)
            && (0..n).all(|j| x[j] > problem.lower[j] - 1e-8 && x[j] < problem.upper[j] + 1e-8);
        let value = problem.objective(&x);
        if feasible && best.as_ref().is_none_or(|(b, _)| value < *b) {
            best = Some((value, x));
        }
    }
    best.unwrap().1
}

#[test]
fn agrees_with_every_active_set_tried() {
    let mut random = Random(21);
    for _ in 0..120 {
        let n = 1 + random.below(5);
        let mut problem = Problem::unconstrained(DMatrix::zeros(n, n), random.vector(n) * 2.0);
        let factor = random.matrix(n + 1, n);
        problem.hessian = factor.tr_mul(&factor) + DMatrix::identity(n, n) * 0.1;
        let x0 = DVector::from_fn(n, |_, _| random.unit());
        problem.lower.fill(0.0);
        problem.upper.fill(1.0);
        let g = random.below(4);
        problem.inequality = random.matrix(g, n);
        problem.inequality_limit =
            &problem.inequality * &x0 + DVector::from_fn(g, |_, _| 0.1 * random.unit());
        if n > 2 && random.below(2) == 0 {
            problem.equality = random.matrix(1, n);
            problem.equality_value = &problem.equality * &x0;
        }
        let difference = (solved(&problem).point.x - exhaustive(&problem)).amax();
        assert!(difference < 1e-7, "{difference:e}");
    }
}

#[test]
fn agrees_with_every_active_set_of_eight_muscles() {
    let mut random = Random(8);
    for _ in 0..4 {
        let factor = random.matrix(20, 8);
        let mut problem =
            Problem::unconstrained(factor.tr_mul(&factor), factor.tr_mul(&random.vector(20)) * 3.0);
        problem.lower.fill(0.0);
        problem.upper.fill(1.0);
        let difference = (solved(&problem).point.x - exhaustive(&problem)).amax();
        assert!(difference < 1e-10, "{difference:e}");
    }
}

/// Cyclic exact minimisation over one variable at a time, which converges for strictly convex `P`.
fn bounded_least_squares(j: &DMatrix<f64>, target: &DVector<f64>) -> DVector<f64> {
    let (p, q) = (j.tr_mul(j), -j.tr_mul(target));
    let mut x = DVector::from_element(p.nrows(), 0.5);
    for _ in 0..200_000 {
        let before = x.clone();
        for k in 0..x.len() {
            let slope = p.row(k).transpose().dot(&x) + q[k];
            x[k] = (x[k] - slope / p[(k, k)]).clamp(0.0, 1.0);
        }
        if (&x - before).amax() < 1e-15 {
            break;
        }
    }
    x
}

#[test]
fn agrees_with_coordinate_descent_on_bounded_least_squares() {
    let mut random = Random(22);
    let mut exact = 0;
    for _ in 0..60 {
        let m = 2 + random.below(23);
        let j = random.matrix(2 * m + 5, m);
        let target = &j * DVector::from_fn(m, |_, _| random.within(-0.7, 1.7)) + random.vector(2 * m + 5);
        let mut problem = Problem::unconstrained(j.tr_mul(&j), -j.tr_mul(&target));
        problem.lower.fill(0.0);
        problem.upper.fill(1.0);
        let (x, oracle) = (solved(&problem).point.x, bounded_least_squares(&j, &target));
        assert!((&x - &oracle).amax() < 1e-9, "{:e}", (&x - &oracle).amax());
        for k in 0..m {
            if oracle[k] == 0.0 || oracle[k] == 1.0 {
                assert_eq!(x[k], oracle[k], "a bound is met exactly");
                exact += 1;
            }
        }
    }
    assert!(exact > 100, "{exact}");
}

#[test]
fn tiny_objectives_are_not_taken_for_zero() {
    let mut problem = Problem::unconstrained(
        DMatrix::from_row_slice(2, 2, &[2.0, 0.5, 0.5, 1.0]),
        DVector::from_vec(vec![-1.0, -0.3]),
    );
    problem.lower.fill(0.0);
    problem.upper.fill(1.0);
    let reference = solved(&problem).point.x;
    for factor in [1e-12, 1e-100, 1e12, 1e100] {
        let mut scaled = problem.clone();
        scaled.hessian *= factor;
        scaled.linear *= factor;
        assert!((solved(&scaled).point.x - &reference).amax() < 1e-14, "{factor:e}");
    }
}

#[test]
fn infeasible_programs_carry_a_proof() {
    let mut random = Random(23);
    for trial in 0..200 {
        let mut problem = random_program(&mut random);
        let n = problem.n_variables();
        // A row that contradicts a positive combination of others: G x <= h and -w'G x <= -w'h - 1.
        let weights = DVector::from_fn(problem.inequality.nrows(), |_, _| random.unit());
        let mixed = DVector::from_fn(problem.equality.nrows(), |_, _| random.normal());
        let row = problem.inequality.tr_mul(&weights) + problem.equality.tr_mul(&mixed);
        let limit = problem.inequality_limit.dot(&weights) + problem.equality_value.dot(&mixed);
        let k = problem.inequality.nrows();
        problem.inequality = problem.inequality.insert_row(k, 0.0);
        for j in 0..n {
            problem.inequality[(k, j)] = -row[j];
        }
        problem.inequality_limit = problem.inequality_limit.push(-limit - random.within(0.1, 2.0));
        let Answer::Infeasible(proof) = qp::solve(&problem).unwrap() else { panic!("program {trial}") };
        let z = &proof.multipliers;
        let value = problem.equality_value.dot(&z.equality) + problem.inequality_limit.dot(&z.inequality)
            - (0..n).filter(|&j| z.lower[j] != 0.0).map(|j| problem.lower[j] * z.lower[j]).sum::<f64>()
            + (0..n).filter(|&j| z.upper[j] != 0.0).map(|j| problem.upper[j] * z.upper[j]).sum::<f64>();
        let force = problem.equality.tr_mul(&z.equality) + problem.inequality.tr_mul(&z.inequality)
            - &z.lower
            + &z.upper;
        assert!(value < 0.0, "program {trial}: {value}");
        assert!(force.amax() / -value < 1e-7, "program {trial}: {:e}", force.amax() / -value);
        assert!(proof.residual <= 1e-8);
        assert!(z.inequality.min() >= 0.0 && z.lower.min() >= 0.0 && z.upper.min() >= 0.0);
    }
}

#[test]
fn unbounded_programs_carry_a_direction() {
    let mut random = Random(24);
    for trial in 0..200 {
        let n = 2 + random.below(8);
        // P and G vanish along d, the gradient falls along it.
        let direction = DVector::from_fn(n, |_, _| random.unit() + 0.1);
        let project = |m: DMatrix<f64>| {
            let along = &m * &direction / direction.norm_squared();
            m - along * direction.transpose()
        };
        let factor = project(random.matrix(n, n));
        let mut problem = Problem::unconstrained(factor.tr_mul(&factor), random.vector(n));
        problem.linear -= &direction * (problem.linear.dot(&direction) + 1.0) / direction.norm_squared();
        problem.inequality = project(random.matrix(2, n));
        problem.inequality_limit = DVector::from_element(2, 1.0);
        problem.lower[0] = -1.0;
        let Answer::Unbounded(proof) = qp::solve(&problem).unwrap() else { panic!("program {trial}") };
        let d = &proof.direction;
        let fall = -problem.linear.dot(d);
        assert!(fall > 0.0);
        assert!((&problem.hessian * d).amax() / fall < 1e-7, "program {trial}");
        assert!((&problem.inequality * d).max() / fall < 1e-7 && d[0] >= 0.0, "program {trial}");
    }
}

#[test]
fn degenerate_programs() {
    // Nothing to choose.
    let empty = Problem::unconstrained(DMatrix::zeros(0, 0), DVector::zeros(0));
    assert_eq!(solved(&empty).point.x.len(), 0);
    let mut contradiction = empty.clone();
    contradiction.equality = DMatrix::zeros(1, 0);
    contradiction.equality_value = DVector::from_element(1, 2.0);
    assert!(matches!(qp::solve(&contradiction).unwrap(), Answer::Infeasible(_)));
    let mut contradiction = empty;
    contradiction.inequality = DMatrix::zeros(2, 0);
    contradiction.inequality_limit = DVector::from_vec(vec![1.0, -2.0]);
    let Answer::Infeasible(proof) = qp::solve(&contradiction).unwrap() else { panic!() };
    assert_eq!(proof.multipliers.inequality.as_slice(), [0.0, 0.5]);
    // No constraint at all.
    let problem = Problem::unconstrained(DMatrix::identity(3, 3), DVector::from_vec(vec![1.0, -2.0, 0.0]));
    assert!((solved(&problem).point.x - DVector::from_vec(vec![-1.0, 2.0, 0.0])).amax() < 1e-14);
    // No objective.
    let mut problem = Problem::unconstrained(DMatrix::zeros(2, 2), DVector::zeros(2));
    problem.lower.fill(0.25);
    problem.upper.fill(1.0);
    assert_eq!(solved(&problem).objective, 0.0);
    // Everything fixed.
    let mut problem = Problem::unconstrained(DMatrix::identity(2, 2), DVector::from_vec(vec![3.0, -3.0]));
    problem.lower.fill(0.5);
    problem.upper.fill(0.5);
    let solution = solved(&problem);
    assert_eq!(solution.point.x.as_slice(), [0.5, 0.5]);
    assert!((solution.point.lower[0] - 3.5).abs() < 1e-14 && (solution.point.upper[1] - 2.5).abs() < 1e-14);
    // Crossing bounds.
    problem.lower[1] = 0.75;
    assert!(matches!(qp::solve(&problem).unwrap(), Answer::Infeasible(_)));
    // One row many times over, active.
    let mut problem = Problem::unconstrained(DMatrix::identity(2, 2), DVector::from_vec(vec![-2.0, -2.0]));
    problem.inequality = DMatrix::from_element(7, 2, 1.0);
    problem.inequality_limit = DVector::from_element(7, 1.0);
    let solution = solved(&problem);
    assert!((solution.point.x - DVector::from_element(2, 0.5)).amax() < 1e-14);
    assert!((solution.point.inequality.sum() - 1.5).abs() < 1e-12);
}

#[test]
fn malformed_programs_are_refused_by_place_and_value() {
    let good = Problem::unconstrained(DMatrix::identity(2, 2), DVector::zeros(2));
    let refused = |change: &dyn Fn(&mut Problem)| {
        let mut problem = good.clone();
        change(&mut problem);
        qp::solve(&problem).unwrap_err()
    };
    assert!(matches!(
        refused(&|p| p.hessian[(1, 0)] = f64::NAN),
        ProblemError::NotFinite { data: Data::Hessian, row: 1, column: 0, .. }
    ));
    assert!(matches!(
        refused(&|p| p.linear[1] = f64::INFINITY),
        ProblemError::NotFinite { data: Data::Linear, row: 1, column: 0, value: f64::INFINITY }
    ));
    assert!(matches!(
        refused(&|p| p.lower[0] = f64::NAN),
        ProblemError::NotFinite { data: Data::Lower, row: 0, .. }
    ));
    assert!(matches!(
        refused(&|p| p.lower[0] = f64::INFINITY),
        ProblemError::NotFinite { data: Data::Lower, .. }
    ));
    assert!(matches!(
        refused(&|p| p.upper[1] = 1e20),
        ProblemError::HugeBound { data: Data::Upper, row: 1, value: 1e20 }
    ));
    assert!(matches!(
        refused(&|p| p.lower = DVector::zeros(3)),
        ProblemError::Shape { data: Data::Lower, rows: 3, expected_rows: 2, .. }
    ));
    assert!(matches!(
        refused(&|p| p.hessian[(0, 1)] = 0.5),
        ProblemError::Asymmetric { row: 1, column: 0, value: 0.0, transposed: 0.5 }
    ));
    assert!(matches!(refused(&|p| p.hessian[(1, 1)] = -1e-3), ProblemError::Indefinite { row: 1, .. }));
    assert!(matches!(
        refused(&|p| p.hessian = DMatrix::from_row_slice(2, 2, &[1.0, 1.1, 1.1, 1.0])),
        ProblemError::Indefinite { value, .. } if (value + 0.1).abs() < 1e-12
    ));
    // The verdict does not depend on units.
    assert!(matches!(
        refused(&|p| p.hessian = DMatrix::from_row_slice(2, 2, &[1e-18, 1.1e-9, 1.1e-9, 1.0])),
        ProblemError::Indefinite { .. }
    ));
    assert!(refused(&|p| p.upper[1] = 1e20).to_string().contains("hi[1] is 1"));
}

#[test]
fn the_certificate_sees_each_wrong_sign() {
    let mut problem = Problem::unconstrained(DMatrix::identity(2, 2), DVector::from_vec(vec![-2.0, 1.0]));
    problem.inequality = DMatrix::from_row_slice(1, 2, &[1.0, 1.0]);
    problem.inequality_limit = DVector::from_element(1, 0.5);
    problem.lower.fill(0.0);
    problem.upper.fill(1.0);
    let point = solved(&problem).point;
    assert!(Certificate::of(&problem, &point).passes());
    let spoilt = |change: &dyn Fn(&mut Point)| {
        let mut point = point.clone();
        change(&mut point);
        Certificate::of(&problem, &point)
    };
    assert!(spoilt(&|p| p.inequality[0] = -p.inequality[0]).dual > 0.1);
    assert!(spoilt(&|p| p.lower[1] *= -1.0).dual > 0.1);
    assert!(spoilt(&|p| p.x[0] += 1e-3).primal > 1e-4);
    assert!(spoilt(&|p| p.inequality[0] *= 2.0).gap > 0.1);
    let unfounded = spoilt(&|p| {
        p.x.fill(0.1);
    });
    assert!(unfounded.worst() > 1e-2);
}
