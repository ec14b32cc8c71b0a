//! Bare counts at the end of a line: one to five digits in each field and nothing else, as most rows of a recording have.

use memchr::memchr_iter;

use super::dialect::Dialect;
use super::number::Number;
use super::taken::Taken;

/// Most digits of a count.
const DIGITS: usize = 5;
const ZEROS: u64 = u64::from_le_bytes([b'0'; 8]);

/// Columns of counts that stand side by side at the end of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tail {
    separator: u8,
    /// Fields before the counts.
    before: usize,
    count: usize,
}

impl Tail {
    /// The tail that holds all columns taken; none where columns stand elsewhere or need more than reading.
    pub(super) fn new(dialect: Dialect, taken: &[Taken], width: usize) -> Option<Self> {
        let separator = dialect.separator.filter(|_| !dialect.decimal_comma)?;
        let before = taken.first()?.place;
        let is_next = |(n, column): (usize, &Taken)| {
            column.place == before + n && column.gain.is_none() && !column.is_opposite
        };
        let is_tail = before + taken.len() == width && taken.iter().enumerate().all(is_next);
        is_tail.then_some(Self {
            separator,
            before,
            count: taken.len(),
        })
    }

    /// Adds the counts of a line to `values`, and returns the text before them. None, and no values, where a field is
    /// anything but bare digits.
    pub(super) fn read<'l, V: Number>(self, line: &'l str, values: &mut Vec<V>) -> Option<&'l str> {
        let (bytes, mut begin, mut end) = (line.as_bytes(), 0, 0);
        if let Some(last) = self.before.checked_sub(1) {
            end = memchr_iter(self.separator, bytes).nth(last)?;
            begin = end + 1;
        }
        let before = line.get(..end).filter(|text| !text.contains('"'))?;
        let mut rest = bytes.get(begin..)?;
        for left in (0..self.count).rev() {
            let read = count(rest).and_then(|(digits, number)| match (left, rest.get(digits)) {
                (0, None) => Some((digits, number)),
                (1.., Some(byte)) if *byte == self.separator => Some((digits + 1, number)),
                _ => None,
            });
            let Some((used, number)) = read else {
                values.clear();
                return None;
            };
            values.push(V::of_count(number));
            rest = &rest[used..];
        }
        Some(before)
    }
}

/// The count that a text begins with, and how many digits it has.
fn count(text: &[u8]) -> Option<(usize, u16)> {
    let eight = match text.first_chunk::<8>() {
        Some(eight) => *eight,
        None => {
            let mut eight = [0; 8];
            eight[..text.len()].copy_from_slice(text);
            eight
        }
    };
    // Eight bytes as one number, the first byte lowest: digits become 0 to 9, all others leave their high half set. A
    // carry reaches only bytes behind the first that is no digit.
    let values = u64::from_le_bytes(eight) ^ ZEROS;
    let others = (values.wrapping_add(0x0606_0606_0606_0606) | values) & 0xF0F0_F0F0_F0F0_F0F0;
    let digits = others.trailing_zeros() as usize / 8;
    if !(1..=DIGITS).contains(&digits) {
        return None;
    }
    // Zeros in front make eight digits of them, which are joined to pairs, fours and the whole.
    let padded = values << (64 - 8 * digits);
    let pairs = padded.wrapping_mul(10).wrapping_add(padded >> 8) & 0x00FF_00FF_00FF_00FF;
    let fours = pairs.wrapping_mul(100).wrapping_add(pairs >> 16) & 0x0000_FFFF_0000_FFFF;
    let whole = fours.wrapping_mul(10_000).wrapping_add(fours >> 32) & 0xFFFF_FFFF;
    Some((digits, u16::try_from(whole).ok()?))
}

#[cfg(test)]
#[path = "bare_tests.rs"]
mod tests;
