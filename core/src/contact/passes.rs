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
    centroids: (&[f32], &[f32]),
    near: &mut [f32],
    assigned: &mut [u32],
) -> f32 {
    let mut margin = f32::INFINITY;
    let n = x.len().min(y.len()).min(near.len()).min(assigned.len());
    let (x, last_x) = x[..n].as_chunks();
    let (y, last_y) = y[..n].as_chunks();
    let (near, last_near) = near[..n].as_chunks_mut();
    let (assigned, last_assigned) = assigned[..n].as_chunks_mut();
    for ((x, y), (near, assigned)) in x.iter().zip(y).zip(near.iter_mut().zip(assigned)) {
        (*near, *assigned) = group::<MARGIN>(x, y, centroids, &mut margin);
    }
    if let (Some(&end_x), Some(&end_y)) = (last_x.last(), last_y.last()) {
        // Lanes beyond the last point repeat it, so that they cannot narrow the margin.
        let (mut x, mut y) = ([end_x; LANES], [end_y; LANES]);
        x[..last_x.len()].copy_from_slice(last_x);
        y[..last_y.len()].copy_from_slice(last_y);
        let (near, assigned) = group::<MARGIN>(&x, &y, centroids, &mut margin);
        last_near.copy_from_slice(&near[..last_near.len()]);
        last_assigned.copy_from_slice(&assigned[..last_assigned.len()]);
    }
    if MARGIN {
        0.5 * libm::sqrtf(margin) * (1.0 - ROUNDING)
    } else {
        0.0
    }
}

/// Squared distances to the nearest centroids, and which they are; `margin` becomes the least square of a margin.
#[inline(always)]
fn group<const MARGIN: bool>(
    x: &[f32; LANES],
    y: &[f32; LANES],
    (cx, cy): (&[f32], &[f32]),
    margin: &mut f32,
) -> ([f32; LANES], [u32; LANES]) {
    let (mut best, mut arg) = ([f32::INFINITY; LANES], [0u32; LANES]);
    let mut second = [f32::INFINITY; LANES];
    for (k, (&kx, &ky)) in cx.iter().zip(cy).enumerate() {
        for lane in 0..LANES {
            let d = square(x[lane], y[lane], kx, ky);
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
            *margin = if square < *margin { square } else { *margin };
        }
    }
    (best, arg)
}

/// Adds a point to its cluster's sums.
#[inline(always)]
pub(super) fn add(sums: &mut [Sum], cluster: u32, (x, y, w): (f32, f32, f32)) {
    let (x, y, w) = (f64::from(x), f64::from(y), f64::from(w));
    add_sum(sums, cluster, [w, w * x, w * y, 1.0]);
}

/// An index beyond the last cluster means the last: a branch here would tear the vectors of [`sum`] apart.
#[inline(always)]
fn add_sum(sums: &mut [Sum], cluster: u32, point: Sum) {
    let last = sums.len() - 1;
    for (s, p) in sums[(cluster as usize).min(last)].iter_mut().zip(point) {
        *s += p;
    }
}

/// The sums of all clusters; `chains` has room for [`chained`] of them and keeps the result in front.
#[inline(always)]
pub(super) fn sum(x: &[f32], y: &[f32], w: &[f32], assigned: &[u32], chains: &mut [Sum]) {
    chains.fill([0.0; 4]);
    let k = chains.len() / CHAINS;
    if k == 0 {
        return;
    }
    let (front, back) = chains.split_at_mut(2 * k);
    let (c0, c1) = front.split_at_mut(k);
    let (c2, c3) = back.split_at_mut(k);
    let n = assigned.len().min(x.len()).min(y.len()).min(w.len());
    let (x, y, w, assigned) = (&x[..n], &y[..n], &w[..n], &assigned[..n]);
    let groups = (x.as_chunks().0.iter().zip(y.as_chunks().0))
        .zip(w.as_chunks().0.iter().zip(assigned.as_chunks().0));
    for ((x, y), (w, a)) in groups {
        let ([x, y, w], a): ([&[f32; CHAINS]; 3], &[u32; CHAINS]) = ([x, y, w], a);
        // four points in one vector each for w, w x, w y
        let w = w.map(f64::from);
        let wx: [f64; CHAINS] = core::array::from_fn(|i| w[i] * f64::from(x[i]));
        let wy: [f64; CHAINS] = core::array::from_fn(|i| w[i] * f64::from(y[i]));
        add_sum(c0, a[0], [w[0], wx[0], wy[0], 1.0]);
        add_sum(c1, a[1], [w[1], wx[1], wy[1], 1.0]);
        add_sum(c2, a[2], [w[2], wx[2], wy[2], 1.0]);
        add_sum(c3, a[3], [w[3], wx[3], wy[3], 1.0]);
    }
    for (i, chain) in (n - n % CHAINS..n).zip([&mut *c0, &mut *c1, &mut *c2]) {
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
