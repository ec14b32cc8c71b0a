//! Tests of `gate.rs`: each refusal, and who is felt.

use super::*;

const LAYOUT: u64 = 9;

fn at(us: u64) -> Instant {
    Instant::from_micros(us)
}

fn head(session: u64, sequence: u64, us: u64) -> Head {
    Head {
        version: 1,
        session,
        sequence,
        sent_us: us,
        taken_us: us,
        layout: LAYOUT,
    }
}

/// A gate that feels session 3, whose clock is ours.
fn gate() -> Gate {
    let mut gate = Gate::new(Patience::new(1, LAYOUT));
    assert_eq!(
        gate.judge(&head(3, 1, 1000), at(1000)),
        Err(Refusal::NoClock)
    );
    gate.echoed(3, at(2000), 2000, at(2000));
    assert!(gate.judge(&head(3, 2, 3000), at(3000)).is_ok());
    gate
}

#[test]
fn each_refusal_has_its_reason_and_is_counted() {
    let mut gate = gate();
    let with = |change: fn(&mut Head)| {
        let mut head = head(3, 3, 10_000);
        change(&mut head);
        head
    };
    let mut refused = |head: Head, now: u64| gate.judge(&head, at(now)).expect_err("refused");
    assert_eq!(
        refused(with(|h| h.version = 2), 10_000),
        Refusal::Version(2)
    );
    assert_eq!(refused(with(|h| h.layout = 8), 10_000), Refusal::Layout(8));
    assert_eq!(refused(with(|h| h.session = 4), 10_000), Refusal::Second(4));
    assert_eq!(
        refused(with(|h| h.taken_us = 10_001), 10_000),
        Refusal::Impossible
    );
    assert_eq!(refused(with(|h| h.sequence = 2), 10_000), Refusal::Order);
    assert_eq!(
        refused(with(|h| h.sequence = u64::MAX), 10_000),
        Refusal::Impossible
    );
    assert!(matches!(refused(with(|_| ()), 110_001), Refusal::Late(_)));
    let tally = *gate.tally();
    let counts = [
        tally.version,
        tally.layout,
        tally.second,
        tally.impossible,
        tally.order,
        tally.late,
    ];
    assert_eq!(counts, [1, 1, 1, 2, 1, 1]);
    assert_eq!((tally.felt, tally.no_clock), (1, 1));
}

#[test]
fn a_flood_of_the_publisher_itself_is_bounded() {
    let mut gate = gate();
    let felt =
        (0..10_000_u64).filter(|i| gate.judge(&head(3, 3 + i, 4000 + i), at(4000 + i)).is_ok());
    // A hundred at once, and ten in ten milliseconds.
    assert!((90..=111).contains(&felt.count()));
    assert!(gate.tally().rate > 9800);
}

#[test]
fn the_second_publisher_waits_for_the_first_ones_lease() {
    let mut gate = gate();
    assert_eq!(gate.feels(at(3000)), Some(3));
    assert_eq!(
        gate.judge(&head(4, 1, 500_000), at(500_000)),
        Err(Refusal::Second(4))
    );
    // The first is silent for more than a second.
    assert_eq!(gate.feels(at(1_003_001)), None);
    assert_eq!(
        gate.judge(&head(4, 2, 1_003_001), at(1_003_001)),
        Err(Refusal::NoClock)
    );
    gate.echoed(4, at(1_004_000), 1_004_000, at(1_004_000));
    assert!(gate.judge(&head(4, 3, 1_005_000), at(1_005_000)).is_ok());
    assert_eq!(gate.feels(at(1_005_000)), Some(4));
    // And now the first one is the second.
    assert_eq!(
        gate.judge(&head(3, 3, 1_006_000), at(1_006_000)),
        Err(Refusal::Second(3))
    );
}

#[test]
fn a_recording_of_frames_is_not_felt_again() {
    let mut gate = gate();
    let frames: Vec<Head> = (0..50)
        .map(|i| head(3, 3 + i, 10_000 + 10_000 * i))
        .collect();
    for frame in &frames {
        assert!(gate.judge(frame, at(frame.sent_us)).is_ok());
    }
    for frame in &frames {
        assert_eq!(gate.judge(frame, at(520_000)), Err(Refusal::Order));
    }
    // An hour later, when the publisher is long gone: its answers cannot be had from a recording.
    let hour = 3_600_000_000;
    gate.judge(&head(5, 1, 0), at(hour)).unwrap_err();
    for frame in &frames {
        assert!(
            gate.judge(frame, at(hour + 2_000_000 + frame.sent_us))
                .is_err()
        );
    }
}
