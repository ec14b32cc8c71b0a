//! Goldens a person can read: contact path and schedule of every scene, and a surface over force and speed, in
//! `fixtures/goldens`. They change only with a reason in the commit message.

use std::collections::BTreeSet;

use insta::Settings;
use palpate_files::{Setup, load_bench, load_scene};
use palpate_records::diff::{Tolerance, compare};
use palpate_records::story::{COLUMNS, GoldenKind, LINES, Story};
use palpate_records::trace::{Driven, Event};
use palpate_run::{Input, Outcome, run};

/// A shipped scene with the default seed, on the bench that ships for it. A golden has one display: a scene of several is that
/// of the finger that drives the default bench.
pub fn shipped(scene: &str) -> Outcome {
    let mut scene = load_scene(scene).unwrap();
    let mut bench = load_bench(scene.value.own_bench()).unwrap();
    if !bench.value.displays.is_empty() {
        scene.value.wants = None;
        bench = load_bench("emulated").unwrap();
    }
    let setup = Setup::join(scene, bench).unwrap();
    run(&setup, &Input::Scene, 1).unwrap()
}

pub(super) fn keep(name: &str, kind: &str, story: &Story) {
    let text = story.text();
    let read = Story::read(&text).unwrap();
    assert_eq!(
        read.text(),
        text,
        "{name} {kind}: a text is read as it is written"
    );
    assert_eq!(
        compare(story, &read, Tolerance::default())
            .iter()
            .find(|d| d.meaning),
        None
    );
    assert!(text.is_ascii(), "{name} {kind}: goldens are ASCII");
    assert!(text.lines().count() <= LINES && text.lines().all(|l| l.len() <= COLUMNS));
    let mut settings = Settings::clone_current();
    settings.set_snapshot_path("../../fixtures/goldens");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(format!("{name}.{kind}"), text));
}

fn check(scene: &str) {
    let trace = shipped(scene).trace;
    keep(scene, "contacts", &Story::contacts(&trace));
    keep(scene, "schedule", &Story::schedule(&trace));
    // What is printed of the ledger is what the events come to.
    let mut driven = Driven::default();
    for event in &trace.events {
        if let Event::Schedule(entry) = event {
            driven.add(entry);
        }
    }
    assert_eq!(trace.ledger.driven, driven, "{scene}");
}

/// A test a scene, so that they run side by side.
macro_rules! scenes {
    ($($test:ident $name:literal),+ $(,)?) => {
        $(#[test]
        fn $test() {
            check($name);
        })+

        #[test]
        fn every_scene_has_its_goldens() {
            let here: BTreeSet<&str> = [$($name),+].into();
            assert_eq!(here, palpate_fixtures::scene_names().collect());
        }
    };
}

scenes! {
    allegro_four_buses "allegro-four-buses",
    allegro_grasp "allegro-grasp",
    allegro_one_bus "allegro-one-bus",
    allegro_one_bus_overwrite "allegro-one-bus-overwrite",
    allegro_rubs "allegro-rubs",
    back_circle "back-circle",
    brush_strokes "brush-strokes",
    by_hand "by-hand",
    coils_circle "coils-circle",
    coins_along "coins-along",
    finger_flexes "finger-flexes",
    digit_circle "digit-circle",
    h1_follow "h1-follow",
    h1_patch "h1-patch",
    icub_patch_stroke "icub-patch-stroke",
    idle "idle",
    press_levels "press-levels",
    rest_between "rest-between",
    rest_in_cell "rest-in-cell",
    rest_on_wire "rest-on-wire",
    scattered_circle "scattered-circle",
    sphere_across "sphere-across",
    sphere_along "sphere-along",
    sphere_along_wifi "sphere-along-wifi",
    sphere_along_wood "sphere-along-wood",
    sphere_circle "sphere-circle",
    sphere_circle_sponge1 "sphere-circle-sponge1",
    sphere_diagonal "sphere-diagonal",
    sphere_rubs_sponge1 "sphere-rubs-sponge1",
    sphere_streamed "sphere-streamed",
    stuck_amplifier "stuck-amplifier",
    ten_fingers "ten-fingers",
    texture_cardboard "texture-cardboard",
    texture_catalogue "texture-catalogue",
    texture_handkerchief "texture-handkerchief",
    texture_shoe_sole "texture-shoe-sole",
    texture_sponge1 "texture-sponge1",
    texture_sponge2 "texture-sponge2",
    texture_towel "texture-towel",
    texture_wood "texture-wood",
    two_finger_press "two-finger-press",
    warm_materials "warm-materials",
    wifi_outage "wifi-outage",
}

/// One way across the pad, mm.
const TRAVERSE_MM: f64 = 14.1;

#[test]
fn a_surface_over_force_and_speed() {
    let base = Setup::load("sphere-along", "emulated").unwrap();
    let decimal = |value: f64| format!("{value:.3}");
    let mut points = Vec::new();
    let mut last = None;
    for force_n in [0.1, 0.2, 0.4, 0.8, 1.6] {
        for speed_mm_s in [2.0, 7.05, 28.2, 112.8] {
            let mut setup = base.clone();
            let touch = &mut setup.scene.value.touches[0];
            touch.force_n.mean = force_n;
            touch.force_n.amplitude = 0.0;
            touch.path.period_s = Some(2.0 * TRAVERSE_MM / speed_mm_s);
            let outcome = run(&setup, &Input::Scene, 1).unwrap();
            let figures = palpate_records::figures::figures(&outcome.trace);
            let duty = figures.iter().find(|f| f.name == "largest duty");
            let milli_percent = duty.and_then(|f| f.value).unwrap();
            let felt_mm = outcome.summary.felt_error_mm.rmse;
            points.push(vec![
                decimal(force_n),
                decimal(speed_mm_s),
                decimal(milli_percent as f64 / 1e3),
                decimal(outcome.trace.ledger.energy_uj as f64 / 1e3),
                felt_mm.map_or_else(|| "-".to_owned(), decimal),
                outcome.summary.limiter_events.to_string(),
            ]);
            last = Some(outcome.trace);
        }
    }
    let mut story = Story::begun(GoldenKind::Surface, &last.unwrap());
    story.table.rows = points;
    keep("sphere-along", "surface", &story);
}
