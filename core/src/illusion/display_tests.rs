//! Tests of `display.rs`.

use super::*;

pub(crate) fn thimble() -> Display {
    let places = [
        (0.0, -14.25),
        (0.0, -4.75),
        (0.0, 4.75),
        (0.0, 14.25),
        (-11.0, -4.75),
        (-11.0, 4.75),
        (11.0, -4.75),
        (11.0, 4.75),
    ];
    let wires: Vec<DisplayWire> = places
        .iter()
        .zip(0..)
        .map(|(&(x, y), c)| DisplayWire {
            place: Point::new(x, y),
            board: Board(0),
            channel: Channel(c),
        })
        .collect();
    Display::new(&wires).unwrap()
}

/// Wires along x, in this order.
pub(crate) fn line(x: &[f32]) -> Display {
    let wire = |(&x, c): (&f32, u8)| DisplayWire {
        place: Point::new(x, 0.0),
        board: Board(0),
        channel: Channel(c),
    };
    let wires: Vec<DisplayWire> = x.iter().zip(0..).map(wire).collect();
    Display::new(&wires).unwrap()
}

#[test]
fn the_thimble_has_the_spacings_of_the_thesis() {
    let display = thimble();
    assert_eq!(display.spacing(), (11.0, 9.5));
    assert_eq!(display.hull().len(), 6);
}

#[test]
fn the_hull_leaves_the_empty_corners_out() {
    let display = thimble();
    assert!(display.contains(Point::new(0.0, 0.0), 0.0));
    assert!(display.contains(Point::new(11.0, 4.75), 0.0));
    assert!(!display.contains(Point::new(11.0, 14.25), 0.0));
    assert!(!display.contains(Point::new(0.0, 15.0), 0.5));
    assert!(display.contains(Point::new(0.0, 15.0), 0.8));
}

#[test]
fn wires_in_line_have_a_hull_without_area() {
    let display = line(&[-6.5, 0.0, 6.5]);
    assert_eq!(display.spacing(), (6.5, f32::INFINITY));
    assert!(display.contains(Point::new(3.0, 0.0), 1e-6));
    assert!(!display.contains(Point::new(3.0, 0.1), 0.01));
    assert!(!display.contains(Point::new(7.0, 0.0), 0.01));
}

#[test]
fn degenerate_arrays_are_refused_by_name() {
    let wire = |x: f32, c| DisplayWire {
        place: Point::new(x, 0.0),
        board: Board(0),
        channel: Channel(c),
    };
    assert_eq!(Display::new(&[]), Err(DisplayError::Empty));
    assert_eq!(
        Display::new(&[wire(0.0, 0), wire(0.0, 1)]),
        Err(DisplayError::Coincident(0, 1))
    );
    assert_eq!(
        Display::new(&[wire(0.0, 0), wire(1.0, 0)]),
        Err(DisplayError::SharedOutput(0, 1))
    );
    assert_eq!(
        Display::new(&[wire(f32::NAN, 0)]),
        Err(DisplayError::NotFinite(0))
    );
    assert_eq!(
        Display::new(&[wire(0.0, 16)]),
        Err(DisplayError::NoSuchOutput(0))
    );
}
