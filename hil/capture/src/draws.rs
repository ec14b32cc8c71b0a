//! Draws for tests of dumps, and dumps with some bytes changed.

/// Draws that are the same in every run (xorshift).
pub(super) struct Draws(pub(super) u64);

impl Draws {
    pub(super) fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound.max(1) as u64) as usize
    }

    pub(super) fn one(&mut self, of: &[u8]) -> u8 {
        of[self.below(of.len())]
    }
}

/// Number of changed dumps; `ci/hostile` asks for more.
fn count() -> usize {
    let asked = std::env::var("PALPATE_MUTATIONS").ok();
    asked.and_then(|n| n.parse().ok()).unwrap_or(3000)
}

/// Reads dumps of which one to four bytes were changed, taken out or put in. `reads` tells whether it read a dump, or refused it
/// with a sentence. Some are read, and some are refused.
pub(super) fn mutate(
    seed: u64,
    dump: impl Fn(&mut Draws) -> Vec<u8>,
    mut reads: impl FnMut(&[u8]) -> bool,
) {
    let mut draw = Draws(seed);
    let mut good = dump(&mut draw);
    let (mut read_all, mut refused) = (0, 0);
    for n in 0..count() {
        if n % 100 == 0 {
            good = dump(&mut draw);
        }
        let mut bytes = good.clone();
        for _ in 0..=draw.below(3) {
            let at = draw.below(bytes.len());
            match draw.below(4) {
                0 => bytes[at] ^= 1 << draw.below(8),
                1 => bytes[at] = draw.one(&[0, 1, 0x7f, 0x80, 0xff]),
                2 => _ = bytes.remove(at),
                _ => bytes.insert(at, draw.one(&[0, 1, 0x80, 0xff])),
            }
        }
        match reads(&bytes) {
            true => read_all += 1,
            false => refused += 1,
        }
    }
    println!(
        "{read_all} of {} changed dumps read, {refused} refused",
        count()
    );
    assert!(
        read_all > 0 && refused > 0,
        "{read_all} read, {refused} refused"
    );
}
