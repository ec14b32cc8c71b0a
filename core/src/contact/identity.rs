//! Matching of the contacts of this frame to those of the last.
//!
//! Rule: a contact at the very place of an old one is that one. Then, again and again, the closest pair of an old
//! and a new contact still free is one contact; of equal distances the lowest old, then the lowest new index.
//! New contacts left over are born with a number never used before; old ones left over are gone.

use alloc::vec::Vec;

/// Memory to match up to a given number of contacts.
#[derive(Clone, Debug)]
pub(super) struct Matcher {
    /// Nearest free new contact of every old one: squared distance and index; `None` once the old one is taken.
    nearest: Vec<Option<(f32, usize)>>,
    taken: Vec<bool>,
}

/// Identity of a contact not yet named.
const UNNAMED: u32 = 0;

impl Matcher {
    /// Room for `most` contacts on either side.
    pub fn new(most: usize) -> Self {
        Self {
            nearest: Vec::with_capacity(most),
            taken: Vec::with_capacity(most),
        }
    }

    /// Fills `ids` for so many `new` contacts (cleared first). `distance2` has the squared distance of an old and a new one;
    /// `next` is the next number to give away, which starts at 1.
    pub fn match_up(
        &mut self,
        old_ids: &[u32],
        new: usize,
        distance2: &dyn Fn(usize, usize) -> f32,
        ids: &mut Vec<u32>,
        next: &mut u32,
    ) {
        ids.clear();
        ids.resize(new, UNNAMED);
        self.taken.clear();
        self.taken.resize(new, false);
        self.nearest.clear();
        for (o, id) in old_ids.iter().enumerate() {
            let found = self.closest(&|n| distance2(o, n));
            // An old contact that has not moved is settled at once.
            if let Some((d, n)) = found
                && d <= 0.0
            {
                ids[n] = *id;
                self.taken[n] = true;
                self.nearest.push(None);
            } else {
                self.nearest.push(found);
            }
        }
        loop {
            let mut best: Option<(f32, usize, usize)> = None;
            for o in 0..self.nearest.len() {
                let Some((_, n)) = self.nearest[o] else {
                    continue;
                };
                if self.taken[n] {
                    self.nearest[o] = self.closest(&|n| distance2(o, n));
                }
                if let Some((d, n)) = self.nearest[o]
                    && best.is_none_or(|b| d < b.0)
                {
                    best = Some((d, o, n));
                }
            }
            let Some((_, o, n)) = best else {
                break;
            };
            ids[n] = old_ids[o];
            self.taken[n] = true;
            self.nearest[o] = None;
        }
        for id in ids.iter_mut().filter(|id| **id == UNNAMED) {
            *id = born(next);
        }
    }

    fn closest(&self, distance2: &dyn Fn(usize) -> f32) -> Option<(f32, usize)> {
        let mut best: Option<(f32, usize)> = None;
        for n in (0..self.taken.len()).filter(|n| !self.taken[*n]) {
            let d = distance2(n);
            if best.is_none_or(|b| d < b.0) {
                best = Some((d, n));
            }
        }
        best
    }
}

/// A number never given before (within 2^32 births; then they start over at 1).
pub(super) fn born(next: &mut u32) -> u32 {
    let id = (*next).max(1);
    *next = id.wrapping_add(1);
    id
}

#[cfg(test)]
#[path = "identity_tests.rs"]
mod tests;
