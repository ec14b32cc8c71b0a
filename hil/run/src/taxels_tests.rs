//! Tests of `taxels.rs`.

use super::*;
use crate::{Input, run};
use palpate_records::trace::Event;

/// Where contacts were, by frame.
fn contacts(setup: &Setup, input: &Input) -> Vec<String> {
    let outcome = run(setup, input, 1).unwrap();
    let events = outcome.trace.events.into_iter();
    let contact = |event| match event {
        Event::Contact {
            frame,
            module,
            contact,
            place,
            intensity_milli,
            level,
            members,
            .. // a recording's times count from its first row
        } => Some(format!(
            "{frame} {module} {contact} {place:?} {intensity_milli} {level} {members}"
        )),
        _ => None,
    };
    events.filter_map(contact).collect()
}

#[test]
fn a_replay_of_the_readings_finds_the_contacts_of_the_scene() {
    for (scene, modules) in [("sphere-along", 1), ("allegro-four-buses", 15)] {
        let setup = Setup::load(scene, "emulated").unwrap();
        let tables = taxels(&setup, 1).unwrap();
        assert_eq!(tables.len(), modules);
        let replayed = contacts(&setup, &Input::Rows(tables));
        assert_eq!(replayed, contacts(&setup, &Input::Scene), "{scene}");
    }
}
