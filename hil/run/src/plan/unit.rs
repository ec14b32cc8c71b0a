//! Agreement of host and driver unit: the stricter of both, in every row.

use palpate_core::guard::{CurrentControl, Limits, Plant};
use palpate_core::illusion::DisplayWire;
use palpate_files::Setup;

use super::{current, guarded};
use crate::failure::Failure;

/// A row of limits or plant: its name, its unit, its values by the host and by the unit.
type Row = (&'static str, &'static str, u64, u64);

/// The names and units of [`Limits::rows`].
const LIMITS: [(&str, &str); 15] = [
    ("longest pulse", "ns"),
    ("longest burst", "us"),
    ("energy of a burst", "nJ"),
    ("wire over 1 s", "uW"),
    ("wire over 10 s", "uW"),
    ("fingertip over 1 s", "uW"),
    ("fingertip over 60 s", "uW"),
    ("hand over 60 s", "uW"),
    ("skin, mean", "millidegrees C"),
    ("skin, peak", "millidegrees C"),
    ("skin, deep", "millidegrees C"),
    ("dose, Omega", "millionths"),
    ("dose, CEM43", "ms"),
    ("age of a reading", "us"),
    ("supply", "mA"),
];

/// Limits and plant of the loop: the stricter of bench and unit; the bench's own where no unit was met.
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

/// Control of currents that host and unit agree on: the wider tolerance.
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

/// Differences of host and unit, a sentence each: the run goes by the stricter.
///
/// # Errors
/// [`Failure::Input`] for a bench that no guard can have.
pub fn differences(setup: &Setup) -> Result<Vec<String>, Failure> {
    let Some(unit) = &setup.unit else {
        return Ok(Vec::new());
    };
    let (limits, plant) = guarded(setup, Some(unit.plant.prescale))?;
    let rows = limits.rows().into_iter().zip(unit.limits.rows());
    let lower = LIMITS.into_iter().zip(rows);
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
    // Both guards keep a limit, so the lower value counts. Of its hardware a guard expects the worst.
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
    lower.for_each(|((what, by), (host, there))| say((what, by, host, there), lowest));
    higher.into_iter().for_each(|row| say(row, highest));
    Ok(said)
}
