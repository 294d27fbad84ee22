//! The quadratic program of an answer, as others read it.

use std::io;

use nalgebra::{DMatrix, DVector};

use super::npz::Npz;
use super::program_text::{lp_text, qps_text};
use crate::contact::PairKind;
use crate::inverse::{ContactMode, LimitName, Part, Program, TangentProgram, Target};

/// The program of an answer with its primal and dual point, to be written in a form that others read.
///
/// ```text
/// minimise    1/2 x'Px + q'x + r
/// subject to  A x  = b        multipliers y, any sign
///             G x <= h        multipliers z >= 0
///        lo <=  x <= hi       multipliers z_lo, z_hi >= 0
/// stationary  P x + q + A'y + G'z - z_lo + z_hi = 0
/// ```
///
/// The variables are the activations, the share of the jaw's opening where it is unknown, and the forces (N) of the
/// contacts that touch; the rows are tied muscles, gaps (mm) that are closed, and gaps that stay open.
#[derive(Clone, Debug)]
pub struct ProgramFile<'a> {
    /// The target's name.
    pub(super) target: &'a str,
    tangent: &'a TangentProgram,
    pub(super) program: Program,
    /// Names of the variables.
    pub(super) variables: Vec<String>,
    /// Names of the parts of the objective.
    parts: Vec<String>,
}

impl<'a> ProgramFile<'a> {
    /// The program of an answer to `target`.
    pub fn new(target: &'a Target, tangent: &'a TangentProgram) -> Self {
        let program = tangent.program();
        let forces = tangent.touching.iter().map(|i| format!("force of contact {i}"));
        let n = program.problem.linear.len();
        let variables = tangent.unknowns.iter().cloned().chain(forces).take(n).collect();
        let part = |part: &Part| match part {
            Part::Marker(k) => format!("marker {}", target.markers[*k].name),
            Part::Feature(k) => format!("feature {}", target.features[*k].name),
            Part::Symmetry(k) => format!("symmetry {k}"),
            Part::Prior(k) => format!("prior of {}", target.priors[*k].muscle),
            Part::Effort => "effort".to_owned(),
        };
        let parts = tangent.shares().iter().map(|share| part(&share.part)).collect();
        Self { target: &target.name, tangent, program, variables, parts }
    }

    /// The variables and multipliers of the answer.
    pub(super) fn point(&self) -> &crate::qp::Point {
        &self.tangent.point
    }

    /// What the row of this name says.
    pub(super) fn row(&self, name: LimitName) -> String {
        let unknown = |k: usize| &self.tangent.unknowns[k];
        match name {
            LimitName::Least(k) => format!("{} at least", unknown(k)),
            LimitName::Greatest(k) => format!("{} at most", unknown(k)),
            LimitName::Tied(i, j) => format!("{} = {}", unknown(i), unknown(j)),
            LimitName::Touching(i) => format!("gap of contact {i} = 0"),
            LimitName::Gap(i) => format!("gap of contact {i} >= 0"),
            LimitName::Force(i) => format!("force of contact {i} >= 0"),
        }
    }

    /// The arrays `P`, `q`, `r`, `A`, `b`, `G`, `h`, `lower`, `upper`; the answer `x`, `y`, `z`, `z_lower`, `z_upper`; the
    /// names `variables`, `equality_names`, `inequality_names`; the objective as the sum of
    /// `1/2 |residual_matrix x + residual_value|^2` and of `part_slope x`, with `part_names`, `part_rows` (first row and the
    /// one after the last) and `part_objective`; of each contact what it keeps apart, `contact_kinds`, and `touching`, those with a force.
    ///
    /// # Errors
    /// [`io::Error`] when the archive cannot be put together.
    pub(super) fn put(&self, file: &mut Npz) -> io::Result<()> {
        let (problem, point) = (&self.program.problem, &self.tangent.point);
        let objective = self.tangent.objective();
        let at = objective.at(&point.x);
        let matrices = [
            ("P", &problem.hessian),
            ("A", &problem.equality),
            ("G", &problem.inequality),
            ("residual_matrix", &objective.matrix),
        ];
        for (name, matrix) in matrices {
            put_matrix(file, name, matrix)?;
        }
        let vectors = [
            ("q", &problem.linear),
            ("b", &problem.equality_value),
            ("h", &problem.inequality_limit),
            ("lower", &problem.lower),
            ("upper", &problem.upper),
            ("residual_value", &objective.value),
            ("x", &point.x),
            ("y", &point.equality),
            ("z", &point.inequality),
            ("z_lower", &point.lower),
            ("z_upper", &point.upper),
        ];
        for (name, vector) in vectors {
            put_vector(file, name, vector)?;
        }
        file.numbers("r", &[], [problem.constant])?;
        file.names("variables", &self.variables)?;
        let rows = |names: &[LimitName]| names.iter().map(|name| self.row(*name)).collect::<Vec<_>>();
        file.names("equality_names", &rows(&self.program.equality))?;
        file.names("inequality_names", &rows(&self.program.inequality))?;
        let parts = self.tangent.shares();
        let ends = parts.iter().flat_map(|share| [share.rows.start as f64, share.rows.end as f64]);
        let mut slopes = DMatrix::zeros(parts.len(), point.x.len());
        for (k, share) in parts.iter().enumerate() {
            share.slopes.iter().for_each(|&(unknown, slope)| slopes[(k, unknown)] += slope);
        }
        let own = parts.iter().map(|share| share.objective(&at, &point.x));
        file.names("part_names", &self.parts)?;
        file.numbers("part_rows", &[parts.len() as u64, 2], ends)?;
        put_matrix(file, "part_slope", &slopes)?;
        file.numbers("part_objective", &[parts.len() as u64], own)?;
        let kinds = self.tangent.contact.iter().flat_map(|c| &c.kinds).map(|kind| word(*kind).to_owned());
        file.names("contact_kinds", &kinds.collect::<Vec<_>>())?;
        let touching = match self.tangent.mode {
            ContactMode::Reactions => &self.tangent.touching[..],
            _ => &[],
        };
        file.numbers("touching", &[touching.len() as u64], touching.iter().map(|i| *i as f64))?;
        file.names("target", &[self.target.to_owned()])
    }

    /// MPS with a `QUADOBJ` section (free form; the upper triangle of `P`), which HiGHS, Gurobi, CPLEX and others read. The
    /// answer stands in comments.
    pub fn qps(&self) -> String {
        qps_text(self)
    }

    /// The LP format of CPLEX with a quadratic objective. The answer stands in comments.
    pub fn lp(&self) -> String {
        lp_text(self)
    }
}

fn word(kind: PairKind) -> &'static str {
    match kind {
        PairKind::UpperTeeth => "upper_teeth",
        PairKind::LowerTeeth => "lower_teeth",
        PairKind::Lips => "lips",
    }
}

fn put_matrix(file: &mut Npz, name: &str, matrix: &DMatrix<f64>) -> io::Result<()> {
    let shape = [matrix.nrows() as u64, matrix.ncols() as u64];
    // NumPy's order is by rows.
    file.numbers(name, &shape, matrix.transpose().iter().copied())
}

fn put_vector(file: &mut Npz, name: &str, vector: &DVector<f64>) -> io::Result<()> {
    file.numbers(name, &[vector.len() as u64], vector.iter().copied())
}
