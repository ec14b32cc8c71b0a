//! Tests of `skeleton.rs`.

use super::*;

#[test]
fn a_right_hand_has_its_thumb_on_the_right_and_a_left_one_on_the_left() {
    let names = ["index", "middle", "ring", "thumb"];
    let [right] = hands(&names, &[0.0; 4]).try_into().unwrap();
    let order: Vec<usize> = right.digits.iter().map(|d| d.finger).collect();
    assert_eq!(order, [2, 1, 0, 3]);
    let tips: Vec<f64> = right
        .digits
        .iter()
        .map(|d| d.at((0.0, d.length)).0)
        .collect();
    assert!(tips.is_sorted(), "{tips:?}");

    let names = ["left-thumb", "left-index", "right-thumb", "right-index"];
    let both = hands(&names, &[0.0; 4]);
    let order = |hand: &Hand| hand.digits.iter().map(|d| d.finger).collect::<Vec<_>>();
    assert_eq!(
        both.iter().map(|h| h.name).collect::<Vec<_>>(),
        ["left", "right"]
    );
    assert_eq!([order(&both[0]), order(&both[1])], [[0, 1], [3, 2]]);
    let thumb = both[0].digits[0];
    assert!(thumb.at((0.0, thumb.length)).0 < both[0].palm[0]);
}

#[test]
fn fingers_that_no_hand_has_stand_in_their_own_order() {
    let [hand] = hands(&["b", "thumb", "a"], &[0.0, 150.0, 0.0])
        .try_into()
        .unwrap();
    let order: Vec<usize> = hand.digits.iter().map(|d| d.finger).collect();
    assert_eq!(order, [0, 1, 2]);
    assert!((hand.digits[1].length - 150.0).abs() < 1e-9);
    assert!(hands(&[], &[]).is_empty());
}
