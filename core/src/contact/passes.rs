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

/// Writes every point's nearest centroid and squared distance; of equal ones the lowest index. Centroids come with
/// their indices.
///
/// With `MARGIN` it returns how much nearer, at least, every point is to its centroid than to any other, mm, all
/// rounding taken off: assignments hold while no centroid moves by half of that. Else 0.
#[inline(always)]
pub(super) fn assign<const MARGIN: bool>(
    (x, y): (&[f32], &[f32]),
    centroids: (&[f32], &[f32], &[u32]),
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
    (cx, cy, index): (&[f32], &[f32], &[u32]),
    margin: &mut f32,
) -> ([f32; LANES], [u32; LANES]) {
    let (mut best, mut arg) = ([f32::INFINITY; LANES], [0u32; LANES]);
    let mut second = [f32::INFINITY; LANES];
    for ((&kx, &ky), &k) in cx.iter().zip(cy).zip(index) {
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
            arg[lane] = if closer { k } else { arg[lane] };
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

/// A cluster that there is not takes nothing.
#[inline(always)]
fn add_sum(sums: &mut [Sum], cluster: u32, point: Sum) {
    if let Some(sum) = sums.get_mut(cluster as usize) {
        for (s, p) in sum.iter_mut().zip(point) {
            *s += p;
        }
    }
}

/// Adds `N` points to their clusters' sums, each in its chain.
#[inline(always)]
fn add_several<const N: usize>(
    [x, y, w]: [&[f32; N]; 3],
    assigned: &[u32; N],
    [c0, c1, c2, c3]: [&mut [Sum]; CHAINS],
) {
    // All products first: only so they are made in vectors. In plain loops: closures of `map` and `from_fn` are compiled
    // without the vectors.
    let mut points = [[0.0; N]; 3];
    for i in 0..N {
        let weight = f64::from(w[i]);
        points[0][i] = weight;
        points[1][i] = weight * f64::from(x[i]);
        points[2][i] = weight * f64::from(y[i]);
    }
    let [w, wx, wy] = points;
    let point = |i: usize| [w[i], wx[i], wy[i], 1.0];
    for i in (0..N).step_by(CHAINS) {
        add_sum(c0, assigned[i], point(i));
        add_sum(c1, assigned[i + 1], point(i + 1));
        add_sum(c2, assigned[i + 2], point(i + 2));
        add_sum(c3, assigned[i + 3], point(i + 3));
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
    let (x, last_x) = x[..n].as_chunks();
    let (y, last_y) = y[..n].as_chunks();
    let (w, last_w) = w[..n].as_chunks();
    let (assigned, last_assigned) = assigned[..n].as_chunks();
    let points = x.iter().zip(y).zip(w.iter().zip(assigned));
    for ((x, y), (w, a)) in points {
        add_several::<LANES>([x, y, w], a, [&mut *c0, &mut *c1, &mut *c2, &mut *c3]);
    }
    let (x, last_x) = last_x.as_chunks();
    let (y, last_y) = last_y.as_chunks();
    let (w, last_w) = last_w.as_chunks();
    let (assigned, last_assigned) = last_assigned.as_chunks();
    let points = x.iter().zip(y).zip(w.iter().zip(assigned));
    for ((x, y), (w, a)) in points {
        add_several::<CHAINS>([x, y, w], a, [&mut *c0, &mut *c1, &mut *c2, &mut *c3]);
    }
    for (i, chain) in (0..last_assigned.len()).zip([&mut *c0, &mut *c1, &mut *c2]) {
        add(chain, last_assigned[i], (last_x[i], last_y[i], last_w[i]));
    }
    for cluster in 0..k {
        for i in 0..4 {
            c0[cluster][i] = (c0[cluster][i] + c1[cluster][i]) + (c2[cluster][i] + c3[cluster][i]);
        }
    }
}

/// Number of sums that [`sum`] needs for `clusters`.
pub(super) const fn chained(clusters: usize) -> usize {
    CHAINS * clusters
}

#[cfg(test)]
#[path = "passes_tests.rs"]
mod tests;
