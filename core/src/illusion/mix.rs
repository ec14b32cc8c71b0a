//! Several contacts on one display: how they share its wires.

use alloc::boxed::Box;
use alloc::vec;

use crate::listed::listed;
use crate::units::{Duration, Point};

use super::law::Illusion;

listed! {
    /// Rules by which contacts share wires. Every rule keeps a wire within [0, 1] and the energy of all wires within
    /// the sum of what each contact alone would have.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Sharing: name {
        /// A wire follows the contact that asks most of it.
        #[default]
        Strongest = "strongest",
        /// A wire's energies add up, to full drive at most.
        Sum = "sum",
        /// Onset after onset, one contact after the other.
        Slices = "slices",
    }
}

/// A contact as the display sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Place on the display, mm.
    pub place: Point,
    /// Intensity weight g, in [0, 1].
    pub weight: f32,
}

/// An illusion, the rule for several contacts, and their memory.
#[derive(Debug)]
pub struct Mixer {
    illusion: Box<dyn Illusion>,
    sharing: Sharing,
    activation: Box<[f32]>,
    one: Box<[f32]>,
}

impl Mixer {
    /// Mixer for a display of this many wires; the last time it allocates.
    pub fn new(illusion: Box<dyn Illusion>, sharing: Sharing, wires: usize) -> Self {
        Self {
            illusion,
            sharing,
            activation: vec![0.0; wires].into(),
            one: vec![0.0; wires].into(),
        }
    }

    /// Targets that the onset with this number renders: all, or with time slices one.
    pub fn rendered<'t>(&self, targets: &'t [Target], onset: u64) -> &'t [Target] {
        if self.sharing != Sharing::Slices || targets.is_empty() {
            return targets;
        }
        let turn = (onset % targets.len() as u64) as usize;
        &targets[turn..=turn]
    }

    /// Writes the time for which every wire is on at the next onset: the law's, or `otherwise` where it has none.
    pub fn last(&self, out: &mut [Duration], otherwise: Duration) {
        for (wire, length) in out.iter_mut().enumerate() {
            *length = self.illusion.lasts(wire).unwrap_or(otherwise);
        }
    }

    /// Weighted activation of every wire, by its index, for contacts at once.
    pub fn activate(&mut self, targets: &[Target]) -> &[f32] {
        if let [only] = targets {
            self.illusion.activate(only.place, &mut self.activation);
            for a in &mut self.activation {
                *a *= only.weight;
            }
            return &self.activation;
        }
        self.activation.fill(0.0);
        for target in targets {
            self.illusion.activate(target.place, &mut self.one);
            for (a, one) in self.activation.iter_mut().zip(&self.one) {
                let mine = one * target.weight;
                *a = match self.sharing {
                    // Slices hand in one target; a rule for more of them is never asked for.
                    Sharing::Strongest | Sharing::Slices => a.max(mine),
                    Sharing::Sum => libm::sqrtf(*a * *a + mine * mine).min(1.0),
                };
            }
        }
        &self.activation
    }
}

#[cfg(test)]
#[path = "mix_tests.rs"]
mod tests;
