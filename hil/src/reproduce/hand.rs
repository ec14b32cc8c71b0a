//! Rows of figure 4.7: the hand of 15 modules at about 30 Hz, which holds twenty things of the YCB set.

use palpate_files::Setup;
use palpate_run::Failure;
use serde_json::json;

use super::row::{Answer, Mark, Row};
use super::setups::{CLUSTERS, THINGS, changed, grasp, grip, hertz, played as run, rate_hz, span};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-4.4.2-rate",
        says: "The hand is read at about 30 Hz.",
        assumed: "All 15 boards wait for one another on one CAN bus of 1 Mbit/s.",
        compute: rate,
    },
    Row {
        id: "fig-4.7-contacts",
        says: "While the hand moves a thing, 75 to 125 taxels are in contact.",
        assumed: "Twenty things of the YCB set by size and weight (recalled), held twice as hard as their weight asks at a friction of 0.5; a flat or soft thing is a very wide sphere. Threshold of (4.3), no margin.",
        compute: contacts,
    },
    Row {
        id: "fig-4.7-speed",
        says: "Compression rarely falls below the hand's 30 Hz, except for K_C = 16.",
        assumed: "This machine, one core: the whole loop. The football of fig-4.7-contacts.",
        compute: speed,
    },
];

fn held(kc: u32, diameter_mm: f64, force: f64) -> Result<Setup, Failure> {
    changed("allegro-one-bus", |scene| {
        scene.compression.kc = kc;
        grasp(scene, diameter_mm, force);
    })
}

fn rate() -> Result<Answer, Failure> {
    let outcome = run(&changed("allegro-one-bus", |_| {})?)?;
    let hz = rate_hz(&outcome);
    let taxels = outcome.summary.taxels.refresh_hz.map_or(0.0, |r| r.median);
    Ok(Answer::new(
        Mark::new((25.0..=36.0).contains(&hz), || {
            "the bus has room for more".into()
        }),
        format!(
            "{hz:.1} frames per second; the median taxel changes {taxels:.1} times per second."
        ),
        json!({ "frames_hz": hz }),
    ))
}

fn contacts() -> Result<Answer, Failure> {
    let mut each = Vec::new();
    for (name, diameter_mm, weight_kg) in THINGS {
        let outcome = run(&held(1, diameter_mm, grip(weight_kg))?)?;
        each.push((name, span(&outcome)));
    }
    let fits = |span: &(u32, u32)| span.0 >= 75 && span.1 <= 125;
    let within = each.iter().filter(|(_, span)| fits(span)).count();
    let mut sweep = Vec::new();
    for newtons in [0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5] {
        let outcome = run(&held(1, 140.0, newtons)?)?;
        sweep.push((newtons, span(&outcome)));
    }
    let told = |all: &mut dyn Iterator<Item = (String, (u32, u32))>| {
        let each = all.map(|(name, (least, most))| format!("{name} {least} to {most}"));
        each.collect::<Vec<_>>().join(", ")
    };
    let cause = told(&mut sweep.iter().map(|(n, span)| (format!("{n} N"), *span)));
    let shown = told(
        &mut each
            .iter()
            .take(4)
            .map(|(n, span)| ((*n).to_owned(), *span)),
    );
    let least = each.iter().map(|(_, span)| span.0).min().unwrap_or(0);
    let most = each.iter().map(|(_, span)| span.1).max().unwrap_or(0);
    Ok(Answer::new(
        Mark::new(within == each.len(), || {
            format!(
                "the grip, which the thesis does not print. The football by force of a module: {cause}"
            )
        }),
        format!(
            "{shown}; {least} to {most} over all twenty, of which {within} stay within 75 to 125."
        ),
        json!({
            "things": each.iter().map(|e| e.0).collect::<Vec<_>>(),
            "spans": each.iter().map(|e| e.1).collect::<Vec<_>>(),
            "sweep_n": sweep.iter().map(|s| s.0).collect::<Vec<_>>(),
            "sweep_spans": sweep.iter().map(|s| s.1).collect::<Vec<_>>(),
        }),
    ))
}

fn speed() -> Result<Answer, Failure> {
    let (_, diameter_mm, weight_kg) = THINGS[0];
    let mut slower = Vec::new();
    for kc in CLUSTERS {
        if hertz(&run(&held(kc, diameter_mm, grip(weight_kg))?)?) < 30.0 {
            slower.push(kc);
        }
    }
    let (mark, found) = match slower.as_slice() {
        [16] => (
            Mark::Agrees,
            "Slower than 30 Hz for K_C = 16 alone.".to_owned(),
        ),
        [] => (
            Mark::Unexplained,
            "Faster than 30 Hz for every K_C, 16 too.".to_owned(),
        ),
        other => (
            Mark::Unexplained,
            format!("Slower than 30 Hz for K_C of {other:?}."),
        ),
    };
    Ok(Answer::new(mark, found, json!({ "slower_at": slower })))
}
