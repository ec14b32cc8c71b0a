//! Rows of the studies: what a protocol can give, and what only people can.

use palpate_files::{TaskKind, load_protocol};
use palpate_run::Failure;
use serde_json::json;

use super::row::{Answer, Mark, Row};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-3.4.2-trials",
        says: "Four subjects rate eight textures three times each.",
        assumed: "Nothing.",
        compute: ratings,
    },
    Row {
        id: "claim-5.4-trials",
        says: "Two users draw four trajectories five times each: 40 trials.",
        assumed: "Nothing.",
        compute: drawings,
    },
    Row {
        id: "fig-3.4",
        says: "Hardness is rated most alike, friction least, among real textures.",
        assumed: "Nothing.",
        compute: || {
            unknown(
                "only people rate; `hil texture panel` has simulated ones, whose spread is set to this order",
            )
        },
    },
    Row {
        id: "fig-3.6",
        says: "Medians on the display are roughly those of the real textures, but for the handkerchief's.",
        assumed: "Nothing.",
        compute: || {
            unknown(
                "only people rate; `hil texture panel` rates the eight emulated textures by a model of people",
            )
        },
    },
];

/// An answer of a row that only people can give.
fn unknown(why: &str) -> Result<Answer, Failure> {
    Ok(Answer::new(
        Mark::Unknown(why.into()),
        "No person has taken part here.",
        json!({}),
    ))
}

/// Trials of one participant in a task of a protocol.
fn trials(protocol: &str, task: TaskKind) -> Result<u64, Failure> {
    let file = load_protocol(protocol)?.value;
    let own = file.tasks().into_iter().filter(|(kind, ..)| *kind == task);
    Ok(own
        .map(|(_, things, each)| things as u64 * u64::from(each))
        .sum())
}

fn ratings() -> Result<Answer, Failure> {
    let each = trials("textures-by-hand", TaskKind::Rating)?;
    Ok(Answer::new(
        Mark::of(each == 24, || "the protocol has other trials".into()),
        format!(
            "Protocol `textures-by-hand`: {each} trials for each participant, {} for four.",
            4 * each
        ),
        json!({ "trials": each }),
    ))
}

fn drawings() -> Result<Answer, Failure> {
    let each = trials("felt-paths", TaskKind::Drawing)?;
    Ok(Answer::new(
        Mark::of(2 * each == 40, || "the protocol has other trials".into()),
        format!(
            "Protocol `felt-paths`: {each} trials for each participant, {} for two.",
            2 * each
        ),
        json!({ "trials": each }),
    ))
}
