//! The table of laws as Markdown.

use std::fmt::Write;

use palpate_core::illusion::IllusionModel;

use super::space::{FREE_BELOW_MS, GIVEN, RANGES, Range, shapes};
use super::{BENCH, CHOOSING, Chosen, Felt, SCORING, SITUATIONS, Scored, UNFELT_MM};

/// A figure of a run, and whether more of it is better.
struct Measure {
    name: &'static str,
    unit: &'static str,
    value: fn(&Felt) -> f64,
    more_is_better: bool,
}

const MEASURES: [Measure; 4] = [
    Measure {
        name: "level",
        unit: "dB",
        value: |felt| felt.level_db,
        more_is_better: true,
    },
    Measure {
        name: "error",
        unit: "mm",
        value: Felt::worst_mm,
        more_is_better: false,
    },
    Measure {
        name: "not felt",
        unit: "onsets",
        value: |felt| f64::from(felt.inside.unfelt),
        more_is_better: false,
    },
    Measure {
        name: "limiter events",
        unit: "",
        value: |felt| f64::from(felt.limited),
        more_is_better: false,
    },
];

/// All of the block: conditions, settings, a table per situation, and where `inverse` is not the best.
pub(super) fn markdown(laws: &[Scored], points: u32) -> String {
    let mut out = conditions(points);
    settings(&mut out, laws);
    for (k, situation) in SITUATIONS.iter().enumerate() {
        let _ = write!(
            out,
            "\n| {situation} | level, dB | error by energy, mm | by amplitude, mm | not felt | taps | limiter events | \
             all onsets: error, mm | not felt |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n"
        );
        for law in laws {
            let _ = writeln!(out, "{}", row(law, k));
        }
    }
    out.push('\n');
    for (k, situation) in SITUATIONS.iter().enumerate() {
        let _ = writeln!(out, "- {situation}: {}", beaten(laws, k));
    }
    out
}

fn conditions(points: u32) -> String {
    let mut out = format!(
        "\nBench `{BENCH}`, the typical person. Each law is tried at the same {points} points: its own settings, the ones \
         found by hand for `energy`, and {} of a low-discrepancy sequence over\n\n",
        points - GIVEN
    );
    for range in RANGES {
        let Range {
            name,
            unit,
            least,
            most,
        } = range;
        let _ = writeln!(out, "- {name}: {least} to {most} {unit}, by its logarithm;");
    }
    out.push_str("- a fifth knob, where the law has one: ");
    for law in IllusionModel::ALL {
        if let Some(range) = shapes(law) {
            let (name, least, most) = (range.name, range.least, range.most);
            let _ = write!(out, "{name} of `{}` {least} to {most}, ", law.name());
        }
    }
    let _ = write!(
        out,
        "`render` of `inverse` smooth or tap. `inverse` finds its duration, and below {FREE_BELOW_MS} ms its frequency.\n\n\
         The objective is the worst run of four paths and a contact at rest on seeds {}: RMSE by the worse centroid, plus \
         {UNFELT_MM} mm times the share of onsets that are not felt, both of the onsets inside the wires' hull. Scores are of \
         seeds {}, least to most: the lowest level (median) and the largest errors of the paths, counts added up, inside the \
         hull; then error by the worse centroid and onsets not felt over all onsets. Taps are bursts too short for a \
         vibration.\n",
        listed(&CHOOSING),
        listed(&SCORING),
    );
    out
}

fn listed(seeds: &[u64]) -> String {
    let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
    seeds.join(", ")
}

fn settings(out: &mut String, laws: &[Scored]) {
    out.push_str("\n| law | chosen settings | point | objective, mm | refused points |\n|---|---|---:|---:|---:|\n");
    for Scored { chosen, .. } in laws {
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} | {} |",
            chosen.law.name(),
            told(chosen),
            chosen.point,
            number(chosen.cost_mm, 2),
            chosen.refused,
        );
    }
}

/// Settings in words.
fn told(chosen: &Chosen) -> String {
    let Some(knobs) = &chosen.knobs else {
        return "its own".into();
    };
    let [soa_ms, tau_d_ms, pulse_us, pwm_hz] = knobs.values;
    let fifth = knobs
        .fifth(chosen.law)
        .map_or(String::new(), |(key, value)| format!(", {key} {value}"));
    format!("SOA {soa_ms:.1} ms, tau_d {tau_d_ms:.1} ms, {pulse_us:.0} us, {pwm_hz:.1} Hz{fifth}")
}

fn row(law: &Scored, k: usize) -> String {
    let span = |value: fn(&Felt) -> f64, digits: usize| {
        let values = || law.by_seed.iter().map(|by| value(&by[k]));
        let least = number(values().fold(f64::INFINITY, f64::min), digits);
        let most = number(values().fold(f64::NEG_INFINITY, f64::max), digits);
        match least == most {
            true => least,
            false => format!("{least} to {most}"),
        }
    };
    let most = |value: fn(&Felt) -> u32| law.by_seed.iter().map(|by| value(&by[k])).max();
    let inside = most(|felt| felt.inside.onsets).unwrap_or(0);
    format!(
        "| `{}` | {} | {} | {} | {} of {inside} | {} | {} | {} | {} of {} |",
        law.chosen.law.name(),
        span(|felt| felt.level_db, 1),
        span(|felt| felt.inside_mm[0], 2),
        span(|felt| felt.inside_mm[1], 2),
        span(|felt| f64::from(felt.inside.unfelt), 0),
        span(|felt| felt.taps as f64, 0),
        span(|felt| f64::from(felt.limited), 0),
        span(|felt| felt.everywhere_mm, 2),
        span(|felt| f64::from(felt.everywhere.unfelt), 0),
        most(|felt| felt.everywhere.onsets).unwrap_or(0),
    )
}

/// A number, or a dash where no wire moved.
fn number(value: f64, digits: usize) -> String {
    match value.is_finite() && value > -100.0 {
        true => format!("{value:.digits$}"),
        false => "-".into(),
    }
}

/// Laws that beat `inverse` by the worst seed, measure by measure.
fn beaten(laws: &[Scored], k: usize) -> String {
    let mut lost = Vec::new();
    for measure in &MEASURES {
        let sign = if measure.more_is_better { 1.0 } else { -1.0 };
        // As a gain, so that the least over the seeds is the worst.
        let gain = |law: &Scored| {
            let gains = law.by_seed.iter().map(|by| sign * (measure.value)(&by[k]));
            gains.fold(f64::INFINITY, f64::min)
        };
        let Some(own) = laws
            .iter()
            .find(|law| law.chosen.law == IllusionModel::Inverse)
            .map(gain)
        else {
            continue;
        };
        let better: Vec<String> = laws
            .iter()
            .filter(|law| gain(law) > own)
            .map(|law| format!("`{}` {:.2}", law.chosen.law.name(), sign * gain(law)))
            .collect();
        if !better.is_empty() {
            lost.push(format!(
                "{}, {:.2} {} against {}",
                measure.name,
                sign * own,
                measure.unit,
                better.join(", ")
            ));
        }
    }
    match lost.is_empty() {
        true => "`inverse` is beaten by no law.".into(),
        false => format!("`inverse` loses by the worst seed in {}.", lost.join("; ")),
    }
}
