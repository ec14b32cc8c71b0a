//! Layout of accounts, as words of 64 bits, the lowest byte first. Figures are the bits of doubles.

use palpate_core::guard::{Doses, Spent, WireMemory};
use palpate_core::units::{Duration, Instant};

use super::uptime::Uptime;

/// Words of a wire.
const WORDS: usize = 68;
/// Word in place of an absent figure.
const ABSENT: u64 = u64::MAX;

/// Output of its hardware that a wire hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// The bus of a driver unit; zero on an adapter, which is one.
    pub bus: u8,
    /// The board's address.
    pub board: u8,
    /// Channel of the board.
    pub channel: u8,
}

impl Output {
    pub(super) fn word(&self) -> u64 {
        u64::from_be_bytes([0, 0, 0, 0, 0, self.bus, self.board, self.channel])
    }

    /// `None` for a word that no output has.
    pub(super) fn of_word(word: u64) -> Option<Self> {
        let [0, 0, 0, 0, 0, bus, board, channel] = word.to_be_bytes() else {
            return None;
        };
        Some(Self {
            bus,
            board,
            channel,
        })
    }
}

/// Heat and dose that are kept of a wire.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Kept {
    pub(super) output: Output,
    /// Time at which the other fields hold.
    pub(super) uptime: Uptime,
    pub(super) wire: WireMemory,
    /// Energy that the wire's fingertip has spent.
    pub(super) tip: Spent,
    pub(super) face_k: f64,
}

impl Kept {
    fn words(&self) -> Vec<u64> {
        let (output, wire) = (self.output, &self.wire);
        let place = output.word();
        let spent = |spent: &Spent| [spent.pj, spent.ago.as_micros()];
        let times = [self.uptime.us, wire.now.as_micros(), wire.at.as_micros()];
        let doses = [wire.doses.omega, wire.doses.cem43_min, self.face_k];
        let figures = wire.energy_j.iter().chain(&wire.bins_ks).chain(&doses);
        let words = [place, self.uptime.boot].into_iter().chain(times);
        words
            .chain(figures.map(|figure| figure.to_bits()))
            .chain([wire.most_c.map_or(ABSENT, f64::to_bits)])
            .chain(spent(&wire.power))
            .chain(spent(&self.tip))
            .collect()
    }

    /// `None` for words that no program has written.
    fn from_words(words: &[u64]) -> Option<Self> {
        let mut words = words.iter().copied();
        let mut word = || words.next().unwrap_or(ABSENT);
        let output = Output::of_word(word())?;
        let boot = word();
        let us = word();
        let [now, at] = [word(), word()].map(Instant::from_micros);
        let mut figure = || f64::from_bits(word());
        let energy_j = std::array::from_fn(|_| figure());
        let bins_ks = std::array::from_fn(|_| figure());
        let [omega, cem43_min, face_k] = [figure(), figure(), figure()];
        let most_c = Some(word()).filter(|bits| *bits != ABSENT);
        let mut spent = || Spent {
            pj: word(),
            ago: Duration::from_micros(word()),
        };
        let wire = WireMemory {
            now,
            at,
            energy_j,
            bins_ks,
            doses: Doses { omega, cem43_min },
            most_c: most_c.map(f64::from_bits),
            power: spent(),
        };
        let kept = Self {
            output,
            uptime: Uptime { boot, us },
            wire,
            tip: spent(),
            face_k,
        };
        let is_face = (0.0..=1e3).contains(&kept.face_k);
        (is_face && kept.wire.check().is_ok()).then_some(kept)
    }
}

/// Wires as bytes.
pub(super) fn of_wires(wires: &[Kept]) -> Vec<u8> {
    bytes(wires.iter().flat_map(Kept::words))
}

/// Bytes as wires; `None` for bytes that are none.
pub(super) fn wires(bytes: &[u8]) -> Option<Vec<Kept>> {
    let words = words(bytes)?;
    let wires = words.chunks_exact(WORDS);
    let is_whole = wires.remainder().is_empty();
    wires
        .map(Kept::from_words)
        .collect::<Option<_>>()
        .filter(|_| is_whole)
}

/// Doses as bytes.
pub(super) fn of_doses(doses: &Doses) -> Vec<u8> {
    bytes([doses.omega, doses.cem43_min].into_iter().map(f64::to_bits))
}

/// Bytes as doses; `None` for bytes that are none.
pub(super) fn doses(bytes: &[u8]) -> Option<Doses> {
    let &[omega, cem43_min] = &*words(bytes)? else {
        return None;
    };
    let [omega, cem43_min] = [omega, cem43_min].map(f64::from_bits);
    let is_dose = |dose: f64| (0.0..=1e6).contains(&dose);
    (is_dose(omega) && is_dose(cem43_min)).then_some(Doses { omega, cem43_min })
}

pub(super) fn bytes(words: impl Iterator<Item = u64>) -> Vec<u8> {
    words.flat_map(u64::to_le_bytes).collect()
}

pub(super) fn words(bytes: &[u8]) -> Option<Vec<u64>> {
    let (words, rest) = bytes.as_chunks::<8>();
    let words = words.iter().map(|word| u64::from_le_bytes(*word));
    rest.is_empty().then(|| words.collect())
}

#[cfg(test)]
#[path = "layout_tests.rs"]
mod tests;
