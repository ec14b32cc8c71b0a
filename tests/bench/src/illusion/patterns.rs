//! Every pattern of a vibration every 58.5 ms, on one wire at rest under a finger: number of pulses, spacing, and how the
//! energy is shared out among the pulses. What bounds the row `smooth, 58.5 ms` of [`super::equal_power`].

use std::fmt::Write;

use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::units::Prescale;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Perceiver, Person};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::START_C;
use palpate_files::Setup;
use palpate_run::{Failure, plan};

use super::in_loop::{DRIVES, person};
use crate::findings::Findings;

/// From burst to burst, s.
const SOA_S: f64 = 0.0585;
/// Bursts until wire and tissue have settled, and after those a person's memory.
const SETTLED: u64 = 680;
const HEARD: u64 = 17;
/// Bursts whose median level counts.
const COUNTED: usize = 9;
/// Lengths of patterns, s: one that lasts as long is a vibration, and one that is over then leaves the pause after
/// which a burst is a new one.
const LASTS_S: (f64, f64) = (0.0303, 0.0371);
/// Spacings that are tried between these.
const SPACINGS: u32 = 4;
/// Pulses of a vibration: a spacing of 25 ms and more would be less than 40 Hz, where no vibration was found.
const PULSES: std::ops::RangeInclusive<usize> = 3..=7;
/// Parts of the energy that a pulse can have.
const PARTS: usize = 8;
/// The widest pulse that the guard passes, s.
const WIDEST_S: f64 = 184e-6;
/// Mean power into the wire, mW: about what the renderer takes there, less, and what the guard bears for ten seconds.
const POWERS_MW: [f64; 5] = [6.0, 9.0, 11.5, 14.0, 18.0];

/// A wire on a finger.
struct Worn {
    wire: WireParameters,
    tissue: TissueParameters,
    amps: f64,
    person: Person,
}

/// A burst: pulses at this distance, s, with these parts of its energy.
#[derive(Clone, Debug, PartialEq)]
struct Burst {
    spacing_s: f64,
    parts: Vec<usize>,
}

impl Burst {
    /// The published one.
    fn seven() -> Self {
        Self {
            spacing_s: Prescale::new(30).period_ns() as f64 * 1e-9,
            parts: vec![1; 7],
        }
    }

    fn is_even(&self) -> bool {
        self.parts.iter().all(|part| *part == self.parts[0])
    }

    /// Returns true if no pulse has more than half of the energy.
    fn is_halved(&self) -> bool {
        let all: usize = self.parts.iter().sum();
        self.parts.iter().all(|part| 2 * part <= all)
    }

    fn name(&self) -> String {
        let parts: Vec<_> = self.parts.iter().map(usize::to_string).collect();
        format!("{} at {:.1} ms", parts.join(":"), self.spacing_s * 1e3)
    }
}

/// All ways to share out so many parts among so many pulses, each at least one.
fn compositions(parts: usize, pulses: usize) -> Vec<Vec<usize>> {
    if pulses == 1 {
        return vec![vec![parts]];
    }
    let mut all = Vec::new();
    for first in 1..=parts - (pulses - 1) {
        for mut rest in compositions(parts - first, pulses - 1) {
            rest.insert(0, first);
            all.push(rest);
        }
    }
    all
}

/// Every burst that is a vibration and leaves its pause.
fn bursts() -> Vec<Burst> {
    let mut all = Vec::new();
    for pulses in PULSES {
        let mut shared = vec![vec![1; pulses]];
        let uneven = compositions(PARTS.max(pulses + 1), pulses);
        shared.extend(
            uneven
                .into_iter()
                .filter(|p| p.iter().any(|part| *part != p[0])),
        );
        for step in 0..SPACINGS {
            let (shortest, longest) = LASTS_S;
            let part = f64::from(step) / f64::from(SPACINGS - 1);
            let spacing_s = (shortest + part * (longest - shortest)) / (pulses - 1) as f64;
            all.extend(shared.iter().map(|parts| Burst {
                spacing_s,
                parts: parts.clone(),
            }));
        }
    }
    all
}

impl Worn {
    fn of(setup: &Setup) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        Ok(Self {
            wire: plan::wire(setup),
            tissue: bench.tissue.parameters(),
            amps: bench.drive.current_ma * 1e-3,
            person: person("typical", setup)?,
        })
    }

    /// Level of a burst that comes again and again at this mean power, dB; none where a pulse would be too wide.
    fn level_db(&self, burst: &Burst, watts: f64) -> Option<f64> {
        let on_s = watts * SOA_S / (self.amps * self.amps * self.wire.resistance_ohm);
        let all: usize = burst.parts.iter().sum();
        let wide = |part: usize| on_s * part as f64 / all as f64;
        if burst.parts.iter().any(|part| wide(*part) > WIDEST_S) {
            return None;
        }
        let mut perceiver = Perceiver::new(self.person, &[(0.0, 0.0)]).ok()?;
        let worn = Wire::new(&self.wire, &self.tissue, START_C);
        let mut worn = worn.and_then(|wire| wire.worn(&self.tissue)).ok()?;
        let nanos = |s: f64| Nanos((s * 1e9).round() as u64);
        let mut levels = Vec::new();
        for n in 0..SETTLED + HEARD + COUNTED as u64 {
            let start_s = n as f64 * SOA_S;
            if n == SETTLED {
                worn.keep_stretches();
            }
            perceiver.onset();
            for (pulse, part) in burst.parts.iter().enumerate() {
                let at_s = start_s + pulse as f64 * burst.spacing_s;
                worn.set_current(nanos(at_s), self.amps);
                worn.set_current(nanos(at_s + wide(*part)), 0.0);
            }
            worn.take_stretches(nanos(start_s + SOA_S), |stretch| perceiver.pass(0, stretch));
            perceiver.settle();
            if n >= SETTLED + HEARD {
                levels.push(perceiver.felt(START_C)?.levels.db());
            }
        }
        levels.sort_unstable_by(f64::total_cmp);
        levels.get(COUNTED / 2).copied()
    }
}

/// The best of some bursts at a power: by how much over the seven, dB, and which.
type Best<'b> = Option<(f64, &'b Burst)>;

/// Measures the frontier on the benches of the row.
///
/// # Errors
/// [`Failure`] where a shipped file cannot be read.
pub fn measure() -> Result<Findings, Failure> {
    let mut found = Findings::new("patterns");
    let (default, thesis) = (DRIVES[0], DRIVES[2]);
    let bursts = bursts();
    let seven = Burst::seven();
    for (drive, wires) in [
        (default, default.wires[0]),
        (thesis, thesis.wires[0]),
        (thesis, thesis.wires[1]),
    ] {
        let bench = format!("{}, {wires}", drive.name);
        let worn = Worn::of(&super::equal_power::setup(drive, wires, &[])?)?;
        let _ = writeln!(
            found.table,
            "\n  {bench}, dB over seven\n    {:>5}  {:>8}  {:28}   {:28}   any",
            "mW", "seven dB", "equal pulses", "at most half in one pulse"
        );
        for mw in POWERS_MW {
            let Some(base) = worn.level_db(&seven, mw * 1e-3) else {
                continue;
            };
            let gains = bursts
                .iter()
                .filter_map(|b| worn.level_db(b, mw * 1e-3).map(|db| (db - base, b)));
            let [mut even, mut half, mut any]: [Best<'_>; 3] = [None; 3];
            for one in gains {
                let better = |best: &Best<'_>| best.is_none_or(|b| one.0 > b.0);
                if better(&any) {
                    any = Some(one);
                }
                if one.1.is_even() && better(&even) {
                    even = Some(one);
                }
                if one.1.is_halved() && better(&half) {
                    half = Some(one);
                }
            }
            let tell = |best: &Best<'_>| {
                best.map_or("-".into(), |(db, b)| format!("{db:+5.2}  {}", b.name()))
            };
            let _ = writeln!(
                found.table,
                "    {mw:>5.1}  {base:>8.2}  {:28}   {:28}   {}",
                tell(&even),
                tell(&half),
                tell(&any)
            );
            let methods = [
                ("default", even),
                ("at most half in one pulse", half),
                ("unequal pulses", any),
            ];
            for (method, best) in methods {
                let gain = best.map_or(f64::NAN, |(db, _)| db);
                found.row(
                    &format!("{bench}: {mw} mW"),
                    method,
                    (gain, "dB over seven equal pulses"),
                    f64::NAN,
                );
            }
        }
    }
    found.words.push(format!(
        "One wire under a finger, {} bursts every {} ms: 3 to 7 pulses that last 30 ms and leave the pause after which a burst \
         is a new one, at {SPACINGS} spacings, with every share of the energy in {PARTS} parts. Levels of the typical person \
         after {:.0} s at this power, without the guard. Names say the shares, pulse by pulse.",
        bursts.len(),
        SOA_S * 1e3,
        SETTLED as f64 * SOA_S,
    ));
    Ok(found)
}

#[cfg(test)]
#[path = "patterns_tests.rs"]
mod tests;
