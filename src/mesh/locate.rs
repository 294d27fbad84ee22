//! Point location: which cell holds a point, or which point of the mesh is closest.

use std::cmp::Ordering;

use super::bvh::{Aabb, Bvh};
use super::closest::{FacetPoint, closest_on_facet, corner_weights};
use super::quality::jacobian;
use super::{CellKind, Extent, Facet, MAX_NODES, Mesh, Site, boundary_facets};
use crate::units::Vec3;

/// Reference coordinates beyond which a point counts as outside a cell.
const INSIDE: f64 = 1e-10;
/// The same for a point that no cell holds by [`INSIDE`], so that round-off on an inner face does not
/// send it to the boundary.
const NEARLY_INSIDE: f64 = 1e-6;
const NEWTON_STEPS: usize = 40;

/// Where a point is in a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Located {
    /// The material point: the query itself inside, the closest point of the boundary outside.
    pub site: Site,
    /// The cell (0-based) that holds it.
    pub cell: usize,
    /// Its reference coordinates there.
    pub xi: Vec3,
    /// Distance from the query to the mesh, mm; 0 inside.
    pub distance_mm: f64,
}

/// A spatial index of a mesh that finds the cell and the weights of points.
///
/// A point that several cells hold goes to the one in which it lies deepest, then to the first; equally
/// close boundary points are told apart by height, depth and distance from the mid-sagittal plane, so
/// that a mirrored mesh gives the mirrored answer.
pub struct Locator {
    mesh: Mesh,
    facets: Vec<Facet>,
    cell_tree: Bvh,
    facet_tree: Bvh,
    tolerance_mm: f64,
}

impl Locator {
    /// The index of `mesh`.
    ///
    /// # Panics
    /// If a cell has a node that the mesh has not.
    pub fn new(mesh: &Mesh) -> Self {
        let facets = boundary_facets(mesh);
        let cell_boxes = mesh.cells.iter().map(|c| {
            let kind = c.kind();
            curved_box(&mesh.points, c.nodes(), kind.edges(), kind.mid_edge_nodes())
        });
        let facet_boxes = facets.iter().map(|f| {
            let mids: &[usize] = if f.nodes().len() == 6 { &[3, 4, 5] } else { &[] };
            curved_box(&mesh.points, f.nodes(), &[[0, 1], [1, 2], [2, 0]], mids)
        });
        let (cell_tree, facet_tree) =
            (Bvh::new(&cell_boxes.collect::<Vec<_>>()), Bvh::new(&facet_boxes.collect::<Vec<_>>()));
        let Extent { lo, hi } = mesh.extent();
        let bare = Mesh::new(mesh.points.clone(), mesh.cells.clone());
        Self { mesh: bare, facets, cell_tree, facet_tree, tolerance_mm: 1e-10 * (hi - lo).norm() }
    }

    /// The facets that bound the mesh.
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Where `point` (mm) is: the cell that holds it, or the closest point of the boundary; `None` if the
    /// mesh has no cell or `point` is not finite.
    pub fn locate(&self, point: Vec3) -> Option<Located> {
        if !point.iter().all(|x| x.is_finite()) {
            return None;
        }
        self.containing(point).or_else(|| self.closest(point))
    }

    /// The cell that holds `point` (mm), or `None` outside.
    pub fn containing(&self, point: Vec3) -> Option<Located> {
        let mut best: Option<(f64, usize, Vec3)> = None;
        self.for_each_holding(
            point,
            |_| true,
            |cell, xi, outside| {
                let better = best.is_none_or(|(least, first, _)| {
                    outside < least - INSIDE || (outside <= least + INSIDE && cell < first)
                });
                if better {
                    best = Some((outside, cell, xi));
                }
            },
        );
        let (_, cell, xi) = best?;
        let mut site = Site::in_cell(&self.mesh.cells[cell], xi, &self.mesh.points);
        site.position = point;
        Some(Located { site, cell, xi, distance_mm: 0.0 })
    }

    /// Every cell (0-based, ascending) among those that `accept` takes that holds `point` (mm): more than one on a face
    /// between cells, and where a deformed mesh passes through itself.
    pub fn all_containing(&self, point: Vec3, accept: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut cells = Vec::new();
        self.for_each_holding(point, accept, |cell, _, _| cells.push(cell));
        cells.sort_unstable();
        cells
    }

    /// Calls `visit` with the cells that hold `point`, its reference coordinates and how far these are outside.
    fn for_each_holding(
        &self,
        point: Vec3,
        accept: impl Fn(usize) -> bool,
        mut visit: impl FnMut(usize, Vec3, f64),
    ) {
        self.cell_tree.for_each_at(point, self.tolerance_mm, |cell| {
            if !accept(cell) {
                return;
            }
            let Some(xi) = self.reference_coordinates(cell, point) else { return };
            let outside = self.mesh.cells[cell].kind().signed_outside(xi);
            if outside <= NEARLY_INSIDE {
                visit(cell, xi, outside);
            }
        });
    }

    /// The point of the boundary closest to `point` (mm), which may lie inside; `None` without cells or
    /// for a point that is not finite.
    pub fn closest(&self, point: Vec3) -> Option<Located> {
        self.closest_among(point, |_| true)
    }

    /// [`closest`](Self::closest) on the facets that `accept` takes; `None` if it takes none.
    pub fn closest_among(&self, point: Vec3, accept: impl Fn(&Facet) -> bool) -> Option<Located> {
        let mut near: Vec<(usize, FacetPoint)> = Vec::new();
        let mut least = f64::INFINITY;
        self.facet_tree.for_each_near(point, |k| {
            let facet = &self.facets[k];
            if !accept(facet) {
                return least + self.tolerance_mm;
            }
            let mut x = [Vec3::zeros(); 6];
            for (x, &node) in x.iter_mut().zip(facet.nodes()) {
                *x = self.mesh.points[node];
            }
            let found = closest_on_facet(&x[..facet.nodes().len()], point);
            least = least.min(found.distance);
            near.push((k, found));
            least + self.tolerance_mm
        });
        near.retain(|(_, found)| found.distance <= least + self.tolerance_mm);
        let by_place = |a: &(usize, FacetPoint), b: &(usize, FacetPoint)| {
            let key = |p: Vec3| [p.y, p.z, p.x.abs()];
            let (ka, kb) = (key(a.1.position), key(b.1.position));
            // Wider than the tolerance of the distance, along which two close points may differ more.
            let same = 1e4 * self.tolerance_mm;
            let differs = (0..3).find(|&k| (ka[k] - kb[k]).abs() > same);
            differs.map_or(Ordering::Equal, |k| ka[k].total_cmp(&kb[k])).then(a.0.cmp(&b.0))
        };
        let (k, found) =
            near.into_iter().reduce(|best, next| if by_place(&next, &best).is_lt() { next } else { best })?;
        let facet = &self.facets[k];
        let cell = &self.mesh.cells[facet.cell];
        let corners = cell.kind().faces()[facet.face];
        let reference = cell.kind().node_positions();
        let weights = corner_weights(corners.len(), found.r, found.s);
        let xi = corners.iter().zip(weights).map(|(&c, w)| w * Vec3::from(reference[c])).sum();
        let site = Site::in_cell(cell, xi, &self.mesh.points);
        let distance_mm = (site.position - point).norm();
        Some(Located { site, cell: facet.cell, xi, distance_mm })
    }

    /// Reference coordinates of `point` in `cell` by Newton, or `None` far outside or where it diverges.
    fn reference_coordinates(&self, cell: usize, point: Vec3) -> Option<Vec3> {
        let kind = self.mesh.cells[cell].kind();
        let mut x = [Vec3::zeros(); MAX_NODES];
        for (x, p) in x.iter_mut().zip(self.mesh.cell_points(cell)) {
            *x = p;
        }
        let x = &x[..kind.n_nodes()];
        newton(kind, x, point, kind.centre()).or_else(|| {
            // A distorted cell may need a start nearer to the answer.
            let gap = |k: &usize| (x[*k] - point).norm_squared();
            let nearest = (0..x.len()).min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
            let node = Vec3::from(kind.node_positions()[nearest]);
            newton(kind, x, point, kind.centre().lerp(&node, 0.8))
        })
    }
}

fn newton(kind: CellKind, x: &[Vec3], point: Vec3, start: Vec3) -> Option<Vec3> {
    let mut xi = start;
    let mut last = f64::INFINITY;
    for _ in 0..NEWTON_STEPS {
        let shape = kind.shape(xi);
        let gap: Vec3 = x.iter().zip(shape).map(|(x, w)| w * x).sum::<Vec3>() - point;
        let step = jacobian(kind, x, xi).lu().solve(&gap)?;
        xi -= step;
        // A NaN fails every comparison, so the test is for what may go on.
        let near = xi.abs().max() < 20.;
        if !near {
            return None;
        }
        let size = step.abs().max();
        // In a cell that is flat against its coordinates rounding keeps the steps from getting smaller.
        if size < 1e-13 || (size < 0.1 * NEARLY_INSIDE && size >= 0.5 * last) {
            return Some(xi);
        }
        last = size;
        // The map of these kinds is linear, so the first step was the last.
        if kind == CellKind::Tet4 {
            return Some(xi);
        }
    }
    None
}

/// A box around a cell or facet: a quadratic edge stays inside the hull of its ends and
/// `2 mid - (a + b) / 2`, its Bezier control point.
fn curved_box(points: &[Vec3], nodes: &[usize], edges: &[[usize; 2]], mids: &[usize]) -> Aabb {
    let at = |k: usize| points[nodes[k]];
    let control = edges.iter().zip(mids).map(|(&[a, b], &mid)| 2. * at(mid) - 0.5 * (at(a) + at(b)));
    Aabb::around((0..nodes.len()).map(at).chain(control))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Cell;
    use crate::mesh::testing::{block, single};

    /// Deterministic numbers in [0, 1).
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    fn distorted_block() -> Mesh {
        let mut mesh = block([4, 3, 3]);
        let mut next = numbers();
        for p in &mut mesh.points {
            *p += 3. * Vec3::new(next() - 0.5, next() - 0.5, next() - 0.5);
        }
        mesh
    }

    #[test]
    fn a_point_on_an_inner_face_of_flat_cells_is_inside() {
        // Cells of 10 x 10 mm and 0.1 um: rounding of a coordinate is 1e-9 of their height. What is on the face
        // between two of them must not be sent to the boundary.
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.7, 1.1);
        let mut mesh = block([3, 3, 4]);
        let Extent { lo, hi } = mesh.extent();
        for p in &mut mesh.points {
            let share = (*p - lo).component_div(&(hi - lo));
            *p = turn * Vec3::new(30. * share.x, 30. * share.y, 4e-4 * share.z) + Vec3::repeat(300.);
        }
        let locator = Locator::new(&mesh);
        let mut next = numbers();
        let top = |cell: &Cell| {
            cell.nodes()[4..].iter().all(|n| mesh.cells.iter().any(|c| c.nodes()[..4].contains(n)))
        };
        let inner: Vec<&Cell> = mesh.cells.iter().filter(|cell| top(cell)).collect();
        for cell in inner.iter().cycle().take(400) {
            let p = Site::in_cell(cell, Vec3::new(next() - 0.5, next() - 0.5, 1.), &mesh.points).position;
            let found = locator.containing(p);
            assert!(found.is_some(), "{p:?} is in no cell");
        }
    }

    #[test]
    fn points_inside_are_found_and_carried_by_their_weights() {
        let mesh = distorted_block();
        let locator = Locator::new(&mesh);
        let mut next = numbers();
        for (index, cell) in mesh.cells.iter().enumerate() {
            let xi = 1.98 * (Vec3::new(next(), next(), next()) - Vec3::repeat(0.5));
            let p = Site::in_cell(cell, xi, &mesh.points).position;
            let found = locator.locate(p).expect("the mesh has cells");
            assert_eq!((found.cell, found.distance_mm), (index, 0.));
            assert!((found.xi - xi).norm() < 1e-9);
            let carried: Vec3 = found.site.weights.iter().map(|&(n, w)| w * mesh.points[n]).sum();
            assert!((carried - p).norm() < 1e-11);
        }
    }

    #[test]
    fn every_kind_finds_its_nodes_and_its_centre() {
        for kind in CellKind::ALL {
            let mesh = single(kind);
            let locator = Locator::new(&mesh);
            for (node, p) in mesh.points.iter().enumerate() {
                let found = locator.locate(*p).expect("the mesh has a cell");
                assert_eq!(found.distance_mm, 0., "{kind:?} {node}");
                assert_eq!(found.site.weights.len(), 1, "{kind:?} {:?}", found.site.weights);
                assert_eq!(found.site.weights[0].0, node);
            }
            assert_eq!(locator.locate(10. * kind.centre()).map(|l| l.distance_mm), Some(0.));
        }
    }

    #[test]
    fn points_outside_go_to_the_closest_point_of_the_boundary() {
        let locator = Locator::new(&block([2, 2, 2]));
        for (p, closest) in [
            (Vec3::new(7., 6., 23.), Vec3::new(7., 6., 20.)),
            (Vec3::new(-3., 6., 24.), Vec3::new(0., 6., 20.)),
            (Vec3::new(-3., -4., 32.), Vec3::new(0., 0., 20.)),
        ] {
            let found = locator.locate(p).expect("the mesh has cells");
            assert!((found.site.position - closest).norm() < 1e-12, "{:?}", found.site.position);
            assert!((found.distance_mm - (p - closest).norm()).abs() < 1e-12);
            assert!((found.site.weights.iter().map(|w| w.1).sum::<f64>() - 1.).abs() < 1e-12);
        }
        assert_eq!(locator.locate(Vec3::new(0., f64::NAN, 0.)), None);
        assert!(Locator::new(&Mesh::default()).locate(Vec3::zeros()).is_none());
    }

    #[test]
    fn a_mirrored_mesh_gives_the_mirrored_answer() {
        let mesh = distorted_block();
        let swap = [1, 0, 3, 2, 5, 4, 7, 6];
        let mirrored = Mesh::new(
            mesh.points.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect(),
            // Reversed, so that ties by cell number would show.
            mesh.cells
                .iter()
                .rev()
                .map(|c| Cell::new(CellKind::Hex8, &swap.map(|k: usize| c.nodes()[k])))
                .collect(),
        );
        let (one, other) = (Locator::new(&mesh), Locator::new(&mirrored));
        let mut next = numbers();
        for k in 0..500 {
            let p = match mesh.points.get(k) {
                Some(node) => *node,
                None => Vec3::new(60. * next() - 10., 50. * next() - 10., 50. * next() - 10.),
            };
            let a = one.locate(p).expect("the mesh has cells").site;
            let b = other.locate(Vec3::new(-p.x, p.y, p.z)).expect("the mesh has cells").site;
            assert_eq!(a.weights.len(), b.weights.len());
            for (wa, wb) in a.weights.iter().zip(&b.weights) {
                assert!(wa.0 == wb.0 && (wa.1 - wb.1).abs() < 1e-9, "{p:?} {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn equally_close_points_are_told_apart_by_place_not_by_cell_order() {
        // Two blocks, one over the other: a point half way between them goes to the lower one.
        let lower = block([1, 1, 1]);
        let points: Vec<Vec3> =
            lower.points.iter().copied().chain(lower.points.iter().map(|p| p + Vec3::y() * 20.)).collect();
        let cell = |shift: usize| Cell::new(CellKind::Hex8, &[0, 1, 3, 2, 4, 5, 7, 6].map(|k| k + shift));
        for cells in [vec![cell(0), cell(8)], vec![cell(8), cell(0)]] {
            let mesh = Mesh::new(points.clone(), cells);
            let found = Locator::new(&mesh).locate(Vec3::new(5., 15., 5.)).expect("the mesh has cells");
            assert!((found.site.position.y - 10.).abs() < 1e-12);
        }
    }
}
