//! Rows of heat by the geometry of a wire.

use alloc::string::ToString;

use super::*;
use crate::guard::decays::RATES;
use crate::guard::dose::{Dose, Doses};
use crate::guard::limits::{HARD, Limits};
use crate::guard::table::{DECAYS, LATENT_K};
use crate::guard::thermal::{Budget, Heat, Tissue};
use crate::guard::used::Used;
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
        length_m: 6.3506e-3,
        ..wire
    };
    let tissue = TissueParameters {
        body_c: 29.1,
        ..tissue
    };
    let expected = WornWire {
        diameter_nm: 76_200,
        length_um: 6_351,
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
        let latent_k = [LATENT_K[0], LATENT_K[2], LATENT_K[1]][n];
        for (rest_c, room) in [(26.0, cold[n]), (36.0, warm[n])] {
            let expected = (limit_c - latent_k - rest_c) / (limit_c - latent_k - 33.0);
            close(room / usual[n], expected);
        }
    }
}

/// Rows twice as large for energies half as large are the same to the bit, so every figure is of the kernel's own rows.
#[test]
fn every_prediction_is_by_the_rows_of_the_wire() {
    let once = WornWire::default().kernel().unwrap();
    let twice = Kernel {
        shallow: once.shallow.map(|c| 2.0 * c),
        deep: once.deep.map(|c| 2.0 * c),
        ..once
    };
    let [mut whole, mut half] = [once, twice].map(|kernel| Budget::new(&HARD, kernel));
    let [mut a, mut b] = [(); 2].map(|()| Tissue::new(33.0));
    let doubled = |rooms: [(f64, _); 4]| rooms.map(|(j, row)| (2.0 * j, row));
    let mut at = Instant::ZERO;
    for n in 0..120_u16 {
        at += Duration::from_millis(if n % 40 == 0 { 3_000 } else { 90 });
        let until = at + Duration::from_millis(10 + u64::from(n % 4) * 10);
        let booking = a.booking(at, until, Duration::from_millis(12));
        assert_eq!(
            a.each_room(&whole, booking),
            doubled(b.each_room(&half, booking))
        );
        let ((j, row), (k, other)) = (a.room(&mut whole, booking), b.room(&mut half, booking));
        assert_eq!((j, row), (2.0 * k, other));
        let joules = f64::from(n % 5) * 1.5e-3;
        let predicted = a.heat(&mut whole, booking, joules);
        assert_eq!(predicted, b.heat(&mut half, booking, joules / 2.0));
        assert_eq!(a.bears(&whole, until, 1.0), b.bears(&half, until, 1.0));
        let [mut used, mut other] = [Used::default(); 2];
        a.add_used(&whole, until, &mut used);
        b.add_used(&half, until, &mut other);
        assert_eq!(used, other);
    }
    assert!(a.dose.omega > 0.0 && a.dose.omega.to_bits() == b.dose.omega.to_bits());
}

#[test]
fn what_flows_evenly_is_by_the_rows_of_the_wire() {
    let seconds = 3600.0;
    let even = |row: &Decays, limit_mc: u64, latent_k: f64| {
        let term = |(c, rate): (&f64, &f64)| c / rate * (1.0 - libm::exp(-rate * seconds));
        let kelvin = limit_mc as f64 * 1e-3 - 33.0 - latent_k;
        kelvin / row.iter().zip(&RATES).map(term).sum::<f64>()
    };
    let [shallow, deep] = &ROWS[0][1];
    // The mean binds, and tissue at 0.4 mm where its limit is tighter.
    for skin_deep_mc in [HARD.skin_deep_mc, 35_000] {
        let limits = Limits {
            skin_deep_mc,
            ..HARD
        };
        let guard = Guard::new(limits, Plant::default(), &[wire()], worn(50_000, 5_000));
        let even_w = even(shallow, HARD.skin_mean_mc, LATENT_K[1]).min(even(
            deep,
            skin_deep_mc,
            LATENT_K[2],
        ));
        let found = guard
            .unwrap()
            .sustained_uw(Duration::from_millis(3_600_000));
        assert_eq!(found, (even_w * 1e6) as u64);
    }
}

#[test]
fn tissue_rests_as_warm_as_the_finger() {
    let kernel = Kernel {
        rest_c: 36.0,
        ..WornWire::default().kernel().unwrap()
    };
    let heat = Heat::new(&HARD, kernel, 1);
    let tissue = &heat.tissues[0];
    close(tissue.shallow_c(&kernel), 36.0 + LATENT_K[0]);
    let rested = Dose::new(36.0 + LATENT_K[0]);
    assert_eq!(tissue.dose.kept_back(), rested.kept_back());
    // Where the dose binds, it leaves what its ceiling leaves above rest.
    let mut spent = tissue.clone();
    let most = heat.budget.doses();
    spent.dose = Dose::at(
        Doses {
            omega: 0.999 * most.omega,
            ..Doses::default()
        },
        36.2,
    );
    let ceiling_c = spent.dose.ceiling_c(&most);
    let until = Instant::from_micros(35_000);
    let booking = spent.booking(Instant::ZERO, until, Duration::ZERO);
    let [peak, dose, ..] = spent.each_room(&heat.budget, booking);
    let latent_c = 36.0 + LATENT_K[0];
    let ratio = (ceiling_c - latent_c) / (43.0 - latent_c);
    assert!(ratio > 0.1 && (dose.0 / peak.0 / ratio - 1.0).abs() < 1e-4);
}

#[test]
fn a_face_counts_from_the_finger() {
    let on = |rest_mc| {
        let worn = WornWire {
            rest_mc,
            ..WornWire::default()
        };
        Guard::new(HARD, Plant::default(), &[wire()], worn).unwrap()
    };
    let mut guard = on(36_000);
    // The mean's row leaves least, whatever the face is now.
    close(guard.warm(Instant::ZERO, 37.5, 37.5), 41.0 - LATENT_K[1]);
    close(guard.predicted().peak_c, 37.5 + LATENT_K[0]);
    let reserve = on(36_000).reserve(Instant::ZERO, Duration::from_millis(1000));
    close(reserve.wires[0].most_c.unwrap(), 43.0);
}

fn wire() -> DisplayWire {
    DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    }
}
