//! Tests of `playback.rs`.

use super::*;
use crate::synthetic;
use palpate_core::skin::{Axes, Layout, Module, RelativeFrame};

#[test]
fn runs_of_zeros_are_counted_and_no_letter_needs_an_escape() {
    let mut out = String::new();
    let frame: Vec<Reading> = (0..=61).map(|n| [0, 0, 0, n * 10]).collect();
    letters(&mut out, &frame, 610);
    assert!(out.starts_with("1BC") && out.ends_with("}~."), "{out}");
    assert!(!out.contains(['\\', '"', '<']), "{out}");
    out.clear();
    letters(&mut out, &[[9, 9, 9, 0]; 24], 610);
    assert_eq!(out, ".", "zeros at the end need not be told");
}

#[test]
fn ten_minutes_of_a_wild_skin_stay_within_their_bytes() {
    let layout = Layout::single(Module::grid("pad", 10, 10, 4.7).unwrap()).unwrap();
    let mut frame = RelativeFrame::new(&layout);
    let mut readings = Readings::whole(&layout, 0);
    for n in 0..60_000_u64 {
        let counts = (0..100).map(|i| [0.0, 0.0, ((n + i) * 7919 % 9973) as f32]);
        frame
            .load(&counts.collect::<Vec<_>>(), Axes::Z, 5.0)
            .unwrap();
        readings.push(n * 10_000, &frame);
    }
    let block = taxels(&readings);
    assert!(
        (100_000..BYTES + 20_000).contains(&block.len()),
        "{}",
        block.len()
    );
    let mut page = String::new();
    let trace = synthetic::circle(600);
    let pad = Plot {
        left: 0.0,
        top: 0.0,
        width: 1.0,
        height: 1.0,
        x: crate::report::scale::Scale::exact(0.0, 1.0),
        y: crate::report::scale::Scale::exact(0.0, 1.0),
    };
    data(&mut page, &trace, Some(&readings), [&pad, &pad]);
    assert!(page.len() < 600_000, "{}", page.len());
    let numbers = page
        .split_once('>')
        .unwrap()
        .1
        .split("</script")
        .next()
        .unwrap();
    let value: serde_json::Value = serde_json::from_str(numbers).unwrap();
    assert_eq!(value["contacts"].as_array().unwrap().len() % 6, 0);
}
