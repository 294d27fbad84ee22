//! Triangulated surfaces, and the one that bounds a volume mesh.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use super::{Facet, Mesh};
use crate::units::Vec3;

/// A triangulated surface, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Vertex positions, mm.
    pub points: Vec<Vec3>,
    /// Vertices of each triangle, 0-based.
    pub triangles: Vec<[usize; 3]>,
}

/// A triangulated piece of the boundary of a mesh, with the way back to the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// The triangles, outward oriented.
    pub surface: Surface,
    /// The mesh node (0-based, ascending) of each vertex of the surface.
    pub nodes: Vec<usize>,
    /// The cell (0-based) behind each triangle.
    pub cells: Vec<usize>,
}

impl Skin {
    /// The triangulation of `facets` of `mesh`: quadrilaterals split along the shorter diagonal,
    /// quadratic triangles in four.
    ///
    /// Equal diagonals are told apart by distances from the mid-sagittal plane, height and depth, so
    /// that a mirrored mesh gets the mirrored triangles.
    pub fn new(mesh: &Mesh, facets: &[Facet]) -> Self {
        let (mut triangles, mut cells) = (Vec::new(), Vec::new());
        for facet in facets {
            for triangle in split(mesh, facet) {
                triangles.push(triangle);
                cells.push(facet.cell);
            }
        }
        let used: BTreeSet<usize> = triangles.iter().flatten().copied().collect();
        let nodes: Vec<usize> = used.into_iter().collect();
        let mut vertex_of = vec![usize::MAX; mesh.n_nodes()];
        for (vertex, &node) in nodes.iter().enumerate() {
            vertex_of[node] = vertex;
        }
        let surface = Surface {
            points: nodes.iter().map(|&node| mesh.points[node]).collect(),
            triangles: triangles.into_iter().map(|t| t.map(|node| vertex_of[node])).collect(),
        };
        Self { surface, nodes, cells }
    }
}

fn split(mesh: &Mesh, facet: &Facet) -> Vec<[usize; 3]> {
    match *facet.nodes() {
        [a, b, c] => vec![[a, b, c]],
        [a, b, c, d] if first_diagonal([a, b, c, d].map(|node| mesh.points[node])) => {
            vec![[a, b, c], [a, c, d]]
        }
        [a, b, c, d] => vec![[a, b, d], [b, c, d]],
        [a, b, c, ab, bc, ca] => vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]],
        _ => Vec::new(),
    }
}

/// Whether a quadrilateral is split along corners 0 and 2 (the shorter diagonal).
pub(crate) fn first_diagonal(p: [Vec3; 4]) -> bool {
    let lengths = [(p[2] - p[0]).norm(), (p[3] - p[1]).norm()];
    let tolerance = 1e-6 * (lengths[0] + lengths[1]);
    if (lengths[0] - lengths[1]).abs() > tolerance {
        return lengths[0] < lengths[1];
    }
    let by_place = |a: &Vec3, b: &Vec3| {
        let (a, b) = ([a.x.abs(), a.y, a.z], [b.x.abs(), b.y, b.z]);
        (0..3).find(|&k| (a[k] - b[k]).abs() > tolerance).map_or(Ordering::Equal, |k| a[k].total_cmp(&b[k]))
    };
    let least = (1..4).fold(0, |best, k| if by_place(&p[k], &p[best]).is_lt() { k } else { best });
    least % 2 == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::{block, single};
    use crate::mesh::{Cell, CellKind, boundary_facets};

    fn volume(surface: &Surface) -> f64 {
        let at = |t: &[usize; 3]| t.map(|v| surface.points[v]);
        surface.triangles.iter().map(at).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.).sum()
    }

    #[test]
    fn the_skin_encloses_the_volume_of_the_mesh() {
        let mesh = block([2, 3, 1]);
        let skin = Skin::new(&mesh, &boundary_facets(&mesh));
        assert!((volume(&skin.surface) - 6000.).abs() < 1e-9);
        for (kind, expected) in
            [(CellKind::Wedge6, 1000.), (CellKind::Tet4, 1000. / 6.), (CellKind::Tet10, 1000. / 6.)]
        {
            let mesh = single(kind);
            let skin = Skin::new(&mesh, &boundary_facets(&mesh));
            assert!((volume(&skin.surface) - expected).abs() < 1e-9, "{kind:?}");
        }
    }

    #[test]
    fn vertices_lead_back_to_the_nodes_and_only_boundary_nodes_appear() {
        let mesh = block([2, 2, 2]);
        let skin = Skin::new(&mesh, &boundary_facets(&mesh));
        assert_eq!(skin.nodes.len(), 26);
        for (p, &node) in skin.surface.points.iter().zip(&skin.nodes) {
            assert_eq!(*p, mesh.points[node]);
        }
    }

    #[test]
    fn a_mirrored_mesh_has_the_mirrored_triangles() {
        let mesh = block([3, 2, 1]);
        let mirror = [1, 0, 3, 2, 5, 4, 7, 6];
        let mirrored = Mesh::new(
            mesh.points.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect(),
            mesh.cells
                .iter()
                .map(|c| Cell::new(CellKind::Hex8, &mirror.map(|k: usize| c.nodes()[k])))
                .collect(),
        );
        let sorted = |mesh: &Mesh| {
            let skin = Skin::new(mesh, &boundary_facets(mesh));
            let mut all: Vec<[usize; 3]> = skin.surface.triangles.clone();
            all.iter_mut().for_each(|t| t.sort_unstable());
            all.sort_unstable();
            all
        };
        assert_eq!(sorted(&mesh), sorted(&mirrored));
    }
}
