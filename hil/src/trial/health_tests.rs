//! Tests of `health.rs`.

use super::*;
use palpate_files::{Setup, load_scene};
use palpate_records::trace::Event;
use palpate_run::{Input, run};

#[test]
fn every_shipped_scene_leaves_a_healthy_bench() {
    for name in palpate_fixtures::scene_names() {
        let own = load_scene(name).unwrap().value.own_bench().to_owned();
        let setup = Setup::load(name, &own).unwrap();
        let outcome = run(&setup, &Input::Scene, 1).unwrap();
        let wrong = after_emulated(&setup.scene.value, &outcome);
        assert_eq!(wrong, Vec::<String>::new(), "{name}");
    }
}

#[test]
fn an_output_that_stays_on_and_a_dead_taxel_are_told() {
    let setup = Setup::load("idle", "emulated").unwrap();
    let mut outcome = run(&setup, &Input::Scene, 1).unwrap();
    outcome.trace.events.push(Event::Edge(event::Edge {
        t_ns: u64::MAX,
        board: 0,
        channel: 3,
        high: true,
    }));
    outcome.summary.taxels.dead = 2;
    let wrong = after_emulated(&setup.scene.value, &outcome);
    assert_eq!(wrong, ["output 0:3 is still on", "2 taxels dead"]);
}
