//! A triangle soup checked, and mended where asked, into a closed outward-oriented surface.

use std::collections::HashMap;

use super::teeth_error::{BoundaryLoop, EdgeAt, Piece, TeethError, TeethWarning};
use crate::mesh::Surface;
use crate::units::Vec3;

/// A piece that encloses less than this part of the largest piece's volume is debris.
const DEBRIS: f64 = 1e-5;

/// `surface` as a closed, outward-oriented manifold: vertices at the same place are merged, triangles
/// without three distinct vertices left out and, when `cap_holes`, every hole closed by a fan about
/// the mean of its rim and pieces left out that then enclose nothing.
///
/// # Errors
/// [`TeethError`] when it is empty, not manifold, not consistently oriented, open (unless
/// `cap_holes`) or has a piece whose normals point inward (negative enclosed volume).
pub fn closed_surface(
    surface: &Surface,
    cap_holes: bool,
) -> Result<(Surface, Vec<TeethWarning>), TeethError> {
    let mut closed = merged(surface)?;
    let mut warnings = Vec::new();
    let loops = boundary_loops(&closed)?;
    if !loops.is_empty() {
        let described = loops.iter().map(|l| describe(&closed, l)).collect();
        if !cap_holes {
            return Err(TeethError::Open { loops: described });
        }
        for rim in &loops {
            cap(&mut closed, rim);
        }
        warnings.push(TeethWarning::Capped { loops: described });
    }
    let pieces = pieces(&closed);
    let measured: Vec<Piece> = pieces.iter().map(|piece| measure(&closed, piece)).collect();
    let largest = measured.iter().fold(0f64, |v, p| v.max(p.volume_mm3.abs()));
    if largest <= 0. {
        return Err(TeethError::Flat);
    }
    let is_debris = |p: &Piece| cap_holes && p.volume_mm3.abs() <= DEBRIS * largest;
    let inward: Vec<Piece> =
        measured.iter().filter(|p| p.volume_mm3 <= 0. && !is_debris(p)).cloned().collect();
    if !inward.is_empty() {
        return Err(TeethError::Inward { pieces: inward });
    }
    let debris: Vec<Piece> = measured.iter().filter(|p| is_debris(p)).cloned().collect();
    if !debris.is_empty() {
        let kept = pieces.iter().zip(&measured).filter(|(_, p)| !is_debris(p)).flat_map(|(t, _)| t);
        let mut kept: Vec<usize> = kept.copied().collect();
        kept.sort_unstable();
        closed = part(&closed, &kept);
        warnings.push(TeethWarning::Debris { pieces: debris });
    }
    Ok((closed, warnings))
}

/// The connected pieces of `surface`, each as its triangles in ascending order.
pub(super) fn pieces(surface: &Surface) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..surface.points.len()).collect();
    fn root(parent: &mut [usize], mut v: usize) -> usize {
        while parent[v] != v {
            parent[v] = parent[parent[v]];
            v = parent[v];
        }
        v
    }
    for t in &surface.triangles {
        for &v in &t[1..] {
            let (a, b) = (root(&mut parent, t[0]), root(&mut parent, v));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut index = HashMap::new();
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for (k, t) in surface.triangles.iter().enumerate() {
        let piece = *index.entry(root(&mut parent, t[0])).or_insert_with(|| {
            pieces.push(Vec::new());
            pieces.len() - 1
        });
        pieces[piece].push(k);
    }
    pieces
}

/// The triangles `triangles` of `surface` with only the vertices they use.
pub(super) fn part(surface: &Surface, triangles: &[usize]) -> Surface {
    let mut new = HashMap::new();
    let mut points = Vec::new();
    let triangles = triangles
        .iter()
        .map(|&t| {
            surface.triangles[t].map(|v| {
                *new.entry(v).or_insert_with(|| {
                    points.push(surface.points[v]);
                    points.len() - 1
                })
            })
        })
        .collect();
    Surface { points, triangles }
}

fn merged(surface: &Surface) -> Result<Surface, TeethError> {
    if surface.triangles.is_empty() {
        return Err(TeethError::Empty);
    }
    if let Some(k) = surface.points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(TeethError::NotFinite { vertex: k + 1, value: surface.points[k].into() });
    }
    let mut points = Vec::new();
    let mut at: HashMap<[u64; 3], usize> = HashMap::new();
    let new: Vec<usize> = surface
        .points
        .iter()
        .map(|p| {
            // Adding zero makes -0 and 0 one place.
            *at.entry([p.x, p.y, p.z].map(|x| (x + 0.).to_bits())).or_insert_with(|| {
                points.push(*p);
                points.len() - 1
            })
        })
        .collect();
    let mut triangles = Vec::with_capacity(surface.triangles.len());
    for (k, t) in surface.triangles.iter().enumerate() {
        if let Some(v) = t.iter().find(|v| **v >= new.len()) {
            return Err(TeethError::MissingVertex { triangle: k + 1, vertex: v + 1, n_vertices: new.len() });
        }
        let t = t.map(|v| new[v]);
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            triangles.push(t);
        }
    }
    if triangles.is_empty() { Err(TeethError::Empty) } else { Ok(Surface { points, triangles }) }
}

/// The holes of `surface`, each as its vertices in the direction in which a cap must run.
fn boundary_loops(surface: &Surface) -> Result<Vec<Vec<usize>>, TeethError> {
    let mut halves: Vec<(usize, usize, bool)> = Vec::with_capacity(3 * surface.triangles.len());
    for t in &surface.triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            halves.push((a.min(b), a.max(b), a < b));
        }
    }
    halves.sort_unstable();
    let (mut crowded, mut opposed) = (Vec::new(), Vec::new());
    let mut next: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut starts = Vec::new();
    for edge in halves.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let (a, b, forward) = edge[0];
        let at = EdgeAt(surface.points[a], surface.points[b]);
        match edge.len() {
            1 => {
                let (from, to) = if forward { (b, a) } else { (a, b) };
                next.entry(from).or_default().push(to);
                starts.push(from);
            }
            2 if edge[0].2 != edge[1].2 => {}
            2 => opposed.push(at),
            _ => crowded.push(at),
        }
    }
    if !crowded.is_empty() {
        return Err(TeethError::NonManifold { edges: crowded });
    }
    if !opposed.is_empty() {
        return Err(TeethError::Inconsistent { edges: opposed });
    }
    let mut loops = Vec::new();
    for start in starts {
        let mut walk = vec![start];
        while let Some(to) = walk.last().and_then(|v| next.get_mut(v)).and_then(Vec::pop) {
            // Two holes that share a vertex are closed one by one.
            match walk.iter().position(|v| *v == to) {
                Some(k) => {
                    loops.push(walk.split_off(k));
                    walk.push(to);
                }
                None => walk.push(to),
            }
        }
    }
    Ok(loops)
}

fn cap(surface: &mut Surface, rim: &[usize]) {
    if let &[a, b, c] = rim {
        surface.triangles.push([a, b, c]);
        return;
    }
    let centre = mean(rim.iter().map(|&v| surface.points[v]));
    let hub = surface.points.len();
    surface.points.push(centre);
    for k in 0..rim.len() {
        surface.triangles.push([rim[k], rim[(k + 1) % rim.len()], hub]);
    }
}

fn describe(surface: &Surface, rim: &[usize]) -> BoundaryLoop {
    let at = |k: usize| surface.points[rim[k % rim.len()]];
    BoundaryLoop {
        centre: mean(rim.iter().map(|&v| surface.points[v])),
        edges: rim.len(),
        length_mm: (0..rim.len()).map(|k| (at(k + 1) - at(k)).norm()).sum(),
    }
}

fn measure(surface: &Surface, piece: &[usize]) -> Piece {
    let corners = |t: usize| surface.triangles[t].map(|v| surface.points[v]);
    let centre = mean(piece.iter().flat_map(|&t| corners(t)));
    let volume = |t: &usize| {
        let [a, b, c] = corners(*t).map(|p| p - centre);
        a.dot(&b.cross(&c)) / 6.
    };
    Piece { centre, triangles: piece.len(), volume_mm3: piece.iter().map(volume).sum() }
}

fn mean(points: impl Iterator<Item = Vec3>) -> Vec3 {
    let (sum, n) = points.fold((Vec3::zeros(), 0.), |(s, n), p| (s + p, n + 1.));
    sum / f64::max(n, 1.)
}
