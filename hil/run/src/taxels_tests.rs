//! Tests of `taxels.rs`.

use super::*;
use crate::{Input, run};
use palpate_records::trace::{Event, event};

/// Where contacts were, by frame.
fn contacts(setup: &Setup, input: &Input) -> Vec<String> {
    let outcome = run(setup, input, 1).unwrap();
    let events = outcome.trace.events.into_iter();
    let contact = |event| match event {
        Event::Contact(event::Contact {
            frame,
            module,
            contact,
            place,
            intensity_milli,
            level,
            members,
            .. // a recording's times count from its first row
        }) => Some(format!(
            "{frame} {module} {contact} {place:?} {intensity_milli} {level} {members}"
        )),
        _ => None,
    };
    events.filter_map(contact).collect()
}

#[test]
fn a_replay_of_the_readings_finds_the_contacts_of_the_scene() {
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let tables = taxels(&setup, 1, |_| ()).unwrap();
    assert_eq!(tables.len(), 1);
    let replayed = contacts(&setup, &Input::tables(tables));
    assert_eq!(replayed, contacts(&setup, &Input::Scene));
}

/// Every module of a recording counts from its own first row, so the replay of a hand is not exact.
#[test]
fn a_hand_makes_one_table_per_module() {
    let setup = Setup::load("allegro-four-buses", "emulated").unwrap();
    let tables = taxels(&setup, 1, |_| ()).unwrap();
    assert_eq!(tables.len(), 15);
    for (table, module) in tables.iter().zip(&setup.sensor.value.modules) {
        assert_eq!(table.columns, 3 * module.readings(), "{}", module.name);
        assert_eq!(table.counts.len(), table.frames() * table.columns);
        assert!(
            table.time_us.windows(2).all(|t| t[0] < t[1]),
            "{}",
            module.name
        );
    }
}

/// What a summary does not need goes while the run goes on, and no figure changes.
#[test]
fn a_summary_is_the_same_without_the_trace() {
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let input = Input::tables(taxels(&setup, 1, |_| ()).unwrap());
    let summary = |summary| {
        let keep = crate::Keep {
            summary,
            ..crate::Keep::default()
        };
        let outcome = crate::run_with(&setup, &input, 1, keep, &mut ()).unwrap();
        (outcome.summary, outcome.trace.events.len())
    };
    let ((whole, events), (thin, fewer)) = (summary(false), summary(true));
    assert_eq!(whole, thin);
    assert!(fewer < events / 2, "{fewer} of {events}");
}
