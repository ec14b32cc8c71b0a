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
mod tests {
    use super::*;

    const ALL: [Order; 4] = [
        Order::Blocks,
        Order::Shuffle,
        Order::LatinSquare,
        Order::AsListed,
    ];

    fn of(order: Order, things: usize, repeats: u32, participant: u32) -> Vec<usize> {
        let mut random = RandomStream::new(7, &format!("order of {participant}"));
        ordered(order, (things, repeats), participant, &mut random)
    }

    #[test]
    fn each_thing_comes_as_often_as_stated() {
        for order in ALL {
            for (things, repeats) in [(1, 1), (1, 5), (2, 3), (5, 4), (8, 3)] {
                let order = of(order, things, repeats, 3);
                assert_eq!(order.len(), things * repeats as usize);
                for thing in 0..things {
                    let times = order.iter().filter(|t| **t == thing).count();
                    assert_eq!(times, repeats as usize, "{order:?}");
                }
            }
        }
    }

    #[test]
    fn in_blocks_each_comes_before_any_comes_again() {
        for order in [Order::Blocks, Order::LatinSquare, Order::AsListed] {
            for block in of(order, 6, 5, 2).chunks(6) {
                let mut sorted = block.to_vec();
                sorted.sort_unstable();
                assert_eq!(sorted, [0, 1, 2, 3, 4, 5]);
            }
        }
        let shuffled = of(Order::Shuffle, 6, 5, 2);
        let whole = |block: &[usize]| (0..6).all(|t| block.contains(&t));
        assert!(!shuffled.chunks(6).all(whole), "{shuffled:?}");
    }

    #[test]
    fn in_a_latin_square_each_follows_each_other_one_equally_often() {
        for things in 2..9 {
            let rows = if things % 2 == 0 { things } else { 2 * things };
            let mut follows = vec![0; things * things];
            for participant in 1..=rows as u32 {
                for pair in of(Order::LatinSquare, things, 1, participant).windows(2) {
                    follows[pair[0] * things + pair[1]] += 1;
                }
            }
            let times = rows / things;
            for (index, count) in follows.iter().enumerate() {
                let same = index / things == index % things;
                assert_eq!(*count, if same { 0 } else { times }, "{things}: {index}");
            }
        }
    }

    #[test]
    fn participants_have_orders_of_their_own() {
        for order in [Order::Blocks, Order::Shuffle, Order::LatinSquare] {
            assert_eq!(of(order, 8, 2, 1), of(order, 8, 2, 1));
            assert_ne!(of(order, 8, 2, 1), of(order, 8, 2, 2));
        }
    }
}
