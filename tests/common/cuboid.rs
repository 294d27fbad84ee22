//! A closed surface whose distances have a closed form.

use modiolus::mesh::Surface;
use modiolus::units::Vec3;

/// The box `lo..hi`, two triangles a side, outward.
pub fn cuboid(lo: Vec3, hi: Vec3) -> Surface {
    let at = |k: usize| {
        let pick = |axis: usize| if k >> axis & 1 == 1 { hi[axis] } else { lo[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Surface { points: (0..8).map(at).collect(), triangles }
}
