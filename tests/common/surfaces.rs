//! The surfaces of a face that a scanner and a segmentation would give.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

use modiolus::face::Face;
use modiolus::mesh::{Facet, Skin, Surface, boundary_facets};
use modiolus::units::Vec3;

/// The skin of a face, each triangle split in four `times` over.
pub fn skin(face: &Face, times: usize) -> Surface {
    let is_skin = |facet: &Facet| facet.corners().iter().all(|n| face.skin.binary_search(n).is_ok());
    let facets: Vec<Facet> = boundary_facets(&face.mesh).into_iter().filter(is_skin).collect();
    (0..times).fold(Skin::new(&face.mesh, &facets).surface, |surface, _| split(&surface))
}

fn split(surface: &Surface) -> Surface {
    let mut points = surface.points.clone();
    let mut middles: HashMap<[usize; 2], usize> = HashMap::new();
    let mut triangles = Vec::new();
    for &[a, b, c] in &surface.triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]| {
            *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                points.push((surface.points[i] + surface.points[j]) / 2.);
                points.len() - 1
            })
        });
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Surface { points, triangles }
}

/// The facets of `face` that lie on `bone`, facing the tissue, moved `in_mm` away from it.
pub fn bone(face: &Face, bone: &str, in_mm: f64) -> Surface {
    let on: BTreeSet<usize> =
        face.supports.iter().filter(|s| s.bone == bone).flat_map(|s| s.nodes.iter().copied()).collect();
    let is_on = |facet: &Facet| facet.corners().iter().all(|n| on.contains(n));
    let facets: Vec<Facet> = boundary_facets(&face.mesh).into_iter().filter(is_on).collect();
    let Surface { mut points, mut triangles } = Skin::new(&face.mesh, &facets).surface;
    let mut out_of_tissue = vec![Vec3::zeros(); points.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|v| points[v]);
        t.iter().for_each(|&v| out_of_tissue[v] += (b - a).cross(&(c - a)));
    }
    points.iter_mut().zip(&out_of_tissue).for_each(|(p, n)| *p += in_mm * n.normalize());
    triangles.iter_mut().for_each(|t| t.swap(1, 2));
    Surface { points, triangles }
}

/// A surface as an OBJ.
pub fn obj(surface: &Surface) -> String {
    let mut text = String::new();
    surface.points.iter().for_each(|p| _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z));
    surface.triangles.iter().for_each(|t| _ = writeln!(text, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1));
    text
}
