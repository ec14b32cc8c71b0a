//! Currents that are set, through whole runs: what records say, what reaches the wires, and what a broken converter ends.

use palpate_core::driver::{Actuators, Pca9685Bank};
use palpate_core::guard::{CurrentControl, Guard, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Instant, Milliamps, Point, Ticks};
use palpate_emulators::display::amplifier::supply::SupplySource;
use palpate_emulators::display::amplifier::{AmplifierConfig, SetError};
use palpate_emulators::display::i2c::BusClock;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayConfig, WirePlace, WornDisplay};
use palpate_files::{Bench, Loaded, Setup, Source, load_bench, load_scene};
use palpate_records::trace::{Event, event};
use palpate_run::{Input, Outcome, run};

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
    let weaker = entries.iter().filter(|e| e.current < Some(Milliamps(1200)));
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
    let guard = Guard::new(HARD, Plant::default(), &wires, WornWire::default()).unwrap();
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
        guard.confirm(&update, update.at());
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

/// A fault of a converter while the sphere rolls.
fn broken(kind: &str, more: &str) -> String {
    format!("[[faults]]\nat_s = 1.2\nkind = \"{kind}\"\n{more}\n")
}

/// Seconds of every edge that goes high.
fn rises(outcome: &Outcome) -> Vec<f64> {
    let rise = |event: &Event| match event {
        Event::Edge(event::Edge { t_ns, high, .. }) if *high => Some(*t_ns as f64 * 1e-9),
        _ => None,
    };
    outcome.trace.events.iter().filter_map(rise).collect()
}

fn noted(outcome: &Outcome, words: &str) -> bool {
    let has = |event: &Event| matches!(event, Event::Note(event::Note { text, .. }) if text.contains(words));
    outcome.trace.events.iter().any(has)
}

#[test]
fn a_converter_that_is_dead_switches_the_outputs_off_until_it_answers() {
    let outcome = sphere(&broken("converter-dead", "board = 0\nuntil_s = 1.3"));
    assert!(noted(&outcome, "actuators: board 0: I2C NoAcknowledge"));
    let rises = rises(&outcome);
    // A burst goes on that had begun; the next one finds no answer. A bus that stays silent for 100 ms would end the run.
    let dead = rises.iter().filter(|t| (1.26..1.3).contains(*t));
    assert_eq!(dead.count(), 0);
    assert!(rises.iter().any(|t| *t < 1.2) && rises.iter().any(|t| *t > 1.4));
    assert!(outputs_are_off(&outcome));
    // For good: the run ends, with everything off.
    let outcome = sphere(&broken("converter-dead", "board = 0"));
    assert!(outcome.failure.is_some());
    assert!(outputs_are_off(&outcome));
    let last = outcome.trace.ledger.length_us as f64 * 1e-6;
    assert!((1.25..1.6).contains(&last), "{last}");
}

#[test]
fn a_converter_that_holds_another_code_gives_no_pulse() {
    // Of all wires: one that is not touched is not looked at before a pulse.
    let all = |kind: &str, more: &str| -> String {
        let each = (0..8).map(|wire| broken(kind, &format!("wire = {wire}\n{more}")));
        each.collect()
    };
    for (kind, faults) in [
        (
            "converter-brown-out",
            broken("converter-brown-out", "board = 0"),
        ),
        ("converter-flipped", all("converter-flipped", "")),
    ] {
        let outcome = sphere(&faults);
        assert!(noted(&outcome, "the converter of output"), "{kind}");
        assert!(outcome.failure.is_none(), "{kind}");
        assert!(outputs_are_off(&outcome), "{kind}");
        assert!(rises(&outcome).iter().any(|t| *t > 1.4), "{kind}");
        // Whatever is wrong with a code, no wire gets more than what was booked.
        let over = outcome.trace.ledger.margins.iter().filter(|m| m.over());
        assert_eq!(
            over.count(),
            0,
            "{kind}: {:?}",
            outcome.trace.ledger.margins
        );
    }
}

#[test]
fn a_converter_that_keeps_its_codes_ends_the_run_with_everything_off() {
    let each = (0..8).map(|wire| broken("converter-stuck", &format!("wire = {wire}")));
    let outcome = sphere(&each.collect::<String>());
    assert!(noted(&outcome, "the converter of output"));
    assert!(outcome.failure.is_some());
    assert!(outputs_are_off(&outcome));
    let over = outcome.trace.ledger.margins.iter().filter(|m| m.over());
    assert_eq!(over.count(), 0, "{:?}", outcome.trace.ledger.margins);
}

#[test]
fn a_fault_of_a_converter_wants_one() {
    let refused = try_on(
        load_bench("emulated").unwrap(),
        "sphere-along",
        &broken("converter-dead", "board = 0"),
    );
    let words = "expected a bench with [dac]: there is no converter to fail";
    assert!(refused.unwrap_err().contains(words));
}

#[test]
fn on_a_driver_unit_a_converter_that_fails_stops_the_unit_itself() {
    let on_unit =
        |more: &str| try_on(load_bench("unit-whole").unwrap(), "sphere-along", more).unwrap();
    let whole = on_unit("");
    let report = whole.summary.unit.unwrap();
    assert_eq!((report.stops, report.sessions), (0, 1), "{report:?}");
    assert!(report.begun > 50, "{report:?}");
    assert!(outputs_are_off(&whole));
    let faults = broken("converter-dead", "board = 0\nuntil_s = 1.5");
    let outcome = on_unit(&faults);
    assert!(noted(
        &outcome,
        "unit: stopped by its own guard, actuator-error"
    ));
    let rises = rises(&outcome);
    assert_eq!(rises.iter().filter(|t| (1.35..1.5).contains(*t)).count(), 0);
    assert!(rises.iter().any(|t| *t > 1.6));
    assert!(outputs_are_off(&outcome));
}

/// The hand `allegro-hand` with these displays and converters.
fn hand(displays: &[(&str, &str, u8, u8, std::ops::Range<u8>)], addresses: &str) -> Outcome {
    let bench = load_bench("allegro-hand").unwrap();
    let display =
        |(name, layout, bus, board, channels): &(&str, &str, u8, u8, std::ops::Range<u8>)| {
            let output = |c| format!("{{ bus = {bus}, board = {board:#04x}, channel = {c} }}");
            let outputs: Vec<String> = channels.clone().map(output).collect();
            format!(
                "[[displays]]\nname = \"{name}\"\nlayout = \"{layout}\"\noutputs = [{}]\n",
                outputs.join(", ")
            )
        };
    let text = bench.source.text();
    let head = &text[..text.find("[[displays]]").unwrap()];
    let displays: Vec<String> = displays.iter().map(display).collect();
    let text = format!(
        "{head}{}[dac]\naddresses = [{addresses}]\n",
        displays.concat()
    )
    .replace(
        "drive.current_ma = 1200.0",
        "drive.current_ma = 1200.0\ndrive.supply_limit_ma = 9000.0\ndrive.soa_ms = 125.0",
    );
    let source = Source::new("bench.toml", text);
    let value = Bench::read(&source).unwrap();
    let bench = Loaded { value, source };
    let setup = Setup::join(load_scene("allegro-grasp").unwrap(), bench).unwrap();
    run(&setup, &Input::Scene, 1).unwrap()
}

#[test]
fn fingers_of_a_hand_set_currents_of_their_own_also_on_one_board() {
    let whole = "thimble-8";
    let apart = [
        ("index", whole, 0, 0x40, 0..8),
        ("middle", whole, 0, 0x41, 0..8),
        ("ring", whole, 1, 0x40, 0..8),
        ("thumb", whole, 1, 0x41, 0..8),
    ];
    let three = "three-in-line";
    let together = [
        ("index", three, 0, 0x40, 0..3),
        ("middle", three, 0, 0x40, 3..6),
        ("ring", three, 1, 0x40, 0..3),
        ("thumb", three, 1, 0x40, 3..6),
    ];
    for (name, outcome) in [
        ("a board each", hand(&apart, "0x48, 0x49, 0x48, 0x49")),
        ("two on a board", hand(&together, "0x48, 0x48")),
    ] {
        let set = currents(&outcome);
        assert!(set.len() > 50 && set.iter().all(Option::is_some), "{name}");
        assert!(outcome.failure.is_none(), "{name}: {:?}", outcome.failure);
        assert!(outputs_are_off(&outcome), "{name}");
        let over = outcome.trace.ledger.margins.iter().filter(|m| m.over());
        assert_eq!(over.count(), 0, "{name}");
        assert!(!noted(&outcome, "actuators:"), "{name}");
        let edges = rises(&outcome);
        assert!(edges.len() > 200, "{name}: {}", edges.len());
    }
}
