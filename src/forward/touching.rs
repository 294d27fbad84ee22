//! Contacts that touch, without those whose rows repeat the others.

use nalgebra::{DMatrix, DVector};

/// A contact whose compliance is lost up to this share when the others are held is redundant.
const DEPENDENT: f64 = 1e-9;

/// A set of contacts with independent rows, and the Cholesky factor of its compliance `S_II`.
///
/// Any contact forces equal forces on such a set in their effect, and conic combinations of contact
/// normals need no more (Caratheodory), so that redundant contacts can stay without force. Adding or
/// dropping one contact of `k` costs O(k^2).
#[derive(Clone, Debug)]
pub struct Touching {
    contacts: Vec<usize>,
    /// Lower triangle, one row a contact.
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
        let mut row: Vec<f64> = Vec::with_capacity(self.contacts.len() + 1);
        for (held, &other) in self.factor.iter().zip(&self.contacts) {
            let k = row.len();
            row.push((column[other] - dot(&held[..k], &row)) / held[k]);
        }
        let own = column[contact];
        let left = own - dot(&row, &row);
        let independent = left > DEPENDENT * own && !self.contacts.contains(&contact);
        if independent {
            row.push(left.sqrt());
            self.factor.push(row);
            self.contacts.push(contact);
        }
        independent
    }

    /// Drops a contact, if it is held.
    pub fn drop(&mut self, contact: usize) {
        let Some(at) = self.contacts.iter().position(|&i| i == contact) else { return };
        self.contacts.remove(at);
        self.factor.remove(at);
        // The rows below have one entry too many; rotations of neighbouring columns clear it.
        for k in at..self.factor.len() {
            let (x, y) = (self.factor[k][k], self.factor[k][k + 1]);
            let length = x.hypot(y);
            let (cosine, sine) = (x / length, y / length);
            for row in &mut self.factor[k..] {
                let (left, right) = (row[k], row[k + 1]);
                row[k] = cosine * left + sine * right;
                row[k + 1] = cosine * right - sine * left;
            }
            self.factor[k].truncate(k + 1);
        }
    }

    /// Solves `S_II x = v` in place, column by column (k x any).
    pub fn solve(&self, values: &mut DMatrix<f64>) {
        let k = self.contacts.len();
        for mut column in values.column_iter_mut() {
            let x = column.as_mut_slice();
            for i in 0..k {
                x[i] = (x[i] - dot(&self.factor[i][..i], &x[..i])) / self.factor[i][i];
            }
            for i in (0..k).rev() {
                x[i] /= self.factor[i][i];
                let (above, own) = x.split_at_mut(i);
                for (value, entry) in above.iter_mut().zip(&self.factor[i]) {
                    *value -= own[0] * entry;
                }
            }
        }
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
        let mut opening = DVector::zeros(compliance.nrows());
        for (&i, &force) in self.contacts.iter().zip(forces) {
            opening.axpy(force, &compliance.column(i), 1.0);
        }
        opening
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
