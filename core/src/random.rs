//! Seeded random streams: ChaCha8, one stream per (seed, identity).
//!
//! A stream belongs to a device, a taxel or an algorithm by its identity, so that a new device leaves
//! the numbers of all the others, and with them old goldens, alone.

use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};

/// A ChaCha8 stream for one identity under one seed.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of `identity` under `seed`. Identities are hashed from text such as `"taxel 3"`,
    /// so they need no central numbering.
    pub fn new(seed: u64, identity: &str) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(fnv1a(identity.as_bytes()));
        Self(rng)
    }

    /// The next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A standard normal deviate (Box & Muller 1958, the cosine branch), by `libm` so that it is the
    /// same on every machine.
    pub fn normal(&mut self) -> f64 {
        let u = 1.0 - self.uniform(); // in (0, 1]: the logarithm stays finite
        let angle = core::f64::consts::TAU * self.uniform();
        libm::sqrt(-2.0 * libm::log(u)) * libm::cos(angle)
    }
}

/// FNV-1a, 64 bit: names a stream, nothing cryptographic.
const fn fnv1a(bytes: &[u8]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0100_0000_01b3);
        i += 1;
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_reproducible_and_independent() {
        let draw = |seed, id: &str| Stream::new(seed, id).next_u64();
        assert_eq!(draw(1, "taxel 3"), draw(1, "taxel 3"));
        assert_ne!(draw(1, "taxel 3"), draw(1, "taxel 4"));
        assert_ne!(draw(1, "taxel 3"), draw(2, "taxel 3"));
    }

    #[test]
    fn normal_deviates_have_unit_variance() {
        let mut stream = Stream::new(7, "test");
        let n = 20_000;
        let (mut sum, mut sum2) = (0.0, 0.0);
        for _ in 0..n {
            let x = stream.normal();
            assert!(x.is_finite());
            sum += x;
            sum2 += x * x;
        }
        let mean = sum / f64::from(n);
        assert!(mean.abs() < 0.03, "{mean}");
        assert!((sum2 / f64::from(n) - 1.0).abs() < 0.05);
    }
}
