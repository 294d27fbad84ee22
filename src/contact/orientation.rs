//! Triangles turned to face outward.

use std::collections::HashMap;

use crate::mesh::Surface;
use crate::units::Vec3;

/// `surface` with every piece oriented alike throughout and outward, and how many triangles were turned for it.
///
/// From one triangle of a piece to the next across edges that two triangles share, a neighbour that runs along the edge
/// in the same direction is turned; a piece that then encloses a negative volume about its middle is turned as a whole.
/// A piece with one side only, such as a Moebius strip, has no such orientation: what is left of its contradiction is
/// found by [`closed_surface`](super::closed_surface).
pub fn oriented(surface: &Surface) -> (Surface, usize) {
    let mut owners: HashMap<[usize; 2], Vec<usize>> = HashMap::with_capacity(2 * surface.triangles.len());
    for (k, t) in surface.triangles.iter().enumerate() {
        for [a, b] in edges(*t) {
            owners.entry([a.min(b), a.max(b)]).or_default().push(k);
        }
    }
    let mut triangles = surface.triangles.clone();
    let mut seen = vec![false; triangles.len()];
    for start in 0..triangles.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut piece = vec![start];
        let mut next = 0;
        while let Some(&k) = piece.get(next) {
            next += 1;
            for edge in edges(triangles[k]) {
                let [a, b] = edge;
                let shared = owners.get(&[a.min(b), a.max(b)]).filter(|of_edge| of_edge.len() == 2);
                for &other in shared.into_iter().flatten() {
                    if std::mem::replace(&mut seen[other], true) {
                        continue;
                    }
                    if edges(triangles[other]).contains(&edge) {
                        triangles[other].swap(1, 2);
                    }
                    piece.push(other);
                }
            }
        }
        if volume(surface, &triangles, &piece) < 0. {
            piece.iter().for_each(|&k| triangles[k].swap(1, 2));
        }
    }
    let turned = triangles.iter().zip(&surface.triangles).filter(|(new, old)| new != old).count();
    (Surface { points: surface.points.clone(), triangles }, turned)
}

fn edges([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Volume between the triangles of a piece and the mean of their corners.
fn volume(surface: &Surface, triangles: &[[usize; 3]], piece: &[usize]) -> f64 {
    let corners = |k: &usize| triangles[*k].map(|v| surface.points[v]);
    let centre = piece.iter().flat_map(corners).sum::<Vec3>() / (3 * piece.len()) as f64;
    let one = |k: &usize| {
        let [a, b, c] = corners(k).map(|p| p - centre);
        a.dot(&b.cross(&c)) / 6.
    };
    piece.iter().map(one).sum()
}
