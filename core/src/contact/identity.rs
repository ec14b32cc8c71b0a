//! Who is who from frame to frame.

use alloc::boxed::Box;
use alloc::vec;

/// Identities of the contacts of the last frame, with their places.
///
/// While the number of contacts stays and they come from a warm start, the cluster index is the identity
/// and nothing is matched. Otherwise old and new contacts are paired, nearest pair first; what is left
/// over is born with a number never used before, or dies.
#[derive(Clone, Debug)]
pub(super) struct Identities {
    ids: Box<[u32]>,
    x: Box<[f32]>,
    y: Box<[f32]>,
    count: usize,
    next: u32,
    new_ids: Box<[u32]>,
    taken: Box<[bool]>,
}

impl Identities {
    pub(super) fn new(most: usize) -> Self {
        Self {
            ids: vec![0; most].into(),
            x: vec![0.0; most].into(),
            y: vec![0.0; most].into(),
            count: 0,
            next: 0,
            new_ids: vec![0; most].into(),
            taken: vec![false; most].into(),
        }
    }

    /// Contacts of the last frame.
    pub(super) const fn count(&self) -> usize {
        self.count
    }

    /// Places of the last frame, by cluster index.
    pub(super) fn places(&self) -> (&[f32], &[f32]) {
        (&self.x[..self.count], &self.y[..self.count])
    }

    /// The identity of contact `i` of the newest frame.
    pub(super) fn id(&self, i: usize) -> u32 {
        self.ids.get(i).copied().unwrap_or(u32::MAX)
    }

    /// Nothing is touched any more: what comes next is new.
    pub(super) const fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes the places of a frame. `continued` says that index i is the contact that index i was.
    pub(super) fn follow(&mut self, x: &[f32], y: &[f32], continued: bool) {
        let n = x.len().min(self.ids.len());
        if !(continued && n == self.count) {
            self.pair(&x[..n], &y[..n]);
        }
        self.x[..n].copy_from_slice(&x[..n]);
        self.y[..n].copy_from_slice(&y[..n]);
        self.count = n;
    }

    fn pair(&mut self, x: &[f32], y: &[f32]) {
        const FREE: u32 = u32::MAX;
        let n = x.len();
        self.new_ids[..n].fill(FREE);
        self.taken[..self.count].fill(false);
        for _ in 0..n.min(self.count) {
            // The nearest free pair; the lowest new, then old, index among equals.
            let mut best: Option<(f32, usize, usize)> = None;
            for new in (0..n).filter(|&i| self.new_ids[i] == FREE) {
                for old in (0..self.count).filter(|&j| !self.taken[j]) {
                    let (dx, dy) = (x[new] - self.x[old], y[new] - self.y[old]);
                    let d = dx * dx + dy * dy;
                    if best.is_none_or(|(least, ..)| d < least) {
                        best = Some((d, new, old));
                    }
                }
            }
            let Some((_, new, old)) = best else { break };
            self.new_ids[new] = self.ids[old];
            self.taken[old] = true;
        }
        for id in &mut self.new_ids[..n] {
            if *id == FREE {
                *id = self.next;
                // After four billion contacts numbers stop being new rather than wrap to living ones.
                self.next = self.next.saturating_add(1).min(FREE - 1);
            }
        }
        self.ids[..n].copy_from_slice(&self.new_ids[..n]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn ids(identities: &Identities) -> Vec<u32> {
        (0..identities.count()).map(|i| identities.id(i)).collect()
    }

    #[test]
    fn births_deaths_merges_and_splits_keep_the_others() {
        let mut who = Identities::new(4);
        who.follow(&[0.0, 10.0], &[0.0, 0.0], true);
        assert_eq!(ids(&who), [0, 1]);
        // A third appears between; order of clusters changes.
        who.follow(&[10.0, 5.0, 0.5], &[0.0, 0.0, 0.0], false);
        assert_eq!(ids(&who), [1, 2, 0]);
        // Two merge near the first: the nearer one keeps its name.
        who.follow(&[9.0, 1.0], &[0.0, 0.0], false);
        assert_eq!(ids(&who), [1, 0]);
        // A split: one keeps the name, the other is new.
        who.follow(&[9.0, 1.0, 2.0], &[0.0, 0.0, 0.0], false);
        assert_eq!(ids(&who), [1, 0, 3]);
        // All lost: nobody comes back.
        who.clear();
        who.follow(&[9.0], &[0.0], true);
        assert_eq!(ids(&who), [4]);
    }
}
