//! Emulated users: two people, five trials each, whose skin touches every wire a little differently.

use palpate_core::units::Point;
use palpate_emulators::touching::Touching;
use palpate_records::felt::FeltOnset;

use crate::felt::Worn;

/// People.
pub const PEOPLE: u32 = 2;
/// Trials of each.
pub const TRIALS: u32 = 5;
/// Seed of their skin.
const SEED: u64 = 1;

/// One trial of one person.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Who.
    pub person: u32,
    /// What was felt.
    pub onsets: Vec<FeltOnset>,
}

/// All trials of a path.
pub fn trials(worn: &mut Worn, path: &[Point], wires: usize) -> Vec<Trial> {
    let mut all = Vec::new();
    for person in 0..PEOPLE {
        for trial in 0..TRIALS {
            let touching = Touching::new(SEED, person, trial, wires);
            all.push(Trial {
                person,
                onsets: worn.follow(path, |wire, seconds| touching.factor(wire, seconds)),
            });
        }
    }
    all
}
