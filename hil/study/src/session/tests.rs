//! Sessions against a small reference: a list of trials made beforehand, walked through reply by reply.

use std::collections::BTreeMap;

use palpate_files::{Order, load_protocol};
use proptest::prelude::*;

use super::*;

fn protocol(name: &str) -> Protocol {
    load_protocol(name).unwrap().value
}

/// Every task at once, short.
fn mixed(order: Order, practice: u32, break_after: Option<u32>) -> Protocol {
    let mut whole = protocol("wearer");
    for (name, conditions) in [("felt-paths", 4), ("roughness", 2), ("illusions", 2)] {
        let other = protocol(name);
        assert_eq!(other.conditions.len(), conditions);
        whole.conditions.extend(other.conditions);
        whole.drawing = whole.drawing.or(other.drawing);
        whole.rating = whole.rating.or(other.rating);
        whole.choice = whole.choice.or(other.choice);
    }
    for trials in [
        &mut whole.absolute_threshold.as_mut().unwrap().trials,
        &mut whole.difference.as_mut().unwrap().trials,
        &mut whole.matching.as_mut().unwrap().trials,
        &mut whole.drawing.as_mut().unwrap().repeats,
        &mut whole.rating.as_mut().unwrap().repeats,
        &mut whole.choice.as_mut().unwrap().repeats,
    ] {
        *trials = 2;
    }
    (whole.order, whole.practice, whole.break_after) = (order, practice, break_after);
    whole
}

/// A reply that fits the step, by a number.
fn reply(step: &Step, n: u8) -> Option<Reply> {
    let sample = |t_ms: f64| Sample {
        t_ms,
        x_mm: f64::from(n) / 16.0,
        y_mm: -1.0,
    };
    Some(match step {
        Step::Consent => Reply::Consent(true),
        Step::Instructions | Step::Break => Reply::Read,
        Step::Question(_) => Reply::Chosen(usize::from(n % 2)),
        Step::Trial(_) if n >= 200 => Reply::Void("the tablet was lost".into()),
        Step::Trial(trial) => Reply::Answer(match &trial.ask {
            Ask::Interval(_) | Ask::Which(_) => Answer::Interval(1 + n % 2),
            Ask::Place => Answer::Place([f64::from(n), 0.0]),
            Ask::Path => Answer::Path(vec![vec![sample(0.0), sample(8.0)], vec![sample(90.0)]]),
            Ask::Ratings(scales) => Answer::Ratings(vec![1 + n % 6; scales.len()]),
        }),
        Step::Done | Step::Declined => return None,
    })
}

/// What the reference says that a session's trials are: how often each of what is played comes, levels aside.
fn expected(protocol: &Protocol, participant: u32) -> BTreeMap<String, u32> {
    let mut counts = BTreeMap::new();
    let mut add = |key: String, times: u32| *counts.entry(key).or_default() += times;
    for (task, wires, times) in [
        (
            "absolute_threshold",
            protocol
                .absolute_threshold
                .as_ref()
                .map(|t| (&t.wires, t.trials)),
        ),
        (
            "difference",
            protocol.difference.as_ref().map(|t| (&t.wires, t.trials)),
        ),
        (
            "matching",
            protocol.matching.as_ref().map(|t| (&t.wires, t.trials)),
        ),
        (
            "localisation",
            protocol
                .localisation
                .as_ref()
                .map(|t| (&t.wires, t.repeats)),
        ),
    ]
    .into_iter()
    .filter_map(|(task, given)| given.map(|(wires, times)| (task, wires, times)))
    {
        wires
            .iter()
            .for_each(|wire| add(format!("{task} {wire}"), times));
    }
    let drawing = protocol.drawing.as_ref().unwrap();
    drawing
        .conditions
        .iter()
        .for_each(|c| add(format!("drawing {c}"), drawing.repeats));
    let rating = protocol.rating.as_ref().unwrap();
    // Odd participants meet the first of a pair, even ones the second.
    let met = &rating.conditions[1 - participant as usize % 2];
    add(format!("rating {met}"), rating.repeats);
    let choice = protocol.choice.as_ref().unwrap();
    choice
        .pairs
        .iter()
        .for_each(|[a, b]| add(format!("choice {a} {b}"), choice.repeats));
    counts
}

/// What a trial plays, levels and order of intervals aside.
fn key(trial: &Trial) -> String {
    let mut played: Vec<String> = trial
        .intervals
        .iter()
        .filter_map(|stimulus| match stimulus {
            Stimulus::Silence => None,
            Stimulus::Wire { wire: 3, .. } if trial.task == TaskKind::Matching => None,
            Stimulus::Wire { wire, .. } => Some(wire.to_string()),
            Stimulus::Condition(name) => Some(name.clone()),
        })
        .collect();
    if trial.task == TaskKind::Choice {
        played.sort_unstable();
        played.reverse(); // "phantom" is the pair's first
    }
    played.dedup();
    format!("{} {}", trial.task.name(), played.join(" "))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_session_is_what_the_reference_says_and_goes_on_where_it_was_killed(
        order in prop::sample::select(vec![Order::Blocks, Order::Shuffle, Order::LatinSquare, Order::AsListed]),
        practice in 0u32..3,
        break_after in prop::option::of(1u32..9),
        participant in 1u32..40,
        seed in any::<u64>(),
        numbers in prop::collection::vec(any::<u8>(), 400),
        killed in 0usize..300,
    ) {
        let protocol = mixed(order, practice, break_after);
        let mut session = Session::new(protocol.clone(), participant, seed);
        let mut resumed = None;
        let (mut replies, mut counts, mut practised) = (Vec::new(), BTreeMap::new(), 0);
        let (mut voids, mut trials, mut since_break) = (0, 0, 0);
        for n in numbers.iter().cycle() {
            if replies.len() == killed {
                // A new program with the replies on record.
                let mut again = Session::new(protocol.clone(), participant, seed);
                replies.iter().for_each(|reply| again.take(reply).unwrap());
                prop_assert_eq!(again.step(), session.step());
                resumed = Some(again);
            }
            // Every fourth void one is too many for a list of 400 numbers that goes round.
            let Some(reply) = reply(session.step(), if voids > 20 { n % 200 } else { *n }) else {
                break;
            };
            if let Step::Break = session.step() {
                prop_assert_eq!(Some(since_break), break_after);
                since_break = 0;
            }
            if let Step::Trial(trial) = session.step() {
                prop_assert_eq!(trial.number, trials + 1);
                match (&reply, trial.practice) {
                    (Reply::Void(_), _) => voids += 1,
                    (_, true) => { practised += 1; trials += 1; since_break += 1; }
                    (_, false) => {
                        *counts.entry(key(trial)).or_insert(0) += 1;
                        trials += 1;
                        since_break += 1;
                    }
                }
            }
            let before = session.step().clone();
            session.take(&reply).unwrap();
            if let (Reply::Void(_), Step::Trial(one), Step::Trial(other)) = (&reply, &before, session.step()) {
                prop_assert_eq!(other.attempt, one.attempt + 1);
                prop_assert_eq!(&other.intervals, &one.intervals);
            }
            if let Some(resumed) = &mut resumed {
                resumed.take(&reply).unwrap();
                prop_assert_eq!(resumed.step(), session.step());
            }
            replies.push(reply);
        }
        prop_assert_eq!(session.step(), &Step::Done);
        prop_assert_eq!(counts, expected(&protocol, participant));
        prop_assert_eq!(practised, 7 * practice);
        prop_assert_eq!(session.progress(), (trials as usize, trials as usize));
        prop_assert!(session.take(&Reply::Read).is_err());
    }
}

#[test]
fn the_first_interval_is_the_right_one_as_often_as_the_second() {
    let mut session = Session::new(protocol("thresholds"), 3, 1);
    let mut first = 0;
    while let Step::Trial(trial) = session.step().clone() {
        first += u32::from(trial.right == Some(1));
        let silent = usize::from(trial.right == Some(1));
        assert_eq!(trial.intervals[silent], Stimulus::Silence);
        session.take(&Reply::Answer(Answer::Interval(1))).unwrap();
    }
    assert_eq!(first, 240);
}

#[test]
fn a_reply_to_something_else_changes_nothing() {
    let mut session = Session::new(protocol("wearer"), 1, 1);
    let begun = session.step().clone();
    assert_eq!(begun, Step::Consent);
    let said = session.take(&Reply::Read).unwrap_err().to_string();
    assert!(said.contains("whether the participant agrees"), "{said}");
    session.take(&Reply::Consent(true)).unwrap();
    assert!(session.take(&Reply::Chosen(2)).is_err());
    assert_eq!(session.step(), &Step::Question(0));
    session.take(&Reply::Chosen(1)).unwrap();
    session.take(&Reply::Read).unwrap();
    for wrong in [
        Answer::Interval(3),
        Answer::Place([0.0, 0.0]),
        Answer::Path(Vec::new()),
        Answer::Ratings(vec![1]),
    ] {
        assert!(session.take(&Reply::Answer(wrong)).is_err());
    }
}

#[test]
fn a_participant_who_does_not_agree_is_asked_nothing() {
    let mut session = Session::new(protocol("wearer"), 1, 1);
    session.take(&Reply::Consent(false)).unwrap();
    assert_eq!(session.step(), &Step::Declined);
    assert_eq!(session.progress().0, 0);
}

#[test]
fn drawings_are_checked_point_by_point() {
    let sample = |t_ms: f64, x_mm: f64| Sample {
        t_ms,
        x_mm,
        y_mm: 0.0,
    };
    let ok = |strokes: Vec<Vec<Sample>>| Ask::Path.check(&Answer::Path(strokes)).is_ok();
    assert!(ok(vec![vec![sample(0.0, 0.0), sample(8.3, 1.0)]]));
    assert!(!ok(vec![vec![sample(5.0, 0.0), sample(4.0, 1.0)]]));
    assert!(!ok(vec![vec![sample(0.0, f64::NAN)]]));
    assert!(!ok(vec![vec![sample(0.0, 900.0)]]));
    assert!(!ok(vec![vec![sample(f64::INFINITY, 0.0)]]));
    assert!(!ok(vec![vec![sample(0.0, 0.0)], Vec::new()]));
}

#[test]
fn the_strongest_of_a_session_is_all_of_it_at_full_drive() {
    let session = Session::new(protocol("thresholds"), 1, 1);
    let trials = session.strongest();
    assert_eq!(trials.len(), 480);
    let full = |s: &Stimulus| matches!(s, Stimulus::Wire { level_db, .. } if *level_db == 0.0);
    assert!(trials.iter().all(|t| t.intervals.iter().any(full)));
}
