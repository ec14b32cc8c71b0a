//! Orders of conditions: another for each participant, always the same for one.

use palpate_core::random::RandomStream;
use palpate_files::Order;

/// Order of so many things, each `repeats` times, for a participant.
pub(crate) fn ordered(
    order: Order,
    (things, repeats): (usize, u32),
    participant: u32,
    random: &mut RandomStream,
) -> Vec<usize> {
    let once: Vec<usize> = (0..things).collect();
    let rounds = 0..repeats;
    match order {
        Order::AsListed => rounds.flat_map(|_| once.clone()).collect(),
        Order::Blocks => rounds
            .flat_map(|_| {
                let mut block = once.clone();
                shuffle(&mut block, random);
                block
            })
            .collect(),
        Order::Shuffle => {
            let mut all: Vec<usize> = rounds.flat_map(|_| once.clone()).collect();
            shuffle(&mut all, random);
            all
        }
        Order::LatinSquare => {
            let rows = if things.is_multiple_of(2) {
                things
            } else {
                2 * things
            };
            let first = participant.saturating_sub(1) as usize * repeats as usize;
            rounds
                .flat_map(|round| row(things, (first + round as usize) % rows.max(1)))
                .collect()
        }
    }
}

/// A row of Williams' square: over all rows each thing follows each other one equally often. An odd number of things needs
/// every row backwards as well.
fn row(things: usize, number: usize) -> Vec<usize> {
    let zigzag = (0..things).map(|k| match k {
        0 => 0,
        k if k % 2 == 1 => k.div_ceil(2),
        k => things - k / 2,
    });
    let mut row: Vec<usize> = zigzag.map(|k| (k + number) % things).collect();
    if number >= things {
        row.reverse();
    }
    row
}

/// Shuffles things (Fisher and Yates).
pub(crate) fn shuffle<T>(things: &mut [T], random: &mut RandomStream) {
    for last in (1..things.len()).rev() {
        let chosen = (random.uniform() * (last + 1) as f64) as usize;
        things.swap(last, chosen.min(last));
    }
}

#[cfg(test)]
#[path = "order_tests.rs"]
mod tests;
