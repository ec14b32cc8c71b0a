//! Every output edge of the emulated PCA9685 against the guarded schedule: period, width, phase, tau_d
//! and SOA. The schedule is read from the trace, the edges come out of the chip's registers.

use palpate_files::{Overrides, Setup, load_bench, load_scene};
use palpate_records::trace::{Event, Trace, event};
use palpate_run::{Input, run};
use proptest::prelude::*;

/// One high phase of an output, nanoseconds.
#[derive(Debug)]
struct Pulse {
    channel: u8,
    rise: u64,
    fall: u64,
}

fn pulses(trace: &Trace) -> Vec<Pulse> {
    let mut high: [Option<u64>; 16] = [None; 16];
    let mut pulses = Vec::new();
    for event in &trace.events {
        if let Event::Edge(event::Edge {
            t_ns,
            channel,
            high: level,
            ..
        }) = *event
        {
            let slot = &mut high[usize::from(channel)];
            match (level, slot.take()) {
                (true, None) => *slot = Some(t_ns),
                (false, Some(rise)) => pulses.push(Pulse {
                    channel,
                    rise,
                    fall: t_ns,
                }),
                (level, was) => {
                    panic!("channel {channel} at {t_ns} ns: edge to {level} after {was:?}")
                }
            }
        }
    }
    assert!(
        high.iter().all(Option::is_none),
        "an output stays high after the end: {high:?}"
    );
    pulses
}

/// Checks every pulse of a trace. `period_ns` is the chip's true period.
fn edges_match_schedule(trace: &Trace, period_ns: f64) {
    let tick = period_ns / 4096.0;
    let (tau, soa) = (trace.header.tau_d_us * 1000, trace.header.soa_us * 1000);
    let entries: Vec<_> = trace
        .events
        .iter()
        .filter_map(|e| {
            if let Event::Schedule(entry) = e {
                Some(*entry)
            } else {
                None
            }
        })
        .collect();
    for entry in &entries {
        assert_eq!(
            entry.at.as_micros() * 1000 % soa,
            0,
            "onset off the SOA grid: {entry:?}"
        );
        let length = (entry.until.as_micros() - entry.at.as_micros()) * 1000;
        // Counted pulses: a channel goes off in the middle of the last one's period.
        let halves = (length as f64 / trace.header.pre_scale.period_ns() as f64) * 2.0;
        let counted = length < tau && (halves - halves.round()).abs() < 1e-3;
        if entry.reason.is_none() {
            assert!(length == tau || counted, "{entry:?}");
        }
    }
    let pulses = pulses(trace);
    // The counter starts with the first awake write and never stops; its phase is read off the first
    // pulse. A held counter (all off) starts anew with the next onset, so phases are per burst.
    for entry in entries.iter().filter(|e| e.width().get() > 0) {
        let at = entry.at.as_micros() * 1000;
        // The end of the run cuts what still lasts.
        let until = entry.until.as_micros().min(trace.ledger.length_us) * 1000;
        let mine: Vec<&Pulse> = pulses
            .iter()
            // Bus time and the rest of a period may pass before either end takes effect.
            .filter(|p| {
                p.channel == entry.channel.0
                    && p.rise >= at
                    && p.rise < until + 2 * period_ns as u64
            })
            .collect();
        let span = (until - at) as f64 / period_ns;
        let count = mine.len() as f64;
        assert!(
            count >= span.floor() - 1.0 && count <= span.floor() + 2.0,
            "{count} pulses in {span} periods: {entry:?}"
        );
        for pulse in &mine {
            let width = (pulse.fall - pulse.rise) as f64;
            let expected = f64::from(entry.width().get()) * tick;
            assert!(
                (width - expected).abs() <= 1.0,
                "width {width} ns, expected {expected}: {entry:?}"
            );
        }
        for pair in mine.windows(2) {
            let period = (pair[1].rise - pair[0].rise) as f64;
            assert!(
                (period - period_ns).abs() <= 1.0,
                "period {period} ns, expected {period_ns}"
            );
        }
        // Phase against every other wire of the same onset: the difference of their ON ticks.
        for other in entries
            .iter()
            .filter(|e| e.at == entry.at && e.width().get() > 0)
        {
            let theirs = pulses
                .iter()
                .find(|p| p.channel == other.channel.0 && p.rise >= at);
            let (Some(first), Some(theirs)) = (mine.first(), theirs) else {
                continue;
            };
            let measured = (theirs.rise as f64 - first.rise as f64).rem_euclid(period_ns);
            let expected =
                ((f64::from(other.on) - f64::from(entry.on)) * tick).rem_euclid(period_ns);
            let off = (measured - expected).abs();
            assert!(
                off.min(period_ns - off) <= 2.0,
                "phase {measured} ns, expected {expected}"
            );
        }
    }
    // And nothing else ever rises: every pulse belongs to an entry.
    for pulse in &pulses {
        let owner = entries.iter().any(|e| {
            let (at, until) = (e.at.as_micros() * 1000, e.until.as_micros() * 1000);
            e.channel.0 == pulse.channel
                && e.width().get() > 0
                && pulse.rise >= at
                && pulse.rise < until + 2 * period_ns as u64
        });
        assert!(owner, "a pulse that no stimulus scheduled: {pulse:?}");
    }
}

#[test]
fn shipped_scenes() {
    for scene in [
        "sphere-along",
        "sphere-across",
        "sphere-diagonal",
        "sphere-circle",
        "two-finger-press",
    ] {
        let trace = super::goldens::shipped(scene).trace;
        edges_match_schedule(&trace, trace.header.pre_scale.period_ns() as f64);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any stimulus length, prescale and oscillator, and a drive that the guard has to limit.
    #[test]
    fn any_timing_and_oscillator(
        tau in 6.0f64..50.0,
        hz in 150.0f64..400.0,
        oscillator in 0.92f64..1.096,
        current in 300.0f64..2300.0,
        seed in 0u64..1000,
    ) {
        let mut shorter = Overrides::default();
        shorter.scene("test", "illusion.model", "balanced");
        shorter.scene("test", "illusion.tau_d_ms", format!("{tau:.3}"));
        shorter.scene("test", "length_s", 3.0);
        shorter.scene("test", "touches[0].end_s", 3.0);
        let scene = load_scene("sphere-circle").unwrap().with(&shorter).unwrap();
        let mut bench = load_bench("emulated").unwrap();
        bench.value.drive.pwm_hz = Some(hz);
        bench.value.drive.oscillator = oscillator;
        bench.value.drive.current_ma = current;
        let setup = Setup::join(scene, bench).unwrap();
        let trace = run(&setup, &Input::Scene, seed).unwrap().trace;
        // The chip rounds its oscillator to a millihertz.
        let osc = (25e6 * oscillator * 1e3).round() * 1e-3;
        let period = 4096.0 * (f64::from(trace.header.pre_scale.get()) + 1.0) / osc * 1e9;
        edges_match_schedule(&trace, period);
    }
}
