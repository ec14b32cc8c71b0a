//! What a finger did a while ago, in few bytes: differences from sample to sample, each in as many bytes as it has digits.
//!
//! A sample has 40 bytes, its difference from the one before about eight. An hour of a finger is 2 MB so.

use palpate_files::HandSample;

/// Samples that lie in one piece.
const PIECE: usize = 512;

/// Samples of the past, in pieces that are never touched again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Packed(Vec<Box<[u8]>>);

impl Packed {
    /// Takes the oldest of `samples`, in whole pieces: those before `until_us`, but for the last of them, which still holds
    /// then.
    pub(crate) fn take(&mut self, samples: &mut Vec<HandSample>, until_us: i64) {
        while samples.get(PIECE).is_some_and(|next| next[0] <= until_us) {
            let mut bytes = Vec::with_capacity(PIECE * 10);
            let mut before = [0; 5];
            for sample in samples.drain(..PIECE) {
                for (value, before) in sample.iter().zip(before) {
                    put(&mut bytes, value - before);
                }
                before = sample;
            }
            self.0.push(bytes.into_boxed_slice());
        }
    }

    /// All of them, oldest first.
    pub(crate) fn samples(&self) -> impl Iterator<Item = HandSample> {
        self.0.iter().flat_map(|piece| {
            let (mut rest, mut sample) = (&**piece, [0; 5]);
            std::iter::from_fn(move || {
                for value in &mut sample {
                    *value += next(&mut rest)?;
                }
                Some(sample)
            })
        })
    }
}

/// Seven bits per byte, lowest first; the sign is the lowest bit of all.
fn put(bytes: &mut Vec<u8>, value: i64) {
    let mut rest = (value << 1 ^ value >> 63) as u64;
    while rest >= 0x80 {
        bytes.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    bytes.push(rest as u8);
}

fn next(bytes: &mut &[u8]) -> Option<i64> {
    let end = bytes.iter().position(|byte| byte & 0x80 == 0)?;
    let (own, rest) = bytes.split_at(end + 1);
    *bytes = rest;
    let own = own.iter().rev();
    let value = own.fold(0, |value, byte| value << 7 | u64::from(byte & 0x7f));
    Some((value >> 1) as i64 ^ -((value & 1) as i64))
}

#[cfg(test)]
#[path = "packed_tests.rs"]
mod tests;
