//! Textures on the wires, the whole way: emulated strokes through network, loop, guard and chip.

use palpate_files::Setup;
use palpate_records::trace::Event;
use palpate_run::{Input, Outcome, run};

fn played(setup: &Setup) -> Outcome {
    run(setup, &Input::Scene, 1).unwrap()
}

fn load(scene: &str) -> Setup {
    Setup::load(scene, "emulated").unwrap()
}

/// A moving contact, one traverse of the pad in so many seconds, whose texture asks for one f_PWM whatever it is.
fn moving(rate_hz: f64, traverse_s: f64) -> Setup {
    let mut setup = load("sphere-along-wood");
    let activation = &mut setup.texture.as_mut().unwrap().activation.value;
    activation.burst_rate_hz = palpate_files::Both {
        smooth: rate_hz,
        rough: rate_hz,
    };
    setup.scene.value.touches[0].path.period_s = Some(2.0 * traverse_s);
    // one who feels bursts of two pulses, too: of what is not felt there is no place
    setup.person = palpate_files::load_person("sensitive").unwrap();
    setup
}

/// Rising edges of a run for each onset with a texture on it, averaged: what is left of a burst's seven, times wires.
fn pulses_per_burst(outcome: &Outcome) -> f64 {
    let events = &outcome.trace.events;
    let first = events.iter().find_map(|e| match e {
        Event::Latent { t_us, .. } => Some(*t_us),
        _ => None,
    });
    let first = first.unwrap_or(u64::MAX);
    let channels = outcome.trace.header.wires.len();
    let mut bursts = vec![(0_u64, 0_u64, 0_u64); channels]; // last edge, bursts, pulses
    for event in events {
        if let Event::Edge {
            t_ns,
            channel,
            high: true,
            ..
        } = event
            && t_ns / 1000 > first
        {
            let (last, all, pulses) = &mut bursts[usize::from(*channel)];
            *all += u64::from(t_ns - *last >= 20_300_000);
            (*last, *pulses) = (*t_ns, *pulses + 1);
        }
    }
    let sum = bursts
        .iter()
        .fold((0, 0), |sum, b| (sum.0 + b.1, sum.1 + b.2));
    sum.1 as f64 / sum.0.max(1) as f64
}

const SURFACES: [&str; 8] = [
    "sponge1",
    "towel",
    "wood",
    "cardboard",
    "sponge2",
    "handkerchief",
    "catalogue",
    "shoe-sole",
];

/// Every texture scene drives wires, within every limit, and the guard has nothing to correct.
#[test]
fn strokes_reach_the_wires_within_the_limits() {
    for surface in SURFACES {
        let outcome = played(&load(&format!("texture-{surface}")));
        let summary = &outcome.summary;
        let texture = summary.texture.as_ref().unwrap();
        println!(
            "{surface:<13} {:>3} windows, roughness {:.2}, {:>4} pulses, {:>3} left out, {} limited, {:.1} mJ, skin {:.2} C",
            texture.windows,
            texture.roughness,
            summary.stimuli,
            texture.rested_pulses,
            summary.limiter_events,
            summary.energy_mj.unwrap(),
            summary.hottest_skin_c.unwrap(),
        );
        assert!(texture.windows >= 10, "{surface}: {}", texture.windows);
        assert!(summary.stimuli > 20, "{surface}: {}", summary.stimuli);
        assert_eq!(summary.limiter_events, 0, "{surface}");
        assert!(summary.margins.iter().all(|m| !m.over()), "{surface}");
    }
}

/// A scene without a texture section and the same with one that is not stroked give the same schedule.
#[test]
fn a_texture_that_nobody_strokes_changes_nothing() {
    let mut plain = load("sphere-along-wood");
    let mut silent = plain.clone();
    plain.scene.value.texture = None;
    // The spacing that a texture needs.
    plain.bench.value.drive.pwm_hz = Some(200.0);
    silent
        .scene
        .value
        .texture
        .as_mut()
        .unwrap()
        .strokes_s
        .clear();
    let (plain, silent) = (played(&plain), played(&silent));
    assert_eq!(plain.trace.events, silent.trace.events);
}

/// What the texture costs the felt path, and that its order is left at every speed of the contact. A slower contact
/// than these meets the guard's limits earlier for its texture (docs/texture.md).
#[test]
fn a_moving_contact_carries_its_texture() {
    for traverse_s in [2.0, 1.0, 0.5] {
        let mut plain = moving(200.0, traverse_s);
        plain.scene.value.texture = None;
        plain.bench.value.drive.pwm_hz = Some(200.0);
        let plain = played(&plain).summary.felt_error_mm.rmse.unwrap();
        let mut more = 0.0;
        for rate_hz in [66.0, 100.0, 133.0, 200.0] {
            let outcome = played(&moving(rate_hz, traverse_s));
            let pulses = pulses_per_burst(&outcome);
            let felt = outcome.summary.felt_error_mm.rmse.unwrap();
            println!(
                "{:.1} mm/s at {rate_hz} Hz: {pulses:.2} pulses a burst, felt {felt:.2} mm, {plain:.2} without",
                14.1 / traverse_s,
            );
            assert!(pulses > more + 0.5, "{traverse_s} s: {more} {pulses}");
            // A texture gives every wire the same pulses, and the counts by which the place is balanced go.
            assert!(felt < plain + 0.5, "{traverse_s} s: {plain} {felt}");
            more = pulses;
        }
    }
}

/// The same contact says where it is and what it is of: one module, its readings gathered for the network.
fn rubbing(surface: &str, traverse_s: f64) -> Setup {
    let mut setup = load("sphere-along-wood");
    let table = palpate_files::load_textures("thesis").unwrap().value;
    let entry = table.texture.into_iter().find(|t| t.name == surface);
    setup.texture.as_mut().unwrap().surface = entry;
    let scene = &mut setup.scene.value;
    // Friction drags the shear along: where the contact is, only the normal axis says.
    scene.compression.axes = palpate_core::skin::Axes::Z;
    let felt = scene.texture.as_mut().unwrap();
    felt.strokes_s.clear();
    (felt.module, felt.rubs) = (None, true);
    let touch = &mut scene.touches[0];
    touch.path.period_s = Some(2.0 * traverse_s);
    (touch.force_n.mean, touch.force_n.amplitude) = (3.0, 0.4);
    setup
}

/// Its place is felt as well as without, and what grips more is rougher, at every speed: of such a contact the network knows the
/// friction alone, which drives it.
#[test]
fn a_contact_that_rubs_carries_its_own_texture() {
    for traverse_s in [1.0, 0.5, 0.25] {
        let rubbed = |surface: &str| {
            let mut plain = rubbing(surface, traverse_s);
            plain.texture = None;
            plain.scene.value.texture = None;
            plain.bench.value.drive.pwm_hz = Some(200.0);
            let plain = played(&plain).summary.felt_error_mm.rmse.unwrap();
            let outcome = played(&rubbing(surface, traverse_s));
            let felt = outcome.summary.felt_error_mm.rmse.unwrap();
            let roughness = outcome.summary.texture.as_ref().unwrap().roughness;
            let pulses = pulses_per_burst(&outcome);
            println!(
                "{surface:<13} {:.0} mm/s: roughness {roughness:.3}, {pulses:.2} pulses a burst, felt {felt:.2} mm, {plain:.2} without",
                14.1 / traverse_s,
            );
            assert!(felt < plain + 0.5, "{surface}: {felt} {plain}");
            roughness
        };
        let all = SURFACES.map(|surface| (surface, rubbed(surface)));
        let of = |wanted: &[&str]| -> Vec<f64> {
            let some = all.iter().filter(|(surface, _)| wanted.contains(surface));
            some.map(|(_, roughness)| *roughness).collect()
        };
        let (grips, slides) = (
            of(&["handkerchief", "shoe-sole", "sponge1"]),
            of(&["wood", "cardboard", "catalogue"]),
        );
        let least = grips.into_iter().fold(f64::INFINITY, f64::min);
        let most = slides.into_iter().fold(0.0, f64::max);
        assert!(least > most, "{traverse_s} s: {least} {most}");
    }
}
