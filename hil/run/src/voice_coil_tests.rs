//! Voice coils from a bench file to samples and what is felt of them: whole runs, their limits and their faults.

use palpate_files::{Bench, Loaded, Overrides, Scene, Source};
use palpate_records::verdict::Verdict;

use super::*;
use crate::{Input, Outcome, run_with};

/// A run on `voice-coil-8` with these changes, and what its card played.
fn ran(setup: &Setup) -> Outcome {
    let keep = Keep {
        audio: true,
        ..Keep::default()
    };
    run_with(setup, &Input::Scene, 1, keep, &mut ()).unwrap()
}

fn setup() -> Setup {
    Setup::load("sphere-along", "voice-coil-8").unwrap()
}

fn with(changes: &[&str]) -> Setup {
    let mut overrides = Overrides::default();
    for change in changes {
        overrides.set("--set", change).unwrap();
    }
    setup().with(&overrides).unwrap()
}

#[test]
fn a_scene_is_felt_where_it_touches_and_no_limit_is_passed() {
    let outcome = ran(&setup());
    let summary = &outcome.summary;
    let conclusion = &summary.conclusion;
    assert_eq!(conclusion.verdict, Verdict::Ok, "{conclusion:?}");
    let error = summary.felt_error_mm.rmse.unwrap();
    assert!(error < 0.7, "{error}");
    let level = summary.felt.level_db.as_ref().unwrap();
    assert!(level.p5 > 20.0, "{level:?}");
    assert!(summary.margins.len() == 3 && summary.margins.iter().all(|m| !m.over()));
    let report = summary.motors.as_ref().unwrap();
    assert_eq!(report.kind, "voice-coil");
    assert!(
        report.face_um > 2.0 && report.coil_rise_k > 0.0,
        "{report:?}"
    );
    assert_eq!(summary.limiter_events, 0);
}

/// Frames of a channel.
fn channel(sound: &Sound, channel: usize) -> Vec<i16> {
    let samples = sound.samples.iter().skip(channel);
    samples.step_by(sound.channels).copied().collect()
}

#[test]
fn the_card_plays_what_the_schedule_says() {
    let outcome = ran(&setup());
    let sound = outcome.sound.as_ref().unwrap();
    assert_eq!((sound.rate_hz, sound.channels), (48_000, 8));
    // As long as the run, and the silence after it.
    let seconds = sound.samples.len() as f64 / (8.0 * 48_000.0);
    assert!((seconds - 10.2).abs() < 0.01, "{seconds}");
    let per_level = 0.3 * std::f64::consts::SQRT_2 / 2.0 * 32767.0 / 4096.0;
    let mut heard = 0;
    for event in &outcome.trace.events {
        let Event::Schedule(entry) = event else {
            continue;
        };
        let samples = channel(sound, usize::from(entry.channel.0));
        // 10 ms of buffer after the onset, and 4 ms of ramp.
        let frame = |at: Instant| ((at.as_micros() + 14_000) * 48 / 1000) as usize;
        let burst = &samples[frame(entry.at)..frame(entry.until) - 192];
        let peak = burst.iter().map(|s| s.unsigned_abs()).max().unwrap_or(0);
        let wanted = per_level * f64::from(entry.off);
        assert!(
            f64::from(peak) <= wanted + 1.0,
            "{entry:?}: {peak} {wanted}"
        );
        // A level has 127 steps.
        assert!(
            f64::from(peak) > wanted - 33.0 * per_level - 4.0,
            "{entry:?}: {peak} {wanted}"
        );
        heard += u32::from(peak > 0);
    }
    assert!(heard > 400, "{heard}");
}

#[test]
fn channels_are_those_that_the_bench_states() {
    let moved = ran(&with(&["bench.haptics.audio.channels=[7,6,5,4,3,2,1,0]"]));
    let plain = ran(&setup());
    let (moved, plain) = (moved.sound.unwrap(), plain.sound.unwrap());
    for own in 0..8 {
        assert!(channel(&moved, own) == channel(&plain, 7 - own), "{own}");
    }
    assert!(plain.samples.iter().any(|sample| *sample != 0));
}

#[test]
fn limits_of_motors_hold_behind_the_guard() {
    let bound = ran(&with(&["bench.haptics.travel_um=10"]));
    let summary = &bound.summary;
    assert!(summary.limiter_events > 0);
    assert!(
        summary.margins.iter().all(|m| !m.over()),
        "{:?}",
        summary.margins
    );
}

/// A run with a fault of this kind and these keys from 3 s on.
fn faulty(lines: &str) -> Outcome {
    let scene = setup().scene.source.text().to_owned();
    let faults = format!("{scene}\n[[faults]]\nat_s = 3.0\n{lines}\n");
    let source = Source::new("s.toml", faults);
    let value = Scene::read(&source).unwrap();
    let bench = palpate_files::load_bench("voice-coil-8").unwrap();
    ran(&Setup::join(Loaded { value, source }, bench).unwrap())
}

#[test]
fn a_coil_that_does_not_move_is_missed_where_it_is() {
    let whole = ran(&setup()).summary.felt_error_mm.rmse.unwrap();
    for kind in ["motor-open", "motor-stuck"] {
        let summary = faulty(&format!("kind = \"{kind}\"\nmotor = 1")).summary;
        let error = summary.felt_error_mm.rmse.unwrap();
        assert!(error > whole + 0.5, "{kind}: {error} {whole}");
    }
}

#[test]
fn a_covered_coil_shows_in_its_margin() {
    let rise = |outcome: &Outcome| outcome.summary.motors.as_ref().unwrap().coil_rise_k;
    let (whole, hot) = (ran(&setup()), faulty("kind = \"coil-hot\"\nmotor = 1"));
    assert!(
        rise(&hot) > 3.0 * rise(&whole),
        "{} {}",
        rise(&hot),
        rise(&whole)
    );
}

#[test]
fn a_card_that_runs_dry_is_silent_and_begins_anew() {
    let outcome = faulty("kind = \"audio-underrun\"");
    assert!(outcome.failure.is_none(), "{:?}", outcome.failure);
    let notes = format!("{:?}", outcome.trace.events);
    assert!(notes.contains("it ran out of samples"), "no note");
    let sound = outcome.sound.as_ref().unwrap();
    let frames = |ms: usize| 8 * 48 * ms;
    let is_silent = |from: usize, to: usize| sound.samples[from..to].iter().all(|s| *s == 0);
    assert!(is_silent(frames(3001), frames(3010)));
    assert!(!is_silent(frames(3300), frames(4000)));
}

#[test]
fn a_card_that_takes_nothing_ends_the_run_in_silence() {
    let outcome = faulty("kind = \"audio-stalled\"");
    let failure = outcome.failure.map(|f| f.to_string()).unwrap_or_default();
    assert!(failure.contains("it takes no more samples"), "{failure}");
    assert!(outcome.summary.sim_s < 4.0, "{}", outcome.summary.sim_s);
    let sound = outcome.sound.unwrap();
    assert!(
        sound.samples[8 * 48 * 3001..]
            .iter()
            .all(|sample| *sample == 0)
    );
    // One that stalls for a moment goes on.
    let brief = faulty("until_s = 3.05\nkind = \"audio-stalled\"");
    assert!(brief.failure.is_none(), "{:?}", brief.failure);
}

#[test]
fn faults_of_another_plant_are_refused() {
    for (bench, kind, wanted) in [
        ("voice-coil-8", "i2c-stuck", "there is no I2C bus"),
        (
            "voice-coil-8",
            "driver-hot\"\nmotor = \"1",
            "there is no I2C bus",
        ),
        ("lra-8", "audio-underrun", "there is no sound card"),
        ("emulated", "audio-underrun", "there is no motor to fail"),
    ] {
        let scene = setup().scene.source.text().to_owned();
        let text = format!("{scene}\n[[faults]]\nat_s = 3.0\nkind = \"{kind}\"\n");
        let source = Source::new("s.toml", text.replace("\"1\"", "1"));
        let value = Scene::read(&source).unwrap();
        let bench = palpate_files::load_bench(bench).unwrap();
        let refused = Setup::join(Loaded { value, source }, bench)
            .unwrap_err()
            .to_string();
        assert!(refused.contains(wanted), "{kind}: {refused}");
    }
}

/// Refusals of a bench of voice coils with these lines.
fn refused(lines: &str) -> String {
    let text = format!("name = \"mine\"\ndescription = \"d\"\n[haptics]\n{lines}");
    let bench = Bench::read(&Source::new("b.toml", text));
    bench.unwrap_err().to_string()
}

#[test]
fn benches_that_cannot_be_are_refused_in_a_sentence() {
    let coils = "kind = \"voice-coil\"\n";
    let table = [
        (
            "[haptics.audio]\nrate_hz = 0\n",
            "b.toml:6: haptics.audio.rate_hz: expected",
        ),
        (
            "[haptics.audio]\nfull_scale_v = 0.0\n",
            "b.toml:6: haptics.audio.full_scale_v: expected",
        ),
        (
            "[haptics.audio]\nfull_scale_v = 0.1\n",
            "the peak of haptics.full_v",
        ),
        (
            "[haptics.audio]\nchannels = [0, 1, 2, 3, 4, 5, 6, 6]\n",
            "b.toml:6: haptics.audio.channels[7]: expected a channel of its own: coil 6 has this channel",
        ),
        ("[haptics.audio]\nchannels = [0]\n", "expected 8 channels"),
        (
            "overdrive_v = 2.0\n",
            "b.toml:5: haptics.overdrive_v: expected nothing of DRV2605L drivers",
        ),
    ];
    for (lines, wanted) in table {
        let found = refused(&format!("{coils}{lines}"));
        assert!(found.contains(wanted), "{lines}: {found}");
    }
    let mixed = refused("kind = \"lra\"\n[haptics.audio]\nsine_hz = 200.0\n");
    assert!(
        mixed.contains("no sound card beside DRV2605L drivers"),
        "{mixed}"
    );
}
