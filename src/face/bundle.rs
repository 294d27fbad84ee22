//! Bundles from single fibres, and rings from their pieces.

use crate::units::Vec3;

/// Length along the fibre over which the direction across it is averaged, mm: skin normals jump from
/// facet to facet, and the bundle must not.
const AVERAGED_MM: f64 = 8.;

/// Ends of ring pieces nearer than this are one point, mm.
const SAME_END_MM: f64 = 2.;

/// `n` fibres side by side over a muscle `width_mm` wide, parallel to the polyline `points` and in
/// the plane tangent to the skin: fibre `k` is `p + w (k + 1/2 - n/2) / n b`, with `b` the unit vector
/// along `t x s`, `t` the tangent and `s = skin_normal(p)`, averaged along the fibre.
///
/// One fibre, or a polyline of fewer than two points, comes back as it is.
pub fn spread(
    points: &[Vec3],
    closed: bool,
    n: usize,
    width_mm: f64,
    skin_normal: impl Fn(Vec3) -> Vec3,
) -> Vec<Vec<Vec3>> {
    let count = points.len();
    if n < 2 || count < 2 {
        return vec![points.to_vec()];
    }
    let tangent = |k: usize| {
        let (last, next) = if closed {
            ((k + count - 1) % count, (k + 1) % count)
        } else {
            (k.saturating_sub(1), (k + 1).min(count - 1))
        };
        (points[next] - points[last]).try_normalize(0.).unwrap_or_else(Vec3::zeros)
    };
    let raw: Vec<Vec3> = (0..count).map(|k| tangent(k).cross(&skin_normal(points[k]))).collect();
    let across: Vec<Vec3> = (0..count)
        .map(|k| {
            let near = |j: &usize| (points[*j] - points[k]).norm() <= AVERAGED_MM;
            let mean: Vec3 = (0..count).filter(near).map(|j| raw[j]).sum();
            let t = tangent(k);
            (mean - mean.dot(&t) * t).try_normalize(1e-9).unwrap_or_else(Vec3::zeros)
        })
        .collect();
    let fibre = |k: usize| {
        let offset = width_mm * ((k as f64 + 0.5) / n as f64 - 0.5);
        points.iter().zip(&across).map(|(p, b)| p + offset * b).collect()
    };
    (0..n).map(fibre).collect()
}

/// The pieces of a sphincter joined end to end to one ring (its points, the first not repeated), each
/// turned round where its other end is nearer; ends that nearly meet become one point. The second
/// value is the widest gap that was bridged, mm.
pub fn join_ring(pieces: &[Vec<Vec3>]) -> (Vec<Vec3>, f64) {
    let mut rest: Vec<Vec<Vec3>> = pieces.iter().filter(|p| !p.is_empty()).cloned().collect();
    if rest.is_empty() {
        return (Vec::new(), 0.);
    }
    let mut ring = rest.remove(0);
    let mut widest = 0f64;
    while let Some(&end) = ring.last() {
        let gap = |piece: &Vec<Vec3>| {
            let ends = [piece[0], piece[piece.len() - 1]].map(|p| (p - end).norm());
            (ends[0].min(ends[1]), ends[1] < ends[0])
        };
        let Some(k) = (0..rest.len()).min_by(|a, b| gap(&rest[*a]).0.total_cmp(&gap(&rest[*b]).0)) else {
            break;
        };
        let mut piece = rest.remove(k);
        let (distance, turned) = gap(&piece);
        if turned {
            piece.reverse();
        }
        widest = widest.max(distance);
        if distance < SAME_END_MM {
            ring.pop();
            piece[0] = (piece[0] + end) / 2.;
        }
        ring.extend(piece);
    }
    let (first, last) = (ring[0], ring[ring.len() - 1]);
    let distance = (last - first).norm();
    if ring.len() > 1 && distance < SAME_END_MM {
        ring.pop();
        ring[0] = (first + last) / 2.;
    }
    (ring, widest.max(distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_fibre_becomes_a_flat_ribbon_parallel_to_the_skin() {
        let line: Vec<Vec3> = (0..21).map(|k| Vec3::new(0., f64::from(k), 0.)).collect();
        // A skin normal that flickers about +z.
        let skin = |p: Vec3| Vec3::new(0., 0.3 * (p.y * 3.).sin(), 1.).normalize();
        let bundle = spread(&line, false, 5, 10., skin);
        let x: Vec<f64> = bundle.iter().map(|f| f[7].x).collect();
        for (x, expect) in x.iter().zip([-4., -2., 0., 2., 4.]) {
            assert!((x - expect).abs() < 1e-9, "{x} {expect}");
        }
        assert!(bundle.iter().flatten().all(|p| p.z.abs() < 1e-9));
        assert_eq!(bundle[2], line);
    }

    #[test]
    fn a_ring_spreads_into_rings_about_the_same_centre() {
        let ring: Vec<Vec3> = (0..90)
            .map(|k| f64::from(k) * std::f64::consts::TAU / 90.)
            .map(|a| 20. * Vec3::new(a.cos(), a.sin(), 0.))
            .collect();
        for (fibre, radius) in spread(&ring, true, 3, 6., |_| Vec3::z()).iter().zip([18., 20., 22.]) {
            assert!(fibre.iter().all(|p| (p.norm() - radius).abs() < 0.02), "{radius} {}", fibre[0].norm());
        }
    }

    #[test]
    fn four_quadrants_in_any_order_and_direction_make_one_ring() {
        let quadrant = |from: f64| -> Vec<Vec3> {
            (0..=6)
                .map(|k| (from + 90. * f64::from(k) / 6.).to_radians())
                .map(|a| 20. * Vec3::new(a.cos(), a.sin(), 0.))
                .collect()
        };
        let mut pieces = vec![quadrant(0.), quadrant(180.), quadrant(90.), quadrant(270.)];
        pieces[1].reverse();
        pieces[3].reverse();
        let (ring, gap) = join_ring(&pieces);
        assert_eq!(ring.len(), 24);
        assert!(gap < 1e-9);
        let turn = |k: usize| ring[k].cross(&ring[(k + 1) % 24]).z;
        assert!((0..24).all(|k| turn(k) > 0.), "one sense of rotation all round");
        let (_, gap) = join_ring(&pieces[..3]);
        assert!(gap > 20., "a missing quadrant shows as a gap: {gap}");
        assert_eq!(join_ring(&[]), (Vec::new(), 0.));
    }
}
