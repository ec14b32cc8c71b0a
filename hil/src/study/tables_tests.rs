//! Tests of `tables.rs`.

use palpate_files::{Source, Wearer, load_protocol};
use palpate_study::OfWire;

use super::*;

fn of_wire(wire: u16, value: f64) -> OfWire {
    OfWire {
        wire,
        estimate: Estimate {
            value,
            low: value - 2.0,
            high: value + 2.0,
        },
        levels: vec![(value, 1, 2)],
    }
}

fn participant(thresholds: Vec<OfWire>, matches: Vec<OfWire>) -> Participant {
    Participant {
        number: 4,
        complete: true,
        trials: 1,
        void: 0,
        thresholds,
        differences: Vec::new(),
        matches,
        answers: Vec::new(),
        drawings: Vec::new(),
    }
}

#[test]
fn a_wearers_file_reads_as_one_with_its_intervals() {
    let mut protocol = load_protocol("wearer").unwrap().value;
    protocol.matching.as_mut().unwrap().level_db = -6.0;
    let thresholds = (0..8)
        .map(|wire| of_wire(wire, -14.0 - f64::from(wire)))
        .collect();
    // The reference, wire 3, stands at -6 dB; wire 0 needs 4 dB more to feel alike.
    let levels = [-2.0, -6.0, -6.0, 0.0, -8.0, -8.0, -6.0, -6.0];
    let matches = [0, 1, 2, 4, 5, 6, 7].map(|wire| of_wire(wire, levels[usize::from(wire)]));
    let text = wearer(&protocol, &participant(thresholds, matches.to_vec()), 8).unwrap();
    let wearer = Wearer::read(&Source::new("w.toml", text)).unwrap();
    assert!((wearer.gain[0] - 1.0).abs() < 1e-12);
    assert!((wearer.gain[3] - 0.631).abs() < 1e-3, "{:?}", wearer.gain);
    assert!((wearer.gain[4] - 0.501).abs() < 1e-3, "{:?}", wearer.gain);
    assert!(
        (wearer.threshold[0] - 0.1995).abs() < 1e-3,
        "{:?}",
        wearer.threshold
    );
    let [low, high] = wearer.threshold_interval.unwrap()[0];
    assert!(low < wearer.threshold[0] && wearer.threshold[0] < high);
    assert_eq!(wearer.gain_interval.unwrap().len(), 8);
}

#[test]
fn a_threshold_over_full_drive_stays_below_the_gain() {
    let protocol = load_protocol("thresholds").unwrap().value;
    let thresholds = (0..8).map(|wire| of_wire(wire, 0.0)).collect();
    let text = wearer(&protocol, &participant(thresholds, Vec::new()), 8).unwrap();
    let wearer = Wearer::read(&Source::new("w.toml", text)).unwrap();
    assert!(
        wearer
            .threshold
            .iter()
            .zip(&wearer.gain)
            .all(|(t, g)| t < g)
    );
}

#[test]
fn without_every_threshold_there_is_no_wearer() {
    let protocol = load_protocol("wearer").unwrap().value;
    assert_eq!(
        wearer(
            &protocol,
            &participant(vec![of_wire(0, -9.0)], Vec::new()),
            8
        ),
        None
    );
}
