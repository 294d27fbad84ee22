//! Contacts that touch, without those whose rows repeat the others.

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector};

/// A contact whose compliance is lost up to this share when the others are held is redundant.
const DEPENDENT: f64 = 1e-9;

/// Right sides from which on a blocked solution is faster than one by one.
const MANY: usize = 8;

/// A set of contacts with independent rows, and the Cholesky factor of its compliance `S_II`.
///
/// Any contact forces equal forces on such a set in their effect, and conic combinations of contact
/// normals need no more (Caratheodory), so that redundant contacts can stay without force. Adding or
/// dropping one contact of `k` costs O(k^2).
#[derive(Clone, Debug)]
pub struct Touching {
    contacts: Vec<usize>,
    /// Lower triangle by columns, each from its diagonal down.
    factor: Vec<Vec<f64>>,
}

impl Touching {
    /// The independent ones among `proposed` contacts, earlier ones first, of the compliance `S` (c x c, mm/N).
    pub fn new(compliance: &DMatrix<f64>, proposed: impl IntoIterator<Item = usize>) -> Self {
        let mut touching = Self { contacts: Vec::new(), factor: Vec::new() };
        for contact in proposed {
            touching.add(compliance, contact);
        }
        touching
    }

    /// The contacts, in the order of the factor.
    pub fn contacts(&self) -> &[usize] {
        &self.contacts
    }

    /// Adds a contact of the compliance `S`; false when its row repeats those held.
    pub fn add(&mut self, compliance: &DMatrix<f64>, contact: usize) -> bool {
        let column = compliance.column(contact);
        let mut row: Vec<f64> = self.contacts.iter().map(|&other| column[other]).collect();
        forward(&self.factor, &mut row);
        let own = column[contact];
        let left = own - dot(&row, &row);
        let independent = left > DEPENDENT * own && !self.contacts.contains(&contact);
        if independent {
            self.factor.iter_mut().zip(&row).for_each(|(column, &entry)| column.push(entry));
            self.factor.push(vec![left.sqrt()]);
            self.contacts.push(contact);
        }
        independent
    }

    /// Drops a contact, if it is held.
    pub fn drop(&mut self, contact: usize) {
        let Some(at) = self.contacts.iter().position(|&i| i == contact) else { return };
        self.contacts.remove(at);
        for (k, column) in self.factor[..at].iter_mut().enumerate() {
            column.remove(at - k);
        }
        // L' L'' + v v' of the rows below: rotations take the dropped column `v` into the columns that stay.
        let dropped = self.factor.remove(at);
        let mut v = dropped[1..].to_vec();
        for (k, column) in self.factor[at..].iter_mut().enumerate() {
            let v = &mut v[k..];
            let length = (column[0] * column[0] + v[0] * v[0]).sqrt();
            let (cosine, sine) = (column[0] / length, v[0] / length);
            for (entry, v) in column.iter_mut().zip(v) {
                (*entry, *v) = (cosine * *entry + sine * *v, cosine * *v - sine * *entry);
            }
        }
    }

    /// Solves `S_II x = v` in place (k x any).
    pub fn solve(&self, values: &mut DMatrix<f64>) {
        if values.ncols() >= MANY {
            return self.solve_many(values);
        }
        for mut column in values.column_iter_mut() {
            let x = column.as_mut_slice();
            forward(&self.factor, x);
            for (k, column) in self.factor.iter().enumerate().rev() {
                let (own, below) = x[k..].split_at_mut(1);
                own[0] = (own[0] - dot(&column[1..], below)) / column[0];
            }
        }
    }

    /// The same with a factor that is put together first, blocked by columns.
    fn solve_many(&self, values: &mut DMatrix<f64>) {
        let (k, columns) = values.shape();
        let mut factor = vec![0.; k * k];
        for (at, column) in self.factor.iter().enumerate() {
            factor[at * (k + 1)..(at + 1) * k].copy_from_slice(column);
        }
        let factor = MatRef::from_column_major_slice(&factor, k, k);
        let mut values = MatMut::from_column_major_slice_mut(values.as_mut_slice(), k, columns);
        solve_lower_triangular_in_place(factor, values.rb_mut(), Par::Seq);
        solve_upper_triangular_in_place(factor.transpose(), values, Par::Seq);
    }

    /// `lambda_I = -S_II^-1 v_I` spread over all `c` contacts, N, for contact-free gaps `v` (c), mm.
    pub fn forces(&self, free_gap: &DVector<f64>) -> DVector<f64> {
        let mut values =
            DMatrix::from_iterator(self.contacts.len(), 1, self.contacts.iter().map(|&i| -free_gap[i]));
        self.solve(&mut values);
        self.spread(values.as_slice(), free_gap.len())
    }

    /// Values of the touching contacts spread over all `c`, zero elsewhere.
    pub fn spread(&self, values: &[f64], c: usize) -> DVector<f64> {
        let mut all = DVector::zeros(c);
        for (&i, &value) in self.contacts.iter().zip(values) {
            all[i] = value;
        }
        all
    }

    /// `S lambda` (c), mm, of forces `lambda_I` (k, N) on the touching contacts.
    pub fn opening(&self, compliance: &DMatrix<f64>, forces: &[f64]) -> DVector<f64> {
        let c = compliance.nrows();
        let mut opening = DVector::zeros(c);
        let column = |i: usize| &compliance.as_slice()[i * c..(i + 1) * c];
        // Four columns at a time, so that the sum is read and written a quarter as often.
        let (fours, rest) = self.contacts.as_chunks::<4>();
        let (force_fours, force_rest) = forces.as_chunks::<4>();
        for (contacts, [f, g, h, e]) in fours.iter().zip(force_fours) {
            let [p, q, r, s] = contacts.map(column);
            let columns = p.iter().zip(q).zip(r).zip(s);
            for (sum, (((p, q), r), s)) in opening.iter_mut().zip(columns) {
                *sum += (f * p + g * q) + (h * r + e * s);
            }
        }
        for (&i, &force) in rest.iter().zip(force_rest) {
            opening.axpy(force, &compliance.column(i), 1.0);
        }
        opening
    }
}

/// Solves `L x = v` in place, `L` being given by its columns from the diagonal down.
fn forward(factor: &[Vec<f64>], x: &mut [f64]) {
    for (k, column) in factor.iter().enumerate() {
        let (own, below) = x[k..].split_at_mut(1);
        own[0] /= column[0];
        for (value, entry) in below.iter_mut().zip(&column[1..]) {
            *value -= own[0] * entry;
        }
    }
}

/// Four partial sums, so that the additions need not wait for each other.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    let mut sums = [0.0; 4];
    for (x, y) in a4.zip(b4) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
