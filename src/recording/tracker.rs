//! From the movement of markers to activations over time.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::marker_map::Dynamics;
use super::mechanism::{Mechanism, TouchingPiece};
use super::movement::Movement;
use super::subject::Subject;
use crate::certainty::SeenPoints;
use crate::inverse::ActivationBounds;
use crate::qp::{Link, LinkRow, Stage, StagedActiveSet, StagedProblem, solve_staged};
use crate::units::Vec3;

/// Frames that are solved together and kept,
const BLOCK: usize = 240;
/// and frames on either side that are solved with them, so that what is kept does not know where blocks end.
const HALO: usize = 30;
/// Programs of a block before it is given up.
const ROUNDS: usize = 40;
/// Changes of its contacts after which a frame keeps them and stays within their piece.
const CHANGES: usize = 4;
/// Change of the unknowns at which the contacts and the jaw's angle have settled.
const SETTLED: f64 = 1e-9;
/// Slack below zero, as a share of its row's size, that is rounding.
const ROUNDING: f64 = 1e-9;
/// Residual of an outlier in standard deviations,
const OUTLYING: f64 = 4.;
/// and as a multiple of the median of its frame and of its marker.
const UNUSUAL: f64 = 4.;

/// Outliers of a frame that are believed, at least.
const FEW: usize = 4;

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FrameStatus {
    /// The optimality conditions hold to 1e-9.
    Ok,
    /// No marker, or no head: what neighbouring frames and the effort leave.
    NoData,
    /// Fewer observed components than muscles, but some.
    Underdetermined,
    /// The optimality conditions do not hold.
    NotSolved,
}

impl FrameStatus {
    /// All, in the order in which they are told.
    pub const ALL: [Self; 4] = [Self::Ok, Self::NoData, Self::Underdetermined, Self::NotSolved];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NoData => "no_data",
            Self::Underdetermined => "underdetermined",
            Self::NotSolved => "not_solved",
        }
    }
}

/// A frame fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedFrame {
    /// What became of it.
    pub status: FrameStatus,
    /// The unknowns (n): activations, then the jaw's in shares of their farthest.
    pub unknowns: Vec<f64>,
    /// Measured less fitted displacement of each bound marker (b), mm; `None` where it was not seen.
    pub residual_mm: Vec<Option<Vec3>>,
    /// Bound markers that did not count, since they are far from what the others say.
    pub outliers: Vec<usize>,
    /// Contacts that touch.
    pub touching: usize,
    /// Their forces together, N.
    pub contact_force_n: f64,
    /// Largest violation of the optimality conditions of its block.
    pub certificate: f64,
}

/// Fits blocks of frames.
#[derive(Clone, Debug)]
pub struct Tracker<'a> {
    mechanism: &'a Mechanism,
    movement: &'a Movement,
    times_s: &'a [f64],
    /// The points at rest (b), mm.
    points_mm: Vec<Vec3>,
    /// `1/sigma` of each component (d), 1/mm.
    weights: DVector<f64>,
    effort: f64,
    /// `None` where frames do not follow each other.
    dynamics: Option<Dynamics>,
}

/// A frame on the way.
struct Here {
    /// Its measured displacements weighted (d), zero where not seen.
    data: DVector<f64>,
    /// Bound markers that do not count.
    missing: Vec<usize>,
    x: DVector<f64>,
    piece: usize,
    changes: usize,
    /// Contacts whose slack is held, once the frame keeps its piece.
    held: Vec<usize>,
}

/// A piece with its weighted movement.
struct Weighted {
    piece: TouchingPiece,
    /// (d x w).
    observed: DMatrix<f64>,
    /// (w x w).
    normal: DMatrix<f64>,
}

impl<'a> Tracker<'a> {
    /// That of the `movement` of the markers of `subject`, seen at `times_s`, whose depth counts `depth_weight` of the rest;
    /// without `dynamics` each frame stands for itself.
    pub fn new(
        mechanism: &'a Mechanism,
        subject: &Subject,
        movement: &'a Movement,
        times_s: &'a [f64],
        depth_weight: f64,
        effort: f64,
        dynamics: Option<Dynamics>,
    ) -> Self {
        let axis = [1., 1., depth_weight];
        let weights = subject.bound.iter().flat_map(|b| axis.map(|w| w / b.sigma_mm));
        let weights = DVector::from_iterator(3 * subject.bound.len(), weights);
        let points_mm = subject.bound.iter().map(|b| b.site.position).collect();
        Self { mechanism, movement, times_s, points_mm, weights, effort, dynamics }
    }

    /// The frames of each block, in order.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        let f = self.times_s.len();
        (0..f).step_by(BLOCK).map(|start| start..(start + BLOCK).min(f)).collect()
    }

    /// The frames of a block fitted. They are fitted together with 30 on either side, by bounded activations that change as
    /// [`Dynamics`] allows; where a marker is far from what the others say it is left out and the block fitted again.
    pub fn fit(&self, block: Range<usize>) -> Vec<TrackedFrame> {
        let window = block.start.saturating_sub(HALO)..(block.end + HALO).min(self.times_s.len());
        let mut outliers: Vec<Vec<usize>> = vec![Vec::new(); window.len()];
        let mut fitted = self.fit_window(&window, &outliers);
        let first = self.outliers(&fitted);
        if first.iter().any(|o| !o.is_empty()) {
            outliers = first;
            fitted = self.fit_window(&window, &outliers);
            // One that is far off pulls its neighbours out with it: they come back.
            let second = self.outliers(&fitted);
            let stays = |(first, second): (&Vec<usize>, &Vec<usize>)| {
                first.iter().copied().filter(|b| second.contains(b)).collect::<Vec<usize>>()
            };
            let both: Vec<Vec<usize>> = outliers.iter().zip(&second).map(stays).collect();
            if both != outliers {
                outliers = both;
                fitted = self.fit_window(&window, &outliers);
            }
        }
        let kept = block.start - window.start..block.end - window.start;
        fitted.drain(kept).collect()
    }

    /// What the markers of a frame that was fitted say of its unknowns: those that were seen and count, on the tangent there,
    /// with the contacts that touch there.
    pub fn seen(&self, frame: &TrackedFrame) -> SeenPoints {
        let x = DVector::from_column_slice(&frame.unknowns);
        let xi = self.mechanism.features(&x);
        let open = self.mechanism.open();
        let piece = match self.mechanism.touching(&xi, &open) {
            Ok(Some(touching)) => self.mechanism.piece(touching),
            _ => open,
        };
        let map = self.mechanism.by_unknowns(&piece.observed, &x);
        let counted: Vec<usize> = (0..frame.residual_mm.len())
            .filter(|b| frame.residual_mm[*b].is_some() && !frame.outliers.contains(b))
            .collect();
        let rows: Vec<usize> = counted.iter().flat_map(|b| 3 * b..3 * b + 3).collect();
        let residual = counted.iter().filter_map(|&b| frame.residual_mm[b]).flat_map(|r| [r.x, r.y, r.z]);
        let (min, max) = self.mechanism.bounds();
        SeenPoints {
            points_mm: counted.iter().map(|&b| self.points_mm[b]).collect(),
            map: map.select_rows(&rows),
            n_muscles: self.mechanism.muscles.len(),
            residual_mm: DVector::from_iterator(rows.len(), residual),
            weights: self.weights.select_rows(&rows),
            x,
            bounds: ActivationBounds { min, max },
        }
    }

    /// Markers of each frame that are far from what the others say: beyond 4 standard deviations and 4 times what is usual
    /// in their frame and for themselves.
    fn outliers(&self, fitted: &[TrackedFrame]) -> Vec<Vec<usize>> {
        let size = |frame: &TrackedFrame, b: usize| {
            let r = frame.residual_mm[b]?;
            let w = self.weights.rows(3 * b, 3);
            Some((r.component_mul(&Vec3::new(w[0], w[1], w[2]))).norm())
        };
        let markers = self.weights.len() / 3;
        let usual = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.)
        };
        let of_marker: Vec<f64> =
            (0..markers).map(|b| usual(&mut fitted.iter().filter_map(|f| size(f, b)).collect())).collect();
        let of_frame = |frame: &TrackedFrame| {
            let usual = usual(&mut (0..markers).filter_map(|b| size(frame, b)).collect());
            let is_far = |b: &usize| {
                size(frame, *b)
                    .is_some_and(|s| s > OUTLYING && s > UNUSUAL * usual && s > UNUSUAL * of_marker[*b])
            };
            let far: Vec<usize> = (0..markers).filter(is_far).collect();
            // Many that are off together are what the model does not know, not what the camera got wrong.
            let seen = frame.residual_mm.iter().flatten().count();
            if far.len() > FEW.max(seen / 20) { Vec::new() } else { far }
        };
        fitted.iter().map(of_frame).collect()
    }

    fn here(&self, frame: usize, outliers: &[usize]) -> Here {
        let row = self.movement.frame(frame);
        let mut data = DVector::zeros(self.weights.len());
        let mut missing = Vec::new();
        for (b, seen) in row.iter().enumerate() {
            match seen {
                Some(u) if !outliers.contains(&b) => {
                    (0..3).for_each(|axis| data[3 * b + axis] = self.weights[3 * b + axis] * u[axis]);
                }
                _ => missing.push(b),
            }
        }
        let x = DVector::zeros(self.mechanism.n_unknowns());
        Here { data, missing, x, piece: 0, changes: 0, held: Vec::new() }
    }

    fn weighted(&self, piece: TouchingPiece) -> Weighted {
        let mut observed = piece.observed.clone();
        for mut column in observed.column_iter_mut() {
            column.component_mul_assign(&self.weights);
        }
        let normal = observed.tr_mul(&observed);
        Weighted { piece, observed, normal }
    }

    /// The program of a frame about where it is.
    fn stage(&self, here: &Here, piece: &Weighted) -> Stage {
        let mechanism = self.mechanism;
        let (m, n) = (mechanism.muscles.len(), mechanism.n_unknowns());
        let xi = mechanism.features(&here.x);
        let mut normal = piece.normal.clone();
        let mut pull = &piece.normal * &xi - piece.observed.tr_mul(&here.data);
        for &b in &here.missing {
            let rows = piece.observed.rows(3 * b, 3);
            normal.gemm_tr(-1., &rows, &rows, 1.);
            pull.gemv_tr(-1., &rows, &(rows * &xi), 1.);
        }
        // r(x + d) = r + J d:  P = J'J,  q = J'r - P x.
        let half = mechanism.by_unknowns(&normal, &here.x);
        let mut hessian = mechanism.by_unknowns(&half.transpose(), &here.x);
        let pull = DMatrix::from_row_slice(1, pull.len(), pull.as_slice());
        let linear = mechanism.by_unknowns(&pull, &here.x).row(0).transpose() - &hessian * &here.x;
        hessian = 0.5 * (&hessian + hessian.transpose());
        for k in 0..n {
            hessian[(k, k)] += match mechanism.jaw() {
                Some(jaw) if k >= m => jaw.sigma.powi(-2),
                _ => self.effort,
            };
        }

        let (lower, upper) = mechanism.bounds();
        let mut stage = Stage::boxed(hessian, linear, lower, upper);
        if !here.held.is_empty() {
            // slack(x) = s(x0) + s' (x - x0) >= 0, each row divided by its size.
            let k = here.held.len();
            (stage.rows, stage.limits) = (DMatrix::zeros(k, n), DVector::zeros(k));
            for (row, &i) in here.held.iter().enumerate() {
                let slack = mechanism.slack(&piece.piece, i);
                let slopes = mechanism.by_unknowns(&slack, &here.x);
                let size = slopes.norm().max(f64::MIN_POSITIVE);
                stage.limits[row] = ((&slack * &xi)[0] - (&slopes * &here.x)[0]) / size;
                stage.rows.row_mut(row).copy_from(&(-slopes.row(0) / size));
            }
        }
        stage
    }

    fn link(&self, frame: usize) -> Link {
        let (m, n) = (self.mechanism.muscles.len(), self.mechanism.n_unknowns());
        let dt = self.times_s[frame + 1] - self.times_s[frame];
        let Some(Dynamics { change_per_root_s, rise_s, fall_s }) = self.dynamics else {
            return Link { weight: DVector::zeros(n), rows: Vec::new() };
        };
        let weight = DVector::from_element(n, 1. / (change_per_root_s.powi(2) * dt));
        // a' - a <= dt / rise,  a - a' <= dt / fall; what the bounds hold anyway is no row.
        let rows = [(-1., dt / rise_s), (1., dt / fall_s)].into_iter().filter(|(_, limit)| *limit < 1.);
        let of =
            |(before, limit)| (0..m).map(move |variable| LinkRow { variable, before, after: -before, limit });
        Link { weight, rows: rows.flat_map(of).collect() }
    }

    fn fit_window(&self, window: &Range<usize>, outliers: &[Vec<usize>]) -> Vec<TrackedFrame> {
        let mut frames: Vec<Here> = window.clone().zip(outliers).map(|(f, out)| self.here(f, out)).collect();
        let mut pieces = vec![self.weighted(self.mechanism.open())];
        let mut known: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        let links: Vec<Link> = (window.start..window.end - 1).map(|f| self.link(f)).collect();
        let mut active = StagedActiveSet::default();
        let (mut certificate, mut is_settled) = (f64::INFINITY, false);
        for _ in 0..ROUNDS {
            let stages = frames.iter().map(|here| self.stage(here, &pieces[here.piece])).collect();
            let problem = StagedProblem { stages, links: links.clone() };
            let Some(solution) = solve_staged(&problem, &mut active) else { break };
            certificate = solution.worst;
            is_settled = true;
            for (here, found) in frames.iter_mut().zip(solution.point.stages) {
                let step = (&found.x - &here.x).amax();
                here.x = found.x;
                is_settled &= step <= SETTLED;
                is_settled &= self.follow(here, &mut pieces, &mut known);
            }
            if is_settled {
                break;
            }
        }
        let passes = is_settled && certificate <= crate::qp::TOLERANCE;
        let tracked = |((here, frame), out): ((&Here, usize), &Vec<usize>)| {
            self.tracked(here, frame, out, &pieces[here.piece], passes, certificate)
        };
        frames.iter().zip(window.clone()).zip(outliers).map(tracked).collect()
    }

    /// Takes the contacts of where a frame is now; whether they are those that it had.
    fn follow(
        &self,
        here: &mut Here,
        pieces: &mut Vec<Weighted>,
        known: &mut BTreeMap<Vec<usize>, usize>,
    ) -> bool {
        let xi = self.mechanism.features(&here.x);
        let piece = &pieces[here.piece].piece;
        if here.changes < CHANGES {
            // Where no forces hold the face the frame stays with what it has.
            let Ok(Some(touching)) = self.mechanism.touching(&xi, piece) else { return true };
            let mut key = touching.contacts().to_vec();
            key.sort_unstable();
            here.piece = *known.entry(key).or_insert_with(|| {
                pieces.push(self.weighted(self.mechanism.piece(touching)));
                pieces.len() - 1
            });
            here.changes += 1;
            return false;
        }
        let slack = self.mechanism.slacks(piece, &xi);
        let least = -ROUNDING * slack.amax();
        let before = here.held.len();
        for i in (0..slack.len()).filter(|&i| slack[i] < least) {
            if !here.held.contains(&i) {
                here.held.push(i);
            }
        }
        here.held.len() == before
    }

    fn tracked(
        &self,
        here: &Here,
        frame: usize,
        outliers: &[usize],
        piece: &Weighted,
        passes: bool,
        certificate: f64,
    ) -> TrackedFrame {
        let xi = self.mechanism.features(&here.x);
        let fitted = &piece.piece.observed * &xi;
        let row = self.movement.frame(frame);
        let residual = |(b, seen): (usize, &Option<Vec3>)| {
            seen.map(|u| u - Vec3::new(fitted[3 * b], fitted[3 * b + 1], fitted[3 * b + 2]))
        };
        let seen = row.len() - here.missing.len();
        let status = if !passes {
            FrameStatus::NotSolved
        } else if seen == 0 {
            FrameStatus::NoData
        } else if 3 * seen < self.mechanism.muscles.len() {
            FrameStatus::Underdetermined
        } else {
            FrameStatus::Ok
        };
        TrackedFrame {
            status,
            unknowns: here.x.as_slice().to_vec(),
            residual_mm: row.iter().enumerate().map(residual).collect(),
            outliers: outliers.to_vec(),
            touching: piece.piece.len(),
            contact_force_n: piece.piece.force_n(&xi),
            certificate,
        }
    }
}
