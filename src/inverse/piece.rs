//! One piece of the contact problem: fixed contact states, everything affine in the activations.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::limit::{Constraint, Constraints, Limit, LimitName};
use super::program::{Linearisation, Space, build};
use super::term::State;
use crate::forward::{ContactResponse, Touching};
use crate::qp::{self, Answer, Infeasible, Point, ProblemError};

/// Violated contacts added to the working set at once.
const BATCH: usize = 40;
/// Slack below this share of its row's size counts as zero.
pub(super) const ROUNDING: f64 = 1e-11;
/// Slack up to which a row is worth keeping for the neighbouring pieces, as a share of its size.
const NEAR: f64 = 1e-2;
/// Coefficients below this share of their summands are cancellation: the slack is constant.
const CONSTANT: f64 = 1e-10;

/// A contact state with the forces eliminated: `lambda_I = -S_II^-1 (g0_I + V_I a)` on the touching set `I`.
///
/// The slack of a contact is its force when it touches and its gap when it is open; every slack must
/// not be negative.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) contact: Option<Arc<ContactResponse>>,
    pub(super) touching: Touching,
    pub(super) space: Space,
    /// Place of each contact in the touching set.
    place: Vec<Option<usize>>,
    /// `lambda_I = force_map a + force_offset`.
    force_map: DMatrix<f64>,
    force_offset: DVector<f64>,
    /// Size of what is summed into each slack, to tell a zero from cancellation.
    slack_size: DVector<f64>,
}

/// The optimum of a piece.
#[derive(Clone, Debug)]
pub(super) struct Optimum {
    pub(super) state: State,
    /// `lambda` (c), N.
    pub(super) force: DVector<f64>,
    /// That of the linearised terms.
    pub(super) objective: f64,
    /// Multipliers of the piece's program over the activations, with one inequality a contact.
    pub(super) point: Point,
    /// Contacts at the boundary of the piece.
    pub(super) boundary: Vec<Crossing>,
    /// Contacts near the boundary that were rows of the last program.
    pub(super) working: BTreeSet<usize>,
}

/// A contact at the boundary of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) contact: usize,
    /// How fast the objective falls beyond, 1/mm of gap for one that opens, 1/N of force for one that closes.
    pub(super) rate: f64,
    /// What the objective could fall by: the rate by the size of the slack beyond.
    pub(super) worth: f64,
}

/// What became of a piece.
pub(super) enum Outcome {
    Optimum(Box<Optimum>),
    Infeasible(Option<Infeasible>),
    NotConverged,
}

/// A slack over the activations: `coefficients a + offset`.
#[derive(Debug)]
struct Slack {
    coefficients: DVector<f64>,
    offset: f64,
}

/// The slacks of the working set as rows over the activations.
#[derive(Debug)]
struct Slacks<'a>(&'a Piece, &'a BTreeMap<usize, Slack>);

impl Limit for Slacks<'_> {
    fn restrict(&self, constraints: &mut Constraints) {
        for (&i, slack) in self.1 {
            let name = if self.0.touches(i) { LimitName::Force(i) } else { LimitName::Gap(i) };
            let coefficients = -&slack.coefficients;
            constraints.inequality.push(Constraint { coefficients, value: slack.offset, name });
        }
    }
}

impl Piece {
    /// The only piece when nothing can touch.
    pub(super) fn without_contact(space: &Space) -> Self {
        Self {
            contact: None,
            touching: Touching::new(&DMatrix::zeros(0, 0), []),
            space: space.clone(),
            place: Vec::new(),
            force_map: DMatrix::zeros(0, space.n_unknowns()),
            force_offset: DVector::zeros(0),
            slack_size: DVector::zeros(0),
        }
    }

    /// The piece on which the independent ones of `proposed` touch.
    pub(super) fn new(
        space: &Space,
        contact: &Arc<ContactResponse>,
        proposed: impl IntoIterator<Item = usize>,
    ) -> Self {
        Self::on(space, contact, Touching::new(&contact.compliance, proposed))
    }

    /// The piece of a touching set.
    pub(super) fn on(space: &Space, contact: &Arc<ContactResponse>, touching: Touching) -> Self {
        let (c, m) = contact.approach.shape();
        let held = touching.contacts();
        let k = held.len();
        let mut maps = DMatrix::from_fn(k, m + 1, |i, j| {
            if j < m { -contact.approach[(held[i], j)] } else { -contact.gap[held[i]] }
        });
        touching.solve(&mut maps);
        let force_offset = maps.column(m).into_owned();
        let force_map = maps.remove_column(m);
        let reach = contact.reach.select_columns(held);
        let row_force = DVector::from_fn(k, |i, _| {
            force_map.row(i).iter().fold(force_offset[i].abs(), |s, v| s.max(v.abs()))
        });
        let mut slack_size = contact.gap.abs();
        for column in contact.approach.column_iter() {
            slack_size.zip_apply(&column, |size, v| *size = size.max(v.abs()));
        }
        for (&i, &force) in held.iter().zip(row_force.iter()) {
            slack_size
                .zip_apply(&contact.compliance.column(i), |size, s| *size = size.max((s * force).abs()));
        }
        let mut place = vec![None; c];
        for (k, &i) in held.iter().enumerate() {
            place[i] = Some(k);
            slack_size[i] = row_force[k];
        }
        let space = Space {
            observed: &space.observed + &reach * &force_map,
            offset: &space.offset + &reach * &force_offset,
        };
        let contact = Some(Arc::clone(contact));
        Self { contact, touching, space, place, force_map, force_offset, slack_size }
    }

    /// The slack of contact `i` over the activations.
    fn slack(&self, i: usize) -> Slack {
        let coefficients =
            |row: &dyn Fn(usize) -> f64| DVector::from_fn(self.force_map.ncols(), |j, _| row(j));
        match (self.place[i], &self.contact) {
            (Some(k), _) => Slack {
                coefficients: coefficients(&|j| self.force_map[(k, j)]),
                offset: self.force_offset[k],
            },
            (None, Some(contact)) => {
                let column = contact.compliance.column(i);
                let held = self.touching.contacts();
                let pull = DVector::from_iterator(held.len(), held.iter().map(|&h| column[h]));
                let own = coefficients(&|j| contact.approach[(i, j)]);
                Slack {
                    coefficients: own + self.force_map.tr_mul(&pull),
                    offset: contact.gap[i] + pull.dot(&self.force_offset),
                }
            }
            (None, None) => Slack { coefficients: coefficients(&|_| 0.0), offset: 0.0 },
        }
    }

    /// All slacks (c) at the activations `a` (m).
    fn slacks_at(&self, a: &DVector<f64>) -> DVector<f64> {
        let Some(contact) = &self.contact else { return DVector::zeros(0) };
        let forces = &self.force_map * a + &self.force_offset;
        let mut slack = &contact.gap + &contact.approach * a;
        slack += self.touching.opening(&contact.compliance, forces.as_slice());
        for (&i, &force) in self.touching.contacts().iter().zip(forces.iter()) {
            slack[i] = force;
        }
        slack
    }

    /// The touching contacts, ascending: the name of the piece.
    pub(super) fn key(&self) -> Vec<usize> {
        let mut key = self.touching.contacts().to_vec();
        key.sort_unstable();
        key
    }

    /// The optimum of the linearised terms over the activations in `limits` and in this piece.
    ///
    /// Only contacts that matter become rows: starting from `working`, violated ones are added until
    /// none is left.
    pub(super) fn optimum(
        &self,
        terms: &Linearisation,
        limits: &[&dyn Limit],
        working: &BTreeSet<usize>,
    ) -> Result<Outcome, ProblemError> {
        let size = |i: usize| self.slack_size[i];
        let constant = |i: usize, slack: &Slack| slack.coefficients.amax() <= CONSTANT * size(i);
        let model = terms.over(&self.space);
        let mut rows: BTreeMap<usize, Slack> = working.iter().map(|&i| (i, self.slack(i))).collect();
        rows.retain(|&i, slack| !constant(i, slack));
        loop {
            let slacks = Slacks(self, &rows);
            let mut all: Vec<&dyn Limit> = limits.to_vec();
            all.push(&slacks);
            let solution = match qp::solve(&build(&model, &all).problem)? {
                Answer::Solved(solution) => solution,
                Answer::Infeasible(proof) => return Ok(Outcome::Infeasible(Some(proof))),
                Answer::NotConverged(_) | Answer::Unbounded(_) => return Ok(Outcome::NotConverged),
            };
            let slack = self.slacks_at(&solution.point.x);
            let mut violated: Vec<usize> = (0..slack.len())
                .filter(|i| slack[*i] < -ROUNDING * size(*i) && !rows.contains_key(i))
                .collect();
            let depth = |i: usize| slack[i] / size(i);
            violated.sort_by(|&i, &j| depth(i).total_cmp(&depth(j)).then(i.cmp(&j)));
            let before = rows.len();
            for i in violated {
                let row = self.slack(i);
                if !constant(i, &row) {
                    rows.insert(i, row);
                } else if row.offset < -1e-9 * size(i) {
                    return Ok(Outcome::Infeasible(None));
                }
                if rows.len() == before + BATCH {
                    break;
                }
            }
            if rows.len() == before {
                let objective = model.objective(&solution.point.x);
                let rows: Vec<usize> = rows.into_keys().collect();
                let optimum = self.finish(terms, solution.point, objective, &rows, &slack);
                return Ok(Outcome::Optimum(Box::new(optimum)));
            }
        }
    }

    fn finish(
        &self,
        terms: &Linearisation,
        mut point: Point,
        objective: f64,
        rows: &[usize],
        slack: &DVector<f64>,
    ) -> Optimum {
        let c = slack.len();
        let mut multiplier = DVector::zeros(c);
        for (&i, &z) in rows.iter().zip(point.inequality.iter()) {
            multiplier[i] = z;
        }
        point.inequality = multiplier;
        let activation = point.x.clone();
        let observed = &self.space.observed * &activation + &self.space.offset;
        let state = State { observed, activation };
        // Rounding on the boundary is not a pull.
        let force = DVector::from_fn(c, |i, _| if self.touches(i) { slack[i].max(0.0) } else { 0.0 });
        let near = |i: usize, share: f64| slack[i] <= share * self.slack_size[i];
        let on_boundary: Vec<usize> = (0..c).filter(|&i| near(i, 1e3 * ROUNDING)).collect();
        let boundary = self.crossings(terms, &state, &point.inequality, &on_boundary);
        let working = rows.iter().copied().filter(|&i| near(i, NEAR)).collect();
        Optimum { state, force, objective, point, boundary, working }
    }

    /// What the objective gains when each contact `on_boundary` crosses: an open one takes force, a
    /// touching one opens.
    ///
    /// With the multipliers `v` of the open gaps and `w` of the touching forces, stationarity by
    /// `lambda_I` gives the multiplier of `g_I = 0`, `mu = S_II^-1 (S_IJ v + w - reach_I' df/du)`; the
    /// neighbouring piece demands `-mu_i >= 0` of a contact that opens, and
    /// `reach_j' df/du + S_jI mu - S_jJ v >= 0` of one that closes. Pieces being convex, a neighbour
    /// whose demand is met has its optimum here too.
    fn crossings(
        &self,
        terms: &Linearisation,
        state: &State,
        multiplier: &DVector<f64>,
        on_boundary: &[usize],
    ) -> Vec<Crossing> {
        let Some(contact) = &self.contact else { return Vec::new() };
        let slope = contact.reach.tr_mul(&terms.observed_gradient(state));
        let mu = self.touching_multipliers(contact, &slope, multiplier);
        let open = self.pushed(multiplier);
        let rate = |i: usize| match self.place[i] {
            Some(k) => mu[k],
            None => {
                let column = contact.compliance.column(i);
                let held: f64 =
                    self.touching.contacts().iter().zip(mu.iter()).map(|(&h, f)| column[h] * f).sum();
                let pressed: f64 = open.iter().map(|&j| column[j] * multiplier[j]).sum();
                pressed - held - slope[i]
            }
        };
        // Beyond the boundary the contact's other slack grows: a gap for a force, a force for a gap.
        let other_size = |i: usize| match self.place[i] {
            Some(_) => contact.compliance[(i, i)] * self.slack_size[i],
            None => self.slack_size[i] / contact.compliance[(i, i)],
        };
        on_boundary
            .iter()
            .map(|&i| {
                let rate = rate(i);
                Crossing { contact: i, rate, worth: rate * other_size(i) }
            })
            .collect()
    }

    /// The slacks of the contacts with a `multiplier` (c) as rows over the unknowns (k x n), each of length one.
    pub(super) fn pushing(&self, multiplier: &DVector<f64>) -> DMatrix<f64> {
        let pushing = (0..multiplier.len()).filter(|&i| multiplier[i] > 0.0);
        let rows: Vec<DVector<f64>> =
            pushing.map(|i| self.slack(i).coefficients).filter(|row| row.norm() > 0.0).collect();
        DMatrix::from_fn(rows.len(), self.force_map.ncols(), |i, j| rows[i][j] / rows[i].norm())
    }

    /// Open contacts whose gap holds the optimum back.
    fn pushed(&self, multiplier: &DVector<f64>) -> Vec<usize> {
        (0..multiplier.len()).filter(|&j| !self.touches(j) && multiplier[j] != 0.0).collect()
    }

    /// `mu` (k), 1/mm, of the touching contacts.
    fn touching_multipliers(
        &self,
        contact: &ContactResponse,
        slope: &DVector<f64>,
        multiplier: &DVector<f64>,
    ) -> DVector<f64> {
        let held = self.touching.contacts();
        let mut values =
            DMatrix::from_iterator(held.len(), 1, held.iter().map(|&i| multiplier[i] - slope[i]));
        for j in self.pushed(multiplier) {
            let column = contact.compliance.column(j);
            for (value, &i) in values.iter_mut().zip(held) {
                *value += multiplier[j] * column[i];
            }
        }
        self.touching.solve(&mut values);
        values.column(0).into_owned()
    }

    /// The optimum as a point of the full program over `(a, lambda_I)`, with the forces not eliminated.
    ///
    /// Rows: ties, then `g_I = 0` in the order of the touching set; inequalities: the open contacts `J`
    /// ascending.
    pub(super) fn lifted(&self, terms: &Linearisation, optimum: &Optimum) -> Point {
        let Some(contact) = &self.contact else { return optimum.point.clone() };
        let held = self.touching.contacts();
        let z = &optimum.point.inequality;
        let slope = contact.reach.tr_mul(&terms.observed_gradient(&optimum.state));
        let mu = self.touching_multipliers(contact, &slope, z);
        let pick = |values: &DVector<f64>| held.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let chain = |head: &DVector<f64>, tail: Vec<f64>| {
            DVector::from_iterator(head.len() + tail.len(), head.iter().copied().chain(tail))
        };
        Point {
            x: chain(&optimum.point.x, pick(&optimum.force)),
            equality: chain(&optimum.point.equality, mu.iter().copied().collect()),
            inequality: DVector::from_vec(self.open().into_iter().map(|j| z[j]).collect()),
            lower: chain(&optimum.point.lower, pick(z)),
            upper: chain(&optimum.point.upper, vec![0.0; held.len()]),
        }
    }

    /// The contacts that do not touch, ascending.
    pub(super) fn open(&self) -> Vec<usize> {
        (0..self.place.len()).filter(|&i| !self.touches(i)).collect()
    }

    /// Whether contact `i` touches.
    pub(super) fn touches(&self, i: usize) -> bool {
        self.place[i].is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::PairKind;
    use crate::inverse::limits::{ActivationBounds, ContactReactions};
    use crate::inverse::target::EffortNorm;
    use crate::inverse::term::Term;
    use crate::inverse::terms::{Effort, MarkerDisplacement};
    use crate::qp::Certificate;

    /// A displaced point pressed by two muscles against two walls that it touches and one farther off.
    fn walls() -> (Space, ContactResponse) {
        let map = DMatrix::from_row_slice(3, 2, &[2.0, 0.5, 0.3, 1.5, -0.4, 0.8]);
        let normals = DMatrix::from_row_slice(3, 3, &[-1.0, 0.0, 0.0, 0.0, -1.0, 0.2, 0.1, -1.0, -0.3]);
        let contact = ContactResponse {
            kinds: vec![PairKind::Lips; 3],
            gap: DVector::from_vec(vec![0.1, 0.2, 5.0]),
            approach: &normals * &map,
            compliance: &normals * normals.transpose(),
            reach: normals.transpose(),
        };
        (Space { observed: map, offset: DVector::from_vec(vec![0.1, -0.2, 0.05]) }, contact)
    }

    fn solve(contact: &ContactResponse) -> (Piece, Linearisation, Box<Optimum>) {
        let (space, _) = walls();
        let wish =
            MarkerDisplacement { point: 0, target_mm: [Some(1.0), Some(0.7), Some(0.5)], sigma_mm: 0.5 };
        let terms: [&dyn Term; 2] = [&wish, &Effort::even(2, 0.1, EffortNorm::L2)];
        let rest = State { observed: DVector::zeros(3), activation: DVector::zeros(2) };
        let terms = Linearisation::new(terms, &rest);
        let piece = Piece::new(&space, &Arc::new(contact.clone()), [0, 1]);
        let bounds = ActivationBounds::unit(2);
        match piece.optimum(&terms, &[&bounds], &BTreeSet::new()) {
            Ok(Outcome::Optimum(optimum)) => (piece, terms, optimum),
            _ => unreachable!("the walls stop no activation"),
        }
    }

    #[test]
    fn the_lifted_point_is_optimal_in_the_full_program() {
        let (plain, contact) = walls();
        let (piece, terms, optimum) = solve(&contact);
        let mut observed = DMatrix::zeros(3, 4);
        observed.columns_mut(0, 2).copy_from(&plain.observed);
        observed.columns_mut(2, 2).copy_from(&contact.reach.columns(0, 2));
        let reactions = ContactReactions {
            contact: Arc::new(contact),
            forces: vec![0, 1],
            touching: vec![0, 1],
            open: vec![2],
        };
        let space = Space { observed, offset: plain.offset };
        let program = build(&terms.over(&space), &[&ActivationBounds::unit(2), &reactions]);
        let certificate = Certificate::of(&program.problem, &piece.lifted(&terms, &optimum));
        assert!(certificate.worst() < 1e-13, "{certificate:?}");
    }

    #[test]
    fn the_rate_of_a_touching_contact_is_the_slope_of_the_optimum_by_its_gap() {
        let (_, contact) = walls();
        let (piece, terms, optimum) = solve(&contact);
        let crossings = piece.crossings(&terms, &optimum.state, &optimum.point.inequality, &[0, 1]);
        for (i, crossing) in crossings.iter().enumerate() {
            let h = 1e-5;
            let value = |sign: f64| {
                let mut moved = contact.clone();
                moved.gap[i] += sign * h;
                solve(&moved).2.objective
            };
            let slope = (value(1.0) - value(-1.0)) / (2.0 * h);
            assert!((slope - crossing.rate).abs() < 1e-6, "{slope} {}", crossing.rate);
        }
    }
}
