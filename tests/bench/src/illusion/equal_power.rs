//! Gain of the renderer's patterns over seven equal pulses of the same mean power, as felt in the loop: a contact
//! rests on a wire, and everything is measured once it has settled.

use std::fmt::Write;

use palpate_core::contact::Levels;
use palpate_core::guard::Guard;
use palpate_core::render::Style;
use palpate_files::{Overrides, Setup};
use palpate_records::trace::{Event, Trace, event};
use palpate_run::{Failure, Input, build, run};

use super::in_loop::{DRIVES, Drive, SEEDS};
use crate::findings::Findings;

/// A run, s.
const LENGTH_S: f64 = 60.0;
/// Start of the measurement, microseconds: a whole number of onsets of either cadence, when a contact has rested for
/// long.
const FROM_US: u64 = 340 * 117_000;
const UNTIL_US: u64 = 511 * 117_000;
/// The widest pulse of the seven, ticks, that is tried.
const WIDEST: u16 = 60;
/// The seven: the published burst and its cadence.
const SEVEN_MS: (f64, f64) = (35.0, 58.5);

/// A pattern of the renderer.
struct Pattern {
    name: &'static str,
    style: Style,
    soa_ms: f64,
    /// Required over the seven, dB, at equal delivered and at equal booked power.
    required_db: [Option<f64>; 2],
}

const PATTERNS: [Pattern; 3] = [
    Pattern {
        name: "smooth, 58.5 ms",
        style: Style::Smooth,
        soa_ms: 58.5,
        required_db: [Some(3.0), None],
    },
    Pattern {
        name: "smooth, 117 ms",
        style: Style::Smooth,
        soa_ms: 117.0,
        required_db: [Some(6.5), Some(5.0)],
    },
    Pattern {
        name: "tap, 117 ms",
        style: Style::Tap,
        soa_ms: 117.0,
        required_db: [Some(8.0), Some(6.0)],
    },
];

/// A contact that rests, settled.
#[derive(Clone, Copy, Debug)]
struct Settled {
    /// Mean power, mW: into the wires, and as the guard counts it.
    mw: [f64; 2],
    /// Median level of the typical person, dB.
    db: f64,
    /// Most pulses of a stimulus.
    pulses: u64,
    /// Stimuli that the guard changed.
    limited: u32,
}

/// A contact on a wire of this bench.
pub(super) fn setup(
    drive: Drive,
    wires: &str,
    changes: &[(&str, String)],
) -> Result<Setup, Failure> {
    let mut overrides = Overrides::default();
    overrides.bench("equal power", "wire.kind", wires);
    overrides.scene("equal power", "length_s", format!("{LENGTH_S:.1}"));
    overrides.scene("equal power", "illusion.intensity", "false");
    for (key, value) in changes {
        overrides.scene("equal power", key, value);
    }
    Ok(Setup::load("rest-on-wire", drive.file)?.with(&overrides)?)
}

fn settled(setup: &Setup, seed: u64) -> Result<Settled, Failure> {
    let outcome = run(setup, &Input::Scene, seed)?;
    if let Some(failure) = outcome.failure {
        return Err(failure);
    }
    let projector = build(setup, seed, Levels::Off)?;
    Ok(Settled::of(&outcome.trace, projector.guard()))
}

impl Settled {
    fn of(trace: &Trace, guard: &Guard) -> Self {
        let period_ns = guard.prescale().period_ns();
        let within = |t_us: u64| (FROM_US..UNTIL_US).contains(&t_us);
        let (mut booked_nj, mut pulses, mut levels) = (0, 0, Vec::new());
        // Time that outputs are high for, ns: in all, and within what is measured. Each pulse gives the same power.
        let (mut high_ns, mut here_ns) = (0, 0);
        for event in &trace.events {
            match event {
                Event::Schedule(entry) if within(entry.at.as_micros()) => {
                    booked_nj += guard.energy_nj(entry.width(), entry.until.since(entry.at));
                    pulses = pulses.max(entry.pulses(period_ns));
                }
                Event::Felt(event::Felt {
                    t_us,
                    met: Some(met),
                    ..
                }) if within(*t_us) => levels.push(met.level_mdb),
                Event::Edge(event::Edge { t_ns, high, .. }) => {
                    // The fall less the rise.
                    let signed = i128::from(*t_ns) * if *high { -1 } else { 1 };
                    high_ns += signed;
                    if within(t_ns / 1000) {
                        here_ns += signed;
                    }
                }
                _ => {}
            }
        }
        levels.sort_unstable();
        let median = levels.get(levels.len() / 2).copied();
        let seconds = (UNTIL_US - FROM_US) as f64 * 1e-6;
        let delivered_mj =
            trace.ledger.energy_uj as f64 * 1e-3 * here_ns as f64 / high_ns.max(1) as f64;
        Self {
            mw: [delivered_mj / seconds, booked_nj as f64 * 1e-6 / seconds],
            db: median.map_or(f64::NAN, |mdb| f64::from(mdb) * 1e-3),
            pulses,
            limited: trace.ledger.driven.limiter_events,
        }
    }
}

/// Seven equal pulses of growing width, until both powers are reached.
fn seven(drive: Drive, wires: &str, most_mw: [f64; 2]) -> Result<Vec<Settled>, Failure> {
    let mut all: Vec<Settled> = Vec::new();
    let (tau_d_ms, soa_ms) = SEVEN_MS;
    for ticks in 4..=WIDEST {
        let changes = [
            ("illusion.model", "nearest".to_owned()),
            ("illusion.tau_d_ms", format!("{tau_d_ms:.1}")),
            ("illusion.soa_ms", format!("{soa_ms:.1}")),
            ("illusion.beta", format!("{:.9}", f64::from(ticks) / 4096.0)),
        ];
        let one = settled(&setup(drive, wires, &changes)?, SEEDS[0])?;
        all.push(one);
        if (0..2).all(|k| one.mw[k] > most_mw[k]) {
            break;
        }
    }
    Ok(all)
}

/// Level of the seven at this power of one kind, dB: between two widths by the logarithm of power.
fn level_at(seven: &[Settled], kind: usize, mw: f64) -> f64 {
    let brackets = |pair: &&[Settled]| (pair[0].mw[kind]..=pair[1].mw[kind]).contains(&mw);
    seven.windows(2).find(brackets).map_or(f64::NAN, |pair| {
        let part = (mw / pair[0].mw[kind]).ln() / (pair[1].mw[kind] / pair[0].mw[kind]).ln();
        pair[0].db + part * (pair[1].db - pair[0].db)
    })
}

/// Measures every pattern on the benches that drive the published current.
///
/// # Errors
/// [`Failure`] where a shipped file cannot be read, or a run fails.
pub fn measure() -> Result<Findings, Failure> {
    let mut found = Findings::new("equal-power");
    let (default, thesis) = (DRIVES[0], DRIVES[2]);
    let (mut limited, mut seven_pulses) = (0, 0);
    for (drive, wires) in [
        (default, default.wires[0]),
        (thesis, thesis.wires[0]),
        (thesis, thesis.wires[1]),
    ] {
        let bench = format!("{}, {wires}", drive.name);
        let _ = writeln!(
            found.table,
            "\n  {bench}\n    {:16} {:>6}  {:>9} {:>6}  {:>8}  {:>17}  {:>14}",
            "pattern",
            "pulses",
            "delivered",
            "booked",
            "level dB",
            "at equal delivered",
            "at equal booked"
        );
        let mut each = Vec::new();
        for pattern in &PATTERNS {
            let changes = [
                ("illusion.model", "inverse".to_owned()),
                ("illusion.render", pattern.style.name().to_owned()),
                ("illusion.soa_ms", format!("{:.1}", pattern.soa_ms)),
            ];
            let setup = setup(drive, wires, &changes)?;
            let seeds = SEEDS.map(|seed| settled(&setup, seed));
            each.push(seeds.into_iter().collect::<Result<Vec<_>, _>>()?);
        }
        let most = |kind: usize| {
            each.iter()
                .flatten()
                .map(|s| s.mw[kind])
                .fold(0.0, f64::max)
        };
        let seven = seven(drive, wires, [most(0), most(1)])?;
        let all = each.iter().flatten().chain(&seven);
        limited += all.map(|s| s.limited).sum::<u32>();
        seven_pulses = seven.iter().map(|s| s.pulses).fold(seven_pulses, u64::max);
        for (pattern, seeds) in PATTERNS.iter().zip(&each) {
            let over = |kind: usize| {
                let gains = seeds
                    .iter()
                    .map(|s| s.db - level_at(&seven, kind, s.mw[kind]));
                gains.fold(f64::INFINITY, f64::min)
            };
            let gains = [over(0), over(1)];
            for (kind, gain) in ["delivered", "booked"].into_iter().zip(gains) {
                let case = format!("{bench}: {}, equal {kind} power", pattern.name);
                found.row(
                    &case,
                    "default",
                    (gain, "dB over seven equal pulses"),
                    f64::NAN,
                );
            }
            let _ = writeln!(found.table, "{}", line(pattern, &seeds[0], gains));
        }
    }
    found.words.push(format!(
        "A contact rests on a wire; level and mean power (mW) are of {:.0} s from {:.0} s on, typical person. Levels over \
         seven equal pulses every {} ms ({seven_pulses} were counted) that get as much power from the same bench: into the \
         wires, or as the guard books it. The least of {} seeds; between two widths of the seven by the logarithm of power. \
         The guard changed {limited} stimuli.",
        (UNTIL_US - FROM_US) as f64 * 1e-6,
        FROM_US as f64 * 1e-6,
        SEVEN_MS.1,
        SEEDS.len(),
    ));
    Ok(found)
}

fn line(pattern: &Pattern, of: &Settled, gains: [f64; 2]) -> String {
    let gain = |kind: usize| {
        let met = pattern.required_db[kind].map_or(String::new(), |least| {
            let met = if gains[kind] >= least {
                "met"
            } else {
                "MISSED"
            };
            format!(" of {least:+.1} {met}")
        });
        format!("{:+.1}{met}", gains[kind])
    };
    format!(
        "    {:16} {:>6}  {:>9.2} {:>6.2}  {:>8.1}  {:>17}  {:>14}",
        pattern.name,
        of.pulses,
        of.mw[0],
        of.mw[1],
        of.db,
        gain(0),
        gain(1)
    )
}
