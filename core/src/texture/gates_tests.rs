//! Tests of `gates.rs`.

use super::*;
use crate::vector::Vectors;
use alloc::vec::Vec;
use pulp::WithSimd;

struct Both<'a>(&'a mut [f32], &'a mut [f32]);
impl WithSimd for Both<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for v in S::as_mut_simd_f32s(self.0).0 {
            *v = tanh(simd, *v);
        }
        for v in S::as_mut_simd_f32s(self.1).0 {
            *v = logistic(simd, *v);
        }
    }
}

#[test]
fn functions_keep_their_stated_errors_and_are_the_same_bits_in_every_width() {
    let mut arguments: Vec<f32> = (-400_000..400_000).map(|i| i as f32 * 5e-5).collect();
    arguments.extend((0..128).flat_map(|e| {
        let v = libm::scalbnf(1.0, e - 100);
        [v, -v]
    }));
    arguments.extend([0.0, -0.0, 1e-40, -1e-40, 1e30, -1e30, f32::MAX, f32::MIN]);
    arguments.resize(arguments.len().next_multiple_of(16), 1.0); // whole vectors of any width
    let [(t, s), (middle_t, middle_s), (plain_t, plain_s)] =
        [Vectors::widest(), Vectors::of_256_bits(), Vectors::plain()].map(|vectors| {
            let (mut t, mut s) = (arguments.clone(), arguments.clone());
            vectors.dispatch_widest(Both(&mut t, &mut s));
            (t, s)
        });
    for (i, &x) in arguments.iter().enumerate() {
        assert_eq!(t[i].to_bits(), plain_t[i].to_bits(), "tanh {x}");
        assert_eq!(s[i].to_bits(), plain_s[i].to_bits(), "logistic {x}");
        assert_eq!(t[i].to_bits(), middle_t[i].to_bits(), "tanh {x}");
        assert_eq!(s[i].to_bits(), middle_s[i].to_bits(), "logistic {x}");
        let x = f64::from(x);
        let (tanh, logistic) = (libm::tanh(x), 1.0 / (1.0 + libm::exp(-x)));
        assert!(
            (f64::from(t[i]) - tanh).abs() <= 4e-7 * tanh.abs().max(1e-30),
            "{x}"
        );
        assert!((f64::from(s[i]) - logistic).abs() <= 2e-7, "{x}");
        assert!(t[i].abs() <= 1.0 && (0.0..=1.0).contains(&s[i]), "{x}");
    }
}
