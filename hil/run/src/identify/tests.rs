//! Traces that the emulator made, with hidden figures and noise.

use super::*;
use palpate_core::random::RandomStream;

/// Bursts of seven pulses at three currents; rows at every edge, and between them.
fn drive() -> Vec<(u64, f64)> {
    let mut rows = Vec::new();
    for burst in 0..4_u64 {
        let amps = [0.99, 1.97, 0.99, 1.4][burst as usize];
        for pulse in 0..7 {
            let start = burst * 120_000 + pulse * 5_079;
            rows.extend([(start, amps), (start + 62, amps)]);
            rows.extend([124, 400, 1_000, 2_500].map(|later| (start + later, 0.0)));
        }
    }
    rows
}

fn hidden(signal: Signal, s: &mut RandomStream) -> Subject {
    let between = |s: &mut RandomStream, low: f64, high: f64| low + (high - low) * s.uniform();
    let mut wire = WireParameters::FINAL;
    wire.bias_stress_pa = between(s, 4e6, 35e6);
    if signal == Signal::Displacement {
        wire.mechanics.transformation_strain = between(s, 0.002, 0.004);
        wire.r_phase = Some(RPhase {
            strain: between(s, 0.0005, 0.0018),
            ..RPhase::LOW
        });
        wire.mount.sag_m = between(s, 120e-6, 300e-6);
    }
    // A vibrometer's trace says nothing of it: it is measured before.
    if signal == Signal::Resistance {
        wire.austenite_ratio = between(s, 0.8, 0.95);
        wire.resistance_ohm = between(s, 1.7, 2.1);
    }
    Subject {
        wire,
        tissue: TissueParameters::DEFAULT,
        start_c: 33.0,
    }
}

fn assumed() -> Subject {
    Subject {
        wire: WireParameters::FINAL,
        tissue: TissueParameters::DEFAULT,
        start_c: 33.0,
    }
}

/// A trace with Gaussian noise.
fn trace(truth: &Subject, signal: Signal, noise: f64, s: &mut RandomStream) -> Vec<Sample> {
    let sample = |(time_us, amps)| Sample {
        time_us,
        value: 0.0,
        amps,
    };
    let mut samples: Vec<Sample> = drive().into_iter().map(sample).collect();
    let course = course(truth, signal, &samples).unwrap();
    for (sample, value) in samples.iter_mut().zip(course) {
        let from = if signal == Signal::Displacement {
            3.0
        } else {
            0.0
        };
        sample.value = value + noise * s.normal() + from;
    }
    samples
}

/// Each figure of a hidden wire, and whether it lies in its interval.
fn tried(signal: Signal, noise: f64, trial: u64) -> Vec<(&'static str, bool)> {
    let mut s = RandomStream::new(trial, "identify");
    let truth = hidden(signal, &mut s);
    let samples = trace(&truth, signal, noise, &mut s);
    let found = identify(&assumed(), signal, &samples).unwrap();
    assert!(
        (found.rms / noise - 1.0).abs() < 0.25,
        "trial {trial}: {found:?}"
    );
    let lies = |(figure, truth): (&Figure, &Unknown)| {
        let found = figure.found.unwrap();
        let lies = (found.value - truth.start).abs() <= found.half;
        (figure.name, lies)
    };
    let expected = unknowns(&truth, signal);
    found.figures.iter().zip(&expected).map(lies).collect()
}

/// How often each figure lies in its interval, of so many trials: half of them on a thread of their own.
fn covered(signal: Signal, noise: f64, trials: u64) -> Vec<(&'static str, f64)> {
    let half = |which: u64| {
        let own = (0..trials).filter(move |trial| trial % 2 == which);
        own.map(|trial| tried(signal, noise, trial))
            .collect::<Vec<_>>()
    };
    let all = std::thread::scope(|scope| {
        let other = scope.spawn(|| half(1));
        [half(0), other.join().unwrap()].concat()
    });
    let mut hits: Vec<(&'static str, f64)> = Vec::new();
    for trial in all {
        hits.resize(trial.len(), ("", 0.0));
        for (hit, (name, lies)) in hits.iter_mut().zip(trial) {
            *hit = (name, hit.1 + f64::from(u8::from(lies)) / trials as f64);
        }
    }
    println!("{signal:?}: {hits:.3?}");
    hits
}

/// The intervals hold as often as they say, for all figures of a signal together.
fn holds(signal: Signal, noise: f64) {
    let figures = covered(signal, noise, 100);
    let all = figures.iter().map(|f| f.1).sum::<f64>() / figures.len() as f64;
    assert!((0.9..=0.98).contains(&all), "{signal:?}: {all}");
    // Of 100 trials 95 +- 2.2 are expected of each.
    assert!(figures.iter().all(|f| f.1 > 0.88), "{figures:?}");
}

#[test]
fn hidden_figures_of_a_displacement_lie_in_their_intervals() {
    holds(Signal::Displacement, 0.05);
}

#[test]
fn hidden_figures_of_a_resistance_lie_in_their_intervals() {
    holds(Signal::Resistance, 0.002);
}

/// A taut wire that stays far below its bands says nothing about its transformation.
#[test]
fn what_a_trace_does_not_show_is_not_stated() {
    let mut s = RandomStream::new(1, "identify");
    let taut = Subject {
        wire: WireParameters::FINAL.taut(),
        ..assumed()
    };
    let mut samples = trace(&taut, Signal::Displacement, 0.05, &mut s);
    samples.truncate(40);
    let found = identify(&taut, Signal::Displacement, &samples).unwrap();
    let strain = &found.figures[2];
    assert_eq!((strain.name, strain.found), ("strain of martensite", None));
    assert!(found.figures[1].found.is_some(), "{found:?}");
}

#[test]
fn cut_off_samples_are_seen_and_rest_is_not_taken_for_them() {
    let mut s = RandomStream::new(1, "identify");
    let mut samples = trace(&assumed(), Signal::Displacement, 0.05, &mut s);
    assert_eq!(clipped(&samples), None);
    let at_rest = |sample: &mut Sample| sample.value = -1e3;
    samples.iter_mut().take(9).for_each(at_rest);
    assert_eq!(clipped(&samples), None);
    samples.iter_mut().for_each(|s| s.value = s.value.min(20.0));
    let (from, count) = clipped(&samples).unwrap();
    assert!(from > 9 && count >= CLIPPED, "{from} {count}");
}
