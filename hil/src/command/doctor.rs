//! `hil doctor`: what this machine can do, what is missing, what to type.

use palpate_buses::guardian::Latch;
use palpate_buses::survey::{Finding, survey};
use serde::Serialize;

use crate::cli::DoctorArgs;
use palpate_live::output::{print, print_json};
use palpate_live::real::watch;
use palpate_run::Failure;

use palpate_buses::pacer::RunClock;
use palpate_core::codec::link::{State, VERSION};
use palpate_files::unnumbered;

use super::devices::{bench, unit_of};
use palpate_live::link::{RemoteUnit, UnitPlace};

/// Exchanges with a unit, the shortest of which counts.
const EXCHANGES: usize = 8;

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    findings: &'a [Finding],
    /// `true` where everything is there that a real bench cannot do without.
    ready: bool,
}

/// Prints what was found. A missing thing is no failure, unless a bench was named.
///
/// # Errors
/// [`Failure::Input`] for a bad bench, [`Failure::Device`] when the named bench lacks something.
pub fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let named = args
        .bench
        .as_deref()
        .map(|name| bench(Some(name), &[], &[]));
    let named = named.transpose()?;
    let real = named.as_ref().and_then(|b| b.value.real.as_ref());
    let watched = named
        .as_ref()
        .zip(real)
        .map(|(b, real)| watch(&b.value, real));
    let can = real.map(|real| real.can.as_slice());
    let mut findings = survey(can, watched.as_ref());
    let place = match named.as_ref().map(|b| b.value.unit_address().is_some()) {
        None | Some(true) => unit_of(args.bench.as_deref(), &args.unit)?,
        Some(false) => unit_of(None, &args.unit)?,
    };
    if named.is_none() && place.is_some() {
        // A unit has buses of its own.
        findings.iter_mut().for_each(|f| f.needed = false);
    }
    let named = named.is_some() || place.is_some();
    findings.extend(place.iter().flat_map(unit));
    let words = |finding: &mut Finding| finding.says = unnumbered(&finding.says);
    findings.iter_mut().for_each(words);
    let ready = findings.iter().all(|f| f.ok || !f.needed);
    if args.json {
        let findings = &findings;
        print_json(&Report { findings, ready })?;
    } else {
        print(|out| {
            for finding in &findings {
                let mark = match (finding.ok, finding.needed) {
                    (true, _) => "ok",
                    (false, true) => "missing",
                    (false, false) => "-",
                };
                writeln!(out, "{mark:<8}{:<12}{}", finding.about, finding.says)?;
                if let Some(remedy) = &finding.remedy {
                    writeln!(out, "{:<20}{remedy}", "")?;
                }
            }
            Ok(())
        })?;
    }
    if ready || !named {
        return Ok(());
    }
    Err(Failure::Device(
        "the bench lacks what is marked `missing`".into(),
    ))
}

/// Findings from a driver unit's answer to a knock. No session begins, so the host that drives it goes on.
fn unit(place: &UnitPlace) -> Vec<Finding> {
    let finding = |about, ok, says: String, remedy| Finding {
        about,
        ok,
        needed: true,
        says,
        remedy,
    };
    let asked = RemoteUnit::open(place, 0, RunClock::start()).and_then(|mut u| u.ask(EXCHANGES));
    let (hello, trip, middle) = match asked {
        Ok(asked) => asked,
        Err(failure) => return vec![finding("unit", false, failure.to_string(), None)],
    };
    let (plant, limits) = (&hello.plant, &hello.limits);
    let ahead_s = (hello.now.as_micros() as f64 - middle.as_micros() as f64) * 1e-6;
    let half_ms = trip.as_micros() as f64 / 2e3;
    let wires: u32 = hello.wires.iter().map(|bits| bits.count_ones()).sum();
    let boards = hello.wires.iter().filter(|bits| **bits != 0).count();
    let rows = if hello.heat {
        "all rows"
    } else {
        "the integer rows"
    };
    let set = hello.current.map_or(String::new(), |current| {
        format!(", currents set up to {} mA", current.full_scale.0)
    });
    let module = match hello.warmth {
        true => ", a Peltier module",
        false => "",
    };
    let fine = |about, says| finding(about, true, says, None);
    let mut found = vec![
        fine(
            "unit",
            format!(
                "{} answers under this key, version {VERSION}, within {:.1} ms",
                place.name,
                2.0 * half_ms
            ),
        ),
        fine(
            "unit clock",
            format!(
                "runs for {:.3} s, known to {half_ms:.2} ms; {ahead_s:+.3} s from this program's",
                hello.now.as_micros() as f64 * 1e-6
            ),
        ),
        fine(
            "unit boards",
            format!(
                "{wires} wires, boards: {boards}, PRE_SCALE {}, {} mA through {} milliohms{set}{module}",
                plant.prescale.get(),
                plant.peak.0,
                plant.wire_milliohm
            ),
        ),
        fine(
            "unit guard",
            format!(
                "{rows}; pulses to {} us, bursts to {} ms and {} mJ, fingertip {} mW over 60 s, off within {} ms",
                limits.pulse_width_ns / 1000,
                limits.burst.as_micros() / 1000,
                limits.burst_energy_nj as f64 / 1e6,
                limits.fingertip_60s_uw as f64 / 1e3,
                limits.stale.as_micros() / 1000
            ),
        ),
        fine(
            "unit state",
            match hello.state {
                State::Ready => format!("drives; {} stops so far", hello.stops),
                State::Stopped(cause) => format!(
                    "stopped, {}; {} stops so far; the next run acknowledges that",
                    cause.word(),
                    hello.stops
                ),
            },
        ),
    ];
    if hello.busy {
        // No fault: or a host that has just ended.
        found.push(Finding {
            needed: false,
            ..finding("unit host", false, "another host drives it".into(), None)
        });
    }
    if let Some(held) = Latch::new(&place.hardware()).look() {
        let says = format!("a run on it was stopped: {}", held.cause);
        let remedy = format!("hil off --unlatch --unit {} --key FILE", place.name);
        found.push(finding("unit stop", false, says, Some(remedy)));
    }
    found
}
