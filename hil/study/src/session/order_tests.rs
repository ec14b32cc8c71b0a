//! Tests of `order.rs`.

use super::*;

const ALL: [Order; 4] = [
    Order::Blocks,
    Order::Shuffle,
    Order::LatinSquare,
    Order::AsListed,
];

fn shown(order: Order, things: usize, repeats: u32, participant: u32) -> Vec<usize> {
    let mut random = RandomStream::new(7, &format!("order of {participant}"));
    ordered(order, (things, repeats), participant, &mut random)
}

#[test]
fn each_thing_comes_as_often_as_stated() {
    for order in ALL {
        for (things, repeats) in [(1, 1), (1, 5), (2, 3), (5, 4), (8, 3)] {
            let order = shown(order, things, repeats, 3);
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
        for block in shown(order, 6, 5, 2).chunks(6) {
            let mut sorted = block.to_vec();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3, 4, 5]);
        }
    }
    let shuffled = shown(Order::Shuffle, 6, 5, 2);
    let whole = |block: &[usize]| (0..6).all(|t| block.contains(&t));
    assert!(!shuffled.chunks(6).all(whole), "{shuffled:?}");
}

#[test]
fn in_a_latin_square_each_follows_each_other_one_equally_often() {
    for things in 2..9 {
        let rows = if things % 2 == 0 { things } else { 2 * things };
        let mut follows = vec![0; things * things];
        for participant in 1..=rows as u32 {
            for pair in shown(Order::LatinSquare, things, 1, participant).windows(2) {
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
        assert_eq!(shown(order, 8, 2, 1), shown(order, 8, 2, 1));
        assert_ne!(shown(order, 8, 2, 1), shown(order, 8, 2, 2));
    }
}
