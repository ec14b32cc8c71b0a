//! Rows of heat by the geometry of a wire.

use alloc::string::ToString;

use super::*;
use crate::guard::limits::{HARD, Limits};
use crate::guard::table::{self, DECAYS};
use crate::guard::thermal::Budget;
use crate::guard::{Guard, Plant};
use crate::illusion::DisplayWire;
use crate::units::{Board, Channel, Duration, Instant, Point};

/// Rows of the final module's wire, which stand in the table as they are.
pub(in crate::guard) const SHALLOW: Decays = ROWS[3][1][0];
/// Its rows at 0.4 mm.
pub(in crate::guard) const DEEP: Decays = ROWS[3][1][1];

/// The budget of a final module's wire.
pub(in crate::guard) fn budget(limits: &Limits) -> Budget {
    Budget::new(limits, WornWire::default().kernel().unwrap())
}

fn worn(diameter_nm: u32, length_um: u32) -> WornWire {
    WornWire {
        diameter_nm,
        length_um,
        ..WornWire::default()
    }
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * (1.0 + b.abs()), "{a} is not {b}");
}

#[test]
fn a_wire_of_the_table_has_its_rows_to_the_bit() {
    let kernel = WornWire::default().kernel().unwrap();
    let expected = Kernel {
        rest_c: 33.0,
        shallow: SHALLOW,
        deep: DEEP,
    };
    assert_eq!(kernel, expected);
    for (n, nm) in DIAMETERS_NM.into_iter().enumerate() {
        assert_eq!(worn(nm, 5000).kernel().unwrap().shallow, ROWS[n][1][0]);
        let short = worn(nm, 3000).kernel().unwrap();
        for (found, rows) in [short.shallow, short.deep].iter().zip(&ROWS[n][2]) {
            for (found, row) in found.iter().zip(rows) {
                close(*found, row * 5.0 / 3.0);
            }
        }
    }
}

#[test]
fn between_wires_of_the_table_rows_lie_on_straight_lines() {
    // A quarter of the way from 75 to 87 um; sqrt 2 of 5 mm: half of what the ends of 5 mm take.
    let long = worn(78_000, 7_071);
    let over = 5000.0 / 7071.0;
    let half = over * over;
    let kernel = long.kernel().unwrap();
    for k in 0..DECAYS {
        for (depth, row) in [(0, &kernel.shallow), (1, &kernel.deep)] {
            let at = |n: usize| (1.0 - half) * ROWS[n][0][depth][k] + half * ROWS[n][1][depth][k];
            close(row[k], over * (0.75 * at(3) + 0.25 * at(4)));
        }
    }
    // Halfway between what the ends of 5 and of 3 mm take.
    let x: f64 = 1.0 + (25.0 / 9.0 - 1.0) / 2.0;
    let um = libm::round(5000.0 / libm::sqrt(x));
    let share = (5000.0 / um * (5000.0 / um) - 1.0) / (25.0 / 9.0 - 1.0);
    let kernel = worn(50_000, um as u32).kernel().unwrap();
    let [long, short] = [1, 2].map(|m: usize| ROWS[0][m][0]);
    for ((found, long), short) in kernel.shallow.iter().zip(long).zip(short) {
        let line = (1.0 - share) * long + share * short;
        close(*found, line * 5000.0 / um);
    }
}

#[test]
fn a_modelled_wire_is_known_to_the_nanometre() {
    let (wire, tissue) = (WireParameters::FINAL, TissueParameters::DEFAULT);
    assert_eq!(WornWire::new(&wire, &tissue), WornWire::default());
    let wire = WireParameters {
        diameter_m: 76.2e-6,
        length_m: 6.3504e-3,
        ..wire
    };
    let tissue = TissueParameters {
        body_c: 29.1,
        ..tissue
    };
    let expected = WornWire {
        diameter_nm: 76_200,
        length_um: 6_350,
        rest_mc: 29_100,
    };
    assert_eq!(WornWire::new(&wire, &tissue), expected);
    let none = WireParameters {
        diameter_m: f64::NAN,
        ..wire
    };
    let none = WornWire::new(&none, &tissue);
    assert_eq!(none.check(), Err(PlantError::Diameter));
}

#[test]
fn what_lies_outside_the_table_is_refused_with_its_range() {
    let of = |worn: WornWire| worn.kernel().err().map(|e| e.to_string());
    let other = |diameter_nm, length_um, rest_mc| {
        of(WornWire {
            diameter_nm,
            length_um,
            rest_mc,
        })
    };
    for (nm, um, mc) in [(50_000, 3_000, 26_000), (100_000, 20_000, 36_000)] {
        assert_eq!(other(nm, um, mc), None);
    }
    let diameter =
        "expected a wire of 50 to 100 um in diameter: the guard has rows of heat for no other";
    let length = "expected a wire of 3 to 20 mm in length: the guard has rows of heat for no other";
    let rest = "expected a finger of 26 to 36 C at rest: the guard has rows of heat for no other";
    for (nm, um, mc, why) in [
        (49_999, 5_000, 33_000, diameter),
        (100_001, 5_000, 33_000, diameter),
        (75_000, 2_999, 33_000, length),
        (75_000, 20_001, 33_000, length),
        (75_000, 5_000, 25_999, rest),
        (75_000, 5_000, 36_001, rest),
    ] {
        assert_eq!(other(nm, um, mc).as_deref(), Some(why));
    }
    // A guard without rows of heat needs no wire, and one that has them refuses it.
    let thick = worn(101_000, 5_000);
    let made = |worn| Guard::last_word(HARD, Plant::default(), &[], worn).err();
    assert_eq!(made(None), None);
    assert_eq!(made(Some(thick)), Some(PlantError::Diameter));
    let whole = Guard::new(HARD, Plant::default(), &[], thick);
    assert_eq!(whole.err(), Some(PlantError::Diameter));
}

#[test]
fn a_warmer_finger_leaves_less_by_as_much() {
    let room = |rest_mc| {
        let worn = WornWire {
            rest_mc,
            ..WornWire::default()
        };
        let guard = Guard::new(HARD, Plant::default(), &[wire()], worn);
        let guard = guard.unwrap();
        assert_eq!(guard.worn(), Some(worn));
        let rest_c = f64::from(rest_mc) * 1e-3;
        assert_eq!(guard.predicted().peak_c, rest_c);
        let at = Instant::from_micros(20_000_000);
        let until = at + Duration::from_millis(35);
        let [peak, _, deep, mean] = guard.rooms(0, at, until).unwrap();
        [peak.0, deep.0, mean.0]
    };
    let (cold, usual, warm) = (room(26_000), room(33_000), room(36_000));
    let limits_c = [43.0, 41.0, 41.0];
    for (n, limit_c) in limits_c.into_iter().enumerate() {
        let latent_k = [table::LATENT_K[0], table::LATENT_K[2], table::LATENT_K[1]][n];
        for (rest_c, room) in [(26.0, cold[n]), (36.0, warm[n])] {
            let expected = (limit_c - latent_k - rest_c) / (limit_c - latent_k - 33.0);
            close(room / usual[n], expected);
        }
    }
}

fn wire() -> DisplayWire {
    DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    }
}
