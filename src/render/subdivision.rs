//! A smooth surface through the facets of a mesh.

use std::collections::HashMap;

use crate::mesh::Site;
use crate::units::Vec3;

/// Triangles or quadrilaterals refined to small quadrilaterals, each vertex carried by mesh nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// The vertices: rest positions and the nodes that carry them.
    pub sites: Vec<Site>,
    /// Corners of each quadrilateral, counter-clockwise seen from outside.
    pub quads: Vec<[usize; 4]>,
}

/// Weights of mesh nodes, ascending.
type Weights = Vec<(usize, f64)>;

/// The Catmull-Clark surface of `facets` (corner nodes, three or four) after `levels` halvings.
///
/// The scheme is linear in the nodes, so the vertices move with any displacement of the nodes as a smooth
/// field does. An edge of one facet only, or of more than two, is a crease, drawn as the cubic
/// B-spline of its nodes; a vertex of one facet only stays.
///
/// Source: E. Catmull, J. Clark, Computer-Aided Design 1978;10:350; creases after H. Biermann et al.,
/// SIGGRAPH 2000.
pub fn refine(points: &[Vec3], facets: &[Vec<usize>], levels: usize) -> Refined {
    let mut nodes: Vec<usize> = facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut weights: Vec<Weights> = nodes.iter().map(|&node| vec![(node, 1.)]).collect();
    let vertex = |node: &usize| nodes.partition_point(|n| n < node);
    let mut faces: Vec<Vec<usize>> = facets.iter().map(|f| f.iter().map(vertex).collect()).collect();
    for _ in 0..levels.max(1) {
        (weights, faces) = halve(&weights, &faces);
    }
    let site =
        |weights: Weights| Site { position: weights.iter().map(|&(n, w)| w * points[n]).sum(), weights };
    Refined {
        sites: weights.into_iter().map(site).collect(),
        quads: faces.iter().map(|f| [f[0], f[1], f[2], f[3]]).collect(),
    }
}

/// An edge and the faces on it.
struct Edge {
    ends: [usize; 2],
    faces: Vec<usize>,
}

fn halve(weights: &[Weights], faces: &[Vec<usize>]) -> (Vec<Weights>, Vec<Vec<usize>>) {
    let mut edges: Vec<Edge> = Vec::new();
    let mut edge_of: HashMap<[usize; 2], usize> = HashMap::new();
    let mut at_vertex: Vec<(Vec<usize>, Vec<usize>)> = vec![Default::default(); weights.len()];
    for (f, face) in faces.iter().enumerate() {
        for (k, &a) in face.iter().enumerate() {
            let b = face[(k + 1) % face.len()];
            let ends = [a.min(b), a.max(b)];
            let e = *edge_of.entry(ends).or_insert_with(|| {
                edges.push(Edge { ends, faces: Vec::new() });
                at_vertex[a].1.push(edges.len() - 1);
                at_vertex[b].1.push(edges.len() - 1);
                edges.len() - 1
            });
            edges[e].faces.push(f);
            at_vertex[a].0.push(f);
        }
    }
    let middle = |face: &Vec<usize>| {
        mix(&face.iter().map(|&v| (&weights[v], 1. / face.len() as f64)).collect::<Vec<_>>())
    };
    let middles: Vec<Weights> = faces.iter().map(middle).collect();
    let on_edges: Vec<Weights> = edges
        .iter()
        .map(|edge| {
            let [a, b] = edge.ends.map(|v| &weights[v]);
            match edge.faces[..] {
                [f, g] => mix(&[(a, 0.25), (b, 0.25), (&middles[f], 0.25), (&middles[g], 0.25)]),
                _ => mix(&[(a, 0.5), (b, 0.5)]),
            }
        })
        .collect();
    let other = |e: usize, v: usize| {
        let [a, b] = edges[e].ends;
        &weights[if a == v { b } else { a }]
    };
    let moved = |v: usize| {
        let (faces_here, edges_here) = &at_vertex[v];
        let creases: Vec<usize> = edges_here.iter().copied().filter(|&e| edges[e].faces.len() != 2).collect();
        let here = &weights[v];
        match creases[..] {
            [] if faces_here.len() > 2 => {
                let n = faces_here.len() as f64;
                let mut parts = vec![(here, (n - 2.) / n)];
                parts.extend(edges_here.iter().map(|&e| (other(e, v), 1. / (n * n))));
                parts.extend(faces_here.iter().map(|&f| (&middles[f], 1. / (n * n))));
                mix(&parts)
            }
            [e, f] if faces_here.len() > 1 => {
                mix(&[(here, 0.75), (other(e, v), 0.125), (other(f, v), 0.125)])
            }
            _ => here.clone(),
        }
    };
    let mut all: Vec<Weights> = (0..weights.len()).map(moved).collect();
    let (first_edge, first_middle) = (all.len(), all.len() + on_edges.len());
    all.extend(on_edges);
    all.extend(middles);
    let mut quads = Vec::with_capacity(4 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        let n = face.len();
        let edge = |k: usize| {
            let (a, b) = (face[k % n], face[(k + 1) % n]);
            first_edge + edge_of[&[a.min(b), a.max(b)]]
        };
        for (k, &corner) in face.iter().enumerate() {
            quads.push(vec![corner, edge(k), first_middle + f, edge(k + n - 1)]);
        }
    }
    (all, quads)
}

/// The sum of weights times their factors.
fn mix(parts: &[(&Weights, f64)]) -> Weights {
    let mut all: Weights = parts
        .iter()
        .flat_map(|(weights, factor)| weights.iter().map(move |&(n, w)| (n, w * factor)))
        .collect();
    all.sort_by_key(|&(node, _)| node);
    all.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 6 x 5 quadrilaterals, some cut into triangles; each corner of the sheet is in one facet.
    fn sheet() -> (Vec<[f64; 2]>, Vec<Vec<usize>>) {
        let points = (0..42).map(|k| [f64::from(k % 7), f64::from(k / 7)]).collect();
        let mut facets = Vec::new();
        for k in (0..35).filter(|k| k % 7 < 6) {
            let quad = [k, k + 1, k + 8, k + 7];
            if k % 3 == 1 {
                facets.extend([vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]]);
            } else {
                facets.push(quad.to_vec());
            }
        }
        (points, facets)
    }

    #[test]
    fn a_plane_stays_a_plane_and_keeps_its_outline() {
        let (flat, facets) = sheet();
        let points: Vec<Vec3> = flat.iter().map(|[x, y]| Vec3::new(*x, *y, 0.3 * x - 0.7 * y + 2.)).collect();
        let refined = refine(&points, &facets, 2);
        for site in &refined.sites {
            let p = site.position;
            assert!((p.z - (0.3 * p.x - 0.7 * p.y + 2.)).abs() < 1e-12, "{p:?}");
            assert!((site.weights.iter().map(|w| w.1).sum::<f64>() - 1.).abs() < 1e-12);
        }
        let area = |q: &[usize; 4]| {
            let p = q.map(|v| refined.sites[v].position);
            ((p[2] - p[0]).x * (p[3] - p[1]).y - (p[2] - p[0]).y * (p[3] - p[1]).x) / 2.
        };
        assert!(refined.quads.iter().all(|q| area(q) > 0.), "orientation is kept");
        assert!((refined.quads.iter().map(area).sum::<f64>() - 30.).abs() < 1e-9);
    }

    #[test]
    fn a_cube_of_many_facets_on_a_sphere_stays_near_it() {
        let n = 8;
        let mut points: Vec<Vec3> = Vec::new();
        let mut facets = Vec::new();
        let mut node = |p: Vec3| {
            let p = p.normalize() * 50.;
            points.iter().position(|q| (p - q).norm() < 1e-6).unwrap_or_else(|| {
                points.push(p);
                points.len() - 1
            })
        };
        for axis in 0..3 {
            for side in [-1., 1.] {
                for k in 0..n * n {
                    let corner = |i: usize, j: usize| {
                        let at = |c: usize| (2. * c as f64 / n as f64 - 1.) * std::f64::consts::FRAC_PI_4;
                        let mut p = Vec3::zeros();
                        p[axis] = side;
                        p[(axis + 1) % 3] = at(k % n + i).tan() * side;
                        p[(axis + 2) % 3] = at(k / n + j).tan();
                        p
                    };
                    facets.push([(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| node(corner(i, j))).to_vec());
                }
            }
        }
        let refined = refine(&points, &facets, 2);
        assert_eq!(refined.quads.len(), 16 * facets.len());
        let radii = refined.sites.iter().map(|s| s.position.norm());
        let (lo, hi) = radii.fold((f64::MAX, 0f64), |(lo, hi), r| (lo.min(r), hi.max(r)));
        assert!(lo > 48. && hi < 50. && hi - lo < 1., "{lo} {hi}");
    }

    #[test]
    fn the_surface_is_carried_by_the_nodes() {
        let (flat, facets) = sheet();
        let points: Vec<Vec3> = flat.iter().map(|[x, y]| Vec3::new(*x, *y, 0.)).collect();
        let refined = refine(&points, &facets, 2);
        // A rigid turn about z, taken as a displacement of the nodes.
        let u: Vec<f64> = points.iter().flat_map(|p| [-p.y - p.x, p.x - p.y, 0.]).collect();
        for site in &refined.sites {
            let p = site.position + site.displacement(&u);
            assert!((p - Vec3::new(-site.position.y, site.position.x, 0.)).norm() < 1e-12);
        }
    }
}
