//! The guardian's decisions, one by one, in virtual time.

use super::*;

const MS: u64 = 1000;

fn at(us: u64) -> Now {
    Now {
        at: Instant::from_micros(us),
        asleep: Duration::ZERO,
    }
}

/// What was done, in order.
#[derive(Debug, Default)]
struct Notes {
    done: Vec<String>,
    line_fails: bool,
}

impl Notes {
    fn take(&mut self) -> Vec<String> {
        std::mem::take(&mut self.done)
    }
}

impl Post for Notes {
    fn cut(&mut self, cut: bool) -> bool {
        self.done.push(if cut { "cut" } else { "release" }.into());
        !self.line_fails
    }

    fn off(&mut self, bus: usize) {
        self.done.push(format!("off {bus}"));
    }

    fn kill(&mut self) {
        self.done.push("kill".into());
    }

    fn latch(&mut self, cause: &Cause, verified: bool) {
        self.done.push(format!("latch {verified}: {cause}"));
    }

    fn tell(&mut self, cause: &Cause, news: News) {
        self.done.push(format!("tell {news:?}: {cause}"));
    }

    fn answer(&mut self, answer: Answer, cause: Option<&Cause>) {
        let cause = cause.map_or_else(String::new, |cause| format!(": {cause}"));
        self.done.push(format!("answer {answer:?}{cause}"));
    }
}

/// A guardian of two buses whose run beats and has its outputs, at 10 ms.
fn awake() -> (Decider, Notes) {
    let mut decider = Decider::new(2, Duration::from_millis(30));
    let mut notes = Notes::default();
    decider.step(at(9 * MS), Event::Release, &mut notes);
    decider.step(at(10 * MS), Event::Beat, &mut notes);
    assert_eq!(notes.take(), ["release", "answer Beat"]);
    (decider, notes)
}

/// Both buses answer that they are off.
fn both_off(decider: &mut Decider, now: Now, notes: &mut Notes) {
    for bus in 0..2 {
        decider.step(now, Event::Swept { bus, off: true }, notes);
    }
}

#[test]
fn a_good_bye_cuts_sweeps_answers_and_ends_without_a_stop() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Bye, &mut notes);
    assert_eq!(notes.take(), ["cut", "off 0", "off 1"]);
    assert_eq!(decider.end(), None);
    both_off(&mut decider, at(12 * MS), &mut notes);
    assert_eq!(
        (notes.take(), decider.end()),
        (vec!["answer Off".to_owned()], Some(0))
    );
}

#[test]
fn a_run_that_waits_for_a_slow_bus_to_be_off_is_not_killed_for_its_silence() {
    for event in [Event::Bye, Event::Trip("the bus is slow")] {
        let (mut decider, mut notes) = awake();
        decider.step(at(11 * MS), event, &mut notes);
        for ms in (15..400).step_by(5) {
            decider.step(at(ms * MS), Event::Time, &mut notes);
        }
        assert!(!notes.take().contains(&"kill".to_owned()), "{event:?}");
        assert_eq!(decider.end(), None);
    }
}

#[test]
fn a_bus_that_fails_at_the_good_bye_is_a_stop_that_is_tried_on() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Bye, &mut notes);
    notes.take();
    decider.step(at(12 * MS), Event::Swept { bus: 1, off: false }, &mut notes);
    let cause = "at the end of the run not everything was known to be off";
    let done = notes.take();
    assert_eq!(done[..2], ["answer NotOff", "off 1"], "{done:?}");
    assert!(done.contains(&format!("latch false: {cause}")), "{done:?}");
    decider.step(at(13 * MS), Event::Swept { bus: 0, off: true }, &mut notes);
    decider.step(at(14 * MS), Event::Swept { bus: 0, off: true }, &mut notes);
    decider.step(at(15 * MS), Event::Swept { bus: 1, off: false }, &mut notes);
    assert_eq!(decider.next(), Instant::from_micros(25 * MS));
    decider.step(at(25 * MS), Event::Time, &mut notes);
    assert!(notes.take().contains(&"off 1".to_owned()));
    decider.step(at(26 * MS), Event::Swept { bus: 1, off: true }, &mut notes);
    let done = notes.take();
    assert!(done.contains(&format!("latch true: {cause}")), "{done:?}");
    assert_eq!(decider.end(), Some(4));
}

#[test]
fn silence_is_a_hang_at_the_heartbeat_and_not_before() {
    let (mut decider, mut notes) = awake();
    let mut now = 10 * MS;
    while notes.done.is_empty() {
        now = decider.next().as_micros();
        assert!(now <= 40 * MS + 10, "{now}");
        decider.step(at(now), Event::Time, &mut notes);
    }
    assert!(now > 40 * MS, "{now}");
    assert_eq!(
        notes.take(),
        [
            "cut",
            "off 0",
            "off 1",
            "latch false: the run hung: no heartbeat for 30 ms",
            "kill"
        ]
    );
}

#[test]
fn a_heartbeat_that_comes_with_a_late_look_counts() {
    let (mut decider, mut notes) = awake();
    for n in 1..=6 {
        decider.step(at((10 + 5 * n) * MS), Event::Time, &mut notes);
    }
    decider.step(at(41 * MS), Event::Beat, &mut notes);
    assert_eq!(notes.take(), ["answer Beat"]);
}

#[test]
fn time_in_which_the_guardian_did_not_run_is_not_held_against_the_run() {
    let (mut decider, mut notes) = awake();
    decider.step(at(105 * MS), Event::Time, &mut notes);
    assert_eq!(
        notes.take(),
        Vec::<String>::new(),
        "95 ms late, and nothing else"
    );
    decider.step(at(110 * MS), Event::Beat, &mut notes);
    assert_eq!(notes.take(), ["answer Beat"]);
}

#[test]
fn unseen_time_is_off_before_anything_else_and_the_run_is_told() {
    for slept in [false, true] {
        let (mut decider, mut notes) = awake();
        let now = match slept {
            true => Now {
                at: Instant::from_micros(12 * MS),
                asleep: Duration::from_millis(3000),
            },
            false => at(111 * MS),
        };
        decider.step(now, Event::Beat, &mut notes);
        let done = notes.take();
        assert_eq!(done[..3], ["cut", "off 0", "off 1"], "{done:?}");
        let words = if slept {
            "suspended for 3000 ms"
        } else {
            "stand still for 101 ms"
        };
        assert!(
            done[3].starts_with("latch false") && done[3].contains(words),
            "{done:?}"
        );
        assert!(done[4].starts_with("answer Halt: unseen time"), "{done:?}");
        // The run lives, and may not have noticed: its buses are asked again until it leaves.
        both_off(&mut decider, now, &mut notes);
        let later = Now {
            at: now.at + AGAIN,
            ..now
        };
        decider.step(later, Event::Time, &mut notes);
        assert!(notes.take().contains(&"off 0".to_owned()));
        // It has its records to end, and is not killed for a heartbeat that does not come.
        let ended = Now {
            at: later.at + Duration::from_millis(90),
            ..later
        };
        decider.step(ended, Event::Time, &mut notes);
        assert!(!notes.take().contains(&"kill".to_owned()));
        decider.step(ended, Event::Bye, &mut notes);
        let later = ended;
        both_off(&mut decider, later, &mut notes);
        both_off(&mut decider, later, &mut notes);
        let done = notes.take();
        assert!(
            done.iter().any(|text| text.starts_with("latch true")),
            "{done:?}"
        );
        assert_eq!(decider.end(), Some(0));
    }
}

#[test]
fn the_bounds_of_unseen_time_are_themselves_seen() {
    let (mut decider, mut notes) = awake();
    let asleep = ASLEEP;
    decider.step(
        Now {
            asleep,
            ..at(10 * MS + UNSEEN.as_micros())
        },
        Event::Beat,
        &mut notes,
    );
    assert_eq!(notes.take(), ["answer Beat"]);
    // Before the first heartbeat nothing is driven.
    let mut decider = Decider::new(2, Duration::from_millis(30));
    decider.step(at(0), Event::Time, &mut notes);
    decider.step(at(500 * MS), Event::Time, &mut notes);
    assert_eq!(notes.take(), Vec::<String>::new());
}

#[test]
fn a_stop_lets_the_run_live_releases_no_line_and_is_latched_as_off_once_it_is() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Stop("stale-input"), &mut notes);
    assert_eq!(
        notes.take(),
        ["cut", "off 0", "off 1", "latch false: stale-input"]
    );
    decider.step(at(11 * MS), Event::Release, &mut notes);
    both_off(&mut decider, at(12 * MS), &mut notes);
    assert_eq!(notes.take(), ["latch true: stale-input"]);
    decider.step(at(13 * MS), Event::Stop("another"), &mut notes);
    assert_eq!(notes.take(), ["off 0", "off 1"], "the first cause is kept");
    both_off(&mut decider, at(14 * MS), &mut notes);
    decider.step(at(15 * MS), Event::Bye, &mut notes);
    both_off(&mut decider, at(16 * MS), &mut notes);
    assert_eq!(decider.end(), Some(0));
}

#[test]
fn a_death_is_swept_again_once_the_run_is_gone() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Closed, &mut notes);
    let died = "the run died without a word";
    assert_eq!(
        notes.take(),
        [
            "cut".to_owned(),
            "off 0".into(),
            "off 1".into(),
            format!("latch false: {died}")
        ]
    );
    both_off(&mut decider, at(12 * MS), &mut notes);
    assert_eq!(decider.end(), None, "it may still have an order on its way");
    decider.step(at(13 * MS), Event::Gone, &mut notes);
    assert_eq!(notes.take()[1..], ["off 0", "off 1"]);
    both_off(&mut decider, at(14 * MS), &mut notes);
    assert_eq!(
        notes.take(),
        [format!("latch true: {died}"), "answer Off".into()]
    );
    assert_eq!(decider.end(), Some(4));
}

#[test]
fn one_that_does_not_go_is_killed_and_reported() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Closed, &mut notes);
    let kills = |notes: &mut Notes| {
        let done = notes.take();
        let count = |word: &str| done.iter().filter(|text| text.starts_with(word)).count();
        (count("kill"), count("tell Stays"))
    };
    assert_eq!(kills(&mut notes), (0, 0));
    for (ms, expected) in [(510, (0, 0)), (511, (1, 0)), (1011, (1, 1)), (1511, (1, 0))] {
        decider.step(at(ms * MS), Event::Time, &mut notes);
        assert_eq!(kills(&mut notes), expected, "{ms}");
    }
}

#[test]
fn one_that_is_asked_to_end_ends_the_run_at_once() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Ended, &mut notes);
    let done = notes.take();
    assert_eq!(done[..3], ["cut", "off 0", "off 1"]);
    assert_eq!(done.last().unwrap(), "kill");
    // After a trip as well, and it goes on trying.
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Trip("no"), &mut notes);
    decider.step(at(12 * MS), Event::Ended, &mut notes);
    decider.step(at(13 * MS), Event::Swept { bus: 0, off: false }, &mut notes);
    assert_eq!(decider.end(), None);
}

#[test]
fn a_trip_is_answered_once_everything_is_off_whether_or_not_the_run_is_gone() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Trip("the bus is dead"), &mut notes);
    decider.step(at(12 * MS), Event::Gone, &mut notes);
    notes.take();
    both_off(&mut decider, at(13 * MS), &mut notes);
    let done = notes.take();
    assert!(
        done[0].starts_with("tell Off") && done[0].ends_with("the bus is dead"),
        "{done:?}"
    );
    assert_eq!(done[1..], ["latch true: the bus is dead", "answer Off"]);
    assert_eq!(decider.end(), Some(4));
}

#[test]
fn a_line_that_cannot_cut_is_a_stop_and_one_that_cannot_release_is_none() {
    let (mut decider, mut notes) = awake();
    notes.line_fails = true;
    decider.step(at(11 * MS), Event::Release, &mut notes);
    assert_eq!(notes.take(), ["release"]);
    decider.step(at(11 * MS), Event::Cut, &mut notes);
    let done = notes.take();
    assert_eq!(
        done[..4],
        [
            "cut",
            "off 0",
            "off 1",
            "latch false: the OE line cannot be set"
        ]
    );
    assert!(done[4].starts_with("answer Halt"), "{done:?}");
}

#[test]
fn noise_and_a_part_that_is_stopped() {
    let (mut decider, mut notes) = awake();
    decider.step(at(11 * MS), Event::Latch("index: stale-input"), &mut notes);
    assert_eq!(
        notes.take(),
        ["latch false: index: stale-input"],
        "nothing is switched"
    );
    decider.step(at(12 * MS), Event::Noise, &mut notes);
    assert!(notes.take().contains(&"off 0".to_owned()));
}
