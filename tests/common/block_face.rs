//! A small mirror-symmetric face: a block of tissue with a pair of muscles and a sphincter.

use modiolus::contact::{Pair, PairKind};
use modiolus::face::{Face, Fibre, Landmark, Muscle, MuscleTissue, Support, Tissue};
use modiolus::mesh::{CellKind, Site};
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
        supports: vec![Support { bone: "skull".into(), nodes: nodes(&|p| p.z == 0.) }],
        muscles: vec![
            muscle("zygomaticus_major_l", false, pull(1.)),
            muscle("zygomaticus_major_r", false, pull(-1.)),
            muscle("orbicularis_oris", true, ring),
        ],
        teeth: Vec::new(),
        mucosa: Vec::new(),
        upper_lip: Vec::new(),
        lower_lip: Vec::new(),
        skin: nodes(&|p| p.z == 12.),
        landmarks,
        mesh,
    }
}

/// Contact candidates of the front of `face` against planes `gap` mm ahead.
pub fn front_pairs(face: &Face, gap_mm: f64) -> Vec<Pair> {
    let front = face.skin.iter().step_by(3);
    front
        .map(|&node| Pair {
            kind: PairKind::UpperTeeth,
            node,
            row: vec![(node, -Vec3::z())],
            gap_mm,
            rest_overlap_mm: 0.,
        })
        .collect()
}
