//! Tests of `passes.rs`.

use super::*;
use crate::random::RandomStream;
use crate::vector::Vectors;

/// Point i in chain i mod 4, chains added in pairs: the order that results hang on.
#[test]
fn sums_have_one_order_for_any_number_of_points_and_width() {
    let mut r = RandomStream::new(8, "sums");
    for n in 0..150 {
        let k = 1 + n % 7;
        let mut values = |scale: f64| -> [f32; 150] {
            core::array::from_fn(|_| (scale * (r.uniform() - 0.3)) as f32)
        };
        let (x, y, w) = (values(50.0), values(1e6), values(1.0));
        let cluster = |i: usize| (i * i / 5) % k;
        let assigned: [u32; 150] = core::array::from_fn(|i| cluster(i) as u32);
        let mut chains = [[[0.0f64; 4]; CHAINS]; 7];
        for i in 0..n {
            let [x, y, w] = [x[i], y[i], w[i]].map(f64::from);
            let sum = &mut chains[cluster(i)][i % CHAINS];
            (sum[0], sum[1], sum[2], sum[3]) =
                (sum[0] + w, sum[1] + w * x, sum[2] + w * y, sum[3] + 1.0);
        }
        for vectors in [Vectors::plain(), Vectors::widest()] {
            let mut got = [[0.5; 4]; CHAINS * 7];
            let got = &mut got[..chained(k)];
            vectors.run(
                #[inline(always)]
                || sum(&x[..n], &y, &w, &assigned, got),
            );
            for (got, [a, b, c, d]) in got.iter().zip(&chains[..k]) {
                let want: Sum = core::array::from_fn(|i| (a[i] + b[i]) + (c[i] + d[i]));
                assert_eq!(got.map(f64::to_bits), want.map(f64::to_bits), "{n} points");
            }
        }
    }
}
