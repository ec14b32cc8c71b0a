//! An Allegro hand through the whole loop: what one CAN bus makes of it, and what four do.

use std::collections::BTreeSet;

use palpate_files::Setup;
use palpate_records::trace::{Event, event};
use palpate_run::{Input, Summary, run};

fn summary(scene: &str) -> Summary {
    let setup = Setup::load(scene, "emulated").unwrap();
    run(&setup, &Input::Scene, 1).unwrap().summary
}

#[test]
fn on_one_bus_waiting_boards_bring_every_taxel_to_31_to_36_hz() {
    let s = summary("allegro-one-bus");
    assert_eq!((s.boards.len(), s.buses.len()), (15, 1));
    for b in &s.boards {
        let in_range = |hz: f64| (31.0..=36.0).contains(&hz);
        assert!(in_range(b.rate_hz.min) && in_range(b.rate_hz.max), "{b:?}");
        assert!(b.readings % 16 < 16 && b.loss < 1e-3, "{b:?}");
    }
    assert!(s.buses[0].load > 0.9, "{:?}", s.buses[0]);
    // A scan is one frame of the loop however far apart its readings come.
    assert!((140..=160).contains(&s.frames), "{}", s.frames);
}

#[test]
fn on_one_bus_overwriting_boards_starve_the_high_identifiers() {
    let s = summary("allegro-one-bus-overwrite");
    assert!(s.buses[0].load > 0.99, "{:?}", s.buses[0]);
    for b in &s.boards {
        assert!(b.rate_hz.max > 99.0 && b.rate_hz.min < 1.0, "{b:?}");
    }
    // Rows 2 and 3 of every pad, and what row 1 cannot get through.
    assert!(s.taxels.dead >= 120, "{:?}", s.taxels);
}

#[test]
fn on_four_buses_every_taxel_keeps_100_hz_at_74_percent_load() {
    let s = summary("allegro-four-buses");
    for b in &s.boards {
        let in_range = |hz: f64| (99.0..=101.0).contains(&hz);
        assert!(in_range(b.rate_hz.min) && in_range(b.rate_hz.max), "{b:?}");
    }
    let fullest = s.buses.iter().map(|b| b.load).fold(0.0, f64::max);
    assert!((0.72..0.77).contains(&fullest), "{fullest}");
    assert_eq!((s.taxels.dead, s.taxels.frozen), (0, 0));
    assert!(s.path_error_mm.unwrap().rmse < 0.5);
}

#[test]
fn a_grasp_is_felt_on_each_of_the_four_fingertips_within_the_limits() {
    let mut setup = Setup::load("allegro-grasp", "emulated").unwrap();
    for tip in [0, 4, 8, 12] {
        setup.scene.value.drives = tip;
        let outcome = run(&setup, &Input::Scene, 1).unwrap();
        let s = outcome.summary;
        assert_eq!(
            (s.limiter_events, s.felt.breaks),
            (0, Some(0)),
            "module {tip}"
        );
        assert!(s.path_error_mm.unwrap().rmse < 0.5, "module {tip}");
        assert!(s.margins.iter().all(|m| m.used() < 1.0), "module {tip}");
        let touched = outcome.trace.events.iter().filter_map(|event| match event {
            Event::Contact(event::Contact { module, .. }) => Some(*module),
            _ => None,
        });
        let touched: BTreeSet<u16> = touched.collect();
        assert_eq!(touched.len(), 15, "{touched:?}");
    }
}
