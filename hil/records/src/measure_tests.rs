//! Tests of `measure.rs`.

use super::*;
use crate::synthetic;

#[test]
fn errors_take_the_nearest_contact_of_the_same_scan() {
    let mut trace = synthetic::empty();
    let contact = |t_us, x| {
        Event::Contact(event::Contact {
            t_us,
            frame: 0,
            module: 0,
            contact: 1,
            place: PlaceUm { x, y: 0 },
            intensity_milli: 0,
            level: 1,
            members: 1,
        })
    };
    let truth = |t_us| {
        Event::Truth(event::Truth {
            t_us,
            place: PlaceUm { x: 0, y: 4_000 },
            force_mn: 1,
        })
    };
    trace.events = vec![
        truth(10),
        contact(10, 3_000),
        contact(10, 90_000),
        truth(20),
        contact(30, 0),
    ];
    let expected = Errors {
        rmse_um: 5_000,
        max_um: 5_000,
        count: 1,
    };
    assert_eq!(path_error(&trace), Some(expected));
    assert_eq!(path_error(&synthetic::empty()), None);
}
