//! A real face with its known faults, through `examples/badin/face.toml`.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::{Path, PathBuf};

use modiolus::contact::{Facets, Pair, PairKind, Patch, Solid};
use modiolus::face::{ContactReach, Face, FaceWarning, polyline_length};
use modiolus::io::{FaceDocument, FaceFileWarningKind, read_face};
use modiolus::mesh::{Locator, Surface};
use modiolus::units::Vec3;

fn badin() -> FaceDocument {
    let data = std::env::var_os("MODIOLUS_DATA").expect("MODIOLUS_DATA names the folder of the real data");
    let base = PathBuf::from(data).join("badin_face");
    assert!(base.is_dir(), "{} is missing", base.display());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/badin/face.toml");
    // Relative to the project's root, as the test command states it.
    let base = if base.is_absolute() { base } else { Path::new(env!("CARGO_MANIFEST_DIR")).join(base) };
    read_face(&file, Some(&base)).unwrap_or_else(|e| panic!("{e}"))
}

fn mirrored(p: Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn it_loads_whole() {
    let FaceDocument { face, warnings, files } = badin();
    let odd = |wanted: fn(&FaceFileWarningKind) -> bool| warnings.iter().filter(|w| wanted(&w.kind)).count();
    assert_eq!(odd(|k| matches!(k, FaceFileWarningKind::Teeth(_))), 4, "holes and loose pieces of each arch");
    assert_eq!(odd(|k| matches!(k, FaceFileWarningKind::Face(FaceWarning::RestOverlap(_)))), 1);
    assert_eq!(odd(|k| matches!(k, FaceFileWarningKind::MovedLandmark { .. })), 0);
    assert_eq!((face.mesh.n_nodes(), face.mesh.cells.len()), (8720, 6342));
    assert_eq!(face.supports.iter().map(|s| s.nodes.len()).collect::<Vec<_>>(), [1606, 329]);
    assert_eq!((face.mucosa.len(), face.skin.len()), (589, 2180));
    assert_eq!(face.muscles.len(), 20, "nine a side and two rings");
    assert_eq!(face.landmarks.len(), 16);
    assert_eq!(files.len(), 7);
    assert_eq!((face.upper_lip.len(), face.lower_lip.len()), (208, 188));
    for muscle in &face.muscles {
        assert!(muscle.fibres.len() >= 5, "{}", muscle.name);
        let step = |f: &modiolus::face::Fibre| {
            f.points.windows(2).map(|p| (p[1] - p[0]).norm()).fold(0f64, f64::max)
        };
        let longest = muscle.fibres.iter().map(step).fold(0f64, f64::max);
        assert!(longest < 1.5, "{}: {longest}", muscle.name);
    }
}

/// Generalised winding number of a surface about `p`, 1 inside and 0 outside: the sum of the solid angles of
/// its triangles over 4 pi. Source: Jacobson et al., ACM Trans. Graph. 32 (2013) 33; van Oosterom and
/// Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.
fn winding_number(surface: &Surface, p: Vec3) -> f64 {
    let angle = |t: &[usize; 3]| {
        let [a, b, c] = t.map(|v| surface.points[v] - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let down = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2. * a.dot(&b.cross(&c)).atan2(down)
    };
    surface.triangles.iter().map(angle).sum::<f64>() / (4. * std::f64::consts::PI)
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn inside_and_outside_agree_with_the_winding_number() {
    let face = badin().face;
    for teeth in &face.teeth {
        let solid = Solid::new(&teeth.surface);
        let (mut inside, mut disagree) = (0, Vec::new());
        for &node in &face.mucosa {
            let p = face.mesh.points[node];
            let (distance, winding) =
                (solid.project(p).unwrap().distance_mm, winding_number(&teeth.surface, p));
            inside += usize::from(distance < 0.);
            if (distance < 0.) != (winding > 0.5) {
                disagree.push((node, distance, winding));
            }
        }
        assert!(disagree.is_empty(), "{disagree:?}");
        assert_eq!(inside, if teeth.upper { 221 } else { 155 });
    }
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn the_rest_overlap_is_the_known_one() {
    let face = badin().face;
    let overlap = face.rest_overlap();
    assert_eq!((overlap.nodes, overlap.inside), (589, 376));
    assert!((overlap.deepest_mm - 8.74).abs() < 0.01, "{overlap:?}");
    assert!((overlap.median_mm - 1.07).abs() < 0.01, "{overlap:?}");
    // Over all nodes, those outside counted as negative depths, the median is 0.4 mm.
    let solids: Vec<Solid> = face.teeth.iter().map(|t| Solid::new(&t.surface)).collect();
    let distance = |node: &usize| {
        let to = |s: &Solid| s.project(face.mesh.points[*node]).unwrap().distance_mm;
        solids.iter().map(to).fold(f64::INFINITY, f64::min)
    };
    let mut all: Vec<f64> = face.mucosa.iter().map(distance).collect();
    all.sort_by(f64::total_cmp);
    assert!((all[294] + 0.38).abs() < 0.03, "{}", all[294]);
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn contact_pairs_push_the_tissue_out_of_the_teeth() {
    let face = badin().face;
    let pairs = face.contact_pairs(ContactReach::default());
    let normals = Facets::of(&face.mesh).node_normals(&face.mesh);
    let own = |p: &Pair| p.row.iter().find(|r| r.0 == p.node).unwrap().1;
    let of = |kind: PairKind| pairs.iter().filter(move |p| p.kind == kind);
    assert!([PairKind::UpperTeeth, PairKind::LowerTeeth].iter().all(|k| of(*k).count() > 400));
    for pair in pairs.iter().filter(|p| p.kind != PairKind::Lips) {
        let (normal, tissue) = (own(pair), normals[&pair.node]);
        assert!((normal.norm() - 1.).abs() < 1e-12 && pair.gap_mm <= 12.);
        // Outside, wherever it looks, a node shall not enter a tooth; inside, it leaves towards its tissue.
        assert!(pair.rest_overlap_mm == 0. || normal.dot(&tissue) < 0., "{pair:?} {tissue}");
        // Far inside, the lip still leaves forwards or sideways, not through the arch to the tongue.
        assert!(pair.rest_overlap_mm < 1. || normal.z > -0.3, "{pair:?}");
    }
    assert!(of(PairKind::Lips).count() > 150);
    assert!(of(PairKind::Lips).all(|p| p.rest_overlap_mm < 0.1));
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn muscles_are_inside_the_tissue_and_mirror_each_other() {
    let face = badin().face;
    let locator = Locator::new(&face.mesh);
    let length = |muscle: &str| -> f64 {
        let fibres = &face.muscles[face.muscle_index(muscle).unwrap()].fibres;
        fibres.iter().map(|f| polyline_length(&f.points, f.closed)).sum::<f64>() / fibres.len() as f64
    };
    for muscle in &face.muscles {
        for p in muscle.fibres.iter().flat_map(|f| &f.points) {
            assert!(locator.locate(*p).unwrap().distance_mm < 1e-6, "{} {p}", muscle.name);
        }
        let Some(base) = muscle.name.strip_suffix("_l") else { continue };
        let right = &face.muscles[face.muscle_index(&format!("{base}_r")).unwrap()];
        assert_eq!(muscle.fibres.len(), right.fibres.len());
        // The right bundle is spread in the opposite order.
        let centre = |m: &modiolus::face::Muscle, k: usize| -> Vec3 {
            m.fibres
                .iter()
                .map(|f| if k == 0 { f.points[0] } else { f.points[f.points.len() - 1] })
                .sum::<Vec3>()
                / m.fibres.len() as f64
        };
        for k in [0, 1] {
            let apart = (centre(muscle, k) - mirrored(centre(right, k))).norm();
            assert!(apart < 0.5, "{base}: {apart}");
        }
        let (l, r) = (length(&muscle.name), length(&right.name));
        assert!((l - r).abs() < 0.02 * l, "{base}: {l} {r}");
    }
    for ring in ["orbicularis_oris_peripheralis", "orbicularis_oris_marginalis"] {
        let muscle = &face.muscles[face.muscle_index(ring).unwrap()];
        assert!(muscle.fibres.iter().all(|f| f.closed));
    }
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn landmarks_are_on_the_skin_and_in_mirrored_pairs() {
    let face: Face = badin().face;
    let skin = Patch::new(&Facets::of(&face.mesh).within(&face.skin), &face.mesh);
    for landmark in &face.landmarks {
        let site = &landmark.site;
        assert!(skin.project(site.position).unwrap().1 < 1e-9, "{}", landmark.name);
        let carried: Vec3 = site.weights.iter().map(|(node, w)| *w * face.mesh.points[*node]).sum();
        assert!((carried - site.position).norm() < 1e-9, "{}", landmark.name);
        if let Some(base) = landmark.name.strip_suffix("_l") {
            let right = face.landmark(&format!("{base}_r")).unwrap();
            assert!((mirrored(right.site.position) - site.position).norm() < 0.05, "{base}");
        }
    }
}
