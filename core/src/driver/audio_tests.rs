//! Tests of `audio.rs`: samples against the sine and envelope that they stand for.

use super::*;
use crate::guard::{Guard, HARD, MotorLimits, Plant};
use crate::illusion::DisplayWire;
use crate::schedule::Stimulus;
use crate::units::{Channel, Milliamps, Point, Ticks};
use alloc::string::ToString;
use alloc::vec;
use alloc::vec::Vec;

/// A sink that keeps all, and fails from a frame on.
#[derive(Default)]
struct Tape {
    samples: Vec<i16>,
    fails: Option<AudioFault>,
    restarts: u32,
}

impl AudioSink for Tape {
    fn latency(&self) -> u32 {
        480
    }

    fn restart(&mut self) -> Result<(), AudioFault> {
        self.restarts += 1;
        Ok(())
    }

    fn write(&mut self, samples: &[i16]) -> Result<(), AudioFault> {
        self.samples.extend(samples);
        self.fails.take().map_or(Ok(()), Err)
    }
}

fn plan() -> AudioPlan {
    AudioPlan {
        rate_hz: 48_000,
        sine_hz: 250.0,
        ramp: 96,
        full: 0.5,
        channels: vec![1, 0],
    }
}

fn started() -> Audio<Tape> {
    let mut audio = Audio::new(Tape::default(), plan()).unwrap();
    assert_eq!(audio.start(Instant::ZERO), Ok(Instant::ZERO));
    audio
}

const fn ms(n: u64) -> Instant {
    Instant::from_micros(1000 * n)
}

/// Updates of a guard: actuator 0 at a level between two times, and its end.
fn updates(width: u16, at: Instant, until: Instant) -> [GuardedVibration; 2] {
    let limits = MotorLimits {
        rated_v: 1.0,
        overdrive_v: 1.0,
        overdrive_s: 0.001,
        travel_um_v: 1.0,
        travel_um: 1000.0,
        rise_k_v2: 1.0,
        coil_s: 10.0,
        rise_k: 1000.0,
        burst: Duration::from_millis(500),
        duty: 1.0,
    };
    let place = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let places: Vec<_> = (0..2).map(place).collect();
    let mut guard = Guard::of_motors(HARD, limits, Plant::default(), &places).unwrap();
    guard.hear(at);
    let stimulus = Stimulus {
        wire: 0,
        width: Ticks::new(width),
        peak: Milliamps(0),
        at,
        until,
    };
    let on = guard.admit_vibration(at, Board(0), &[stimulus], |_| ());
    let off = guard.expire_vibration(until, Board(0));
    [on.unwrap(), off.unwrap()]
}

/// Samples of the channel of an actuator.
fn heard(audio: &Audio<Tape>, actuator: usize) -> Vec<i16> {
    let channel = usize::from(audio.plan.channels[actuator]);
    let samples = audio.sink.samples.iter();
    samples.skip(channel).step_by(2).copied().collect()
}

#[test]
fn a_burst_is_a_sine_under_a_trapezium_at_its_frames() {
    let mut audio = started();
    let [on, off] = updates(Ticks::PER_PERIOD, ms(10), ms(40));
    assert_eq!(on.levels()[0], Some(127));
    audio.apply(&on).unwrap();
    audio.apply(&off).unwrap();
    audio.render(ms(60));
    let found = heard(&audio, 0);
    assert_eq!(found.len(), 48 * 60);
    for (n, sample) in found.iter().enumerate() {
        let (rise, fall) = ((n as f64 - 479.0) / 96.0, (1920.0 + 95.0 - n as f64) / 96.0);
        let envelope = rise.min(fall).clamp(0.0, 1.0);
        let sine = (core::f64::consts::TAU * 250.0 * n as f64 / 48_000.0).sin();
        let wanted = 0.5 * 32767.0 * envelope * sine;
        assert!(
            (f64::from(*sample) - wanted).abs() < 1.01,
            "{n}: {sample} {wanted}"
        );
        assert!(f64::from(*sample).abs() <= 0.5 * 32767.0);
    }
    assert!(heard(&audio, 1).iter().all(|sample| *sample == 0));
}

#[test]
fn everything_is_silent_a_stated_number_of_frames_after_an_all_off() {
    let mut audio = started();
    audio
        .apply(&updates(Ticks::PER_PERIOD, ms(10), ms(400))[0])
        .unwrap();
    audio.render(ms(50));
    audio.all_off().unwrap();
    audio.render(ms(80));
    let found = heard(&audio, 0);
    let last = found.iter().rposition(|sample| *sample != 0).unwrap();
    assert!((48 * 50..48 * 50 + 96).contains(&last), "{last}");
    // The card's 480 frames on top: 12 ms.
    assert_eq!(audio.tail(), Duration::from_millis(12));
    assert_eq!(audio.confirmed(ms(50)), ms(62));
}

#[test]
fn levels_go_straight_from_one_to_the_next_and_cost_no_click() {
    let mut audio = started();
    let [half, _] = updates(Ticks::PER_PERIOD / 2, ms(0), ms(400));
    let [full, _] = updates(Ticks::PER_PERIOD, ms(20), ms(400));
    audio.apply(&half).unwrap();
    audio.apply(&full).unwrap();
    audio.render(ms(40));
    let found = heard(&audio, 0);
    let jumps = found
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).unsigned_abs());
    // The steepest of a full sine: 2 pi f / rate of its peak, and a step of the envelope.
    let steepest = 0.5 * 32767.0 * (core::f64::consts::TAU * 250.0 / 48_000.0 + 1.0 / 96.0);
    assert!(f64::from(jumps.max().unwrap()) <= steepest + 1.0);
    let peak = |frames: core::ops::Range<usize>| found[frames].iter().max().copied().unwrap();
    assert!(peak(48 * 10..48 * 20) < peak(48 * 30..48 * 40) / 2 + 100);
}

#[test]
fn a_fault_of_the_card_ends_every_envelope_and_a_start_begins_anew() {
    let mut audio = started();
    let [on, off] = updates(Ticks::PER_PERIOD, ms(10), ms(25));
    audio.apply(&on).unwrap();
    audio.sink.fails = Some(AudioFault::Underrun);
    audio.render(ms(20));
    assert_eq!(
        audio.verify(),
        Err(DriverError::Audio(AudioFault::Underrun))
    );
    assert_eq!(audio.all_off(), audio.verify());
    assert_eq!(audio.apply(&off), audio.verify());
    let before = audio.sink.samples.len();
    audio.render(ms(30));
    assert_eq!(audio.sink.samples.len(), before);
    assert_eq!(audio.start(ms(30)), Ok(ms(30)));
    assert_eq!((audio.verify(), audio.sink.restarts), (Ok(()), 2));
    audio.render(ms(40));
    let new = &audio.sink.samples[before..];
    assert!(new.len() == 2 * 480 && new.iter().all(|sample| *sample == 0));
}

#[test]
fn plans_that_cannot_be_are_refused_in_a_sentence() {
    let refused = |change: fn(&mut AudioPlan)| {
        let mut plan = plan();
        change(&mut plan);
        Audio::new(Tape::default(), plan).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused(|p| p.rate_hz = 0), AudioPlanError::NoRate);
    assert_eq!(
        refused(|p| p.sine_hz = 0.0),
        AudioPlanError::Sine(0.0, 48_000)
    );
    assert_eq!(
        refused(|p| p.sine_hz = 12_001.0),
        AudioPlanError::Sine(12_001.0, 48_000)
    );
    assert_eq!(refused(|p| p.full = 1.01), AudioPlanError::Level(1.01));
    assert!(matches!(
        refused(|p| p.full = f64::NAN),
        AudioPlanError::Level(_)
    ));
    assert_eq!(
        refused(|p| p.channels = vec![3, 3]),
        AudioPlanError::ChannelTwice(1, 3)
    );
    assert_eq!(
        refused(|p| p.channels = vec![32]),
        AudioPlanError::NoChannel(0, 32)
    );
    assert_eq!(refused(|p| p.channels.clear()), AudioPlanError::Count(0));
    let told = refused(|p| p.sine_hz = 20_000.0).to_string();
    assert_eq!(
        told,
        "a sine of 20000 Hz at 48000 samples per second, expected above 0 and at most 12000 Hz"
    );
}
