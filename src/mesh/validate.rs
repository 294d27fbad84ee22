//! Whether a mesh can be computed with.

use std::collections::{BTreeMap, HashMap};

use super::connectivity::check_supports;
use super::facet::faces_by_corners;
use super::{Cell, Facet, Mesh, MeshError, MeshWarning, Quality};
use crate::units::Vec3;

/// Least size of a face mesh, mm.
pub(super) const MIN_EXTENT_MM: f64 = 5.0;
/// Greatest size of a face mesh, mm.
pub(crate) const MAX_EXTENT_MM: f64 = 1000.0;
/// How many numbers a message lists.
pub(super) const SHOWN: usize = 8;

/// Below this scaled Jacobian a cell is a sliver.
const SLIVER: f64 = 0.1;
/// Below this ratio of least and greatest Jacobian a cell is distorted.
const DISTORTED: f64 = 0.1;
/// Below this ratio of thickness and width a cell is thin.
const THIN: f64 = 1. / 30.;
/// Nodes closer than this times the size of the mesh are at one place.
const COINCIDENT: f64 = 1e-7;
/// Farthest a mid-edge node may be from the middle, over the length of the edge.
const MID_EDGE: f64 = 0.25;

/// Checks that `mesh`, held at the nodes `fixed` (0-based) in all three directions, can be computed with.
///
/// All that [`validate_shape`] checks, then that no part of the mesh can move rigidly: no supports, too
/// few supports, parts that are joined to nothing fixed, and hinges.
///
/// # Errors
/// The first thing wrong, with the numbers of nodes and cells as in the file, and the fix.
pub fn validate(mesh: &Mesh, fixed: &[usize]) -> Result<Vec<MeshWarning>, MeshError> {
    let warnings = validate_shape(mesh)?;
    check_supports(mesh, fixed)?;
    Ok(warnings)
}

/// Checks that `mesh` is well formed wherever it may be held: coordinates, size, cells and how they meet.
///
/// # Errors
/// The first thing wrong, with the numbers of nodes and cells as in the file, and the fix.
pub fn validate_shape(mesh: &Mesh) -> Result<Vec<MeshWarning>, MeshError> {
    if mesh.cells.is_empty() {
        return Err(MeshError::NoCells);
    }
    check_points(mesh)?;
    for (k, cell) in mesh.cells.iter().enumerate() {
        check_nodes(mesh, k, cell)?;
    }
    check_extent(mesh)?;
    let mut warnings = check_quality(mesh)?;
    for (k, cell) in mesh.cells.iter().enumerate() {
        check_mid_edges(mesh, k, cell)?;
    }
    check_faces(mesh)?;
    warnings.extend(coincident_nodes(mesh));
    warnings.extend(orphan_nodes(mesh));
    Ok(warnings)
}

fn check_points(mesh: &Mesh) -> Result<(), MeshError> {
    for (node, p) in mesh.points.iter().enumerate() {
        if let Some((axis, value)) = ['x', 'y', 'z'].into_iter().zip(p.iter()).find(|(_, x)| !x.is_finite()) {
            return Err(MeshError::NotFinite { node: mesh.node_id(node), axis, value: *value });
        }
    }
    Ok(())
}

fn check_nodes(mesh: &Mesh, k: usize, cell: &Cell) -> Result<(), MeshError> {
    let nodes = cell.nodes();
    for (position, &node) in nodes.iter().enumerate() {
        if node >= mesh.n_nodes() {
            return Err(MeshError::MissingNode { cell: mesh.cell_id(k), node, n_nodes: mesh.n_nodes() });
        }
        if nodes[..position].contains(&node) {
            return Err(MeshError::RepeatedNode { cell: mesh.cell_id(k), node: mesh.node_id(node) });
        }
    }
    Ok(())
}

fn check_extent(mesh: &Mesh) -> Result<(), MeshError> {
    let extent_mm = mesh.extent().longest_mm();
    if (MIN_EXTENT_MM..=MAX_EXTENT_MM).contains(&extent_mm) {
        Ok(())
    } else {
        Err(MeshError::Extent { extent_mm })
    }
}

fn check_quality(mesh: &Mesh) -> Result<Vec<MeshWarning>, MeshError> {
    let qualities: Vec<Quality> = mesh.cells.iter().map(|c| Quality::new(c, &mesh.points)).collect();
    for (k, (quality, cell)) in qualities.iter().zip(&mesh.cells).enumerate() {
        let longest = cell
            .kind()
            .edges()
            .iter()
            .map(|&[a, b]| (mesh.points[cell.nodes()[a]] - mesh.points[cell.nodes()[b]]).norm())
            .fold(0., f64::max);
        let jacobian = [quality.max_jacobian, quality.min_jacobian, quality.node_jacobian]
            .iter()
            .fold(0., |m, j| j.abs().max(m));
        if jacobian <= 1e-9 * longest.powi(3) {
            return Err(MeshError::ZeroVolume { cell: mesh.cell_id(k), jacobian });
        }
    }
    let inverted: Vec<usize> = (0..qualities.len()).filter(|&k| qualities[k].is_inverted()).collect();
    if let Some(&first) = inverted.first() {
        return Err(MeshError::Inverted {
            cells: inverted.iter().take(SHOWN).map(|&k| mesh.cell_id(k)).collect(),
            count: inverted.len(),
            jacobian: qualities[first].min_jacobian.min(qualities[first].node_jacobian),
            everywhere: qualities[first].max_jacobian <= 0.,
        });
    }
    let worst_of = |measure: fn(&Quality) -> f64, limit: f64| {
        let mut bad: Vec<usize> = (0..qualities.len()).filter(|&k| measure(&qualities[k]) < limit).collect();
        bad.sort_by(|&i, &j| measure(&qualities[i]).total_cmp(&measure(&qualities[j])));
        let worst = measure(&qualities[*bad.first()?]);
        let cells = bad.iter().take(SHOWN).map(|&k| mesh.cell_id(k)).collect();
        Some((cells, bad.len(), worst))
    };
    let slivers = worst_of(|q| q.scaled_jacobian, SLIVER).map(|(cells, count, worst)| MeshWarning::Slivers {
        cells,
        count,
        worst,
    });
    let distorted = worst_of(Quality::jacobian_ratio, DISTORTED)
        .map(|(cells, count, worst)| MeshWarning::Distorted { cells, count, worst });
    let thin = worst_of(|q| if q.scaled_jacobian < SLIVER { 1. } else { q.thickness_ratio }, THIN)
        .map(|(cells, count, worst)| MeshWarning::Thin { cells, count, worst });
    Ok(slivers.into_iter().chain(distorted).chain(thin).collect())
}

fn check_mid_edges(mesh: &Mesh, k: usize, cell: &Cell) -> Result<(), MeshError> {
    let at = |local: usize| mesh.points[cell.nodes()[local]];
    for (&[a, b], &mid) in cell.kind().edges().iter().zip(cell.kind().mid_edge_nodes()) {
        let offset_mm = (at(mid) - 0.5 * (at(a) + at(b))).norm();
        let edge_mm = (at(b) - at(a)).norm();
        if offset_mm > MID_EDGE * edge_mm {
            let (cell, node) = (mesh.cell_id(k), mesh.node_id(cell.nodes()[mid]));
            return Err(MeshError::MidEdgeNode { cell, node, offset_mm, edge_mm });
        }
    }
    Ok(())
}

fn check_faces(mesh: &Mesh) -> Result<(), MeshError> {
    let mismatch = |a: &Facet, b: &Facet| MeshError::MismatchedFaces {
        first: mesh.cell_id(a.cell),
        second: mesh.cell_id(b.cell),
        first_nodes: a.nodes().len(),
        second_nodes: b.nodes().len(),
    };
    let mut faces: Vec<Vec<Facet>> = faces_by_corners(mesh).into_values().collect();
    // The map has no order, and the first error must be the same in every run.
    faces.sort_unstable_by_key(|owners| (owners[0].cell, owners[0].face));
    let mut boundary = Vec::new();
    for owners in &faces {
        match owners[..] {
            [only] => boundary.push(only),
            [a, b] => {
                let sorted = |f: &Facet| {
                    let mut nodes = f.nodes().to_vec();
                    nodes.sort_unstable();
                    nodes
                };
                if sorted(&a) != sorted(&b) {
                    return Err(mismatch(&a, &b));
                }
            }
            _ => {
                let cells = owners.iter().map(|f| mesh.cell_id(f.cell)).collect();
                return Err(MeshError::SharedFace { cells });
            }
        }
    }
    if let Some((a, b)) = half_covered(&boundary) {
        return Err(mismatch(&a, &b));
    }
    if let Some((a, b)) = crossed_diagonals(&boundary) {
        return Err(mismatch(&a, &b));
    }
    check_hanging(mesh, &boundary)
}

/// Two triangles on one pair of corners against two on the other pair: the same quadrilateral, split along one diagonal
/// by the cells on one side and along the other by those on the other side.
fn crossed_diagonals(boundary: &[Facet]) -> Option<(Facet, Facet)> {
    let mut apexes: BTreeMap<[usize; 2], Vec<(usize, &Facet)>> = BTreeMap::new();
    for facet in boundary.iter().filter(|f| f.corners().len() == 3) {
        let &[a, b, c] = facet.corners() else { continue };
        for (ends, apex) in [([a, b], c), ([b, c], a), ([c, a], b)] {
            let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            apexes.entry(ends).or_default().push((apex, facet));
        }
    }
    for (&[a, c], sides) in &apexes {
        for (k, &(b, first)) in sides.iter().enumerate() {
            for &(d, second) in &sides[k + 1..] {
                let Some(others) = apexes.get(&[b.min(d), b.max(d)]) else { continue };
                let across = |apex: usize| {
                    let own = [first.cell, second.cell];
                    // The four faces of one cell lie like that, too.
                    others.iter().find(|(v, f)| *v == apex && !own.contains(&f.cell)).map(|(_, f)| **f)
                };
                if let (Some(other), Some(_)) = (across(a), across(c)) {
                    return Some((*first, other));
                }
            }
        }
    }
    None
}

/// A triangle on three corners of a quadrilateral: a wedge or tetrahedron against half a hexahedron face.
fn half_covered(boundary: &[Facet]) -> Option<(Facet, Facet)> {
    let triangles: HashMap<[usize; 4], &Facet> =
        boundary.iter().filter(|f| f.corners().len() == 3).map(|f| (f.key(), f)).collect();
    for quad in boundary.iter().filter(|f| f.corners().len() == 4) {
        for skip in 0..4 {
            let mut key = [usize::MAX; 4];
            let kept = (0..4).filter(|k| *k != skip).map(|k| quad.corners()[k]);
            key.iter_mut().zip(kept).for_each(|(k, node)| *k = node);
            key.sort_unstable();
            if let Some(triangle) = triangles.get(&key) {
                return Some((*quad, **triangle));
            }
        }
    }
    None
}

/// A boundary node in the middle of a facet of a cell with which its own cells share nodes. Surfaces
/// that merely touch, such as closed lips, share none.
fn check_hanging(mesh: &Mesh, boundary: &[Facet]) -> Result<(), MeshError> {
    let mut facets_of: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, facet) in boundary.iter().enumerate() {
        for &node in facet.nodes() {
            facets_of.entry(node).or_default().push(k);
        }
    }
    for (&node, own) in &facets_of {
        let p = mesh.points[node];
        for neighbour in own.iter().flat_map(|&k| boundary[k].nodes()) {
            for &k in &facets_of[neighbour] {
                let facet = &boundary[k];
                if !facet.nodes().contains(&node) && lies_within(mesh, facet, p) {
                    let (node, cell) = (mesh.node_id(node), mesh.cell_id(facet.cell));
                    return Err(MeshError::HangingNode { node, cell });
                }
            }
        }
    }
    Ok(())
}

/// Whether `p` lies on `facet` but on none of its nodes.
fn lies_within(mesh: &Mesh, facet: &Facet, p: Vec3) -> bool {
    let x: Vec<Vec3> = facet.nodes().iter().map(|&node| mesh.points[node]).collect();
    let size = (x[1] - x[0]).norm().max((x[2] - x[0]).norm());
    let tolerance = 1e-6 * size;
    let centre = x[0];
    if (p - centre).norm() > 4. * size || x.iter().any(|x| (x - p).norm() <= 1e3 * tolerance) {
        return false;
    }
    super::closest::closest_on_facet(&x, p).distance <= tolerance
}

fn coincident_nodes(mesh: &Mesh) -> Option<MeshWarning> {
    let tolerance = COINCIDENT * mesh.extent().longest_mm();
    let mut order: Vec<usize> = (0..mesh.n_nodes()).collect();
    order.sort_unstable_by(|&i, &j| mesh.points[i].x.total_cmp(&mesh.points[j].x).then(i.cmp(&j)));
    let mut pairs = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let p = mesh.points[i];
        let close = order[k + 1..].iter().take_while(|&&j| mesh.points[j].x - p.x <= tolerance);
        pairs.extend(
            close.filter(|&&j| (mesh.points[j] - p).norm() <= tolerance).map(|&j| [i.min(j), i.max(j)]),
        );
    }
    pairs.sort_unstable();
    let count = pairs.len();
    let shown = pairs.into_iter().take(SHOWN).map(|pair| pair.map(|k| mesh.node_id(k))).collect();
    (count > 0).then_some(MeshWarning::CoincidentNodes { pairs: shown, count })
}

fn orphan_nodes(mesh: &Mesh) -> Option<MeshWarning> {
    let mut used = vec![false; mesh.n_nodes()];
    for &node in mesh.cells.iter().flat_map(Cell::nodes) {
        used[node] = true;
    }
    let orphans: Vec<usize> = (0..used.len()).filter(|&node| !used[node]).collect();
    let nodes = orphans.iter().take(SHOWN).map(|&node| mesh.node_id(node)).collect();
    (!orphans.is_empty()).then_some(MeshWarning::OrphanNodes { nodes, count: orphans.len() })
}
