//! Strength, heat and limits of a wire design: one wire on a finger, the same burst again and again.
//!
//! A point of the design space is geometry, stress and drive. Its mean power is given, and the width of its pulses follows:
//! so points compare at equal heat. The wire is the exact model of every run, the person is every run's.

use palpate_core::guard::{BURST_GAP, HARD, WornWire};
use palpate_core::physics::{AIR_POWER, ParameterError, TissueParameters, WireParameters};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Levels, Perceiver, Person};
use palpate_emulators::time::Nanos;

/// A period of the PWM chip at PRE_SCALE 30, ns: pulses of a burst are as far apart.
const PERIOD_NS: u64 = 5_079_040;
/// Ratio of the slowest oscillator of a chip to the nominal one, by the guard: pulses are longer by it.
const SLOWEST: f64 = 25.0 / 23.0;
/// Seconds of the run, the last ones, in which the person feels the bursts. The second half is measured: by then the
/// leaky energy has forgotten the silence before.
const LISTENING_S: f64 = 2.0;

/// Pulses that a wire is driven with, burst after burst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulsePattern {
    /// Current of a pulse, A.
    pub amps: f64,
    /// Pulses of a burst, one per PWM period.
    pub pulses: u32,
    /// Time from burst to burst, s.
    pub cadence_s: f64,
    /// Mean electrical power, W: the width of a pulse follows from it.
    pub watts: f64,
}

impl PulsePattern {
    /// Width of a pulse through this resistance, s.
    pub fn width_s(&self, resistance_ohm: f64) -> f64 {
        let on = self.amps * self.amps * resistance_ohm * f64::from(self.pulses);
        self.watts * self.cadence_s / on
    }
}

/// Strength, temperatures and limits of a point of the design space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignOutcome {
    /// Resistance between the terminals, Ohm.
    pub resistance_ohm: f64,
    /// Width of a pulse, s.
    pub width_s: f64,
    /// Levels over the person's threshold in the last second.
    pub levels: Levels,
    /// Hottest wire, degrees C.
    pub wire_c: f64,
    /// Hottest tissue at 0.1 mm, on this finger and in the worst corner of the guard's range, degrees C.
    pub skin_c: [f64; 2],
    /// Reason why it is no design: the first row of the limit table that forbids it, or `bow` where the wire pulls its bow
    /// straighter than the model knows.
    pub excluded: Option<&'static str>,
}

/// Resizes a wire to another diameter and length. Resistivity and the resistance of crimps and leads stay; heat to
/// still air goes as a cylinder's (Morgan).
pub fn resized(wire: &WireParameters, diameter_m: f64, length_m: f64) -> WireParameters {
    let over = |d: f64, l: f64| l / (d * d);
    let inside = wire.resistance_ohm * wire.wire_share * over(diameter_m, length_m)
        / over(wire.diameter_m, wire.length_m);
    let resistance_ohm = wire.resistance_ohm * (1.0 - wire.wire_share) + inside;
    WireParameters {
        diameter_m,
        length_m,
        resistance_ohm,
        wire_share: inside / resistance_ohm,
        air_h: wire.air_h * libm::pow(diameter_m / wire.diameter_m, AIR_POWER),
        ..*wire
    }
}

/// The worst corner of the guard's parameter range for tissue over seconds (`docs/guard.md`): best contact, all the heat
/// in the wire, a wire that gives off late what it took, and the warmest finger.
fn worst(wire: &WireParameters, tissue: &TissueParameters) -> (WireParameters, TissueParameters) {
    let wire = WireParameters {
        wire_share: 1.0,
        specific_heat: 837.0,
        ..*wire
    };
    let guarded_c = f64::from(WornWire::default().rest_mc) / 1e3;
    let tissue = TissueParameters {
        contact_h: 10_000.0,
        contact_fraction: 0.5,
        body_c: tissue.body_c.max(guarded_c),
        ..*tissue
    };
    (wire, tissue)
}

/// Drives a wire for `seconds`, and has a person feel it.
///
/// # Errors
/// A parameter that cannot be computed with, by name.
pub fn outcome(
    wire: &WireParameters,
    tissue: &TissueParameters,
    pattern: &PulsePattern,
    person: Person,
    seconds: f64,
) -> Result<DesignOutcome, ParameterError> {
    let width_s = pattern.width_s(wire.resistance_ohm);
    let mut outcome = DesignOutcome {
        resistance_ohm: wire.resistance_ohm,
        width_s,
        levels: Levels::SILENT,
        wire_c: tissue.body_c,
        skin_c: [tissue.body_c; 2],
        excluded: forbidden(pattern, width_s, wire.resistance_ohm),
    };
    if width_s * 1e9 >= PERIOD_NS as f64 {
        return Ok(outcome); // on without end: there is no pulse to compute
    }
    let mut perceiver = Perceiver::new(person, &[(0.0, 0.0)])?;
    let mut worn = Wire::new(wire, tissue, tissue.body_c)?.worn(tissue)?;
    let mut end = drive(
        &mut worn,
        pattern,
        width_s,
        seconds - LISTENING_S,
        Nanos::ZERO,
    );
    worn.keep_stretches();
    for _ in 0..2 {
        perceiver.onset();
        end = drive(&mut worn, pattern, width_s, LISTENING_S / 2.0, end);
        worn.take_stretches(end, |stretch| perceiver.pass(0, stretch));
        perceiver.settle();
    }
    let peaks = worn.peaks(worn.now());
    let tight = worn.was_tight(worn.now());
    if let Some(felt) = perceiver.felt(peaks.shallow_c) {
        outcome.levels = felt.levels;
    }
    let (wire_there, tissue_there) = worst(wire, tissue);
    let mut hottest = Wire::new(&wire_there, &tissue_there, tissue_there.body_c)?;
    let end = drive(&mut hottest, pattern, width_s, seconds, Nanos::ZERO);
    outcome.wire_c = peaks.wire_c;
    outcome.skin_c = [peaks.shallow_c, hottest.peaks(end).shallow_c];
    let rows = [
        (
            "skin-peak",
            outcome.skin_c[1] * 1e3 > HARD.skin_peak_mc as f64,
        ),
        ("bow", tight),
        ("size", WornWire::new(wire, tissue).check().is_err()),
    ];
    outcome.excluded = outcome.excluded.or_else(|| first(&rows));
    Ok(outcome)
}

/// Drives bursts from `from` on, for `seconds` or one burst more. Returns the end.
fn drive(
    wire: &mut Wire,
    pattern: &PulsePattern,
    width_s: f64,
    seconds: f64,
    from: Nanos,
) -> Nanos {
    let nanos = |s: f64| libm::round(s * 1e9) as u64;
    let (width, cadence) = (nanos(width_s).max(1), nanos(pattern.cadence_s));
    let bursts = libm::ceil(seconds / pattern.cadence_s) as u64;
    for burst in 0..bursts {
        for pulse in 0..u64::from(pattern.pulses) {
            let at = from.0 + burst * cadence + pulse * PERIOD_NS;
            wire.set_current(Nanos(at), pattern.amps);
            wire.set_current(Nanos(at + width), 0.0);
        }
    }
    let end = Nanos(from.0 + bursts * cadence);
    wire.advance(end);
    end
}

/// The first row of the limit table that a pattern passes by itself, whatever the wire does.
fn forbidden(pattern: &PulsePattern, width_s: f64, resistance_ohm: f64) -> Option<&'static str> {
    let burst_s = f64::from(pattern.pulses.saturating_sub(1)) * PERIOD_NS as f64 / 1e9 + width_s;
    let burst_j =
        pattern.amps * pattern.amps * resistance_ohm * width_s * f64::from(pattern.pulses);
    let gap_s = BURST_GAP.as_micros() as f64 / 1e6;
    let rows = [
        (
            "pulse-width",
            width_s * SLOWEST * 1e9 > HARD.pulse_width_ns as f64,
        ),
        ("burst", burst_s * 1e6 > HARD.burst.as_micros() as f64),
        ("burst", burst_j * 1e9 > HARD.burst_energy_nj as f64),
        // bursts that come sooner are one to the guard
        ("burst", pattern.cadence_s - burst_s < gap_s),
        ("wire-power", pattern.watts * 1e6 > HARD.wire_10s_uw as f64),
    ];
    first(&rows)
}

fn first(rows: &[(&'static str, bool)]) -> Option<&'static str> {
    rows.iter().find(|row| row.1).map(|row| row.0)
}

/// Marks the points that no other beats: as strong or stronger at tissue as cool or cooler and as small a current or
/// smaller. Points that a limit forbids are left out.
pub fn undominated(points: &[(PulsePattern, DesignOutcome)]) -> Vec<bool> {
    let figures = |(pattern, of): &(PulsePattern, DesignOutcome)| {
        [of.levels.db(), -of.skin_c[1], -pattern.amps]
    };
    let allowed = |of: &DesignOutcome| of.excluded.is_none();
    let beaten = |point: &(PulsePattern, DesignOutcome)| {
        let own = figures(point);
        points.iter().filter(|p| allowed(&p.1)).any(|other| {
            let theirs = figures(other);
            let pairs = || theirs.iter().zip(&own);
            pairs().all(|(t, o)| t >= o) && pairs().any(|(t, o)| t > o)
        })
    };
    let best = |point: &(PulsePattern, DesignOutcome)| allowed(&point.1) && !beaten(point);
    points.iter().map(best).collect()
}

#[cfg(test)]
#[path = "design_tests.rs"]
mod tests;
