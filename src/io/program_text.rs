//! Quadratic programs as text: MPS with a quadratic objective, and the LP format of CPLEX.

use std::fmt::Write;

use super::ProgramFile;
use crate::qp::Problem;

/// Text of a program under construction; writing to it cannot fail.
struct Text(String);

impl Text {
    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        let _ = self.0.write_fmt(line);
        self.0.push('\n');
    }
}

/// The name of a variable: letters, digits and `_` only, told apart by their number.
fn variables(file: &ProgramFile<'_>) -> Vec<String> {
    let safe = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name = |(k, name): (usize, &String)| format!("x{k}_{}", name.chars().map(safe).collect::<String>());
    file.variables.iter().enumerate().map(name).collect()
}

/// The answer as comments that begin with `mark`.
fn comments(file: &ProgramFile<'_>, names: &[String], mark: &str) -> Text {
    let point = file.point();
    let mut text = Text(String::new());
    text.line(format_args!("{mark} The program of an answer of Modiolus: {}", file.target));
    text.line(format_args!(
        "{mark} minimise 1/2 x'Px + q'x + r, A x = b (y), G x <= h (z >= 0), lo <= x <= hi (z_lo, z_hi >= 0)"
    ));
    text.line(format_args!("{mark} stationary: P x + q + A'y + G'z - z_lo + z_hi = 0"));
    text.line(format_args!("{mark} variable, x, z_lo, z_hi"));
    for (k, name) in names.iter().enumerate() {
        let [x, lower, upper] = [point.x[k], point.lower[k], point.upper[k]];
        text.line(format_args!("{mark} {name} {x:e} {lower:e} {upper:e}"));
    }
    let rows =
        [('e', &file.program.equality, &point.equality), ('i', &file.program.inequality, &point.inequality)];
    text.line(format_args!("{mark} row, multiplier, what it says"));
    for (letter, limits, multipliers) in rows {
        for (k, (limit, multiplier)) in limits.iter().zip(multipliers.iter()).enumerate() {
            let said: String = file.row(*limit).chars().filter(|c| !c.is_control()).collect();
            text.line(format_args!("{mark} {letter}{k} {multiplier:e} {said}"));
        }
    }
    text
}

/// The rows of `problem` with their names: equalities `e`, inequalities `i`.
fn rows(problem: &Problem) -> impl Iterator<Item = (String, bool, Vec<(usize, f64)>, f64)> {
    let all = [
        ('e', true, &problem.equality, &problem.equality_value),
        ('i', false, &problem.inequality, &problem.inequality_limit),
    ];
    all.into_iter().flat_map(|(letter, is_equal, matrix, values)| {
        (0..values.len()).map(move |k| {
            let entries = matrix.row(k).iter().copied().enumerate().filter(|(_, v)| *v != 0.).collect();
            (format!("{letter}{k}"), is_equal, entries, values[k])
        })
    })
}

pub(super) fn qps_text(file: &ProgramFile<'_>) -> String {
    let problem = &file.program.problem;
    let names = variables(file);
    let mut text = comments(file, &names, "*");
    text.line(format_args!("NAME {}\nROWS\n N obj", file.target));
    let mut columns: Vec<Vec<(String, f64)>> = vec![Vec::new(); names.len()];
    let mut right = vec![("obj".to_owned(), -problem.constant)];
    for (row, is_equal, entries, value) in rows(problem) {
        text.line(format_args!(" {} {row}", if is_equal { 'E' } else { 'L' }));
        for (k, entry) in entries {
            columns[k].push((row.clone(), entry));
        }
        right.push((row, value));
    }
    text.line(format_args!("COLUMNS"));
    for (k, (name, column)) in names.iter().zip(columns).enumerate() {
        text.line(format_args!(" {name} obj {:e}", problem.linear[k]));
        for (row, entry) in column {
            text.line(format_args!(" {name} {row} {entry:e}"));
        }
    }
    text.line(format_args!("RHS"));
    for (row, value) in right {
        text.line(format_args!(" rhs {row} {value:e}"));
    }
    text.line(format_args!("BOUNDS"));
    for (k, name) in names.iter().enumerate() {
        let (lower, upper) = (problem.lower[k], problem.upper[k]);
        match lower.is_finite() {
            true => text.line(format_args!(" LO bnd {name} {lower:e}")),
            false => text.line(format_args!(" MI bnd {name}")),
        }
        if upper.is_finite() {
            text.line(format_args!(" UP bnd {name} {upper:e}"));
        }
    }
    text.line(format_args!("QUADOBJ"));
    for (i, first) in names.iter().enumerate() {
        for (j, second) in names.iter().enumerate().skip(i).filter(|(j, _)| problem.hessian[(i, *j)] != 0.) {
            text.line(format_args!(" {first} {second} {:e}", problem.hessian[(i, j)]));
        }
    }
    text.line(format_args!("ENDATA"));
    text.0
}

pub(super) fn lp_text(file: &ProgramFile<'_>) -> String {
    let problem = &file.program.problem;
    let names = variables(file);
    let mut text = comments(file, &names, "\\");
    // One term a line: the format has a longest line.
    text.line(format_args!("minimize\n obj:"));
    for (name, q) in names.iter().zip(problem.linear.iter()) {
        text.line(format_args!(" {q:+e} {name}"));
    }
    text.line(format_args!(" + ["));
    for (i, first) in names.iter().enumerate() {
        for (j, second) in names.iter().enumerate().skip(i).filter(|(j, _)| problem.hessian[(i, *j)] != 0.) {
            let p = problem.hessian[(i, j)];
            match i == j {
                true => text.line(format_args!(" {p:+e} {first} ^ 2")),
                false => text.line(format_args!(" {:+e} {first} * {second}", 2. * p)),
            }
        }
    }
    text.line(format_args!(" ] / 2\n {:+e}\nsubject to", problem.constant));
    for (row, is_equal, entries, value) in rows(problem) {
        text.line(format_args!(" {row}:"));
        if entries.is_empty() {
            text.line(format_args!(" 0 {}", names[0]));
        }
        for (k, entry) in entries {
            text.line(format_args!(" {entry:+e} {}", names[k]));
        }
        text.line(format_args!(" {} {value:e}", if is_equal { "=" } else { "<=" }));
    }
    text.line(format_args!("bounds"));
    let bound = |value: f64| match value {
        value if value.is_finite() => format!("{value:e}"),
        value if value > 0. => "+inf".to_owned(),
        _ => "-inf".to_owned(),
    };
    for (k, name) in names.iter().enumerate() {
        text.line(format_args!(" {} <= {name} <= {}", bound(problem.lower[k]), bound(problem.upper[k])));
    }
    text.line(format_args!("end"));
    text.0
}
