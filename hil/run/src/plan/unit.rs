//! What host and driver unit make of each other: the stricter of both, in every row.

use palpate_core::codec::link::Hello;
use palpate_core::guard::{CurrentControl, Limits, Plant};
use palpate_core::illusion::DisplayWire;
use palpate_files::Setup;

use super::{current, guarded};
use crate::failure::Failure;

/// A row of limits or plant: its name, its unit, its values by the host and by the unit.
type Row = (&'static str, &'static str, u64, u64);

/// What the loop plays by: the bench's own where no unit was met.
///
/// # Errors
/// [`Failure::Input`] where the unit's chips count another period, or it lacks an output that the display needs.
pub(super) fn agreed(
    setup: &Setup,
    (limits, plant): (Limits, Plant),
    wires: &[DisplayWire],
) -> Result<(Limits, Plant), Failure> {
    let Some(unit) = &setup.unit else {
        return Ok((limits, plant));
    };
    let name = &setup.bench.value.name;
    if unit.plant.prescale != plant.prescale {
        let [here, there] =
            [plant.prescale, unit.plant.prescale].map(|p| (p.get(), 1e9 / p.period_ns() as f64));
        return Err(Failure::Input(format!(
            "bench `{name}`: expected PRE_SCALE {} ({:.2} Hz) as the scene and its illusion need, found a unit with {} ({:.2} Hz): start the unit with a bench of that drive.pwm_hz and drive.clock, or state the unit's here",
            here.0, here.1, there.0, there.1
        )));
    }
    let lacks = |wire: &&DisplayWire| {
        let carried = unit.wires.get(usize::from(wire.board.0));
        carried.is_none_or(|bits| bits >> wire.channel.0 & 1 == 0)
    };
    if let Some(wire) = wires.iter().find(lacks) {
        return Err(Failure::Input(format!(
            "bench `{name}`: expected a unit with a wire on each output of the display, found none on channel {} of its board {}: make the outputs of bench and unit agree",
            wire.channel.0, wire.board.0
        )));
    }
    Ok((limits.stricter(&unit.limits), plant.worse(&unit.plant)))
}

/// What host and unit make of amplifiers whose current is set: the wider tolerance.
///
/// # Errors
/// [`Failure::Input`] where the unit sets none, or of another full scale; or where it has no Peltier module and the bench does.
pub(super) fn agreed_current(
    setup: &Setup,
    own: Option<CurrentControl>,
) -> Result<Option<CurrentControl>, Failure> {
    let bench = &setup.bench.value;
    let Some(unit) = &setup.unit else {
        return Ok(own);
    };
    let bad = |text: String| Err(Failure::Input(format!("bench `{}`: {text}", bench.name)));
    if bench.heat.is_some() && !unit.warmth {
        return bad("expected a unit with a Peltier module for [heat], found one without: leave [heat] out, or start a unit that has one".into());
    }
    match (own, unit.current) {
        (Some(own), Some(unit)) if own.full_scale == unit.full_scale => Ok(Some(CurrentControl {
            full_scale: own.full_scale,
            gain_ppm: own.gain_ppm.max(unit.gain_ppm),
            offset: own.offset.max(unit.offset),
        })),
        (Some(own), Some(unit)) => bad(format!(
            "expected a unit whose currents are set up to {} mA, found {} mA: make drive.current_ma of both agree",
            own.full_scale.0, unit.full_scale.0
        )),
        (Some(_), None) => bad("expected a unit whose currents are set, found one whose amplifiers have a current of their own: leave [dac] out, or start the unit with it".into()),
        (None, _) => Ok(None),
    }
}

/// Where host and unit differ, a sentence each: what is played by is the stricter.
///
/// # Errors
/// [`Failure::Input`] for a bench that no guard can have.
pub fn differences(setup: &Setup) -> Result<Vec<String>, Failure> {
    let Some(unit) = &setup.unit else {
        return Ok(Vec::new());
    };
    let (limits, plant) = guarded(setup, Some(unit.plant.prescale))?;
    let lower = limit_rows(&limits, unit);
    let higher = [
        (
            "most current of a pulse, its tolerance included",
            "mA",
            plant.peak.0.into(),
            unit.plant.peak.0.into(),
        ),
        (
            "resistance of a wire",
            "milliohms",
            plant.wire_milliohm.into(),
            unit.plant.wire_milliohm.into(),
        ),
    ];
    let mut said = Vec::new();
    let mut say = |(what, by, host, there): Row, why: &str| {
        if host != there {
            said.push(format!(
                "unit: {what}: {there} {by} on the unit, {host} {by} on this bench. {why}"
            ));
        }
    };
    // A limit is kept by both guards; what a guard is told of its hardware it expects the worst of.
    let lowest = "The lower counts: both guards must let a stimulus pass.";
    let highest = "The higher counts: a guard expects what heats more.";
    if let Some((own, there)) = current::control(&setup.bench.value).zip(unit.current) {
        let ppm = |control: &CurrentControl| u64::from(control.gain_ppm);
        let offset = |control: &CurrentControl| u64::from(control.offset.0);
        for row in [
            (
                "tolerance of a current that is set",
                "ppm",
                ppm(&own),
                ppm(&there),
            ),
            ("its offset", "mA", offset(&own), offset(&there)),
        ] {
            say(row, highest);
        }
    }
    lower.into_iter().for_each(|row| say(row, lowest));
    higher.into_iter().for_each(|row| say(row, highest));
    Ok(said)
}

fn limit_rows(host: &Limits, unit: &Hello) -> [Row; 15] {
    let unit = &unit.limits;
    let us = |d: palpate_core::units::Duration| d.as_micros();
    [
        (
            "longest pulse",
            "ns",
            host.pulse_width_ns,
            unit.pulse_width_ns,
        ),
        ("longest burst", "us", us(host.burst), us(unit.burst)),
        (
            "energy of a burst",
            "nJ",
            host.burst_energy_nj,
            unit.burst_energy_nj,
        ),
        ("wire over 1 s", "uW", host.wire_1s_uw, unit.wire_1s_uw),
        ("wire over 10 s", "uW", host.wire_10s_uw, unit.wire_10s_uw),
        (
            "fingertip over 1 s",
            "uW",
            host.fingertip_1s_uw,
            unit.fingertip_1s_uw,
        ),
        (
            "fingertip over 60 s",
            "uW",
            host.fingertip_60s_uw,
            unit.fingertip_60s_uw,
        ),
        ("hand over 60 s", "uW", host.hand_60s_uw, unit.hand_60s_uw),
        (
            "skin, mean",
            "millidegrees C",
            host.skin_mean_mc,
            unit.skin_mean_mc,
        ),
        (
            "skin, peak",
            "millidegrees C",
            host.skin_peak_mc,
            unit.skin_peak_mc,
        ),
        (
            "skin, deep",
            "millidegrees C",
            host.skin_deep_mc,
            unit.skin_deep_mc,
        ),
        (
            "dose, Omega",
            "millionths",
            host.dose_omega_ppm,
            unit.dose_omega_ppm,
        ),
        ("dose, CEM43", "ms", host.dose_cem43_ms, unit.dose_cem43_ms),
        ("age of a reading", "us", us(host.stale), us(unit.stale)),
        ("supply", "mA", host.supply.0.into(), unit.supply.0.into()),
    ]
}
