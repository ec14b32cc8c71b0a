//! Tests of `pairs.rs`.

use palpate_records::mcap::proto::Message;

use super::*;

fn message(frame: u32, x_mm: f64) -> Vec<u8> {
    let mut message = Message::default();
    message
        .uint(1, frame)
        .uint(3, 7_u32)
        .double(4, x_mm)
        .double(6, 300.0)
        .uint(7, 1_u32);
    message.bytes().to_vec()
}

fn told(rows: &[(u64, u32, f64)]) -> Vec<Frame> {
    let messages: Vec<_> = rows
        .iter()
        .map(|(t, frame, x)| (*t, message(*frame, *x)))
        .collect();
    frames(messages.iter().map(|(t, data)| (*t, data.as_slice())))
}

#[test]
fn a_frame_of_the_wearer_has_time_and_number_of_the_robots_frame_that_says_the_same() {
    let robot = told(&[
        (10_000, 1, 0.1),
        (20_000, 2, 0.2),
        (30_000, 3, 0.3),
        (40_000, 4, 0.2),
    ]);
    // The second was lost, the clocks are 4 ms apart, and the last says what a frame before it said.
    let wearer = told(&[
        (14_000, 1, 0.1),
        (34_000, 2, 0.3),
        (44_000, 3, 0.2),
        (54_000, 4, 9.9),
    ]);
    let (paired, same) = paired(&robot, &wearer, 5000);
    let times: Vec<u64> = paired.iter().map(|frame| frame.t_us).collect();
    assert_eq!((times, same), (vec![10_000, 30_000, 40_000, 54_000], 3));
    let numbers: Vec<u32> = paired.iter().map(|f| f.contacts[0].frame).collect();
    assert_eq!(numbers, [1, 3, 4, 4]);
}

#[test]
fn what_is_no_contact_is_left_out() {
    let bytes = [0xff_u8, 0xff];
    assert!(frames([(1, &bytes[..])].into_iter()).is_empty());
}
