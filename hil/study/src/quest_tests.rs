//! Tests of `quest.rs`.

use serde::Deserialize;

use super::*;

#[derive(Deserialize)]
struct Session {
    levels: Vec<f64>,
    correct: Vec<bool>,
    thresholds: Vec<f64>,
}

#[derive(Deserialize)]
struct Vectors {
    quest: Vec<Session>,
}

/// From 0.5 dB to 0.5 dB, as `ci/peers/adaptive.py` has it.
fn domain() -> QuestDomain {
    QuestDomain {
        levels: (-40..=0).map(f64::from).collect(),
        thresholds: (-80..=0).map(|half| f64::from(half) / 2.0).collect(),
        slopes: vec![2.0, 3.5, 5.0],
        guess: 0.5,
        lapse: 0.02,
        part: 1.0 - (-1.0f64).exp(),
    }
}

#[test]
fn it_asks_what_questplus_asks_trial_by_trial() {
    let vectors: Vectors = serde_json::from_str(include_str!("adaptive.json")).unwrap();
    assert_eq!(vectors.quest.len(), 6);
    for (number, session) in vectors.quest.iter().enumerate() {
        let mut quest = Quest::new(domain());
        assert_eq!(session.levels.len(), 60);
        for (trial, level) in session.levels.iter().enumerate() {
            let asked = (quest.next(), trial);
            assert_eq!(asked, (*level, trial), "session {number}, trial {trial}");
            quest.answer(*level, session.correct[trial]);
            let (found, expected) = (quest.threshold(), session.thresholds[trial]);
            assert!(
                (found.value - expected).abs() < 1e-6,
                "session {number}, trial {trial}: {found:?}, questplus {expected}"
            );
            assert!(found.low < found.value && found.value < found.high);
        }
    }
}

#[test]
fn answers_that_cannot_be_leave_what_was_known() {
    let mut quest = Quest::new(QuestDomain {
        lapse: 0.0,
        guess: 0.0,
        ..domain()
    });
    // Not a number is at no level; the nearest is then the first.
    quest.answer(f64::NAN, true);
    quest.answer(1e300, false);
    let found = quest.threshold();
    assert!(
        found.value.is_finite() && found.low <= found.high,
        "{found:?}"
    );
}
