//! Calibration against the published bench, and draws that do not depend on their order.

use palpate_core::physics::{History, Mechanics, TissueParameters, WireParameters, WireState};
use palpate_emulators::person::channels::Person;
use palpate_files::{EvidenceDrive, load_evidence};

use super::weigh::{Visit, visit};
use super::*;

/// Bursts of the published rows: the first module's, the final one's.
fn drives() -> [EvidenceDrive; 2] {
    let rows = load_evidence("published").unwrap().value.row;
    [0, 1].map(|row: usize| rows[row].drive.clone().unwrap())
}

/// Stroke of the first module, and second visit of the final one, for a hypothesis about their wires.
fn published(change: impl Fn(&mut WireParameters)) -> (Visit, Visit) {
    let person = Person {
        vibration_um: 0.45,
        flutter_um: 5.0,
        np2_um: None,
        growth: [0.7, 1.0],
    };
    let played = |base: WireParameters, drive: &EvidenceDrive| {
        let mut wire = base;
        change(&mut wire);
        visit(&wire, &TissueParameters::DEFAULT, drive, person).unwrap()
    };
    let [first, second] = drives();
    (
        played(WireParameters::FIRST, &first),
        played(WireParameters::FINAL, &second),
    )
}

fn strain(strain: f64, sag_um: f64) -> impl Fn(&mut WireParameters) {
    move |wire| {
        wire.mechanics = Mechanics {
            transformation_strain: strain,
            ..wire.mechanics
        };
        wire.reversible = 0.02;
        wire.mount.sag_m = sag_um * 1e-6;
    }
}

#[test]
fn table() {
    for sag in [43.0, 100.0, 170.0] {
        let taut = published(|w| {
            *w = w.taut();
            w.mount.sag_m = sag * 1e-6;
        });
        println!("taut {sag}: {taut:?}");
        for eps in [0.01, 0.002, 0.001] {
            println!("loose {eps} {sag}: {:?}", published(strain(eps, sag)));
        }
        let passed = published(|w| {
            strain(0.01, sag)(w);
            w.history = History {
                state: WireState::Passed,
                sag_state: WireState::Passed,
                coldest_c: None,
            };
        });
        println!("passed {sag}: {passed:?}");
    }
}
