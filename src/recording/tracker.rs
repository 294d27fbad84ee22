//! From the movement of markers to activations over time.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::marker_map::Dynamics;
use super::mechanism::{TouchingPiece, sorted};
use super::mechanisms::Mechanisms;
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
/// Frames from one to the next of those from which the others begin.
const STRIDE: usize = 6;
/// Programs of a block before it is given up.
const ROUNDS: usize = 40;
/// Changes of its contacts after which a frame keeps them and stays within their piece.
const CHANGES: usize = 4;
/// Change of the unknowns at which the contacts and the jaw's angle have settled.
const SETTLED: f64 = 1e-9;
/// Slack below zero, as a share of its row's size, that is rounding.
const ROUNDING: f64 = 1e-9;
/// Share of the curvature by the jaw's opening that its arc may take away.
const MOST_BENT: f64 = 0.5;
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

/// Contacts of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touched {
    /// Contacts that touch.
    pub contacts: usize,
    /// Their forces together, N.
    pub force_n: f64,
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
    /// What touches; `None` without contact, and where contact is in the tangent of a face at rest.
    pub touched: Option<Touched>,
    /// Largest violation of the optimality conditions of its block.
    pub certificate: f64,
}

/// Fits blocks of frames.
#[derive(Clone, Debug)]
pub struct Tracker<'a> {
    mechanisms: &'a Mechanisms,
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
#[derive(Clone)]
struct Here {
    frame: usize,
    /// Its measured displacements weighted (d), zero where not seen.
    data: DVector<f64>,
    /// Bound markers that do not count.
    missing: Vec<usize>,
    /// Those of them that are seen, but far from what the others say.
    outliers: Vec<usize>,
    x: DVector<f64>,
    piece: usize,
    /// The features at which its piece was found.
    found_at: DVector<f64>,
    changes: usize,
    /// Contacts whose slack is held, once the frame keeps its piece.
    held: Vec<usize>,
}

/// Frames that are solved together.
struct Window {
    frames: Vec<Here>,
    links: Vec<Link>,
    pieces: Pieces,
    active: StagedActiveSet,
}

/// A piece with its weighted movement.
struct Weighted {
    piece: TouchingPiece,
    /// (d x w).
    observed: DMatrix<f64>,
    /// (w x w).
    normal: DMatrix<f64>,
}

/// The pieces that frames of a window had, each made once.
#[derive(Default)]
struct Pieces {
    all: Vec<Weighted>,
    /// By mechanism and contacts.
    known: BTreeMap<(usize, Vec<usize>), usize>,
}

impl Pieces {
    /// The place of the piece with these contacts, which `make` makes where there is none.
    fn place(&mut self, key: (usize, Vec<usize>), make: impl FnOnce() -> Weighted) -> usize {
        *self.known.entry(key).or_insert_with(|| {
            self.all.push(make());
            self.all.len() - 1
        })
    }
}

impl<'a> Tracker<'a> {
    /// That of the `movement` of the markers of `subject`, seen at `times_s`, whose depth counts `depth_weight` of the rest;
    /// without `dynamics` each frame stands for itself.
    pub fn new(
        mechanisms: &'a Mechanisms,
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
        Self { mechanisms, movement, times_s, points_mm, weights, effort, dynamics }
    }

    /// The frames of each block, in order.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        let f = self.times_s.len();
        (0..f).step_by(BLOCK).map(|start| start..(start + BLOCK).min(f)).collect()
    }

    /// The frames of a block fitted. They are fitted together with 30 on either side, by bounded activations that change as
    /// [`Dynamics`] allows; where a marker is far from what the others say it is left out and the block fitted again.
    pub fn fit(&self, block: Range<usize>) -> Vec<TrackedFrame> {
        let range = block.start.saturating_sub(HALO)..(block.end + HALO).min(self.times_s.len());
        let mut window = self.window(&range);
        self.begin(&mut window);
        let mut fitted = self.settle(&mut window);
        let first = self.outliers(&fitted);
        if first.iter().any(|o| !o.is_empty()) {
            self.leave_out(&mut window, &first);
            fitted = self.settle(&mut window);
            // One that is far off pulls its neighbours out with it: they come back.
            let second = self.outliers(&fitted);
            let stays = |(first, second): (&Vec<usize>, &Vec<usize>)| {
                first.iter().copied().filter(|b| second.contains(b)).collect::<Vec<usize>>()
            };
            let both: Vec<Vec<usize>> = first.iter().zip(&second).map(stays).collect();
            if both != first {
                self.leave_out(&mut window, &both);
                fitted = self.settle(&mut window);
            }
        }
        let kept = block.start - range.start..block.end - range.start;
        fitted.drain(kept).collect()
    }

    /// What the markers of a frame that was fitted say of its unknowns: those that were seen and count, on the tangent there,
    /// with the contacts that touch there.
    pub fn seen(&self, frame: usize, fitted: &TrackedFrame) -> SeenPoints {
        let mechanism = self.mechanisms.of(frame);
        let x = DVector::from_column_slice(&fitted.unknowns);
        let xi = mechanism.features(&x);
        let open = mechanism.open();
        let piece = match mechanism.touching(&xi, &open) {
            Ok(Some(touching)) => mechanism.piece(touching),
            _ => open,
        };
        let map = mechanism.by_unknowns(&piece.observed, &x);
        let counted: Vec<usize> = (0..fitted.residual_mm.len())
            .filter(|b| fitted.residual_mm[*b].is_some() && !fitted.outliers.contains(b))
            .collect();
        let rows: Vec<usize> = counted.iter().flat_map(|b| 3 * b..3 * b + 3).collect();
        let residual = counted.iter().filter_map(|&b| fitted.residual_mm[b]).flat_map(|r| [r.x, r.y, r.z]);
        let (min, max) = mechanism.bounds();
        SeenPoints {
            points_mm: counted.iter().map(|&b| self.points_mm[b]).collect(),
            map: map.select_rows(&rows),
            n_muscles: mechanism.muscles.len(),
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

    /// The frames of `range` before anything is known of them.
    fn window(&self, range: &Range<usize>) -> Window {
        let mut pieces = Pieces::default();
        let frames = range.clone().map(|frame| {
            let (index, mechanism) = (self.mechanisms.index(frame), self.mechanisms.of(frame));
            let piece = pieces.place((index, Vec::new()), || self.weighted(mechanism.open()));
            let x = DVector::zeros(mechanism.n_unknowns());
            let found_at = mechanism.features(&x);
            let mut here = Here {
                frame,
                data: DVector::zeros(self.weights.len()),
                missing: Vec::new(),
                outliers: Vec::new(),
                x,
                piece,
                found_at,
                changes: 0,
                held: Vec::new(),
            };
            self.observe(&mut here, &[]);
            here
        });
        Window {
            frames: frames.collect(),
            links: (range.start..range.end - 1).map(|f| self.link(f, f + 1)).collect(),
            pieces,
            active: StagedActiveSet::default(),
        }
    }

    /// What the markers of a frame say without its `outliers`.
    fn observe(&self, here: &mut Here, outliers: &[usize]) {
        here.data.fill(0.);
        here.missing.clear();
        here.outliers = outliers.to_vec();
        for (b, seen) in self.movement.frame(here.frame).iter().enumerate() {
            match seen {
                Some(u) if !outliers.contains(&b) => {
                    (0..3).for_each(|axis| here.data[3 * b + axis] = self.weights[3 * b + axis] * u[axis]);
                }
                _ => here.missing.push(b),
            }
        }
    }

    /// The same frames without the `outliers` of each, to go on from where they are.
    fn leave_out(&self, window: &mut Window, outliers: &[Vec<usize>]) {
        for (here, outliers) in window.frames.iter_mut().zip(outliers) {
            self.observe(here, outliers);
            here.changes = 0;
            here.held.clear();
        }
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
        let mechanism = self.mechanisms.of(here.frame);
        let (m, n) = (mechanism.muscles.len(), mechanism.n_unknowns());
        let xi = mechanism.features(&here.x);
        let mut normal = piece.normal.clone();
        let mut pull = &piece.normal * &xi - piece.observed.tr_mul(&here.data);
        for &b in &here.missing {
            let rows = piece.observed.rows(3 * b, 3);
            normal.gemm_tr(-1., &rows, &rows, 1.);
            pull.gemv_tr(-1., &rows, &(rows * &xi), 1.);
        }
        // P = J'J and what bends with the jaw's arc,  q = J'r - P x.
        let half = mechanism.by_unknowns(&normal, &here.x);
        let mut hessian = mechanism.by_unknowns(&half.transpose(), &here.x);
        if n > m {
            hessian[(m, m)] += mechanism.bend(&pull, &here.x).max(-MOST_BENT * hessian[(m, m)]);
        }
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

    fn link(&self, frame: usize, next: usize) -> Link {
        let (m, n) = (self.mechanisms.first().muscles.len(), self.mechanisms.first().n_unknowns());
        let dt = self.times_s[next] - self.times_s[frame];
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

    /// Brings the frames of a window near to where they will be: every few of them are fitted, and those between begin from
    /// between them.
    fn begin(&self, window: &mut Window) {
        let n = window.frames.len();
        // Frames that do not follow each other say nothing of those between.
        if self.dynamics.is_none() || n <= 2 * STRIDE {
            return;
        }
        let mut chosen: Vec<usize> = (0..n - 1).step_by(STRIDE).collect();
        chosen.push(n - 1);
        let frames: Vec<Here> = chosen.iter().map(|&t| window.frames[t].clone()).collect();
        let links = frames.windows(2).map(|pair| self.link(pair[0].frame, pair[1].frame)).collect();
        let pieces = std::mem::take(&mut window.pieces);
        let mut few = Window { frames, links, pieces, active: StagedActiveSet::default() };
        self.iterate(&mut few);
        let nearest: Vec<usize> = (0..n).map(|t| ((t + STRIDE / 2) / STRIDE).min(chosen.len() - 1)).collect();
        window.active = few.active.spread(&nearest);
        window.pieces = few.pieces;
        for (t, here) in window.frames.iter_mut().enumerate() {
            let k = (t / STRIDE).min(chosen.len() - 2);
            let (before, after) = (&few.frames[k], &few.frames[k + 1]);
            let share = (t - chosen[k]) as f64 / (chosen[k + 1] - chosen[k]) as f64;
            here.x = before.x.lerp(&after.x, share);
            let near = &few.frames[nearest[t]];
            if self.mechanisms.index(near.frame) == self.mechanisms.index(here.frame) {
                (here.piece, here.found_at) = (near.piece, near.found_at.clone());
            }
        }
    }

    /// Fits the frames of a window together.
    fn settle(&self, window: &mut Window) -> Vec<TrackedFrame> {
        let (passes, certificate) = self.iterate(window);
        let tracked = |here: &Here| self.tracked(here, &window.pieces.all[here.piece], passes, certificate);
        window.frames.iter().map(tracked).collect()
    }

    /// Fits the frames of a window together, until contacts and jaw stay where they are: whether they do and the optimality
    /// conditions hold, and how well.
    fn iterate(&self, window: &mut Window) -> (bool, f64) {
        let Window { frames, links, pieces, active } = window;
        let (mut certificate, mut is_settled) = (f64::INFINITY, false);
        for _ in 0..ROUNDS {
            let stages = frames.iter().map(|here| self.stage(here, &pieces.all[here.piece])).collect();
            let problem = StagedProblem { stages, links: std::mem::take(links) };
            let solution = solve_staged(&problem, active);
            *links = problem.links;
            let Some(solution) = solution else { break };
            certificate = solution.worst;
            is_settled = true;
            for (t, found) in solution.point.stages.into_iter().enumerate() {
                let (before, rest) = frames.split_at_mut(t);
                let here = &mut rest[0];
                is_settled &= (&found.x - &here.x).amax() <= SETTLED;
                here.x = found.x;
                is_settled &= self.follow(here, before.last(), pieces);
            }
            if is_settled {
                break;
            }
        }
        (is_settled && certificate <= crate::qp::TOLERANCE, certificate)
    }

    /// Takes the contacts of where a frame is now; whether they are those that it had. They are sought from its own or from those of
    /// the frame `before`, whichever was found nearer.
    fn follow(&self, here: &mut Here, before: Option<&Here>, pieces: &mut Pieces) -> bool {
        let (index, mechanism) = (self.mechanisms.index(here.frame), self.mechanisms.of(here.frame));
        let xi = mechanism.features(&here.x);
        let slack = mechanism.slacks(&pieces.all[here.piece].piece, &xi);
        let least = -ROUNDING * slack.amax();
        if slack.iter().all(|slack| *slack >= least) {
            here.found_at = xi;
            return true;
        }
        if here.changes < CHANGES {
            let off = |other: &Here| (&other.found_at - &xi).norm_squared();
            let beside = before.filter(|other| self.mechanisms.index(other.frame) == index);
            let near = beside.filter(|other| off(other) < off(here)).map_or(here.piece, |other| other.piece);
            // Where no forces hold the face the frame stays with what it has.
            let Ok(Some(touching)) = mechanism.touching(&xi, &pieces.all[near].piece) else { return true };
            here.found_at = xi;
            let key = (index, sorted(&touching));
            let piece = pieces.place(key, || self.weighted(mechanism.piece(touching)));
            let is_same = piece == here.piece;
            here.piece = piece;
            here.changes += usize::from(!is_same);
            return is_same;
        }
        let before = here.held.len();
        for i in (0..slack.len()).filter(|&i| slack[i] < least) {
            if !here.held.contains(&i) {
                here.held.push(i);
            }
        }
        here.held.len() == before
    }

    fn tracked(&self, here: &Here, piece: &Weighted, passes: bool, certificate: f64) -> TrackedFrame {
        let mechanism = self.mechanisms.of(here.frame);
        let xi = mechanism.features(&here.x);
        let fitted = &piece.piece.observed * &xi;
        let row = self.movement.frame(here.frame);
        let residual = |(b, seen): (usize, &Option<Vec3>)| {
            seen.map(|u| u - Vec3::new(fitted[3 * b], fitted[3 * b + 1], fitted[3 * b + 2]))
        };
        let seen = row.len() - here.missing.len();
        let status = if !passes {
            FrameStatus::NotSolved
        } else if seen == 0 {
            FrameStatus::NoData
        } else if 3 * seen < mechanism.muscles.len() {
            FrameStatus::Underdetermined
        } else {
            FrameStatus::Ok
        };
        TrackedFrame {
            status,
            unknowns: here.x.as_slice().to_vec(),
            residual_mm: row.iter().enumerate().map(residual).collect(),
            outliers: here.outliers.clone(),
            touched: mechanism.has_contact().then(|| piece.piece.touched(&xi)),
            certificate,
        }
    }
}
