//! Textures on the wires, the whole way: emulated strokes through network, loop, guard and chip.

use palpate_emulators::sensor::surface::{SurfaceTexture, spearman};
use palpate_files::{Setup, TextureEntry};
use palpate_records::trace::{Event, event};
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
        Event::Latent(event::Latent { t_us, .. }) => Some(*t_us),
        _ => None,
    });
    let first = first.unwrap_or(u64::MAX);
    let channels = outcome.trace.header.wires.len();
    let mut bursts = vec![(0_u64, 0_u64, 0_u64); channels]; // last edge, bursts, pulses
    for event in events {
        if let Event::Edge(event::Edge {
            t_ns,
            channel,
            high: true,
            ..
        }) = event
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

/// Every texture scene drives wires, within every limit, the guard has nothing to correct, and the typical person feels it on
/// the default bench.
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
        let onsets = &summary.onsets;
        assert!(!onsets.mostly_unfelt(), "{surface}: {onsets:?}");
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

/// The same contact says where it is and what it is of: one module, a turn of the pad in so many seconds.
fn rubbing(surface: TextureEntry, turn_s: f64) -> Setup {
    let mut setup = load("sphere-rubs-sponge1");
    setup.texture.as_mut().unwrap().surface = Some(surface);
    let touch = &mut setup.scene.value.touches[0];
    touch.path.period_s = Some(turn_s);
    setup
}

/// Materials in no table, every property drawn by itself.
fn drawn(count: usize) -> Vec<TextureEntry> {
    let table = palpate_files::load_textures("thesis").unwrap().value;
    let materials = palpate_texture::world::draw_unseen(count, 99);
    let entry = |m: SurfaceTexture| TextureEntry {
        name: m.name,
        stiffness_n_per_mm: m.stiffness_n_per_mm,
        relief_um: 1000.0 * m.relief_mm,
        wavelength_mm: m.wavelength_mm,
        octaves: m.octaves,
        friction: m.friction,
        ..table.texture[0].clone()
    };
    materials.into_iter().map(entry).collect()
}

/// Its place is felt as well as without, and what has more relief is rougher, as far as a contact of a few taxels can say: at
/// 10 mm/s half of the readings' rate is a ripple of 0.2 mm, and slow ones are gone with what is slow. PALPATE_MATERIALS says of how
/// many materials.
#[test]
fn a_contact_that_rubs_carries_its_own_texture() {
    let asked = std::env::var("PALPATE_MATERIALS").ok();
    let materials = drawn(asked.map_or(32, |count| count.parse().unwrap()));
    let relief: Vec<f64> = materials.iter().map(|m| m.relief_um).collect();
    for (turn_s, asked) in [(4.6, 0.4), (1.6, 0.65), (0.8, 0.65)] {
        let speed = 14.1 * core::f64::consts::PI / turn_s;
        let mut plain = rubbing(materials[0].clone(), turn_s);
        plain.texture = None;
        plain.scene.value.texture = None;
        plain.bench.value.drive.pwm_hz = Some(200.0);
        let plain = played(&plain).summary.felt_error_mm.rmse.unwrap();
        let rubbed = |surface: &TextureEntry| {
            let outcome = played(&rubbing(surface.clone(), turn_s));
            let felt = outcome.summary.felt_error_mm.rmse.unwrap();
            assert!(felt < plain + 0.5, "{}: {felt} {plain}", surface.name);
            let rough = outcome.summary.texture.as_ref().unwrap().roughness;
            (rough, pulses_per_burst(&outcome), felt)
        };
        let all: Vec<_> = materials.iter().map(rubbed).collect();
        let rough: Vec<f64> = all.iter().map(|of| of.0).collect();
        let pulses: Vec<f64> = all.iter().map(|of| -of.1).collect();
        let felt = all.iter().map(|of| of.2).fold(0.0, f64::max);
        let (told, shown) = (spearman(&rough, &relief), spearman(&pulses, &relief));
        println!(
            "{speed:.0} mm/s: rank correlation of relief with roughness {told:.2}, with pulses left out {shown:.2}, felt at most {felt:.2} mm, {plain:.2} without"
        );
        assert!(
            told > asked && shown > asked,
            "{speed} mm/s: {told} {shown}"
        );
    }
}
