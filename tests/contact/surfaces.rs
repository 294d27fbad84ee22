//! Contact: distances in every nearest-feature region, ways out of a solid, pairs and their symmetry; overlap by
//! other geometry.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::collections::BTreeMap;

use crate::common::block_face::block_face;
use crate::common::cuboid;
use modiolus::contact::{Facets, Lip, Pair, PairKind, Solid, teeth_pairs};
use modiolus::face::standard::{Resolution, standard};
use modiolus::face::{ContactReach, Face, Inside, OverlapSearch, Pose, RigidMotion, Teeth, overlap};
use modiolus::forward::Model;
use modiolus::mesh::{Cell, CellKind, Mesh, Surface};
use modiolus::units::Vec3;

fn union(parts: &[Surface]) -> Surface {
    let mut all = Surface::default();
    for part in parts {
        let shift = all.points.len();
        all.points.extend(&part.points);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + shift)));
    }
    all
}

/// Signed distance of the box `-h..h` (closed form).
fn box_distance(p: Vec3, h: Vec3) -> f64 {
    let q = p.abs() - h;
    q.sup(&Vec3::zeros()).norm() + q.max().min(0.)
}

#[test]
fn a_box_answers_its_closed_form_in_every_region() {
    let h = Vec3::new(3., 2., 1.);
    let solid = Solid::new(&cuboid(-h, h));
    let mut regions = [0; 4];
    // Steps that avoid the box's planes of symmetry, where the closest point inside is not unique.
    for i in 0..27 {
        let cell = [i % 3, i / 3 % 3, i / 9];
        for s in [0.1, 0.35, 0.9] {
            let p = Vec3::from_fn(|axis, _| match cell[axis] {
                0 => -h[axis] - s - 0.1 * axis as f64,
                1 => h[axis] * (s - 0.07 * axis as f64) * 0.9,
                _ => h[axis] + s + 0.2 * axis as f64,
            });
            regions[cell.iter().filter(|c| **c != 1).count()] += 1;
            let found = solid.project(p).unwrap();
            assert!((found.distance_mm - box_distance(p, h)).abs() < 1e-12, "{p} {found:?}");
            assert!((found.normal.norm() - 1.).abs() < 1e-12);
            assert!((p - found.point - found.distance_mm * found.normal).norm() < 1e-12, "{p} {found:?}");
            for axis in 0..3 {
                let mut step = Vec3::zeros();
                step[axis] = 1e-6;
                let d = |q: Vec3| solid.project(q).unwrap().distance_mm;
                let slope = (d(p + step) - d(p - step)) / 2e-6;
                assert!((slope - found.normal[axis]).abs() < 1e-7, "{p} {axis}");
            }
        }
    }
    assert_eq!(regions, [3, 18, 36, 24], "inside, faces, edges, corners were all walked");
}

#[test]
fn on_the_surface_itself_the_normal_is_the_features() {
    let solid = Solid::new(&cuboid(Vec3::zeros(), Vec3::new(2., 2., 2.)));
    let cases = [
        (Vec3::new(1.2, 0.7, 2.), Vec3::z()),
        (Vec3::new(2., 0.7, 2.), Vec3::new(1., 0., 1.).normalize()),
        (Vec3::new(2., 2., 2.), Vec3::new(1., 1., 1.).normalize()),
    ];
    for (p, normal) in cases {
        let found = solid.project(p).unwrap();
        assert!(found.distance_mm.abs() < 1e-15 && (found.normal - normal).norm() < 1e-12, "{found:?}");
    }
}

#[test]
fn overlapping_pieces_are_one_solid() {
    let parts = [
        cuboid(Vec3::zeros(), Vec3::new(2., 2., 2.)),
        cuboid(Vec3::new(1., 0.1, 0.1), Vec3::new(3., 1.9, 1.9)),
    ];
    let solid = Solid::new(&union(&parts));
    // Outside the first and near its face, yet deep in the second.
    let found = solid.project(Vec3::new(2.05, 1., 1.1)).unwrap();
    assert!((found.distance_mm + 0.8).abs() < 1e-12, "{found:?}");
    assert!((solid.project(Vec3::new(3.5, 1., 1.)).unwrap().distance_mm - 0.5).abs() < 1e-12);
}

#[test]
fn a_point_that_is_not_finite_has_no_projection() {
    let solid = Solid::new(&cuboid(Vec3::zeros(), Vec3::new(2., 2., 2.)));
    assert_eq!(solid.project(Vec3::new(f64::NAN, 0., 0.)), None);
}

#[test]
fn a_node_deep_in_an_arch_leaves_towards_its_own_tissue() {
    // An arch 4 mm thick, the lip in front of it (+z) whose inner surface looks back (-z).
    let solid = Solid::new(&cuboid(Vec3::new(-20., -5., -4.), Vec3::new(20., 5., 0.)));
    let deep = Vec3::new(1.3, 0.2, -3.);
    let nearest = solid.project(deep).unwrap();
    assert!((nearest.normal + Vec3::z()).norm() < 1e-12, "the nearest way out is the tongue's side");
    let tissue = BTreeMap::from([(0, -Vec3::z())]);
    let pairs = teeth_pairs(PairKind::UpperTeeth, 0, &solid, &[deep], &[0], &tissue, 5.);
    assert!((pairs[0].row[0].1 - Vec3::z()).norm() < 1e-12, "{pairs:?}");
    assert!(pairs[0].gap_mm == 0. && (pairs[0].rest_overlap_mm - 1.).abs() < 1e-12, "{pairs:?}");
    let unknown = teeth_pairs(PairKind::UpperTeeth, 0, &solid, &[deep], &[0], &BTreeMap::new(), 5.);
    assert!((unknown[0].row[0].1 + Vec3::z()).norm() < 1e-12, "{unknown:?}");
}

#[test]
fn the_gap_of_a_node_hardly_inside_a_tooth_changes_as_its_row_says() {
    // Mucosa that is folded over faces away from the side that it came in through.
    let solid = Solid::new(&cuboid(-Vec3::new(3., 2., 1.), Vec3::new(3., 2., 1.)));
    let tissue = BTreeMap::from([(0, -Vec3::z())]);
    let depth = |p: Vec3| {
        let pairs = teeth_pairs(PairKind::UpperTeeth, 0, &solid, &[p], &[0], &tissue, 5.);
        (pairs[0].gap_mm - pairs[0].rest_overlap_mm, pairs[0].normal())
    };
    let (before, after) = (Vec3::new(0.4, 0.3, -0.92), Vec3::new(0.4, 0.3, -0.98));
    for side in [1., -1.] {
        let [(there, row), (here, _)] = [after, before].map(|p| depth(Vec3::new(p.x, p.y, side * p.z)));
        let step = Vec3::new(0., 0., side * (after - before).z);
        assert!((there - here - row.dot(&step)).abs() < 1e-12, "{side}: {there} {here} {row:?}");
    }
}

#[test]
fn teeth_pairs_stop_at_the_cutoff_and_follow_the_displacement() {
    let solid = Solid::new(&cuboid(Vec3::new(-9., -9., -9.), Vec3::new(9., 9., 0.)));
    let points = [Vec3::new(0.3, 0.2, 2.), Vec3::new(0.3, 0.2, 5.01), Vec3::new(0.3, 0.2, -0.5)];
    let none = BTreeMap::new();
    let pairs = teeth_pairs(PairKind::LowerTeeth, 0, &solid, &points, &[0, 1, 2], &none, 5.);
    assert_eq!(pairs.iter().map(|p| p.node).collect::<Vec<_>>(), [0, 2]);
    assert_eq!((pairs[0].gap_mm, pairs[0].rest_overlap_mm), (2., 0.));
    assert_eq!((pairs[1].gap_mm, pairs[1].rest_overlap_mm), (0., 0.5));
    let moved = points[0] + Vec3::new(0.1, 0., -0.5);
    let gap = pairs[0].gap_mm + pairs[0].row[0].1.dot(&(moved - points[0]));
    assert!((gap - solid.project(moved).unwrap().distance_mm).abs() < 1e-12);
    assert!(pairs.iter().all(|p| p.kind == PairKind::LowerTeeth));
}

/// Two plates of `nx` by 2 hexes, the upper one from `gap` up, their faces bent by `bend(x)`.
fn lips(nx: usize, gap: f64, bend: impl Fn(f64) -> f64) -> (Mesh, Vec<usize>, Vec<usize>) {
    let (mut points, mut cells) = (Vec::new(), Vec::new());
    let mut sides = [Vec::new(), Vec::new()];
    for (side, base) in [(0usize, gap), (1, -1.)] {
        let first = points.len();
        let id = |i: usize, j: usize, k: usize| first + (i * 3 + j) * 2 + k;
        for i in 0..=nx {
            for j in 0..3 {
                for k in 0..2 {
                    let x = 2. * i as f64 - nx as f64;
                    sides[side].push(points.len());
                    points.push(Vec3::new(x, base + f64::from(k) + bend(x), f64::from(j)));
                }
            }
        }
        for i in 0..nx {
            for j in 0..2 {
                let n =
                    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)];
                // The second axis is z and the third is y: reversed so that the cell is not inverted.
                let nodes = [4, 5, 6, 7, 0, 1, 2, 3].map(|c: usize| id(i + n[c].0, j + n[c].1, n[c].2));
                cells.push(Cell::new(CellKind::Hex8, &nodes));
            }
        }
    }
    let [upper, lower] = sides;
    (Mesh::new(points, cells), upper, lower)
}

fn lip_pairs(mesh: &Mesh, upper: &[usize], lower: &[usize], cutoff_mm: f64) -> Vec<Pair> {
    lip_planes(mesh, upper, lower, cutoff_mm, None)
}

fn lip_planes(
    mesh: &Mesh,
    upper: &[usize],
    lower: &[usize],
    cutoff_mm: f64,
    near_mm: Option<f64>,
) -> Vec<Pair> {
    let facets = Facets::of(mesh);
    let lips = Lip::both(mesh, &facets, upper, lower);
    modiolus::contact::lip_pairs(mesh, &facets, &lips, cutoff_mm, near_mm)
}

#[test]
fn lips_meet_face_to_face_and_nowhere_else() {
    let (mesh, upper, lower) = lips(3, 0.7, |_| 0.);
    let pairs = lip_pairs(&mesh, &upper, &lower, 3.);
    assert_eq!(pairs.len(), 24, "the twelve nodes of either facing side");
    for pair in &pairs {
        assert!((pair.gap_mm - 0.7).abs() < 1e-12, "{pair:?}");
        let up = if upper.contains(&pair.node) { 1. } else { -1. };
        let own = pair.row.iter().find(|r| r.0 == pair.node).unwrap().1;
        assert!((own - Vec3::new(0., up, 0.)).norm() < 1e-12);
        assert!(pair.row.iter().map(|r| r.1).sum::<Vec3>().norm() < 1e-12, "a pair is in balance: {pair:?}");
    }
    assert!(lip_pairs(&mesh, &upper, &lower, 0.6).is_empty());
}

#[test]
fn a_lip_meets_what_lies_around_the_nodes_of_the_other_one() {
    // Of the lower plate only the cell in the middle is lip; its neighbours begin 1 mm beside its nodes and end at
    // 7 mm, beyond the 6 mm to which they are met.
    let (mesh, upper, all_lower) = lips(7, 0.7, |_| 0.);
    let lower: Vec<usize> =
        all_lower.iter().copied().filter(|&node| mesh.points[node].x.abs() <= 1.).collect();
    let pairs = lip_pairs(&mesh, &upper, &lower, 3.);
    let met = |x: f64| pairs.iter().any(|p| upper.contains(&p.node) && mesh.points[p.node].x == x);
    assert!([-7., -5., -3., -1., 1., 3., 5., 7.].map(met).iter().all(|met| *met), "{pairs:?}");
    let (mesh, upper, all_lower) = lips(9, 0.7, |_| 0.);
    let lower: Vec<usize> =
        all_lower.iter().copied().filter(|&node| mesh.points[node].x.abs() <= 1.).collect();
    let pairs = lip_pairs(&mesh, &upper, &lower, 1.5);
    let met = |x: f64| pairs.iter().any(|p| upper.contains(&p.node) && mesh.points[p.node].x == x);
    assert!(met(7.) && met(-7.) && !met(9.) && !met(-9.), "{pairs:?}");
    // Only the nodes of a lip meet the other one.
    assert!(pairs.iter().all(|p| upper.contains(&p.node) || lower.contains(&p.node)));
}

#[test]
fn the_far_side_of_the_other_lip_is_no_overlap() {
    // Lips as plates 1 mm thick with 0.7 mm between them. The upper side of the upper one faces away from the lower
    // one, whose lower side faces it from behind, 2.7 mm away through both.
    let (mesh, upper, lower) = lips(3, 0.7, |_| 0.);
    let pairs = lip_pairs(&mesh, &upper, &lower, 5.);
    assert!(pairs.iter().all(|pair| pair.rest_overlap_mm == 0.), "{pairs:?}");
    assert_eq!(pairs.len(), 24, "the outer sides meet nothing");
    // Really inside, by more than the depth that the closest facet decides: 0.8 mm of plates 4 mm thick.
    let (mut mesh, upper, lower) = lips(3, -0.2, |_| 0.);
    mesh.points.iter_mut().for_each(|p| *p *= 4.);
    let deep = lip_pairs(&mesh, &upper, &lower, 3.);
    assert!(deep.iter().any(|pair| (pair.rest_overlap_mm - 0.8).abs() < 1e-12), "{deep:?}");
}

#[test]
fn crossed_lips_touch_and_keep_their_depth() {
    let (mesh, upper, lower) = lips(2, -0.2, |_| 0.);
    let pairs = lip_pairs(&mesh, &upper, &lower, 3.);
    assert_eq!(pairs.len(), 18);
    for pair in &pairs {
        assert!(pair.gap_mm == 0. && (pair.rest_overlap_mm - 0.2).abs() < 1e-12, "{pair:?}");
        let up = if upper.contains(&pair.node) { 1. } else { -1. };
        assert!(pair.row.iter().find(|r| r.0 == pair.node).unwrap().1.y * up > 0.99, "{pair:?}");
    }
}

#[test]
fn a_node_in_a_groove_of_the_other_lip_meets_both_flanks() {
    // The lower lip's upper side is y = |x|, the upper lip's lower side 3 mm above it but for one node that has
    // come down between the flanks.
    let (mut mesh, upper, lower) = lips(4, 3., f64::abs);
    let in_row = |p: &Vec3| p.x == 0. && p.y == 3. && p.z == 1.;
    let node = *upper.iter().find(|&&n| in_row(&mesh.points[n])).unwrap();
    let slope = 0.5f64.sqrt();
    for p in [Vec3::new(0.1, 0.7, 0.9), Vec3::new(-0.3, 0.5, 1.2)] {
        mesh.points[node] = p;
        let pairs = lip_planes(&mesh, &upper, &lower, 5., Some(1.5));
        let own: Vec<&Pair> = pairs.iter().filter(|pair| pair.node == node).collect();
        for flank in [Vec3::new(-slope, slope, 0.), Vec3::new(slope, slope, 0.)] {
            let met = own.iter().find(|pair| (pair.normal() - flank).norm() < 1e-9);
            let met = met.unwrap_or_else(|| panic!("{p} does not meet {flank}: {own:?}"));
            assert!((met.gap_mm - met.rest_overlap_mm - flank.dot(&p)).abs() < 1e-9, "{met:?}");
            assert!(met.row.iter().map(|r| r.1).sum::<Vec3>().norm() < 1e-12, "in balance: {met:?}");
            // The facets that carry it are those of this flank.
            assert!(met.row.iter().all(|(n, _)| *n == node || mesh.points[*n].x * flank.x <= 0.), "{met:?}");
        }
        assert!(own.iter().all(|pair| pair.normal().x.abs() > 0.5), "no third plane: {own:?}");
    }
}

#[test]
fn the_gap_of_a_lip_pair_falls_with_the_displacement_as_its_row_says() {
    let (mesh, upper, lower) = lips(3, 0.7, |x| 0.05 * x * x);
    let gaps = |mesh: &Mesh| -> BTreeMap<usize, f64> {
        let pairs = lip_pairs(mesh, &upper, &lower, 3.);
        pairs.iter().map(|p| (p.node, p.gap_mm)).collect()
    };
    let pairs = lip_pairs(&mesh, &upper, &lower, 3.);
    let (h, before) = (1e-6, gaps(&mesh));
    let mut checked = 0;
    for pair in &pairs {
        for &(node, coefficient) in &pair.row {
            let mut moved = mesh.clone();
            moved.points[node] += h * coefficient.normalize();
            let slope = (gaps(&moved)[&pair.node] - before[&pair.node]) / h;
            assert!((slope - coefficient.norm()).abs() < 1e-5, "{pair:?} node {node}: {slope}");
            checked += 1;
        }
    }
    assert!(checked > 40, "{checked}");
}

#[test]
fn mirrored_lips_have_mirrored_pairs() {
    // A bend with its valley on the mid-plane: nodes there tie between the left and the right.
    for bend in [0.6, -0.6] {
        let (mesh, upper, lower) = lips(4, 0.9, |x| bend * x * x);
        let mirror: BTreeMap<usize, usize> = (0..mesh.n_nodes())
            .map(|a| {
                let q = mesh.points[a].component_mul(&Vec3::new(-1., 1., 1.));
                (a, (0..mesh.n_nodes()).find(|b| (mesh.points[*b] - q).norm() < 1e-12).unwrap())
            })
            .collect();
        let pairs = lip_pairs(&mesh, &upper, &lower, 5.);
        let find = |node: usize| -> &Pair { pairs.iter().find(|p| p.node == node).unwrap() };
        let mut ties = 0;
        for pair in &pairs {
            let twin = find(mirror[&pair.node]);
            assert!((twin.gap_mm - pair.gap_mm).abs() < 1e-12);
            let row: BTreeMap<usize, Vec3> = twin.row.iter().copied().collect();
            assert_eq!(row.len(), pair.row.len(), "{pair:?} {twin:?}");
            for (node, coefficient) in &pair.row {
                let expect = coefficient.component_mul(&Vec3::new(-1., 1., 1.));
                assert!((row[&mirror[node]] - expect).norm() < 1e-9, "{pair:?} {twin:?}");
            }
            let reaches = |side: f64| pair.row.iter().any(|r| mesh.points[r.0].x * side > 1.);
            ties += usize::from(mesh.points[pair.node].x == 0. && reaches(1.) && reaches(-1.));
        }
        assert!(ties > 0, "a node of the mid-plane ties at bend {bend}");
    }
}

/// A block 60 x 40 x 12 mm of 10 mm cells whose front, at z = 12, is mucosa before `teeth` on the upper jaw.
fn block_before(teeth: Surface) -> Face {
    let mut face = block_face([6, 4, 1]);
    face.mucosa = face.skin.clone();
    face.teeth = vec![Teeth { upper: true, bone: "maxilla".into(), surface: teeth }];
    face
}

fn shifted(face: &Face, by: impl Fn(Vec3) -> Vec3) -> Vec<f64> {
    face.mesh.points.iter().flat_map(|p| by(*p).as_slice().to_vec()).collect()
}

#[test]
fn a_box_pushed_into_tissue_overlaps_it_by_how_far_it_was_pushed() {
    let face = block_before(cuboid(Vec3::new(-13., -7., 11.7), Vec3::new(13., 7., 20.)));
    let search = OverlapSearch::new(&face);
    for (push, jaw) in [(0., 0.), (0.4, 0.), (0.4, 0.5), (-0.1, 0.15), (-0.2, 0.5)] {
        let u = shifted(&face, |_| Vec3::z() * push);
        let pose = Pose::rest().with("maxilla", RigidMotion::translation(Vec3::z() * jaw));
        let found = search.at(&face, &u, &pose);
        let expected = f64::max(0.3 + push - jaw, 0.);
        for depth in [found.teeth_mm(), found.tooth_edges_mm(), found.deepest_mm()] {
            assert!((depth - expected).abs() < 1e-9, "{push} {jaw}: {depth} for {expected}");
        }
        assert!((found.beyond_rest_mm() - f64::max(push - jaw, 0.).min(expected)).abs() < 1e-9);
        assert_eq!(found.tissue_mm(), 0.);
    }
}

#[test]
fn a_ridge_between_nodes_is_found_where_no_node_and_no_sample_is_inside() {
    // Facets run from x = 0 to 10: nodes at 0 and 10, samples at 0, 2, 4, 6, 8, 10.
    for (from, to, sampled) in [(2.5, 7.5, true), (4.5, 5.5, false)] {
        let face = block_before(cuboid(Vec3::new(from, 1., 11.8), Vec3::new(to, 9., 20.)));
        let u = vec![0.; 3 * face.mesh.n_nodes()];
        let reach = ContactReach::default();
        assert_eq!(face.contact_pairs_at(reach, &u, &Pose::rest()).overlap_mm(), 0., "no node is inside");
        let found = overlap(&face, &u, &Pose::rest());
        assert!((found.tooth_edges_mm() - 0.2).abs() < 1e-9, "{}", found.tooth_edges_mm());
        assert!((found.teeth_mm() - if sampled { 0.2 } else { 0. }).abs() < 1e-9, "{}", found.teeth_mm());
        let place = found.deepest().unwrap();
        assert_eq!(face.landmarks[place.landmark.unwrap()].name, "cheilion_l");
    }
}

#[test]
fn blocks_that_cross_are_as_deep_as_they_crossed() {
    // A block above another one, 1 mm apart, turned and narrower so that none of their lattices match.
    let mut face = block_face([6, 4, 1]);
    let mut other = block_face([5, 3, 2]).mesh;
    let below = face.mesh.n_nodes();
    let turn = nalgebra::Rotation3::from_euler_angles(0., 0., 0.3);
    face.mesh.points.extend(other.points.drain(..).map(|p| turn * (0.6 * p) + Vec3::z() * 13.));
    let shift = |c: &Cell| Cell::new(c.kind(), &c.nodes().iter().map(|n| n + below).collect::<Vec<_>>());
    face.mesh.cells.extend(other.cells.iter().map(shift));
    face.mesh = Mesh::new(std::mem::take(&mut face.mesh.points), std::mem::take(&mut face.mesh.cells));
    face.upper_lip = (below..face.mesh.n_nodes()).collect();
    face.lower_lip = face.skin.clone();
    for crossed in [-0.5, 0.3, 1.7] {
        let u = shifted(&face, |p| if p.z > 12.5 { -Vec3::z() * (1. + crossed) } else { Vec3::zeros() });
        let found = overlap(&face, &u, &Pose::rest());
        let expected = f64::max(crossed, 0.);
        assert!((found.tissue_mm() - expected).abs() < 1e-9, "{} for {expected}", found.tissue_mm());
        assert_eq!((found.teeth.len(), found.tooth_edges.len()), (0, 0));
        let both = [false, true].map(|upper| found.tissue.iter().any(|i| (i.nodes[0] >= below) == upper));
        assert_eq!(both, [crossed > 0.; 2], "samples of either block");
    }
}

/// Whether `cell` of `mesh` holds `p`, by Newton from its centre and from near each of its nodes; up to `margin` outside, in
/// reference coordinates.
fn holds(mesh: &Mesh, cell: usize, p: Vec3, margin: f64) -> bool {
    let kind = mesh.cells[cell].kind();
    let x: Vec<Vec3> = mesh.cell_points(cell).collect();
    let starts = kind.node_positions().iter().map(|n| 0.7 * Vec3::from(*n)).chain([kind.centre()]);
    starts.into_iter().any(|mut xi| {
        for _ in 0..30 {
            let (shape, gradient) = (kind.shape(xi), kind.shape_gradient(xi));
            let gap = x.iter().zip(shape).map(|(x, w)| w * x).sum::<Vec3>() - p;
            let slope: nalgebra::Matrix3<f64> = x.iter().zip(gradient).map(|(x, g)| x * g.transpose()).sum();
            let Some(step) = slope.try_inverse().map(|inverse| inverse * gap) else { return false };
            xi -= step;
        }
        let carried = x.iter().zip(kind.shape(xi)).map(|(x, w)| w * x).sum::<Vec3>();
        (carried - p).norm() < 1e-9 && kind.signed_outside(xi) < margin
    })
}

#[test]
fn the_standard_face_rests_apart_off_the_bone_and_overlaps_where_every_cell_was_asked() {
    let face = standard(&Resolution::COARSE);
    let search = OverlapSearch::new(&face);
    let rest = search.at(&face, &vec![0.; 3 * face.mesh.n_nodes()], &Pose::rest());
    // Where the tissue leaves the arch for the bone, facets with nodes on the bone cut through the arch's margin.
    let on_bone = |i: &Inside| face.supports.iter().any(|s| i.nodes.iter().any(|n| s.nodes.contains(n)));
    assert!(rest.all().all(on_bone), "{:?}", rest.all().find(|i| !on_bone(i)));
    assert_eq!((rest.tissue.len(), rest.beyond_rest_mm()), (0, 0.));

    // Without contact these press the cheeks into the teeth and the lips into each other.
    let model = Model::new(&face, Vec::new()).unwrap();
    let act = |name: &String| {
        f64::from(u8::from(name.starts_with("orbicularis") || name.starts_with("buccinator")))
    };
    let a: Vec<f64> = model.muscles().iter().map(act).collect();
    let pose = Pose::opened(face.jaw.as_ref().unwrap(), 2.);
    let u = model.at_pose(&vec![0.5; a.len()], &pose).unwrap().displacement(&a, &[]);
    let found = search.at(&face, &u, &pose);
    assert!([found.teeth_mm(), found.tooth_edges_mm(), found.tissue_mm()].iter().all(|mm| *mm > 0.5));

    let displaced = |(k, p): (usize, &Vec3)| p + Vec3::new(u[3 * k], u[3 * k + 1], u[3 * k + 2]);
    let points: Vec<Vec3> = face.mesh.points.iter().enumerate().map(displaced).collect();
    let mesh = Mesh::new(points, face.mesh.cells.clone());
    let balls = [&face.mesh, &mesh].map(|mesh| {
        let ball = |cell: usize| {
            let centre = mesh.cell_points(cell).sum::<Vec3>() / 8.;
            (centre, mesh.cell_points(cell).map(|p| (p - centre).norm()).fold(0., f64::max))
        };
        (0..mesh.cells.len()).map(ball).collect::<Vec<(Vec3, f64)>>()
    });
    let held_in = |k: usize, p: Vec3, margin: f64, is_other: &dyn Fn(&Cell) -> bool| {
        let (mesh, balls) = ([&face.mesh, &mesh][k], &balls[k]);
        let near = |cell: &usize| (p - balls[*cell].0).norm() <= balls[*cell].1 + 1e-3;
        (0..mesh.cells.len()).filter(near).any(|c| is_other(&mesh.cells[c]) && holds(mesh, c, p, margin))
    };
    let in_rest = |p: Vec3| held_in(0, p, 1e-5, &|_| true);
    // Well inside for what must be found, hardly outside for what was found: on faces between cells either may be.
    let held = |p: Vec3, is_other: &dyn Fn(&Cell) -> bool| held_in(1, p, -1e-5, is_other);
    let nearly_held = |p: Vec3, is_other: &dyn Fn(&Cell) -> bool| held_in(1, p, 1e-5, is_other);
    let at = |list: &[Inside], p: Vec3| list.iter().any(|i| (i.at - p).norm() < 1e-9 && i.depth_mm > 1e-4);
    let teeth = face.teeth_at(&pose);
    let mut inside = [0; 3];
    let at_rest = face.teeth.iter().flat_map(|t| &t.surface.points);
    for (p, rest) in teeth.iter().flat_map(|t| &t.surface.points).zip(at_rest).step_by(11) {
        // Roots lie in the tissue at rest, before the bone.
        if held(*p, &|_| true) && !in_rest(*rest) {
            inside[0] += 1;
            assert!(at(&found.tooth_edges, *p), "tooth vertex {p:?}");
        }
    }
    let lips = face.upper_lip.iter().chain(&face.lower_lip);
    for &node in face.mucosa.iter().chain(lips) {
        let p = mesh.points[node];
        let expected = held(p, &|cell| !cell.nodes().contains(&node));
        inside[1] += usize::from(expected);
        assert!(!expected || at(&found.tissue, p), "tissue node {node}");
    }
    let solids: Vec<Solid> = teeth.iter().map(|t| Solid::new(&t.surface)).collect();
    for (&node, solid) in face.mucosa.iter().flat_map(|node| solids.iter().map(move |solid| (node, solid))) {
        let depth = -solid.project(mesh.points[node]).unwrap().distance_mm;
        if depth > 1e-4 {
            inside[2] += 1;
            let same = |i: &Inside| i.nodes == [node] && (i.depth_mm - depth).abs() < 1e-9;
            assert!(found.teeth.iter().any(same), "node {node} is {depth} mm inside a tooth");
        }
    }
    assert!(inside.iter().all(|n| *n > 20), "{inside:?}");
    let in_other = |i: &Inside| nearly_held(i.at, &|c| !c.nodes().iter().any(|n| i.nodes.contains(n)));
    assert!(found.tissue.iter().step_by(41).all(in_other));
    assert!(found.tooth_edges.iter().step_by(211).all(|i| nearly_held(i.at, &|_| true)));
}
