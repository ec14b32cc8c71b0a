//! Tests of `staircase.rs`.

use serde::Deserialize;

use super::*;

#[derive(Deserialize)]
struct Session {
    levels: Vec<f64>,
    correct: Vec<bool>,
    turns: Vec<f64>,
}

#[derive(Deserialize)]
struct Vectors {
    staircase: Vec<Session>,
}

#[test]
fn it_asks_what_psychopy_asks_trial_by_trial() {
    let vectors: Vectors = serde_json::from_str(include_str!("adaptive.json")).unwrap();
    assert_eq!(vectors.staircase.len(), 20);
    for (number, session) in vectors.staircase.iter().enumerate() {
        let mut staircase = Staircase::new((-40.0, 0.0));
        for (trial, level) in session.levels.iter().enumerate() {
            let asked = (staircase.next(), trial);
            assert_eq!(asked, (*level, trial), "session {number}");
            staircase.answer(session.correct[trial]);
        }
        assert_eq!(staircase.turns, session.turns, "session {number}");
        assert_eq!(staircase.turns.len(), 12, "session {number}");
    }
}
