//! A tree of boxes: which items may hold a point, which may be nearest to it.

use crate::units::Vec3;

const LEAF_SIZE: usize = 4;

/// Depth of the deepest tree there can be, and more: halving items down to leaves ends before.
const DEEPEST: usize = usize::BITS as usize;

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
        (0..3).all(|k| self.lo[k] <= other.hi[k] && other.lo[k] <= self.hi[k])
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
    boxes: Vec<Aabb>,
}

impl Bvh {
    pub(crate) fn new(boxes: Vec<Aabb>) -> Self {
        let mut tree = Self { nodes: Vec::new(), items: (0..boxes.len()).collect(), boxes };
        if !tree.items.is_empty() {
            tree.build(0, tree.items.len());
        }
        tree
    }

    fn build(&mut self, start: usize, end: usize) -> usize {
        let boxes = &self.boxes;
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
        let first = self.build(start, start + middle);
        let second = self.build(start + middle, end);
        let node = &mut self.nodes[me];
        (node.leaf, node.first, node.second) = (false, first, second);
        me
    }

    /// The same tree over items that have moved, to `boxes` in the order of the first ones.
    pub(crate) fn refitted(&self, boxes: Vec<Aabb>) -> Self {
        let mut tree = Self { nodes: self.nodes.clone(), items: self.items.clone(), boxes };
        // Children come after their parent.
        for k in (0..tree.nodes.len()).rev() {
            let node = &tree.nodes[k];
            let bounds = if node.leaf {
                let items = &tree.items[node.first..node.second];
                items[1..].iter().fold(tree.boxes[items[0]], |b, &i| b.joined(&tree.boxes[i]))
            } else {
                tree.nodes[node.first].bounds.joined(&tree.nodes[node.second].bounds)
            };
            tree.nodes[k].bounds = bounds;
        }
        tree
    }

    /// Calls `visit` with every item whose box overlaps `bounds`.
    pub(crate) fn for_each_overlapping(&self, bounds: &Aabb, mut visit: impl FnMut(usize)) {
        let mut stack = [0; DEEPEST];
        let mut waiting = self.nodes.len().min(1);
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting]];
            if !node.bounds.overlaps(bounds) {
                continue;
            }
            if node.leaf {
                let items = &self.items[node.first..node.second];
                items.iter().filter(|&&item| self.boxes[item].overlaps(bounds)).for_each(|&item| visit(item));
            } else {
                stack[waiting] = node.second;
                stack[waiting + 1] = node.first;
                waiting += 2;
            }
        }
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
            for &item in &self.items[node.first..node.second] {
                if self.boxes[item].distance(p) <= margin {
                    visit(item);
                }
            }
        }
    }

    /// Calls `visit` with items until none that is left can be nearer to `p` than the greatest
    /// distance that `visit` last returned; nearer branches go first.
    pub(super) fn for_each_near(&self, p: Vec3, mut visit: impl FnMut(usize) -> f64) {
        let mut reach = f64::INFINITY;
        let mut stack: Vec<(f64, usize)> = (0..self.nodes.len().min(1)).map(|k| (0., k)).collect();
        while let Some((distance, k)) = stack.pop() {
            if distance > reach {
                continue;
            }
            let node = &self.nodes[k];
            if node.leaf {
                for &item in &self.items[node.first..node.second] {
                    if self.boxes[item].distance(p) <= reach {
                        reach = visit(item);
                    }
                }
                continue;
            }
            let [a, b] = [node.first, node.second].map(|k| (self.nodes[k].bounds.distance(p), k));
            stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
        }
    }
}
