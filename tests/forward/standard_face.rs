//! The standard face at every resolution: symmetry, element quality, fibres in the tissue, closed
//! teeth clear of the mucosa, and the distances an anthropometer would measure.

use std::collections::{BTreeMap, BTreeSet};

use modiolus::contact::Solid;
use modiolus::face::standard::{Parameters, Resolution, parametric, standard};
use modiolus::face::{ContactReach, Face, Muscle};
use modiolus::forward::Model;
use modiolus::mesh::{CellKind, Mesh, Surface};
use modiolus::units::Vec3;

fn faces() -> [(&'static str, Face); 2] {
    [("coarse", standard(&Resolution::COARSE)), ("standard", standard(&Resolution::STANDARD))]
}

type Bits = [u64; 3];

/// The exact bits of a point; `-0.0` counts as `0.0`.
fn bits(p: Vec3) -> Bits {
    [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits)
}

fn mirror(p: Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

fn at(face: &Face, name: &str) -> Vec3 {
    face.landmark(name).unwrap_or_else(|| panic!("no landmark {name}")).site.position
}

fn muscle<'a>(face: &'a Face, name: &str) -> &'a Muscle {
    &face.muscles[face.muscle_index(name).unwrap_or_else(|| panic!("no muscle {name}"))]
}

/// Partner of every node, by the exact bits of its mirror image.
fn partners(mesh: &Mesh) -> Vec<usize> {
    let ids: BTreeMap<Bits, usize> = mesh.points.iter().enumerate().map(|(k, p)| (bits(*p), k)).collect();
    assert_eq!(ids.len(), mesh.n_nodes(), "two nodes share a place");
    mesh.points.iter().map(|p| ids[&bits(mirror(*p))]).collect()
}

#[test]
fn degrees_of_freedom_are_those_promised() {
    for (resolution, least, most) in [
        (Resolution::COARSE, 9_000, 12_000),
        (Resolution::STANDARD, 27_000, 33_000),
        (Resolution::FINE, 180_000, 220_000),
    ] {
        let dofs = 3 * standard(&resolution).mesh.n_nodes();
        assert!((least..=most).contains(&dofs), "{resolution:?}: {dofs}");
    }
}

#[test]
fn generation_is_deterministic() {
    assert_eq!(standard(&Resolution::COARSE), standard(&Resolution::COARSE));
}

#[test]
fn the_mesh_is_its_own_mirror_image() {
    for (name, face) in faces() {
        let partner = partners(&face.mesh);
        let cells: BTreeSet<BTreeSet<usize>> =
            face.mesh.cells.iter().map(|c| c.nodes().iter().copied().collect()).collect();
        for cell in &face.mesh.cells {
            let image: BTreeSet<usize> = cell.nodes().iter().map(|&n| partner[n]).collect();
            assert!(cells.contains(&image), "{name}");
        }
        let mut lists = vec![&face.skin, &face.mucosa, &face.upper_lip, &face.lower_lip];
        lists.extend(face.supports.iter().map(|s| &s.nodes));
        for list in lists {
            assert!(!list.is_empty() && list.windows(2).all(|w| w[0] < w[1]), "{name}");
            let mut image: Vec<usize> = list.iter().map(|&n| partner[n]).collect();
            image.sort_unstable();
            assert_eq!(&image, list, "{name}");
        }
    }
}

#[test]
fn stiffness_and_loads_are_their_own_mirror_images() {
    let face = standard(&Resolution::COARSE);
    let model = Model::new(&face, Vec::new()).expect("a model");
    let partner = partners(&face.mesh);
    let reflect = |u: &[f64]| -> Vec<f64> {
        let image = |i: usize| {
            if i.is_multiple_of(3) { -u[3 * partner[i / 3]] } else { u[3 * partner[i / 3] + i % 3] }
        };
        (0..u.len()).map(image).collect()
    };
    let twin = |name: &str| match (name.strip_suffix("_l"), name.strip_suffix("_r")) {
        (Some(stem), _) => format!("{stem}_r"),
        (_, Some(stem)) => format!("{stem}_l"),
        _ => name.to_owned(),
    };
    let twins: Vec<usize> = face.muscles.iter().filter_map(|m| face.muscle_index(&twin(&m.name))).collect();
    // Any activation and movement will do, as long as neither is symmetric.
    let a: Vec<f64> = (0..twins.len()).map(|m| (m * 13 % 29) as f64 / 29.0).collect();
    let mirrored: Vec<f64> = twins.iter().map(|&m| a[m]).collect();
    let u: Vec<f64> = (0..model.n_dofs()).map(|i| (i * 37 % 101) as f64 / 101.0 - 0.5).collect();
    let force = |a: &[f64], u: &[f64]| model.stiffness().pattern().multiply(&model.stiffness().at(a), u);
    let (there, back) = (reflect(&force(&a, &u)), force(&mirrored, &reflect(&u)));
    let scale = there.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    let worst = there.iter().zip(&back).fold(0.0, |m: f64, (f, g)| m.max((f - g).abs()));
    println!("K is its own mirror image to {:.1e}", worst / scale);
    assert!(worst <= 1e-12 * scale, "{:.1e}", worst / scale);
    for (m, load) in model.loads().iter().enumerate() {
        let dense = |load: &[(usize, f64)]| {
            let mut full = vec![0.0; model.n_dofs()];
            load.iter().for_each(|&(dof, f)| full[dof] += f);
            full
        };
        let (own, image) = (dense(load), reflect(&dense(&model.loads()[twins[m]])));
        let worst = own.iter().zip(&image).fold(0.0, |m: f64, (f, g)| m.max((f - g).abs()));
        assert!(worst < 1e-12, "{}: {worst:.1e} N", face.muscles[m].name);
    }
}

#[test]
fn quadrants_together_are_the_ring() {
    let quarters = Parameters { orbicularis_quadrants: true, ..Parameters::default() };
    let (whole, parts) = (
        standard(&Resolution::COARSE),
        parametric(&quarters, &Resolution::COARSE).unwrap_or_else(|e| panic!("{e}")),
    );
    assert_eq!(parts.muscles.len(), whole.muscles.len() + 6);
    let load = |face: &Face, stem: &str| {
        let model = Model::new(face, Vec::new()).expect("a model");
        let mut sum = vec![0.0; model.n_dofs()];
        for (muscle, column) in face.muscles.iter().zip(model.loads()) {
            if muscle.name.starts_with(stem) {
                column.iter().for_each(|&(dof, f)| sum[dof] += f);
            }
        }
        sum
    };
    for stem in ["orbicularis_oris_peripheralis", "orbicularis_oris_marginalis"] {
        let (ring, four) = (load(&whole, stem), load(&parts, stem));
        let scale = ring.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        let worst = ring.iter().zip(&four).fold(0.0, |m: f64, (f, g)| m.max((f - g).abs()));
        assert!(worst < 1e-12 + 1e-9 * scale, "{stem}: {worst:.1e} of {scale:.2} N");
        for quarter in ["upper_l", "upper_r", "lower_l", "lower_r"] {
            assert!(muscle(&parts, &format!("{stem}_{quarter}")).fibres.iter().all(|f| !f.closed));
        }
    }
}

#[test]
fn contact_candidates_are_their_own_mirror_image() {
    let face = standard(&Resolution::COARSE);
    let partner = partners(&face.mesh);
    let pairs = face.contact_pairs(ContactReach::default());
    for pair in &pairs {
        let image = pairs.iter().find(|p| p.kind == pair.kind && p.node == partner[pair.node]);
        let image = image.unwrap_or_else(|| panic!("{:?} of node {} has no image", pair.kind, pair.node));
        assert!((image.gap_mm - pair.gap_mm).abs() < 1e-9);
        for (node, push) in &pair.row {
            let other = image.row.iter().find(|r| r.0 == partner[*node]).map_or(Vec3::zeros(), |r| r.1);
            let at = face.mesh.points[pair.node];
            assert!(
                (mirror(other) - push).norm() < 1e-9,
                "{:?} at {at:.2?}: {push:.3?} {other:.3?}",
                pair.kind
            );
        }
    }
}

#[test]
fn muscles_teeth_and_landmarks_are_mirrored() {
    for (name, face) in faces() {
        for left in &face.muscles {
            if let Some(stem) = left.name.strip_suffix("_l") {
                let right = muscle(&face, &format!("{stem}_r"));
                assert_eq!(left.max_force_n, right.max_force_n);
                for (l, r) in left.fibres.iter().zip(&right.fibres) {
                    let image: Vec<Bits> = l.points.iter().map(|p| bits(mirror(*p))).collect();
                    assert_eq!(image, r.points.iter().map(|p| bits(*p)).collect::<Vec<_>>(), "{name} {stem}");
                }
            } else if !left.name.ends_with("_r") {
                for ring in &left.fibres {
                    assert!(ring.closed);
                    let own: BTreeSet<Bits> = ring.points.iter().map(|p| bits(*p)).collect();
                    let image: BTreeSet<Bits> = ring.points.iter().map(|p| bits(mirror(*p))).collect();
                    assert_eq!(own, image, "{name} {}", left.name);
                }
            }
        }
        for teeth in &face.teeth {
            let place = |k: usize| bits(teeth.surface.points[k]);
            let image = |k: usize| bits(mirror(teeth.surface.points[k]));
            let start = |t: [Bits; 3]| {
                let k = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
                [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]
            };
            let own: BTreeSet<_> = teeth.surface.triangles.iter().map(|t| start(t.map(place))).collect();
            for &[a, b, c] in &teeth.surface.triangles {
                assert!(own.contains(&start([image(a), image(c), image(b)])), "{name}");
            }
        }
        for landmark in &face.landmarks {
            match landmark.name.strip_suffix("_l") {
                Some(stem) => {
                    let right = at(&face, &format!("{stem}_r"));
                    assert_eq!(bits(mirror(landmark.site.position)), bits(right), "{stem}");
                }
                None if landmark.name.ends_with("_r") => {}
                None => assert_eq!(landmark.site.position.x, 0.0, "{}", landmark.name),
            }
            let carried: Vec3 = landmark.site.weights.iter().map(|&(n, w)| w * face.mesh.points[n]).sum();
            assert!((carried - landmark.site.position).norm() < 1e-12);
            assert!(landmark.site.weights.iter().all(|(n, _)| face.skin.binary_search(n).is_ok()));
        }
    }
}

/// Smallest over the corners of the Jacobian divided by the lengths of the three edges there.
fn scaled_jacobian(mesh: &Mesh, cell: usize) -> f64 {
    const NEIGHBOURS: [[usize; 3]; 8] =
        [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]];
    let p: Vec<Vec3> = mesh.cell_points(cell).collect();
    let corner = |c: usize| {
        let [a, b, d] = NEIGHBOURS[c].map(|n| (p[n] - p[c]).normalize());
        a.cross(&b).dot(&d)
    };
    (0..8).map(corner).fold(f64::INFINITY, f64::min)
}

#[test]
fn hexes_are_well_shaped() {
    for (name, face, bound) in [
        ("coarse", standard(&Resolution::COARSE), 0.2),
        ("standard", standard(&Resolution::STANDARD), 0.2),
        ("fine", standard(&Resolution::FINE), 0.2),
    ] {
        let mesh = &face.mesh;
        assert!(mesh.cells.iter().all(|c| c.kind() == CellKind::Hex8));
        let (worst, cell) = (0..mesh.cells.len())
            .map(|c| (scaled_jacobian(mesh, c), c))
            .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a });
        let centre = mesh.cell_points(cell).sum::<Vec3>() / 8.0;
        assert!(worst >= bound, "{name}: scaled Jacobian {worst:.3} at {centre:.1?}");
    }
}

/// Length along the surface over the thickness of a cell whose layers run from face 0-1-2-3 to face
/// 4-5-6-7: the greater of the mean lengths along columns and along rows, over the mean of the four
/// edges through the thickness.
fn bending_aspect(mesh: &Mesh, cell: usize) -> f64 {
    let p: Vec<Vec3> = mesh.cell_points(cell).collect();
    let mean = |edges: [[usize; 2]; 4]| edges.iter().map(|&[a, b]| (p[a] - p[b]).norm()).sum::<f64>() / 4.0;
    let columns = mean([[0, 1], [3, 2], [4, 5], [7, 6]]);
    let rows = mean([[1, 2], [0, 3], [5, 6], [4, 7]]);
    columns.max(rows) / mean([[0, 4], [1, 5], [2, 6], [3, 7]])
}

/// A layer errs in bending by its length along the surface over its thickness; the lips bend over two
/// layers of 1 or better, or over more that together are as good: L layers of aspect L / 2.
#[test]
fn lips_bend_over_two_layers_of_aspect_one() {
    let mut failures = Vec::new();
    for (name, resolution) in
        [("coarse", Resolution::COARSE), ("standard", Resolution::STANDARD), ("fine", Resolution::FINE)]
    {
        let face = standard(&resolution);
        let layers = resolution.layers as f64;
        let (mut worst, mut place) = (0.0_f64, Vec3::zeros());
        for cell in 0..face.mesh.cells.len() {
            let centre = face.mesh.cell_points(cell).sum::<Vec3>() / 8.0;
            if centre.x.abs() > 20.0 || !(-14.0..14.0).contains(&centre.y) {
                continue;
            }
            let aspect = bending_aspect(&face.mesh, cell) * 2.0 / layers;
            if aspect > worst {
                (worst, place) = (aspect, centre);
            }
        }
        println!("{name}: as two layers, aspect {worst:.2} at {place:.1?}");
        if worst > 1.0 {
            failures.push(format!("{name}: aspect {worst:.2} at {place:.1?}"));
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

#[test]
fn supports_leave_the_mucosa_free() {
    for (name, face) in faces() {
        let fixed: BTreeSet<usize> = face.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        let total: usize = face.supports.iter().map(|s| s.nodes.len()).sum();
        assert_eq!(fixed.len(), total, "{name}: a node has two bones");
        assert!(face.mucosa.iter().all(|n| !fixed.contains(n)), "{name}");
        assert!(face.upper_lip.iter().chain(&face.lower_lip).all(|n| !fixed.contains(n)), "{name}");
        assert!(face.upper_lip.iter().all(|n| face.lower_lip.binary_search(n).is_err()), "{name}");
    }
}

#[test]
fn lips_meet_along_a_band_and_go_round_to_the_teeth() {
    for (name, face) in faces() {
        let (top, low) = (at(&face, "stomion_superius"), at(&face, "stomion_inferius"));
        assert!((top.y - low.y - 0.15).abs() < 1e-9, "{name}: {}", top.y - low.y);
        assert!(top.z.abs() < 0.5 && (0.5 * (top + low)).norm() < 0.5, "{name}");
        // Opening between the lips' faces at the mid-line, from the teeth forward.
        let mut opening: Vec<(f64, f64)> = Vec::new();
        for p in face.upper_lip.iter().map(|&n| face.mesh.points[n]).filter(|p| p.x == 0.0) {
            let below = face.lower_lip.iter().map(|&n| face.mesh.points[n]);
            let across = below.filter(|q| q.x == 0.0 && (q.z - p.z).abs() < 1e-9).map(|q| p.y - q.y);
            if let Some(nearest) = across.min_by(f64::total_cmp) {
                opening.push((p.z, nearest));
            }
        }
        opening.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        opening.dedup_by(|a, b| a.0 == b.0);
        let opening: Vec<_> = opening.into_iter().filter(|(z, _)| *z <= 0.1).collect();
        println!("{name}: opening at depth {opening:.2?}");
        assert!(opening.len() >= 4, "{name}: {opening:?}");
        let depth = -opening[0].0;
        let wide = opening.iter().filter(|(_, gap)| *gap > 1.0).map(|(z, _)| -z);
        let band = wide.fold(f64::INFINITY, f64::min);
        assert!(band < 0.7 * depth, "{name}: the lips meet over {band:.1} of {depth:.1} mm");
        assert!(opening[0].1 > 4.0, "{name}: the edges by the teeth are {:.1} mm apart", opening[0].1);
        assert!(opening.windows(2).all(|w| w[0].1 >= w[1].1 - 1e-9), "{name}: {opening:?}");
    }
}

/// Whether `point` lies in one of the mesh's hexes, by Newton on the trilinear map.
fn inside(mesh: &Mesh, boxes: &[(Vec3, Vec3)], point: Vec3) -> bool {
    boxes.iter().enumerate().any(|(cell, (lo, hi))| {
        if !(0..3).all(|k| lo[k] - 1e-9 <= point[k] && point[k] <= hi[k] + 1e-9) {
            return false;
        }
        let p: Vec<Vec3> = mesh.cell_points(cell).collect();
        let mut xi = Vec3::zeros();
        for _ in 0..25 {
            let (n, g) = (CellKind::Hex8.shape(xi), CellKind::Hex8.shape_gradient(xi));
            let at: Vec3 = (0..8).map(|k| n[k] * p[k]).sum();
            let jacobian: nalgebra::Matrix3<f64> = (0..8).map(|k| p[k] * g[k].transpose()).sum();
            let Some(step) = jacobian.lu().solve(&(point - at)) else { return false };
            xi += step.map(|s| s.clamp(-1.0, 1.0));
        }
        xi.amax() <= 1.0 + 1e-7
    })
}

fn boxes(mesh: &Mesh) -> Vec<(Vec3, Vec3)> {
    let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    (0..mesh.cells.len())
        .map(|c| mesh.cell_points(c).fold(start, |(lo, hi), p| (lo.inf(&p), hi.sup(&p))))
        .collect()
}

#[test]
fn fibres_run_inside_the_tissue() {
    for (name, face) in faces() {
        let boxes = boxes(&face.mesh);
        for muscle in &face.muscles {
            assert!(muscle.fibres.len() >= 5, "{name} {}", muscle.name);
            for fibre in &muscle.fibres {
                let n = fibre.points.len();
                for k in 0..n {
                    let p = fibre.points[k];
                    assert!(inside(&face.mesh, &boxes, p), "{name} {}: {p:.2?} outside", muscle.name);
                    if fibre.closed || k + 1 < n {
                        let step = fibre.points[(k + 1) % n] - p;
                        assert!((0.5..1.6).contains(&step.norm()), "{name} {} {step:?}", muscle.name);
                    }
                    if k + 2 < n {
                        let turn =
                            (fibre.points[k + 1] - p).angle(&(fibre.points[k + 2] - fibre.points[k + 1]));
                        assert!(turn < 0.8, "{name} {}: kink {turn:.2} at {p:.1?}", muscle.name);
                    }
                }
            }
        }
    }
}

#[test]
fn every_muscle_reaches_gauss_points() {
    for (name, face) in faces() {
        let g = 1.0 / 3.0_f64.sqrt();
        let mut gauss = Vec::new();
        for cell in 0..face.mesh.cells.len() {
            let p: Vec<Vec3> = face.mesh.cell_points(cell).collect();
            for corner in CellKind::Hex8.node_positions() {
                let n = CellKind::Hex8.shape(g * Vec3::from(*corner));
                gauss.push((0..8).map(|k| n[k] * p[k]).sum::<Vec3>());
            }
        }
        for muscle in &face.muscles {
            let points = || muscle.fibres.iter().flat_map(|f| &f.points);
            let reach = Vec3::repeat(muscle.radius_mm);
            let (lo, hi) = points().fold(
                (points().next().copied().unwrap_or_default(), Vec3::repeat(f64::MIN)),
                |(lo, hi), p| (lo.inf(&(p - reach)), hi.sup(&(p + reach))),
            );
            let near = |q: &&Vec3| {
                (0..3).all(|k| lo[k] <= q[k] && q[k] <= hi[k])
                    && points().any(|p| (p - *q).norm() <= muscle.radius_mm)
            };
            let count = gauss.iter().filter(near).count();
            assert!(count >= 10, "{name} {}: {count} Gauss points", muscle.name);
        }
    }
}

#[test]
fn teeth_are_closed_and_point_outward() {
    let face = standard(&Resolution::COARSE);
    assert_eq!(face.teeth.iter().map(|t| t.upper).collect::<Vec<_>>(), [true, false]);
    for teeth in &face.teeth {
        let Surface { points, triangles } = &teeth.surface;
        let mut edges = BTreeMap::new();
        for t in triangles {
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        for (&(a, b), &count) in &edges {
            assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
        }
        let volume: f64 =
            triangles.iter().map(|t| points[t[0]].dot(&points[t[1]].cross(&points[t[2]])) / 6.0).sum();
        assert!((3_000.0..15_000.0).contains(&volume), "{volume}");
    }
}

/// Distance from `p` to a triangle.
fn triangle_distance(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| (e - s).cross(&(p - s)).dot(&normal) >= 0.0);
    if inside {
        return ((p - a).dot(&normal) / normal.norm()).abs();
    }
    let segment = |s: Vec3, e: Vec3| {
        let t = ((p - s).dot(&(e - s)) / (e - s).norm_squared()).clamp(0.0, 1.0);
        (p - s - t * (e - s)).norm()
    };
    segment(a, b).min(segment(b, c)).min(segment(c, a))
}

/// Signed distance by brute force; the sign is the winding number's (van Oosterom and Strackee 1983).
fn signed_distance(p: Vec3, surface: &Surface) -> f64 {
    let (mut distance, mut winding) = (f64::INFINITY, 0.0);
    for t in &surface.triangles {
        let [a, b, c] = t.map(|k| surface.points[k]);
        distance = distance.min(triangle_distance(p, a, b, c));
        let [a, b, c] = [a - p, b - p, c - p];
        let [la, lb, lc] = [a.norm(), b.norm(), c.norm()];
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        winding += 2.0 * a.dot(&b.cross(&c)).atan2(below);
    }
    if winding > 2.0 * std::f64::consts::PI { -distance } else { distance }
}

#[test]
fn the_ends_of_the_arches_tell_inside_from_outside() {
    for teeth in standard(&Resolution::COARSE).teeth {
        let solid = Solid::new(&teeth.surface);
        let (mut inside, mut wrong) = (0, Vec::new());
        for k in 0..25 * 15 * 15 {
            let [i, j, l] = [k % 25, k / 25 % 15, k / 375].map(f64::from);
            let p = Vec3::new(-48.3 + 4.0 * i, -20.6 + 2.9 * j, -80.4 + 2.5 * l);
            let distance = solid.project(p).map_or(f64::NAN, |at| at.distance_mm);
            inside += usize::from(distance < 0.0);
            if (distance < 0.0) != (signed_distance(p, &teeth.surface) < 0.0) {
                wrong.push((p, distance));
            }
        }
        assert!(inside > 10 && wrong.is_empty(), "{inside} inside, {}: {:.2?}", wrong.len(), wrong.first());
    }
}

#[test]
fn the_mucosa_lies_just_outside_the_teeth() {
    for (name, face) in faces() {
        let mut gaps = Vec::new();
        for &node in &face.mucosa {
            let p = face.mesh.points[node];
            let gap = face.teeth.iter().map(|t| signed_distance(p, &t.surface)).fold(f64::INFINITY, f64::min);
            assert!(gap > 0.15, "{name}: gap {gap:.2} at {p:.1?}");
            if p.y.abs() < 9.0 && p.x.abs() < 20.0 {
                assert!(gap < 2.2, "{name}: gap {gap:.2} at {p:.1?}");
            }
            gaps.push(gap);
        }
        gaps.sort_by(f64::total_cmp);
        let quantile = |q: f64| gaps[(q * (gaps.len() - 1) as f64) as usize];
        println!(
            "{name}: gaps min {:.2} median {:.2} 90 % {:.2} max {:.2}, {} nodes",
            gaps[0],
            quantile(0.5),
            quantile(0.9),
            quantile(1.0),
            gaps.len()
        );
        assert!((0.2..1.0).contains(&quantile(0.5)), "{name}: median gap {:.2}", quantile(0.5));
    }
}

#[test]
fn teeth_and_gum_stand_behind_all_of_the_mucosa() {
    for (name, face) in faces() {
        let held: BTreeSet<usize> = face.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        let mut nearest: BTreeMap<usize, f64> = BTreeMap::new();
        for pair in face.contact_pairs(ContactReach::default()) {
            if pair.tooth.is_some() {
                let gap = nearest.entry(pair.node).or_insert(f64::INFINITY);
                *gap = gap.min(pair.gap_mm);
            }
        }
        let extent = |points: &mut dyn Iterator<Item = Vec3>| {
            let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
            points.fold(none, |(lo, hi), p| (lo.inf(&p), hi.sup(&p)))
        };
        let (lo, hi) = extent(&mut face.mucosa.iter().map(|&n| face.mesh.points[n]));
        let [upper, lower] = &face.teeth[..] else { panic!("{name}: two arches") };
        let [upper, lower] = [upper, lower].map(|t| extent(&mut t.surface.points.iter().copied()));
        let farthest = nearest.values().copied().fold(0.0, f64::max);
        println!("{name}: mucosa from {lo:.1?} to {hi:.1?}, at most {farthest:.2} mm from an arch");
        println!("{name}: arches from {upper:.1?} to {lower:.1?}");
        assert!(face.mucosa.iter().all(|n| held.contains(n) || nearest.contains_key(n)), "{name}");
        assert!(farthest < 2.5, "{name}: {farthest}");
        // It ends in the fornices, before the gum does, and before the molars do.
        assert!(upper.1.y > hi.y + 1.5 && lower.0.y < lo.y - 1.5, "{name}");
        assert!(upper.0.z < lo.z - 5.0 && lower.0.z < lo.z - 5.0, "{name}");
        // Necks of the teeth are a crown from their edges: cheeks reach beyond them, onto the gum.
        assert!(hi.y > upper.0.y + 10.0 && lo.y < lower.1.y - 10.0, "{name}");
    }
}

#[test]
fn the_arches_do_not_touch() {
    let face = standard(&Resolution::COARSE);
    let [upper, lower] = &face.teeth[..] else { panic!("two arches") };
    assert!(lower.surface.points.iter().all(|&p| signed_distance(p, &upper.surface) > 0.2));
}

#[test]
fn distances_are_anthropometric() {
    for (name, face) in faces() {
        let height = |a: &str, b: &str| at(&face, a).y - at(&face, b).y;
        let width = |stem: &str| at(&face, &format!("{stem}_l")).x - at(&face, &format!("{stem}_r")).x;
        let stomion = 0.5 * (at(&face, "stomion_superius").y + at(&face, "stomion_inferius").y);
        for (what, value, target, tolerance) in [
            ("mouth width", width("cheilion"), 50.7, 0.1),
            ("subnasale to stomion", at(&face, "subnasale").y - stomion, 21.4, 0.7),
            ("subnasale to gnathion", height("subnasale", "gnathion"), 64.6, 2.5),
            ("upper vermilion", at(&face, "labiale_superius").y - stomion, 10.1, 0.7),
            ("lower vermilion", stomion - at(&face, "labiale_inferius").y, 10.2, 0.7),
            ("philtral crests", width("crista_philtri"), 14.6, 0.1),
            ("alar bases", width("alar_base"), 36.0, 1.5),
            ("nose protrusion", at(&face, "pronasale").z - at(&face, "alar_base_l").z, 22.0, 2.5),
            ("nose length", height("nasion", "subnasale"), 50.1, 1.5),
            ("pronasale height", at(&face, "pronasale").y, 35.0, 3.0),
            ("pogonion height", at(&face, "pogonion").y, -31.0, 4.0),
            ("sublabiale height", at(&face, "sublabiale").y, -18.0, 2.5),
        ] {
            println!("{name}: {what} {value:.2} ({target})");
            assert!((value - target).abs() <= tolerance, "{name}: {what} {value:.2}, not {target}");
        }
    }
}

#[test]
fn other_proportions_keep_the_quality() {
    let drawn = Parameters::default();
    for parameters in [
        Parameters { mouth_width_mm: 44.0, upper_lip_mm: 19.0, ..drawn.clone() },
        Parameters { mouth_width_mm: 58.0, upper_lip_mm: 24.0, ..drawn.clone() },
        Parameters { upper_vermilion_mm: 7.0, lower_vermilion_mm: 12.5, philtrum_width_mm: 12.0, ..drawn },
    ] {
        let face = parametric(&parameters, &Resolution::COARSE).unwrap_or_else(|e| panic!("{e}"));
        let worst = (0..face.mesh.cells.len()).map(|c| scaled_jacobian(&face.mesh, c)).fold(1.0, f64::min);
        assert!(worst > 0.2, "{parameters:?}: {worst}");
        let width = at(&face, "cheilion_l").x - at(&face, "cheilion_r").x;
        assert!((width - parameters.mouth_width_mm).abs() < 1e-9);
        assert_eq!(face.muscles.len(), standard(&Resolution::COARSE).muscles.len());
    }
}

#[test]
fn the_promised_muscles_and_landmarks_are_there() {
    let face = standard(&Resolution::COARSE);
    let paired = [
        "zygomaticus_major",
        "zygomaticus_minor",
        "levator_labii_superioris",
        "levator_labii_superioris_alaeque_nasi",
        "levator_anguli_oris",
        "risorius",
        "buccinator",
        "depressor_anguli_oris",
        "depressor_labii_inferioris",
        "mentalis",
        "incisivus_superior",
        "incisivus_inferior",
        "platysma",
    ];
    for stem in paired {
        for side in ["l", "r"] {
            let force = muscle(&face, &format!("{stem}_{side}")).max_force_n;
            assert!((0.4..5.0).contains(&force), "{stem}: {force} N");
        }
    }
    for ring in ["orbicularis_oris_peripheralis", "orbicularis_oris_marginalis"] {
        assert!(muscle(&face, ring).fibres.iter().all(|f| f.closed));
    }
    assert_eq!(face.muscles.len(), 2 * paired.len() + 2);
    for name in [
        "cheilion",
        "crista_philtri",
        "alar_base",
        "nasolabial_fold",
        "upper_lip_lateral",
        "lower_lip_lateral",
    ] {
        assert!(at(&face, &format!("{name}_l")).x > 0.0);
    }
}
