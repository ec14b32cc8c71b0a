//! Tests of `builder.rs`.

use alloc::vec::Vec;

use super::*;
use crate::illusion::DisplayWire;
use crate::units::{Board, Channel};

fn display(wires: u8) -> Display {
    let wire = |n: u8| DisplayWire {
        place: Point::new(10.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    Display::new(&(0..wires).map(wire).collect::<Vec<_>>()).unwrap()
}

fn layout() -> Layout {
    let pad = |name, x| {
        let pad = Module::grid(name, 4, 4, 4.7).unwrap();
        pad.with_origin(Point::new(x, 0.0)).unwrap()
    };
    Layout::new(alloc::vec![pad("a", -50.0), pad("b", 50.0)]).unwrap()
}

#[test]
fn nothing_has_to_be_stated() {
    let projector = Projector::builder(layout(), display(2)).build().unwrap();
    assert_eq!(projector.timing().duration.as_micros(), 35_000);
    assert_eq!(projector.timing().soa.as_micros(), 58_500);
    assert_eq!(projector.guard().limits(), &HARD);
    let edges = [-7.05, 7.05].map(|x| projector.map().apply(Point::new(x, 0.0)).x);
    assert!(edges[0].abs() < 1e-4 && (edges[1] - 10.0).abs() < 1e-4);
}

#[test]
fn the_area_is_the_driving_modules_or_the_whole_skins() {
    let module = sensor_area(&layout(), 1, Scope::Module);
    assert!((module.min.x + 7.05).abs() < 1e-4 && (module.max.x - 7.05).abs() < 1e-4);
    let skin = sensor_area(&layout(), 1, Scope::Skin);
    assert!((skin.min.x + 57.05).abs() < 1e-4 && (skin.max.x - 57.05).abs() < 1e-4);
}

#[test]
fn what_does_not_fit_is_refused() {
    let none = Projector::builder(layout(), display(2)).drives(2).build();
    assert!(matches!(none, Err(PlanError::NoSuchModule(2))));
    let outside = Rect {
        min: Point::new(-8.0, -1.0),
        max: Point::new(8.0, 1.0),
    };
    let area = Projector::builder(layout(), display(2))
        .area(outside)
        .build();
    assert!(matches!(area, Err(PlanError::Map(_))));
    let alone = Output::builder(display(1)).build();
    assert!(matches!(alone, Err(PlanError::Illusion(_))));
    let other = Output::builder(display(2)).calibration(Calibration::even(3));
    assert!(matches!(other.build(), Err(PlanError::Calibration(_))));
    let plant = Plant {
        wire_milliohm: 0,
        ..Plant::default()
    };
    let absurd = Output::builder(display(2)).plant(plant).build();
    assert!(matches!(absurd, Err(PlanError::Plant(_))));
}
