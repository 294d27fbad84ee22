//! A small mirror-symmetric face: a block of tissue with a pair of muscles and a sphincter.

use modiolus::contact::{Pair, PairKind, ToothPoint};
use modiolus::face::{Face, Fibre, Jaw, Landmark, Muscle, MuscleTissue, Support, Teeth, Tissue};
use modiolus::mesh::{CellKind, Site, Surface};
use modiolus::units::Vec3;

use super::grids::grid;

fn muscle(name: &str, closed: bool, points: Vec<Vec3>) -> Muscle {
    Muscle {
        name: name.into(),
        max_force_n: 1.,
        radius_mm: 3.,
        area_mm2: None,
        insertion_mm: if closed { 0. } else { 5. },
        fibres: vec![Fibre { points, closed }],
    }
}

/// A block 60 x 40 x 12 mm of `cells` hexes, fixed at its back, symmetric about x = 0.
pub fn block_face(cells: [usize; 3]) -> Face {
    let mesh = grid(CellKind::Hex8, cells, |p| Vec3::new(60. * (p.x - 0.5), 40. * (p.y - 0.5), 12. * p.z));
    let nodes =
        |select: &dyn Fn(Vec3) -> bool| (0..mesh.n_nodes()).filter(|&n| select(mesh.points[n])).collect();
    let pull = |side: f64| {
        (0..=25)
            .map(|i| {
                let t = f64::from(i) / 25.;
                Vec3::new(side * (26. - 18. * t), 15. - 12. * t, 1.5 + 6. * t + 3. * t * (1. - t))
            })
            .collect()
    };
    let ring = (0..48)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 48.).sin_cos();
            Vec3::new(15. * cos, 10. * sin, 8.)
        })
        .collect();
    let landmarks = [("cheilion_l", 15.), ("cheilion_r", -15.)]
        .map(|(name, x)| {
            let at = Vec3::new(x, 0., 12.);
            let node = (0..mesh.n_nodes())
                .min_by(|&a, &b| (mesh.points[a] - at).norm().total_cmp(&(mesh.points[b] - at).norm()))
                .unwrap();
            Landmark { name: name.into(), site: Site::node(node, mesh.points[node]) }
        })
        .to_vec();
    Face {
        name: "block".into(),
        tissue: Tissue::default(),
        muscle_tissue: MuscleTissue::default(),
        supports: vec![Support { bone: "skull".into(), part_of: None, nodes: nodes(&|p| p.z == 0.) }],
        muscles: vec![
            muscle("zygomaticus_major_l", false, pull(1.)),
            muscle("zygomaticus_major_r", false, pull(-1.)),
            muscle("orbicularis_oris", true, ring),
        ],
        jaw: None,
        teeth: Vec::new(),
        mucosa: Vec::new(),
        upper_lip: Vec::new(),
        lower_lip: Vec::new(),
        skin: nodes(&|p| p.z == 12.),
        landmarks,
        mesh,
    }
}

/// A block 20 x 20 x 10 mm of `cells` cells of `kind`, fixed at its back, with the points `corner_l` and `corner_r` 5 mm off the
/// middle of its front and a pair of muscles below them.
pub fn pulled_block(kind: CellKind, cells: [usize; 3]) -> Face {
    let mut face = block_face([2, 2, 2]);
    face.mesh = grid(kind, cells, |p| Vec3::new(20. * p.x - 10., 20. * p.y - 10., 10. * p.z - 10.));
    let nodes =
        |z: f64| (0..face.mesh.n_nodes()).filter(|&k| face.mesh.points[k].z == z).collect::<Vec<usize>>();
    let (back, skin) = (nodes(-10.), nodes(0.));
    face.landmarks = [("corner_l", 5.), ("corner_r", -5.)]
        .map(|(name, x)| {
            let at = Vec3::new(x, 0., 0.);
            let node = skin.iter().copied().find(|&k| (face.mesh.points[k] - at).norm() < 1e-9).unwrap();
            Landmark { name: name.into(), site: Site::node(node, at) }
        })
        .to_vec();
    face.supports[0].nodes = back;
    face.skin = skin;
    face.muscles = pair("zygomaticus", 3., 2., [[8., 6., -8.], [6., 2., -4.], [3., -4., -1.]]);
    face
}

/// A muscle of 0.2 N along `bends` on the left and its mirror image.
pub fn pair(name: &str, radius_mm: f64, insertion_mm: f64, bends: [[f64; 3]; 3]) -> Vec<Muscle> {
    let bends = bends.map(Vec3::from);
    let part = |k: usize| (0..10).map(move |i| bends[k].lerp(&bends[k + 1], f64::from(i) / 10.));
    let left: Vec<Vec3> = part(0).chain(part(1)).chain([bends[2]]).collect();
    let muscle = |side: &str, sign: f64| Muscle {
        name: format!("{name}_{side}"),
        max_force_n: 0.2,
        radius_mm,
        area_mm2: None,
        insertion_mm,
        fibres: vec![Fibre {
            points: left.iter().map(|p| Vec3::new(sign * p.x, p.y, p.z)).collect(),
            closed: false,
        }],
    };
    vec![muscle("l", 1.), muscle("r", -1.)]
}

/// Contact candidates of the front of `face` against planes `gap` mm ahead.
pub fn front_pairs(face: &Face, gap_mm: f64) -> Vec<Pair> {
    let front = face.skin.iter().step_by(3);
    front
        .map(|&node| Pair {
            kind: PairKind::UpperTeeth,
            node,
            row: vec![(node, -Vec3::z())],
            tooth: None,
            gap_mm,
            rest_overlap_mm: 0.,
        })
        .collect()
}

/// The block with its back below y = -5 mm on a jaw that turns about an axis behind it, free up to y = 5 mm, and a tooth surface
/// on either bone.
pub fn jaw_block(cells: [usize; 3]) -> Face {
    let mut face = block_face(cells);
    let back = face.supports[0].nodes.clone();
    let beyond =
        |side: f64| back.iter().copied().filter(|&n| side * face.mesh.points[n].y > 5. - 1e-9).collect();
    let (upper, lower): (Vec<usize>, Vec<usize>) = (beyond(1.), beyond(-1.));
    face.supports[0].nodes = upper;
    face.supports.push(Support { bone: "mandible".into(), part_of: None, nodes: lower });
    let condyles = [Vec3::new(50., 25., -70.), Vec3::new(-50., 25., -70.)];
    face.jaw = Some(Jaw { bone: "mandible".into(), condyles, incisor: Vec3::new(0., -5., 10.) });
    let teeth = |upper: bool, bone: &str| Teeth { upper, bone: bone.into(), surface: Surface::default() };
    face.teeth = vec![teeth(true, "skull"), teeth(false, "mandible")];
    face
}

/// The [`front_pairs`] of a jaw block: those below the middle are kept off teeth of the jaw.
pub fn jaw_pairs(face: &Face, gap_mm: f64) -> Vec<Pair> {
    let mut pairs = front_pairs(face, gap_mm);
    for pair in &mut pairs {
        let p = face.mesh.points[pair.node];
        let surface = usize::from(p.y < 0.);
        pair.tooth = Some(ToothPoint { surface, at: p + gap_mm * Vec3::z() });
    }
    pairs
}
