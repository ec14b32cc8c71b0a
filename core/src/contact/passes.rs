//! The two loops of K-means that touch every point: who is nearest (4.5, 4.6), and the sums of (4.7).
//!
//! Written for [`crate::vector`]: sixteen points at a time, and every sum in an order that no vector width changes.

/// Points side by side: two AVX2 registers hide the latency of the comparison.
const LANES: usize = 16;

/// Sums run in this many interleaved chains, point i in chain i mod 4: neighbours on a skin mostly share a
/// cluster, and one chain would wait for its last addition at every point.
const CHAINS: usize = 4;

/// Sums over a cluster: w, w x, w y, and the number of points (exact in f64).
pub(super) type Sum = [f64; 4];

/// Relative error of a computed distance, with room: the differences, the squares and their sum round.
const ROUNDING: f32 = 2e-6;

/// The squared distance as every pass computes it: differences first, no fused multiply-add.
#[inline(always)]
pub(super) fn square(ax: f32, ay: f32, bx: f32, by: f32) -> f32 {
    let (dx, dy) = (ax - bx, ay - by);
    dx * dx + dy * dy
}

/// Writes every point's nearest centroid and squared distance; of equal ones the lowest index.
///
/// With `MARGIN` it returns how much nearer, at least, every point is to its centroid than to any other, mm, all
/// rounding taken off: assignments hold while no centroid moves by half of that. Else 0.
#[inline(always)]
pub(super) fn assign<const MARGIN: bool>(
    (x, y): (&[f32], &[f32]),
    (cx, cy): (&[f32], &[f32]),
    near: &mut [f32],
    assigned: &mut [u32],
) -> f32 {
    let mut margin = f32::INFINITY;
    let n = x.len().min(y.len()).min(near.len()).min(assigned.len());
    let mut at = 0;
    while at < n {
        let count = LANES.min(n - at);
        // Lanes beyond the last point repeat it, so that they cannot narrow the margin.
        let (mut bx, mut by) = ([x[at + count - 1]; LANES], [y[at + count - 1]; LANES]);
        bx[..count].copy_from_slice(&x[at..at + count]);
        by[..count].copy_from_slice(&y[at..at + count]);
        let (mut best, mut arg) = ([f32::INFINITY; LANES], [0u32; LANES]);
        let mut second = [f32::INFINITY; LANES];
        for (k, (&kx, &ky)) in cx.iter().zip(cy).enumerate() {
            for lane in 0..LANES {
                let d = square(bx[lane], by[lane], kx, ky);
                let closer = d < best[lane];
                if MARGIN {
                    let farther = if closer { best[lane] } else { d };
                    second[lane] = if farther < second[lane] {
                        farther
                    } else {
                        second[lane]
                    };
                }
                best[lane] = if closer { d } else { best[lane] };
                arg[lane] = if closer { k as u32 } else { arg[lane] };
            }
        }
        if MARGIN {
            // sqrt(s) - sqrt(b) is at least (s - b) / 2 sqrt(s), and nearly that where it is smallest: one root at
            // the end in place of two a point.
            for lane in 0..LANES {
                let gap = second[lane] * (1.0 - ROUNDING) - best[lane] * (1.0 + ROUNDING);
                let gap = if gap > 0.0 { gap } else { 0.0 };
                let square = gap * gap / (second[lane] + f32::MIN_POSITIVE);
                margin = if square < margin { square } else { margin };
            }
        }
        near[at..at + count].copy_from_slice(&best[..count]);
        assigned[at..at + count].copy_from_slice(&arg[..count]);
        at += count;
    }
    if MARGIN {
        0.5 * libm::sqrtf(margin) * (1.0 - ROUNDING)
    } else {
        0.0
    }
}

/// Adds a point to its cluster's sums.
#[inline(always)]
pub(super) fn add(sums: &mut [Sum], cluster: u32, (x, y, w): (f32, f32, f32)) {
    let (x, y, w) = (f64::from(x), f64::from(y), f64::from(w));
    if let Some(sum) = sums.get_mut(cluster as usize) {
        let point = [w, w * x, w * y, 1.0];
        for (s, p) in sum.iter_mut().zip(point) {
            *s += p;
        }
    }
}

/// The sums of all clusters; `chains` has room for [`chained`] of them and keeps the result in front.
#[inline(always)]
pub(super) fn sum(x: &[f32], y: &[f32], w: &[f32], assigned: &[u32], chains: &mut [Sum]) {
    chains.fill([0.0; 4]);
    let k = chains.len() / CHAINS;
    let (front, back) = chains.split_at_mut(2 * k);
    let (c0, c1) = front.split_at_mut(k);
    let (c2, c3) = back.split_at_mut(k);
    let n = assigned.len().min(x.len()).min(y.len()).min(w.len());
    let (x, y, w, assigned) = (&x[..n], &y[..n], &w[..n], &assigned[..n]);
    let mut at = 0;
    while at + CHAINS <= n {
        let point = |i: usize| (x[at + i], y[at + i], w[at + i]);
        add(c0, assigned[at], point(0));
        add(c1, assigned[at + 1], point(1));
        add(c2, assigned[at + 2], point(2));
        add(c3, assigned[at + 3], point(3));
        at += CHAINS;
    }
    for (i, chain) in (at..n).zip([&mut *c0, &mut *c1, &mut *c2]) {
        add(chain, assigned[i], (x[i], y[i], w[i]));
    }
    for cluster in 0..k {
        for i in 0..4 {
            c0[cluster][i] = (c0[cluster][i] + c1[cluster][i]) + (c2[cluster][i] + c3[cluster][i]);
        }
    }
}

/// How many sums [`sum`] needs for `clusters`.
pub(super) const fn chained(clusters: usize) -> usize {
    CHAINS * clusters
}
