//! Polygons as triangles.

use std::collections::HashMap;

use super::Location;
use super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use crate::mesh::{Surface, first_diagonal};
use crate::units::Vec3;

/// Most corners of a polygon: ears are looked for anew after each one that is cut.
const MAX_CORNERS: usize = 128;
/// A corner whose height over the line of its neighbours is less than this part of their distance lies on it.
const STRAIGHT: f64 = 1e-9;

/// Vertices and polygons as a file lists them: vertices at exactly the same place are one.
#[derive(Default)]
pub(super) struct Polygons {
    points: Vec<Vec3>,
    /// The point of each vertex.
    vertices: Vec<usize>,
    merged: HashMap<[u64; 3], usize>,
    /// Corners of all polygons one after the other, and where each polygon ends.
    corners: Vec<usize>,
    ends: Vec<usize>,
}

impl Polygons {
    /// Adds the next vertex.
    pub(super) fn vertex(&mut self, p: Vec3) {
        // Adding 0 makes -0 and 0 the same place.
        let key = [p.x, p.y, p.z].map(|x| (x + 0.).to_bits());
        let point = *self.merged.entry(key).or_insert_with(|| {
            self.points.push(p);
            self.points.len() - 1
        });
        self.vertices.push(point);
    }

    /// How many vertices there are.
    pub(super) fn n_vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Adds a polygon of the vertices `corners` (0-based).
    ///
    /// # Errors
    /// When it has no three corners, or too many.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub(super) fn polygon(
        &mut self,
        corners: &[usize],
        at: impl FnOnce() -> Location,
    ) -> Result<(), MeshFileError> {
        if !(3..=MAX_CORNERS).contains(&corners.len()) {
            let what = format!("a face of {} corners", corners.len());
            let fix = "export triangles, or faces of up to 128 corners";
            return Err(MeshFileError::new(at(), MeshFileErrorKind::UnsupportedFormat { what, fix }));
        }
        let start = self.corners.len();
        for &corner in corners {
            let point = self.vertices[corner];
            if self.corners[start..].last() != Some(&point) {
                self.corners.push(point);
            }
        }
        // What folds up when its vertices merge is no polygon.
        while self.corners.len() > start + 1 && self.corners.last() == self.corners.get(start) {
            self.corners.pop();
        }
        if self.corners.len() < start + 3 {
            self.corners.truncate(start);
        }
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// The polygons cut into triangles: a quadrilateral along its shorter diagonal, others by their ears. A corner
    /// on the straight line between its neighbours that no other polygon has would be a hole without area, and is
    /// left out.
    ///
    /// # Errors
    /// When there is no polygon.
    pub(super) fn surface(self, at: &Location) -> Result<Surface, MeshFileError> {
        if self.ends.is_empty() {
            let kind = MeshFileErrorKind::Syntax { expected: "faces".into(), found: "none".into() };
            return Err(MeshFileError::new(at.clone(), kind));
        }
        let mut uses = vec![0_usize; self.points.len()];
        self.corners.iter().for_each(|&corner| uses[corner] += 1);
        let mut triangles = Vec::new();
        let mut start = 0;
        for &end in &self.ends {
            let mut corners = self.corners[start..end].to_vec();
            start = end;
            let mut k = 0;
            while corners.len() > 3 && k < corners.len() {
                let n = corners.len();
                let [a, b, c] =
                    [corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n]].map(|v| self.points[v]);
                let base = c - a;
                let straight = base.cross(&(b - a)).norm() <= STRAIGHT * base.norm_squared()
                    && (b - a).dot(&(c - b)) > 0.;
                if straight && uses[corners[k]] == 1 {
                    corners.remove(k);
                } else {
                    k += 1;
                }
            }
            self.cut(&corners, &mut triangles);
        }
        let solid = |t: &[usize; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        triangles.retain(solid);
        Ok(Surface { points: self.points, triangles })
    }

    fn cut(&self, corners: &[usize], triangles: &mut Vec<[usize; 3]>) {
        match *corners {
            [a, b, c] => triangles.push([a, b, c]),
            [a, b, c, d] if first_diagonal([a, b, c, d].map(|v| self.points[v])) => {
                triangles.extend([[a, b, c], [a, c, d]]);
            }
            [a, b, c, d] => triangles.extend([[a, b, d], [b, c, d]]),
            [_, _, _, ..] => self.cut_ears(corners.to_vec(), triangles),
            _ => {}
        }
    }

    /// Cuts off one ear after the other: a corner that bulges and whose triangle holds no other corner.
    /// Source: Meisters, Am. Math. Mon. 82 (1975) 648.
    fn cut_ears(&self, mut corners: Vec<usize>, triangles: &mut Vec<[usize; 3]>) {
        let origin = self.points[corners[0]];
        let at = |v: usize| self.points[v] - origin;
        // Newell's normal, which corners out of the plane tilt little.
        let normal: Vec3 =
            (0..corners.len()).map(|k| at(corners[k]).cross(&at(corners[(k + 1) % corners.len()]))).sum();
        while corners.len() > 3 {
            let n = corners.len();
            let triangle = |k: usize| [corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n]];
            let turn = |[a, b, c]: [Vec3; 3]| (b - a).cross(&(c - b)).dot(&normal);
            let is_ear = |k: &usize| {
                let t = triangle(*k);
                let [a, b, c] = t.map(at);
                let holds = |v: &usize| {
                    let p = at(*v);
                    !t.contains(v)
                        && [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|side| turn(side) >= 0.)
                };
                turn([a, b, c]) > 0. && !corners.iter().any(holds)
            };
            // A polygon that crosses itself may have no ear; it is cut all the same.
            let ear = (0..n).find(is_ear).unwrap_or(0);
            triangles.push(triangle(ear));
            corners.remove(ear);
        }
        triangles.push([corners[0], corners[1], corners[2]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(points: &[[f64; 3]], polygons: &[&[usize]]) -> Surface {
        let mut all = Polygons::default();
        points.iter().for_each(|p| all.vertex(Vec3::from(*p)));
        for polygon in polygons {
            all.polygon(polygon, Location::default).unwrap_or_else(|e| panic!("{e}"));
        }
        all.surface(&Location::default()).unwrap_or_else(|e| panic!("{e}"))
    }

    fn area(surface: &Surface) -> f64 {
        let cross = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|v| surface.points[v]);
            (b - a).cross(&(c - a)) / 2.
        };
        surface.triangles.iter().map(cross).sum::<Vec3>().norm()
    }

    #[test]
    fn a_hollow_polygon_is_cut_inside_itself() {
        // An L of area 3, whose triangles must not overlap.
        let l = [[0., 0., 1.], [2., 0., 1.], [2., 1., 1.], [1., 1., 1.], [1., 2., 1.], [0., 2., 1.]];
        let cut = surface(&l, &[&[0, 1, 2, 3, 4, 5]]);
        assert_eq!(cut.triangles.len(), 4);
        let each: f64 = cut
            .triangles
            .iter()
            .map(|t| area(&Surface { points: cut.points.clone(), triangles: vec![*t] }))
            .sum();
        assert!((area(&cut) - 3.).abs() < 1e-12 && (each - 3.).abs() < 1e-12);
    }

    #[test]
    fn a_corner_on_an_edge_stays_only_where_another_polygon_has_it() {
        let points = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.], [1., -1., 0.]];
        assert_eq!(surface(&points, &[&[0, 1, 2, 3, 4]]).triangles.len(), 2);
        assert_eq!(surface(&points, &[&[0, 1, 2, 3, 4], &[1, 0, 5]]).triangles.len(), 4);
    }

    #[test]
    fn too_many_corners_and_too_few() {
        let mut polygons = Polygons::default();
        (0..200).for_each(|k| polygons.vertex(Vec3::repeat(f64::from(k))));
        let all: Vec<usize> = (0..200).collect();
        assert!(polygons.polygon(&all, Location::default).is_err());
        assert!(polygons.polygon(&all[..2], Location::default).is_err());
        assert!(polygons.surface(&Location::default()).is_err(), "nothing was added");
    }
}
