//! Clocks that are set amid a recording, and columns of other units.

use super::*;

fn all(times: &mut Times, us: &[u64]) -> Result<Vec<u64>, OutOfTime> {
    us.iter().map(|us| times.row("f", *us)).collect()
}

/// A Pi writes 1970 until its time server answers.
const PI: [u64; 5] = [
    5_000_000,
    5_025_000,
    1_700_000_000_000_000,
    1_700_000_000_025_000,
    1_700_000_000_050_000,
];

#[test]
fn a_jump_is_refused_or_taken_out() {
    let refused = all(&mut Times::new(false), &PI).unwrap_err();
    assert!(refused.expected.contains("--split-jumps"), "{refused:?}");
    assert_eq!(
        refused.found.unwrap(),
        "a jump of the clock, 53.9 years ahead"
    );
    let mut times = Times::new(true);
    let split = all(&mut times, &PI).unwrap();
    assert_eq!(
        split,
        [5_000_000, 5_025_000, 5_050_000, 5_075_000, 5_100_000]
    );
    assert_eq!(
        times.take_notes(),
        [
            "f: a jump of the clock, 53.9 years ahead taken out: a new piece, joined at 0.050 s of the run"
        ]
    );
    let split = all(&mut Times::new(true), &[PI[2], PI[0]]).unwrap();
    assert_eq!(split, [PI[2], PI[2] + 1]);
}

/// One frame of a stray stamp: what follows goes on at the usual distance, and the run is no longer for it.
#[test]
fn a_stray_hop_is_taken_out_and_not_doubled() {
    let mut times = Times::new(true);
    let us = |k: u64| k * 10_000 + if k == 50 { 6_200_000 } else { 0 };
    let played: Vec<u64> = (0..100).map(|k| times.frame("f", us(k)).unwrap()).collect();
    assert_eq!(played.last(), Some(&990_000));
    assert_eq!(times.take_notes().len(), 2);
    // Without being asked to, a silence is a silence.
    let mut times = Times::new(false);
    assert_eq!(times.frame("f", 0), Ok(0));
    assert_eq!(times.frame("f", 6_200_000), Ok(6_200_000));
}

#[test]
fn rows_rise_and_frames_may_be_a_little_out_of_order() {
    let rows = all(&mut Times::new(false), &[5, 5]).unwrap_err();
    assert_eq!(rows.expected, "more than the row before, 5");
    let mut times = Times::new(false);
    for (us, result) in [(2_000_000, true), (1_500_000, true), (900_000, false)] {
        assert_eq!(times.frame("f", us).is_ok(), result, "{us}");
    }
}

#[test]
fn rows_share_an_instant_of_a_coarse_clock_and_no_more() {
    let mut times = Times::new(false);
    assert!((0..100).all(|k| times.coarse_row("f", k / 4 * 1000).is_ok()));
    let mut times = Times::new(false);
    let all: Result<Vec<_>, _> = (0..100).map(|_| times.coarse_row("f", 1_000_000)).collect();
    let found = all.unwrap_err().found.unwrap();
    assert_eq!(found, "11 rows of one instant, 1000000 us");
}

#[test]
fn a_recording_has_at_most_a_day() {
    let hours: Vec<u64> = (0..26).map(|h| h * 3_600_000_000).collect();
    assert_eq!(all(&mut Times::new(false), &hours[..25]).unwrap().len(), 25);
    assert!(all(&mut Times::new(false), &hours).is_err());
}

#[test]
fn other_units_look_like_what_they_are() {
    for (step, word) in [
        (1, Some("row numbers")),
        (7, Some("milliseconds")),
        (100, None),
        (
            25_000_000,
            Some("nanoseconds: they would be rows every 25.000 s"),
        ),
        (25_000, None),
        (500, None),
    ] {
        let mut times = Times::new(false);
        let rows: Vec<u64> = (0..20).map(|n| 7 + n * step).collect();
        all(&mut times, &rows).unwrap();
        let looks = times.looks_like();
        let fits = word.map_or(looks.is_none(), |w| {
            looks.as_ref().is_some_and(|l| l.starts_with(w))
        });
        assert!(fits, "{step}: {looks:?}");
    }
}

#[test]
fn a_column_has_a_unit() {
    let column: TimeColumn = "timestamp:ms".parse().unwrap();
    assert_eq!(
        (column.name.as_str(), column.unit),
        ("timestamp", TimeUnit::Ms)
    );
    assert_eq!(column.unit.micros("4027818"), Some(4_027_818_000));
    assert_eq!(
        TimeUnit::S.micros("1436509052.249713"),
        Some(1_436_509_052_249_713)
    );
    assert_eq!(TimeUnit::Ns.micros("25999"), Some(25));
    for bad in ["-1", "nan", "inf", "1e30", ""] {
        assert_eq!(TimeUnit::S.micros(bad), None, "{bad}");
    }
    assert!("t:min".parse::<TimeColumn>().is_err());
    assert!(":ms".parse::<TimeColumn>().is_err());
    assert_eq!("t".parse::<TimeColumn>().unwrap().unit, TimeUnit::Us);
}
