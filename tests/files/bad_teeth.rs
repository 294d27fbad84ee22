//! Tooth surfaces that are no solids, and how they are told.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use modiolus::contact::{Solid, TeethError, TeethWarning, closed_surface, oriented};
use modiolus::mesh::Surface;
use modiolus::units::Vec3;

const QUADS: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn cube(at: f64, side: f64) -> Surface {
    let corner = |k: usize| Vec3::from_fn(|axis, _| at + if k >> axis & 1 == 1 { side } else { 0. });
    let triangles = QUADS.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Surface { points: (0..8).map(corner).collect(), triangles }
}

fn with(mut a: Surface, b: &Surface) -> Surface {
    let shift = a.points.len();
    a.points.extend(&b.points);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + shift)));
    a
}

fn reversed(mut s: Surface) -> Surface {
    s.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    s
}

#[test]
fn a_closed_outward_surface_passes_as_it_is() {
    let (closed, warnings) = closed_surface(&cube(0., 2.), false).unwrap();
    assert_eq!((closed, warnings.len()), (cube(0., 2.), 0));
}

#[test]
fn an_empty_surface_is_refused() {
    assert_eq!(closed_surface(&Surface::default(), true), Err(TeethError::Empty));
    let shrunk = Surface { points: vec![Vec3::zeros(); 3], triangles: vec![[0, 1, 2]] };
    assert_eq!(closed_surface(&shrunk, true), Err(TeethError::Empty));
}

#[test]
fn a_coordinate_that_is_not_finite_is_refused_by_its_vertex() {
    let mut surface = cube(0., 2.);
    surface.points[4].y = f64::NAN;
    let error = closed_surface(&surface, true).unwrap_err();
    assert!(matches!(error, TeethError::NotFinite { vertex: 5, .. }), "{error}");
}

#[test]
fn a_vertex_that_does_not_exist_is_refused() {
    let mut surface = cube(0., 2.);
    surface.triangles[3][1] = 8;
    assert_eq!(
        closed_surface(&surface, true),
        Err(TeethError::MissingVertex { triangle: 4, vertex: 9, n_vertices: 8 })
    );
}

#[test]
fn edges_of_three_triangles_are_listed() {
    let mut surface = cube(0., 2.);
    surface.points.push(Vec3::new(1., 1., 5.));
    surface.triangles.push([0, 1, 8]);
    let error = closed_surface(&surface, true).unwrap_err();
    let TeethError::NonManifold { edges } = &error else { panic!("{error}") };
    assert_eq!(edges.len(), 1);
    assert!(error.to_string().contains("(0.00, 0.00, 0.00) to (2.00, 0.00, 0.00)"), "{error}");
}

#[test]
fn triangles_oriented_against_their_neighbours_are_listed() {
    let mut surface = cube(0., 2.);
    surface.triangles[0].swap(0, 1);
    let error = closed_surface(&surface, false).unwrap_err();
    let TeethError::Inconsistent { edges } = &error else { panic!("{error}") };
    assert_eq!(edges.len(), 3);
}

#[test]
fn holes_are_refused_with_their_count_and_place() {
    let mut surface = with(cube(0., 2.), &cube(10., 2.));
    surface.triangles.truncate(23); // the second cube lacks one triangle
    surface.triangles.drain(0..2); // the first lacks its side z = 0
    let error = closed_surface(&surface, false).unwrap_err();
    let TeethError::Open { loops } = &error else { panic!("{error}") };
    let mut edges: Vec<usize> = loops.iter().map(|l| l.edges).collect();
    edges.sort_unstable();
    assert_eq!(edges, [3, 4]);
    let square = loops.iter().find(|l| l.edges == 4).unwrap();
    assert!((square.centre - Vec3::new(1., 1., 0.)).norm() < 1e-12 && (square.length_mm - 8.).abs() < 1e-12);
    let text = error.to_string();
    assert!(text.contains("2 holes") && text.contains("(1.00, 1.00, 0.00)"), "{text}");
    assert!(text.contains("cap_holes = true"), "{text}");
}

#[test]
fn holes_are_capped_when_asked_and_the_solid_is_whole() {
    let mut surface = cube(0., 2.);
    surface.triangles.drain(0..2);
    let (closed, warnings) = closed_surface(&surface, true).unwrap();
    assert!(matches!(&warnings[..], [TeethWarning::Capped { loops }] if loops.len() == 1), "{warnings:?}");
    let solid = Solid::new(&closed);
    for (z, distance) in [(-0.5, 0.5), (0.25, -0.25), (1.5, -0.5), (2.5, 0.5)] {
        let found = solid.project(Vec3::new(0.9, 1.05, z)).unwrap();
        assert!((found.distance_mm - distance).abs() < 1e-12, "{z} {found:?}");
    }
    assert!(closed_surface(&closed, false).unwrap().1.is_empty(), "what was capped is closed");
}

#[test]
fn holes_that_share_a_vertex_are_capped_one_by_one() {
    let mut surface = cube(0., 2.);
    // One triangle of the floor and one of the roof's neighbour that meet in a corner only.
    surface.triangles.retain(|t| *t != [0, 2, 3] && *t != [0, 1, 5]);
    let (closed, warnings) = closed_surface(&surface, true).unwrap();
    assert!(matches!(&warnings[..], [TeethWarning::Capped { loops }] if loops.len() == 2), "{warnings:?}");
    assert!(closed_surface(&closed, false).is_ok());
}

#[test]
fn pieces_turned_inside_out_are_refused_each() {
    let error = closed_surface(&reversed(cube(0., 2.)), false).unwrap_err();
    assert!(matches!(&error, TeethError::Inward { pieces } if pieces.len() == 1), "{error}");
    let one_of_two = with(cube(0., 2.), &reversed(cube(10., 1.)));
    let error = closed_surface(&one_of_two, true).unwrap_err();
    let TeethError::Inward { pieces } = &error else { panic!("{error}") };
    assert!((pieces[0].volume_mm3 + 1.).abs() < 1e-12 && pieces[0].triangles == 12, "{error}");
    assert!(error.to_string().contains("(10.50, 10.50, 10.50)"), "{error}");
}

#[test]
fn loose_triangles_are_left_out_when_holes_are_capped() {
    let scrap = Surface {
        points: vec![Vec3::new(5., 5., 5.), Vec3::new(6., 5., 5.), Vec3::new(5., 6., 5.)],
        triangles: vec![[0, 1, 2]],
    };
    let (closed, warnings) = closed_surface(&with(cube(0., 2.), &scrap), true).unwrap();
    assert_eq!(closed.triangles.len(), 12);
    assert!(warnings.iter().any(|w| matches!(w, TeethWarning::Debris { pieces } if pieces.len() == 1)));
    assert_eq!(closed_surface(&scrap, true), Err(TeethError::Flat));
}

#[test]
fn doubled_vertices_are_merged() {
    let whole = cube(0., 2.);
    let soup = Surface {
        points: whole.triangles.iter().flatten().map(|v| whole.points[*v]).collect(),
        triangles: (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    };
    let (closed, _) = closed_surface(&soup, false).unwrap();
    assert_eq!((closed.points.len(), closed.triangles.len()), (8, 12));
}

#[test]
fn triangles_are_turned_outward_on_request() {
    let both = with(cube(0., 2.), &cube(5., 1.));
    assert_eq!(oriented(&both), (both.clone(), 0));
    let mut mixed = both.clone();
    for k in [1, 2, 7] {
        mixed.triangles[k].swap(1, 2);
    }
    assert!(matches!(closed_surface(&mixed, false), Err(TeethError::Inconsistent { .. })));
    let (turned, count) = oriented(&mixed);
    assert_eq!(count, 3);
    assert!(closed_surface(&turned, false).unwrap().1.is_empty());
    let (turned, count) = oriented(&with(cube(0., 2.), &reversed(cube(5., 1.))));
    assert_eq!(count, 12);
    assert!(closed_surface(&turned, false).is_ok());
    // Still where a hole has to be closed.
    let mut open = mixed;
    open.triangles.remove(0);
    assert!(closed_surface(&oriented(&open).0, true).is_ok());
}
