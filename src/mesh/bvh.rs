//! A tree of boxes: which items may hold a point, which may be nearest to it.

use std::collections::VecDeque;
use std::ptr;

use crate::units::Vec3;

const LEAF_SIZE: usize = 4;

/// A box with its least and greatest corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub(crate) lo: Vec3,
    pub(crate) hi: Vec3,
}

impl Aabb {
    const EMPTY: f64 = f64::INFINITY;

    pub(crate) fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        let empty = Self { lo: Vec3::repeat(Self::EMPTY), hi: Vec3::repeat(-Self::EMPTY) };
        points.into_iter().fold(empty, |b, p| Self { lo: b.lo.inf(&p), hi: b.hi.sup(&p) })
    }

    /// The box widened by `margin` on every side.
    pub(crate) fn widened(self, margin: f64) -> Self {
        Self { lo: self.lo.add_scalar(-margin), hi: self.hi.add_scalar(margin) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        // Without branches, which nearby boxes would mispredict.
        (self.lo.x <= other.hi.x)
            & (other.lo.x <= self.hi.x)
            & (self.lo.y <= other.hi.y)
            & (other.lo.y <= self.hi.y)
            & (self.lo.z <= other.hi.z)
            & (other.lo.z <= self.hi.z)
    }

    /// Sum of its sides.
    fn size(&self) -> f64 {
        (self.hi - self.lo).sum()
    }

    fn joined(self, other: &Self) -> Self {
        Self { lo: self.lo.inf(&other.lo), hi: self.hi.sup(&other.hi) }
    }

    fn centre(&self) -> Vec3 {
        0.5 * (self.lo + self.hi)
    }

    /// Distance from `p`, 0 inside.
    fn distance(&self, p: Vec3) -> f64 {
        (self.lo - p).sup(&(p - self.hi)).sup(&Vec3::zeros()).norm()
    }
}

#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb,
    /// Range of `items` in a leaf, the two children otherwise.
    leaf: bool,
    first: usize,
    second: usize,
}

/// A bounding volume hierarchy over items that are known by their position in a list.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    items: Vec<usize>,
    /// In the order of `items`.
    boxes: Vec<Aabb>,
}

impl Bvh {
    pub(crate) fn new(boxes: &[Aabb]) -> Self {
        let mut tree = Self { nodes: Vec::new(), items: (0..boxes.len()).collect(), boxes: Vec::new() };
        if !tree.items.is_empty() {
            tree.build(boxes, 0, tree.items.len());
        }
        tree.boxes = tree.items.iter().map(|&item| boxes[item]).collect();
        tree
    }

    fn build(&mut self, boxes: &[Aabb], start: usize, end: usize) -> usize {
        let items = &mut self.items[start..end];
        let bounds = items[1..].iter().fold(boxes[items[0]], |b, &i| b.joined(&boxes[i]));
        let me = self.nodes.len();
        self.nodes.push(Node { bounds, leaf: true, first: start, second: end });
        if items.len() <= LEAF_SIZE {
            return me;
        }
        let axis = (bounds.hi - bounds.lo).imax();
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |&i, &j| {
            boxes[i].centre()[axis].total_cmp(&boxes[j].centre()[axis]).then(i.cmp(&j))
        });
        let first = self.build(boxes, start, start + middle);
        let second = self.build(boxes, start + middle, end);
        let node = &mut self.nodes[me];
        (node.leaf, node.first, node.second) = (false, first, second);
        me
    }

    /// The same tree over items that have moved, to `boxes` in the order of the first ones.
    pub(crate) fn refitted(&self, boxes: &[Aabb]) -> Self {
        let boxes: Vec<Aabb> = self.items.iter().map(|&item| boxes[item]).collect();
        let mut nodes = self.nodes.clone();
        // Children come after their parent.
        for k in (0..nodes.len()).rev() {
            let node = &nodes[k];
            nodes[k].bounds = if node.leaf {
                let own = &boxes[node.first..node.second];
                own[1..].iter().fold(own[0], |b, next| b.joined(next))
            } else {
                nodes[node.first].bounds.joined(&nodes[node.second].bounds)
            };
        }
        Self { nodes, items: self.items.clone(), boxes }
    }

    /// Nodes of this tree and of `other` below which all pairs of items whose boxes overlap are found, at least `n` where
    /// there are so many: each is a task for [`pairs_below`](Self::pairs_below). Of a tree and itself each pair once.
    pub(crate) fn meetings(&self, other: &Self, n: usize) -> Vec<[usize; 2]> {
        let mut waiting = VecDeque::new();
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            waiting.push_back([0, 0]);
        }
        let mut done = Vec::new();
        while waiting.len() + done.len() < n
            && let Some(meeting) = waiting.pop_front()
        {
            match self.halves(other, meeting) {
                Some(halves) => waiting.extend(halves),
                None => done.push(meeting),
            }
        }
        done.extend(waiting);
        done
    }

    /// Calls `visit` with an item of this tree and one of `other` for all whose boxes overlap below the nodes `meeting`.
    pub(crate) fn pairs_below(&self, other: &Self, meeting: [usize; 2], mut visit: impl FnMut(usize, usize)) {
        let mut stack = vec![meeting];
        while let Some([a, b]) = stack.pop() {
            if !self.nodes[a].bounds.overlaps(&other.nodes[b].bounds) {
                continue;
            }
            if let Some(halves) = self.halves(other, [a, b]) {
                stack.extend(halves);
                continue;
            }
            let (mine, others) = (&self.nodes[a], &other.nodes[b]);
            for i in (mine.first..mine.second).filter(|&i| self.boxes[i].overlaps(&others.bounds)) {
                let start = if self.is_own(other, [a, b]) { i + 1 } else { others.first };
                for j in start..others.second {
                    if self.boxes[i].overlaps(&other.boxes[j]) {
                        visit(self.items[i], other.items[j]);
                    }
                }
            }
        }
    }

    /// Whether a meeting is that of a node with itself.
    fn is_own(&self, other: &Self, [a, b]: [usize; 2]) -> bool {
        a == b && ptr::eq(self, other)
    }

    /// The meetings that `[a, b]` is made of, where not both are leaves.
    fn halves(&self, other: &Self, [a, b]: [usize; 2]) -> Option<impl Iterator<Item = [usize; 2]> + use<>> {
        let (mine, others) = (&self.nodes[a], &other.nodes[b]);
        let halves = if mine.leaf && others.leaf {
            return None;
        } else if self.is_own(other, [a, b]) {
            [
                Some([mine.first, mine.first]),
                Some([mine.second, mine.second]),
                Some([mine.first, mine.second]),
            ]
        } else if others.leaf || (!mine.leaf && mine.bounds.size() >= others.bounds.size()) {
            [Some([mine.first, b]), Some([mine.second, b]), None]
        } else {
            [Some([a, others.first]), Some([a, others.second]), None]
        };
        Some(halves.into_iter().flatten())
    }

    /// Calls `visit` with every item whose box, widened by `margin`, holds `p`.
    pub(super) fn for_each_at(&self, p: Vec3, margin: f64, mut visit: impl FnMut(usize)) {
        let mut stack: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        while let Some(node) = stack.pop().map(|k| &self.nodes[k]) {
            if node.bounds.distance(p) > margin {
                continue;
            }
            if !node.leaf {
                stack.extend([node.second, node.first]);
                continue;
            }
            for k in node.first..node.second {
                if self.boxes[k].distance(p) <= margin {
                    visit(self.items[k]);
                }
            }
        }
    }

    /// Calls `visit` with items until none that is left can be nearer to `p` than the greatest
    /// distance that `visit` last returned; nearer branches go first.
    pub(crate) fn for_each_near(&self, p: Vec3, mut visit: impl FnMut(usize) -> f64) {
        let mut reach = f64::INFINITY;
        let mut stack: Vec<(f64, usize)> = (0..self.nodes.len().min(1)).map(|k| (0., k)).collect();
        while let Some((distance, k)) = stack.pop() {
            if distance > reach {
                continue;
            }
            let node = &self.nodes[k];
            if node.leaf {
                for k in node.first..node.second {
                    if self.boxes[k].distance(p) <= reach {
                        reach = visit(self.items[k]);
                    }
                }
                continue;
            }
            let [a, b] = [node.first, node.second].map(|k| (self.nodes[k].bounds.distance(p), k));
            stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of up to 1 mm on a spiral.
    fn boxes(n: usize, shift: f64) -> Vec<Aabb> {
        let place = |k: usize| {
            let t = k as f64 * 0.7 + shift;
            Vec3::new(3. * t.cos(), 3. * t.sin(), 0.02 * t)
        };
        (0..n)
            .map(|k| Aabb::around([place(k), place(k) + Vec3::new(0.7, 0.5, 0.3 + 0.01 * (k % 9) as f64)]))
            .collect()
    }

    fn found(a: &Bvh, b: &Bvh, tasks: usize) -> Vec<[usize; 2]> {
        let mut pairs = Vec::new();
        for meeting in a.meetings(b, tasks) {
            a.pairs_below(b, meeting, |i, j| pairs.push([i, j]));
        }
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn boxes_of_two_trees_that_overlap_are_met_once_also_after_they_moved() {
        for (n, m) in [(0, 5), (1, 1), (3, 40), (150, 90)] {
            for shift in [0., 0.4] {
                let [first, second] = [boxes(n, shift), boxes(m, 0.2 - shift)];
                let trees =
                    [Bvh::new(&boxes(n, 0.)).refitted(&first), Bvh::new(&boxes(m, 5.)).refitted(&second)];
                let all = (0..n).flat_map(|i| (0..m).map(move |j| [i, j]));
                let expected: Vec<_> = all.filter(|&[i, j]| first[i].overlaps(&second[j])).collect();
                for tasks in [1, 7, 1000] {
                    assert_eq!(found(&trees[0], &trees[1], tasks), expected, "{n} {m}");
                }
            }
        }
    }

    #[test]
    fn boxes_of_one_tree_that_overlap_are_met_once() {
        let all = boxes(130, 0.);
        let tree = Bvh::new(&all);
        let pairs = (0..130).flat_map(|i| (0..i).map(move |j| [j, i]));
        let mut expected: Vec<_> = pairs.filter(|&[i, j]| all[i].overlaps(&all[j])).collect();
        expected.sort_unstable();
        assert!(expected.len() > 130);
        for tasks in [1, 7, 1000] {
            let mut met: Vec<_> =
                found(&tree, &tree, tasks).iter().map(|&[i, j]| [i.min(j), i.max(j)]).collect();
            met.sort_unstable();
            assert_eq!(met, expected);
        }
    }
}
