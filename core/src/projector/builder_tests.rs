//! Tests of `builder.rs`.

use alloc::vec::Vec;

use super::*;
use crate::illusion::{DisplayWire, TimingLaw};
use crate::units::{Board, Channel, Ticks};

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
    assert_eq!(projector.timing().duration.as_micros(), 38_092);
    assert_eq!(projector.timing().soa.as_micros(), 117_000);
    // The width at which the default bench's wire is felt most.
    assert_eq!(projector.width(1.0), Ticks::new(41));
    assert_eq!(projector.guard().limits(), &HARD);
    let edges = [-7.05, 7.05].map(|x| projector.map().apply(Point::new(x, 0.0)).x);
    assert!(edges[0].abs() < 1e-4 && (edges[1] - 10.0).abs() < 1e-4);
}

#[test]
fn a_plant_of_ones_own_is_linear_unless_its_response_is_stated() {
    let plant = Plant::default();
    let output = || Output::builder(display(2)).plant(plant);
    let linear = output().build().unwrap();
    let widest = linear.guard().widest();
    let full = Response::linear(widest).largest();
    assert!((f32::from(linear.width(1.0).get()) - full).abs() <= 0.5);
    // As many pulses of 5 ms as last 30 ms.
    assert_eq!(linear.timing().duration.as_micros(), 33_013);
    let stated = output().response(Response::between(&[(0, 0.0), (10, 1.0)]));
    assert_eq!(stated.build().unwrap().width(1.0), Ticks::new(10));
}

#[test]
fn a_published_law_has_no_renderer() {
    let timing = TimingLaw::default().timing(None, None).unwrap();
    let law = build(&display(2), &ModelSettings::default()).unwrap();
    let published = Output::builder(display(2)).illusion(law, timing).build();
    let published = published.unwrap();
    assert!(published.renderer().is_none());
    assert_eq!(published.timing(), timing);
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
    // Two pulses 42 ms apart are longer than any burst.
    let plant = Plant {
        prescale: Prescale::new(255),
        ..Plant::default()
    };
    let slow = Output::builder(display(2)).plant(plant).build();
    assert!(matches!(slow, Err(PlanError::Pattern(_))));
}
