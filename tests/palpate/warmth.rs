//! Warmth through whole runs: what a material is felt as, what a broken sensor or bridge ends, and what a warm face leaves
//! the wires.

use palpate_core::peltier::LIMITS;
use palpate_files::{Loaded, Overrides, Scene, Setup, Source, load_bench, load_scene};
use palpate_records::margin::Limited;
use palpate_records::trace::{Event, event};
use palpate_run::{Input, Outcome, run};

use super::faults::{outputs_are_off, try_on};
use super::goldens::shipped;

/// Time, face, aim, sink in degrees C, and current in mA, of every record of the module.
fn faces(outcome: &Outcome) -> Vec<(f64, f64, Option<f64>, i32)> {
    let milli = |mc: i32| f64::from(mc) * 1e-3;
    let events = outcome.trace.events.iter();
    events
        .filter_map(|event| match event {
            Event::Face(event::Face {
                t_us,
                face_mc,
                aim_mc,
                milliamps,
                ..
            }) => Some((
                *t_us as f64 * 1e-6,
                milli(*face_mc),
                aim_mc.map(milli),
                *milliamps,
            )),
            _ => None,
        })
        .collect()
}

fn face_at(outcome: &Outcome, t_s: f64) -> f64 {
    let faces = faces(outcome);
    faces.iter().rfind(|f| f.0 <= t_s).unwrap().1
}

fn told(outcome: &Outcome, words: &str) -> Option<f64> {
    outcome.trace.events.iter().find_map(|event| match event {
        Event::Note(event::Note { t_us, text }) if text.contains(words) => {
            Some(*t_us as f64 * 1e-6)
        }
        _ => None,
    })
}

/// The sphere of four seconds on the bench `warm`, with faults and materials.
fn sphere(more: &str) -> Result<Outcome, String> {
    try_on(load_bench("warm").unwrap(), "sphere-along", more)
}

const METAL: &str = "[[materials]]\nstart_s = 1.0\nmaterial = \"metal\"\n";

/// Each material of `warm-materials` brings the face to where skin and it meet, within every limit.
fn meets_each_material(outcome: &Outcome) {
    let felt = [(3.9, 31.9), (7.9, 31.0), (11.9, 27.6), (15.9, 23.5)];
    for (t_s, celsius) in felt {
        let face_c = face_at(outcome, t_s);
        assert!(
            (face_c - celsius).abs() < 0.5,
            "{t_s} s: {face_c}, expected {celsius}"
        );
    }
    assert!(face_at(outcome, 21.9) > 35.0);
    let over = outcome.trace.ledger.margins.iter().filter(|m| m.over());
    assert_eq!(over.count(), 0, "{:?}", outcome.trace.ledger.margins);
}

#[test]
fn a_material_is_felt_where_skin_and_it_meet() {
    let outcome = shipped("warm-materials");
    meets_each_material(&outcome);
    let heat = outcome.summary.heat.unwrap();
    assert!(
        heat.error_k.unwrap() < 0.3 && heat.stops == 0 && !heat.thermostat,
        "{heat:?}"
    );
}

#[test]
fn a_warm_face_weakens_the_wires_and_a_cold_one_does_not_strengthen_them() {
    let stimuli = |more: &str| {
        let outcome = sphere(more).unwrap();
        let widths = outcome.trace.events.iter().filter_map(|event| match event {
            Event::Schedule(entry) => Some(u64::from(entry.width().get())),
            _ => None,
        });
        widths.sum::<u64>()
    };
    let rest = stimuli("");
    let cold = stimuli(METAL);
    let warm = stimuli(&format!("{METAL}object_c = 40.0\n"));
    assert!(cold <= rest && rest > 0);
    assert!(warm < rest * 9 / 10, "{warm} of {rest}");
}

#[test]
fn a_broken_sensor_switches_the_module_off_and_a_good_one_on_again() {
    for (kind, word, within_s) in [
        ("face-sensor-open", "sensor-open", 0.02),
        ("face-sensor-short", "sensor-short", 0.02),
        ("face-sensor-stale", "sensor-stale", 0.12),
    ] {
        let fault = format!("{METAL}[[faults]]\nat_s = 2.0\nuntil_s = 2.5\nkind = \"{kind}\"\n");
        let outcome = sphere(&fault).unwrap();
        let off = told(&outcome, &format!("Peltier module off: {word}")).unwrap();
        assert!((2.0..2.0 + within_s).contains(&off), "{kind}: off at {off}");
        let on = told(&outcome, "Peltier module on again").unwrap();
        assert!((3.5..3.55).contains(&on), "{kind}: on at {on}");
        let without = faces(&outcome)
            .into_iter()
            .filter(|f| f.0 > off && f.0 < on);
        assert!(without.clone().count() > 10);
        assert!(
            without.into_iter().all(|f| f.2.is_none() && f.3 == 0),
            "{kind}"
        );
        assert_eq!(outcome.summary.heat.unwrap().stops, 1);
        assert!(outputs_are_off(&outcome));
    }
}

#[test]
fn the_thermostat_ends_what_no_program_can() {
    let outcome = sphere("[[faults]]\nat_s = 0.5\nkind = \"bridge-shorted\"\n").unwrap();
    let cut = told(&outcome, "cut by its thermostat").unwrap();
    let margin = outcome.trace.ledger.margin(Limited::FaceWarm).unwrap();
    assert!(
        margin.over() && margin.worst() < LIMITS.thermostat_c + 0.05,
        "{margin:?}"
    );
    assert!(faces(&outcome).iter().all(|f| f.0 <= cut || f.3 == 0));
}

#[test]
fn a_bench_without_a_module_takes_no_notice_of_warmth() {
    let bench = || load_bench("emulated").unwrap();
    let fault = format!("{METAL}[[faults]]\nat_s = 1.0\nkind = \"face-sensor-open\"\n");
    let (plain, warm) = (
        try_on(bench(), "sphere-along", ""),
        try_on(bench(), "sphere-along", &fault),
    );
    let (plain, warm) = (plain.unwrap(), warm.unwrap());
    assert_eq!(plain.trace.ledger, warm.trace.ledger);
    assert_eq!((warm.summary.heat, faces(&warm).len()), (None, 0));
    assert_eq!(warm.summary.faults[0].count, 0);
}

/// `warm-materials` on a driver unit that regulates the module itself.
fn on_unit(more: &str) -> Outcome {
    let scene = palpate_fixtures::scene("warm-materials").unwrap();
    let source = Source::new("scene.toml", format!("{scene}\n{more}"));
    let value = Scene::read(&source).unwrap();
    let bench = load_bench("unit-whole").unwrap();
    let setup = Setup::join(Loaded { value, source }, bench).unwrap();
    run(&setup, &Input::Scene, 1).unwrap()
}

#[test]
fn a_driver_unit_regulates_its_module_within_the_same_limits() {
    let outcome = on_unit("");
    meets_each_material(&outcome);
    let heat = outcome.summary.heat.unwrap();
    assert!(
        heat.error_k.unwrap() < 0.5 && heat.stops == 0 && !heat.thermostat,
        "{heat:?}"
    );
    let unit = outcome.summary.unit.unwrap();
    assert_eq!((unit.stops, unit.sessions), (0, 1), "{unit:?}");
    assert!(unit.begun > 200, "{unit:?}");
    // The host's guard knows of the face, so that the unit's has next to nothing to change.
    assert!(unit.limited * 50 < unit.begun, "{unit:?}");
}

#[test]
fn a_units_module_is_off_without_a_host_and_without_its_sensor() {
    let metal = "[[faults]]\nat_s = 14.5\nuntil_s = 15.5\nkind = \"link-outage\"\n";
    let outcome = on_unit(metal);
    let quiet: Vec<_> = faces(&outcome)
        .into_iter()
        .filter(|f| (14.7..15.4).contains(&f.0))
        .collect();
    assert!(quiet.iter().all(|f| f.3 == 0), "{quiet:?}");
    assert!(faces(&outcome).iter().any(|f| f.0 > 15.6 && f.3 != 0));
    for (kind, word) in [
        ("face-sensor-open", "sensor-open"),
        ("face-sensor-short", "sensor-short"),
        ("face-sensor-stale", "sensor-stale"),
    ] {
        let fault = format!("[[faults]]\nat_s = 14.0\nuntil_s = 14.5\nkind = \"{kind}\"\n");
        let outcome = on_unit(&fault);
        let off = told(&outcome, &format!("Peltier module off: {word}")).unwrap();
        // The unit switches off at once; the host hears of it behind the network.
        assert!((14.0..14.3).contains(&off), "{kind}: off at {off}");
        let on = told(&outcome, "Peltier module on again").unwrap();
        assert!((15.5..15.8).contains(&on), "{kind}: on at {on}");
        let without = faces(&outcome).into_iter();
        let without: Vec<_> = without.filter(|f| f.0 > off && f.0 < 15.4).collect();
        assert!(
            without.len() > 8 && without.iter().all(|f| f.3 == 0),
            "{kind}"
        );
        assert_eq!(outcome.summary.heat.unwrap().stops, 1, "{kind}");
    }
}

#[test]
fn a_unit_without_thermal_rows_makes_no_face_warmer_than_skin() {
    let scene = load_scene("warm-materials").unwrap();
    let mut rows = Overrides::default();
    rows.bench("test", "unit.heat", false);
    let bench = load_bench("unit-whole").unwrap().with(&rows).unwrap();
    let setup = Setup::join(scene, bench).unwrap();
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    let heat = outcome.summary.heat.unwrap();
    assert!(heat.warmest_face_c < 33.1, "{heat:?}");
    assert!(heat.coldest_face_c < 24.0, "{heat:?}");
    let unit = outcome.summary.unit.unwrap();
    assert_eq!(unit.stops, 0, "{unit:?}");
}
