//! Tests of `view.rs`.

use alloc::vec::Vec;

use super::*;

fn rect(half_width: f32, half_height: f32) -> Rect {
    Rect {
        min: Point::new(-half_width, -half_height),
        max: Point::new(half_width, half_height),
    }
}

fn contact(x: f32, y: f32, intensity: f32) -> Contact {
    Contact {
        id: 1,
        module: 0,
        place: Point::new(x, y),
        intensity,
        level: 1,
        members: 1,
        ..Contact::default()
    }
}

/// A window of 20 mm by 20 mm on a skin of 200 mm by 100 mm, shown on 10 mm by 10 mm.
fn view(hysteresis: f32) -> View {
    let window = Window {
        size: (20.0, 20.0),
        hysteresis,
    };
    View::following(window, rect(100.0, 50.0), rect(5.0, 5.0)).unwrap()
}

fn moves(view: &mut View, contacts: &[Contact]) -> bool {
    view.frame(contacts.iter())
}

#[test]
fn the_window_goes_to_what_is_outside_and_shows_it_in_the_middle() {
    let mut view = view(0.25);
    assert_eq!(view.map().apply(Point::default()), Point::default());
    assert!(!moves(&mut view, &[]), "nothing happens");
    assert!(!moves(&mut view, &[contact(9.9, -9.9, 1.0)]), "it is shown");
    assert!(moves(&mut view, &[contact(40.0, 20.0, 1.0)]));
    let shown = [40.0, 45.0, 49.0].map(|x| view.map().apply(Point::new(x, 20.0)).x);
    assert_eq!(shown, [0.0, 2.5, 4.5], "half the size");
    assert!(!view.map().shows(Point::default()));
}

#[test]
fn at_the_skins_edge_the_window_stays_on_it() {
    let mut view = view(0.0);
    assert!(moves(&mut view, &[contact(100.0, -50.0, 1.0)]));
    let corner = view.map().apply(Point::new(100.0, -50.0));
    assert!(corner.distance(Point::new(5.0, -5.0)) < 1e-4, "{corner:?}");
}

#[test]
fn it_moves_only_to_what_is_stronger_by_its_hysteresis() {
    let (near, far) = (contact(0.0, 0.0, 100.0), |i| contact(60.0, 0.0, i));
    let mut steady = view(0.25);
    let moved: Vec<bool> = [90.0, 110.0, 125.0, 126.0]
        .map(|i| moves(&mut steady, &[near, far(i)]))
        .into();
    assert_eq!(moved, [false, false, false, true]);
    // Back at equal strength it stays where it is.
    assert!(!moves(&mut steady, &[near, far(100.0)]));
    assert!(moves(&mut view(0.0), &[near, far(101.0)]));
}

#[test]
fn a_window_larger_than_the_skin_is_refused() {
    let window = Window {
        size: (201.0, 20.0),
        hysteresis: 0.25,
    };
    let view = View::following(window, rect(100.0, 50.0), rect(5.0, 5.0));
    assert_eq!(view.err(), Some(MapError::NotContained));
}
