//! The global stiffness, a sum of parts.

use std::ops::Range;

use nalgebra::Matrix3;

use super::ElementStiffness;

/// Lower triangle of a symmetric matrix of 3 x 3 node blocks, stored column by column.
///
/// Column `3j + c` holds rows `3j + c ..= 3j + 2` and then the three rows of each later node that
/// shares an element with `j`, ascending: positions are found from the node graph alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// Start of each node's neighbours in `neighbours`.
    starts: Vec<usize>,
    /// Later neighbours of each node, ascending.
    neighbours: Vec<usize>,
    /// Start of each dof column in the values.
    columns: Vec<usize>,
}

impl Pattern {
    /// The pattern of `n_nodes` nodes joined by elements, each given by its nodes (0-based).
    pub fn new<'a>(n_nodes: usize, elements: impl IntoIterator<Item = &'a [usize]>) -> Self {
        let mut later = vec![Vec::new(); n_nodes];
        for nodes in elements {
            for &j in nodes {
                later[j].extend(nodes.iter().filter(|&&i| i > j));
            }
        }
        let mut starts = Vec::with_capacity(n_nodes + 1);
        let mut neighbours = Vec::new();
        let mut columns = Vec::with_capacity(3 * n_nodes + 1);
        let mut position = 0;
        for list in &mut later {
            list.sort_unstable();
            list.dedup();
            starts.push(neighbours.len());
            neighbours.extend_from_slice(list);
            for c in 0..3 {
                columns.push(position);
                position += 3 - c + 3 * list.len();
            }
        }
        starts.push(neighbours.len());
        columns.push(position);
        Self { starts, neighbours, columns }
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of stored values.
    pub fn n_values(&self) -> usize {
        self.columns[3 * self.n_nodes()]
    }

    /// Later neighbours of `node`, ascending.
    pub fn later_neighbours(&self, node: usize) -> &[usize] {
        &self.neighbours[self.starts[node]..self.starts[node + 1]]
    }

    /// Positions in the values of dof column `column`.
    pub fn column(&self, column: usize) -> Range<usize> {
        self.columns[column]..self.columns[column + 1]
    }

    /// Rows of dof column `column`, ascending.
    pub fn rows(&self, column: usize) -> impl Iterator<Item = usize> + '_ {
        let (node, axis) = (column / 3, column % 3);
        let own = column..3 * node + 3;
        debug_assert!(own.len() == 3 - axis);
        own.chain(self.later_neighbours(node).iter().flat_map(|&i| 3 * i..3 * i + 3))
    }

    /// Whether nodes `i` and `j` are joined, or the same.
    pub(super) fn joins(&self, i: usize, j: usize) -> bool {
        i == j || self.later_neighbours(i.min(j)).binary_search(&i.max(j)).is_ok()
    }

    /// Position in the values of the first entry of block `(i, j)`, `i > j`, in column `3j + axis`.
    fn block(&self, i: usize, j: usize, axis: usize) -> usize {
        let k = self.later_neighbours(j).partition_point(|&other| other < i);
        self.columns[3 * j + axis] + 3 - axis + 3 * k
    }

    /// Calls `add(position, value)` for every entry in the lower triangle of an element's blocks `(i, j)` at `i n + j`.
    pub(super) fn scatter(&self, nodes: &[usize], k: &[Matrix3<f64>], mut add: impl FnMut(usize, f64)) {
        let n = nodes.len();
        for (b, &j) in nodes.iter().enumerate() {
            for (a, &i) in nodes.iter().enumerate() {
                let block: &Matrix3<f64> = &k[a * n + b];
                if i == j {
                    for c in 0..3 {
                        for r in c..3 {
                            add(self.columns[3 * j + c] + r - c, block[(r, c)]);
                        }
                    }
                } else if i > j {
                    for c in 0..3 {
                        let start = self.block(i, j, c);
                        for r in 0..3 {
                            add(start + r, block[(r, c)]);
                        }
                    }
                }
            }
        }
    }

    /// Adds the block of nodes `i` and `j`, and its mirror image.
    pub(crate) fn add_block(&self, i: usize, j: usize, block: &Matrix3<f64>, values: &mut [f64]) {
        if i == j {
            self.scatter(&[i], &[*block], |at, value| values[at] += value);
        } else {
            let (none, turned) = (Matrix3::zeros(), block.transpose());
            self.scatter(&[i, j], &[none, *block, turned, none], |at, value| values[at] += value);
        }
    }

    /// `K u` for the symmetric matrix with these `values`.
    pub fn multiply(&self, values: &[f64], u: &[f64]) -> Vec<f64> {
        let mut out = vec![0.; u.len()];
        for column in 0..u.len() {
            let mut own = 0.;
            for (row, &value) in self.rows(column).zip(&values[self.column(column)]) {
                own += value * u[row];
                if row != column {
                    out[row] += value * u[column];
                }
            }
            out[column] += own;
        }
        out
    }
}

/// `K = K0 + sum_p c_p K_p` in N/mm over all dofs, supports included.
///
/// `K0` holds all tissue at rest; a part `K_p` (mm) is what one elastic tensor of one muscle adds per
/// N/mm² of its coefficient `c_p(a)`, on the few entries that the muscle touches. Law `reinforced` has one
/// part a muscle, `K_m >= 0`, whose coefficient is proportional to the activation: `K(a)` is affine.
#[derive(Clone, Debug)]
pub struct Stiffness {
    pattern: Pattern,
    base: Vec<f64>,
    parts: Vec<Vec<(usize, f64)>>,
}

impl Stiffness {
    /// The zero matrix for `n_nodes` nodes joined by elements, each given by its nodes (0-based), with `n_parts` muscle
    /// parts.
    pub fn new<'a>(n_nodes: usize, elements: impl IntoIterator<Item = &'a [usize]>, n_parts: usize) -> Self {
        let pattern = Pattern::new(n_nodes, elements);
        let base = vec![0.; pattern.n_values()];
        Self { pattern, base, parts: vec![Vec::new(); n_parts] }
    }

    /// Adds an element's stiffness to `K0`.
    pub fn add_base(&mut self, nodes: &[usize], k: &ElementStiffness) {
        let Self { pattern, base, .. } = self;
        pattern.scatter(nodes, k, |at, value| base[at] += value);
    }

    /// Adds an element's stiffness to `K_part`; call [`finish`](Self::finish) after the last.
    pub fn add_part(&mut self, part: usize, nodes: &[usize], k: &ElementStiffness) {
        let Self { pattern, parts, .. } = self;
        pattern.scatter(nodes, k, |at, value| parts[part].push((at, value)));
    }

    /// Merges the entries of the parts.
    pub fn finish(&mut self) {
        for part in &mut self.parts {
            part.sort_by_key(|&(at, _)| at);
            let mut merged: Vec<(usize, f64)> = Vec::new();
            for &(at, value) in part.iter() {
                match merged.last_mut() {
                    Some(last) if last.0 == at => last.1 += value,
                    _ => merged.push((at, value)),
                }
            }
            *part = merged;
        }
    }

    /// `by_tissue K_t + by_muscle (K - K_t)`, with `tissue` the values of `K_t`, a part of `K0`.
    #[must_use]
    pub(super) fn scaled(&self, tissue: &[f64], by_tissue: f64, by_muscle: f64) -> Self {
        let base = self.base.iter().zip(tissue).map(|(k, t)| by_tissue * t + by_muscle * (k - t)).collect();
        let scaled = |part: &Vec<(usize, f64)>| part.iter().map(|&(at, k)| (at, by_muscle * k)).collect();
        Self { pattern: self.pattern.clone(), base, parts: self.parts.iter().map(scaled).collect() }
    }

    /// Where the values stand.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Values of `K` on [`pattern`](Self::pattern); `coefficients` holds one value a part, N/mm².
    pub fn at(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut values = self.base.clone();
        for (part, &c) in self.parts.iter().zip(coefficients) {
            for &(at, value) in part {
                values[at] += c * value;
            }
        }
        values
    }

    /// Adds `c K_part u` to `out` (3n), N.
    pub fn add_part_product(&self, part: usize, c: f64, u: &[f64], out: &mut [f64]) {
        let entries = &self.parts[part];
        let mut k = 0;
        for column in 0..u.len() {
            let range = self.pattern.column(column);
            if k == entries.len() {
                break;
            }
            if entries[k].0 >= range.end {
                continue;
            }
            let rows: Vec<usize> = self.pattern.rows(column).collect();
            while k < entries.len() && entries[k].0 < range.end {
                let (row, value) = (rows[entries[k].0 - range.start], entries[k].1);
                out[row] += c * value * u[column];
                if row != column {
                    out[column] += c * value * u[row];
                }
                k += 1;
            }
        }
    }
}
