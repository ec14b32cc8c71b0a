//! Seeded random streams: ChaCha8, one stream per (seed, identity).
//!
//! A stream belongs to a device, a taxel or an algorithm by its identity, so that a new device leaves
//! the numbers of all the others, and with them old goldens, alone.

use chacha20::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// A ChaCha8 stream for one identity under one seed.
#[derive(Debug)]
pub struct RandomStream(ChaCha8Rng);

/// The generator has no copy of its own, so that keys are not multiplied by accident; ours guard no secret.
impl Clone for RandomStream {
    fn clone(&self) -> Self {
        let mut rng = ChaCha8Rng::from_seed(self.0.get_seed());
        rng.set_stream(self.0.get_stream());
        rng.set_word_pos(self.0.get_word_pos());
        Self(rng)
    }
}

impl RandomStream {
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
#[path = "random_tests.rs"]
mod tests;
