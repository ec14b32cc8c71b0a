//! Currents that are set, through whole runs: what records say, what reaches the wires, and what a broken converter ends.

use palpate_core::driver::{Actuators, Pca9685Bank};
use palpate_core::guard::{CurrentControl, Guard, HARD, Plant};
use palpate_core::illusion::DisplayWire;
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Instant, Milliamps, Point, Ticks};
use palpate_emulators::display::amplifier::supply::SupplySource;
use palpate_emulators::display::amplifier::{AmplifierConfig, SetError};
use palpate_emulators::display::i2c::BusClock;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayConfig, WirePlace, WornDisplay};
use palpate_files::load_bench;
use palpate_records::trace::Event;
use palpate_run::Outcome;

use super::faults::{outputs_are_off, try_on};

fn sphere(more: &str) -> Outcome {
    try_on(load_bench("set-current").unwrap(), "sphere-along", more).unwrap()
}

fn currents(outcome: &Outcome) -> Vec<Option<Milliamps>> {
    let events = outcome.trace.events.iter();
    let current = |event: &Event| match event {
        Event::Schedule(entry) => Some(entry.current),
        _ => None,
    };
    events.filter_map(current).collect()
}

#[test]
fn a_run_sets_currents_and_its_records_say_them() {
    let outcome = sphere("");
    let currents = currents(&outcome);
    assert!(!currents.is_empty());
    assert!(currents.iter().all(Option::is_some));
    let mut text = Vec::new();
    palpate_records::schedule::write_schedule(&outcome.trace, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    let set = text
        .lines()
        .skip(1)
        .filter(|l| l.contains("\"current_ma\""));
    assert_eq!(set.count(), currents.len());
    let wires = |_: &str| outcome.trace.header.wires.clone();
    let again = palpate_records::schedule::read_schedule(&text, wires).unwrap();
    let read = |event: &Event| match event {
        Event::Schedule(entry) => Some(entry.current),
        _ => None,
    };
    let read: Vec<_> = again.events.iter().filter_map(read).collect();
    assert_eq!(read, currents);
    assert!(outputs_are_off(&outcome));
}

#[test]
fn a_weak_level_has_less_current_and_no_narrower_pulse() {
    let outcome = sphere("");
    let entries = outcome.trace.events.iter().filter_map(|event| match event {
        Event::Schedule(entry) => Some(*entry),
        _ => None,
    });
    let entries: Vec<_> = entries.collect();
    let tick_ns = outcome.trace.header.pre_scale.tick_ns() as f64;
    let narrowest = (50e3 / tick_ns).round() as u16;
    let asked = entries.iter().map(|e| e.requested.get()).min();
    assert!(asked >= Some(narrowest), "{asked:?}, {narrowest}");
    let weaker = entries.iter().filter(|e| e.current < Some(Milliamps(1970)));
    let weaker = weaker.count();
    assert!(weaker > 0 && weaker < entries.len(), "{weaker}");
}

/// The power, W, in the only wire at full and at half the current, of amplifiers with this error.
fn watts(error: SetError, rise: Nanos) -> Vec<f64> {
    let parameters = WireParameters::default();
    let config = DisplayConfig {
        boards: vec![(0x40, 1.0)],
        converters: vec![0x48],
        wires: vec![WirePlace {
            at: Point::new(0.0, 0.0),
            board: 0,
            channel: 0,
        }],
        amplifier: AmplifierConfig {
            current: Milliamps(990),
            set: Some(error),
            rise,
            on_ohm: 0.0,
        },
        source: SupplySource {
            volts: f64::INFINITY,
            ohm: 0.0,
        },
        wire: parameters,
        tissue: TissueParameters::default(),
        clock: BusClock::Fast,
    };
    let mut display = WornDisplay::new(&config).unwrap();
    display.keep_flows();
    let wires = [DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    }];
    let control = CurrentControl {
        full_scale: Milliamps(990),
        gain_ppm: 20_000,
        offset: Milliamps(5),
    };
    let guard = Guard::new(HARD, Plant::default(), &wires).unwrap();
    let mut guard = guard.with_current(control).unwrap();
    let bank = Pca9685Bank::new(display.bus(), &[0x40], Plant::default().prescale);
    let mut bank = bank.with_converters(&[0x48], Milliamps(990));
    bank.start(Instant::ZERO).unwrap();
    let mut found = Vec::new();
    for (at_us, milliamps) in [(10_000, 990), (200_000, 495)] {
        let [at, until] = [at_us, at_us + 20_000].map(Instant::from_micros);
        display.advance(Nanos::from(at), &mut |_| ()).unwrap();
        guard.hear(at);
        let s = Stimulus {
            wire: 0,
            width: Ticks::new(80),
            peak: Milliamps(milliamps),
            at,
            until,
        };
        let update = guard.admit(at, Board(0), &[s], |_| ());
        bank.apply(&update).unwrap();
        guard.confirm(&update);
        display.advance(Nanos::from(until), &mut |_| ()).unwrap();
        bank.apply(&guard.expire(until, Board(0))).unwrap();
        let over = Nanos::from(until) + Nanos::from_micros(12_000);
        display.advance(over, &mut |_| ()).unwrap();
        let flows = display.take_flows();
        assert!(
            flows.len() >= 3
                && flows
                    .iter()
                    .all(|f| f.watts.to_bits() == flows[0].watts.to_bits())
        );
        found.push(flows[0].watts / parameters.resistance_ohm);
    }
    found
}

#[test]
fn what_heats_a_wire_goes_with_the_square_of_what_is_set_and_its_error() {
    let close = |found: &[f64], amps: [f64; 2]| {
        for (found, amps) in found.iter().zip(amps) {
            // A code of 4095 and a milliampere of the amplifier are all the rounding there is.
            assert!((found.sqrt() - amps).abs() < 0.0011, "{found} of {amps}");
        }
    };
    let exact = SetError {
        gain: 1.0,
        offset_ma: 0.0,
    };
    close(&watts(exact, Nanos::ZERO), [0.990, 0.495]);
    close(&watts(exact, Nanos::from_micros(20)), [0.990, 0.495]);
    let off = SetError {
        gain: 1.02,
        offset_ma: 5.0,
    };
    close(&watts(off, Nanos::ZERO), [1.0148, 0.5099]);
}
