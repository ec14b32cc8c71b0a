//! Parts of a session that stand on its pages: the participant's screens, which name no condition, wire or level, and
//! the experimenter's words.

use palpate_study::{Ask, Session, Step, Stimulus, Trial};
use serde_json::{Value, json};

/// Space around the display's wires on a page, mm.
const MARGIN_MM: f64 = 9.0;

/// Screen of the participant at the present step, on a display whose wires lie at these places, mm.
pub(super) fn screen(session: &Session, wires_mm: &[[f64; 2]]) -> Value {
    let protocol = session.protocol();
    let (done, all) = session.progress();
    let mut view = match session.step() {
        Step::Consent => json!({ "screen": "consent", "text": protocol.consent }),
        Step::Instructions => json!({ "screen": "instructions", "text": protocol.instructions }),
        Step::Question(number) => {
            let question = &protocol.questions[*number];
            json!({ "screen": "question", "text": question.text, "choices": question.choices })
        }
        Step::Break => json!({ "screen": "break", "seconds": protocol.break_s }),
        Step::Trial(trial) => asked(trial, wires_mm),
        Step::Done => json!({ "screen": "done" }),
        Step::Declined => json!({ "screen": "declined" }),
    };
    view["part"] = json!(done as f64 / all.max(1) as f64);
    view
}

fn asked(trial: &Trial, wires_mm: &[[f64; 2]]) -> Value {
    let frame_mm = frame(wires_mm);
    match &trial.ask {
        Ask::Interval(question) => json!({ "screen": "interval", "text": question }),
        Ask::Which(question) => json!({ "screen": "interval", "text": question }),
        Ask::Place => {
            json!({ "screen": "place", "text": "Where was it?", "frame_mm": frame_mm })
        }
        Ask::Path => {
            json!({ "screen": "path", "text": "Draw the path that you felt.", "frame_mm": frame_mm })
        }
        Ask::Ratings(scales) => {
            let scales: Vec<Value> = scales
                .iter()
                .map(|s| json!({ "name": s.name, "low": s.low, "high": s.high }))
                .collect();
            json!({ "screen": "ratings", "text": "How was it?", "scales": scales })
        }
    }
}

/// Left, bottom, right and top of what a page shows, mm.
fn frame(wires_mm: &[[f64; 2]]) -> [f64; 4] {
    let over = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
        wires_mm.iter().map(|wire| wire[axis]).fold(from, pick)
    };
    let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
    [
        over(0, f64::min, low) - MARGIN_MM,
        over(1, f64::min, low) - MARGIN_MM,
        over(0, f64::max, high) + MARGIN_MM,
        over(1, f64::max, high) + MARGIN_MM,
    ]
}

/// A step as the experimenter reads it.
pub(super) const fn step_name(step: &Step) -> &'static str {
    match step {
        Step::Consent => "consent",
        Step::Instructions => "instructions",
        Step::Question(_) => "question",
        Step::Break => "break",
        Step::Trial(_) => "trial",
        Step::Done => "done",
        Step::Declined => "declined",
    }
}

/// A trial as the experimenter reads it.
pub(super) fn words(trial: &Trial) -> String {
    let played = trial.intervals.iter().map(|stimulus| match stimulus {
        Stimulus::Silence => "nothing".to_owned(),
        Stimulus::Wire { wire, level_db } => format!("wire {wire} at {level_db:.1} dB"),
        Stimulus::Condition(name) => name.clone(),
    });
    let played: Vec<String> = played.collect();
    let practice = if trial.practice { ", practice" } else { "" };
    let again = match trial.attempt {
        0 => String::new(),
        n => format!(", begun for the {}. time", n + 1),
    };
    format!(
        "{}{practice}{again}: {}",
        trial.task.name(),
        played.join(", then ")
    )
}
