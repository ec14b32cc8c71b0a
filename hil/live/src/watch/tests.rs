//! The screen as people see it, at 80x24 and below.

use insta::assert_snapshot;
use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Board, Channel, Ticks};
use palpate_records::trace::PlaceUm;

use super::grid::Cell;
use super::*;
use palpate_files::Setup;
use palpate_run::plan;
use palpate_run::{Input, run};

/// A shipped scene at a moment of its run, as its events tell it.
fn at(scene: &str, t_us: u64) -> View {
    let setup = Setup::load(scene, "emulated").unwrap();
    let trace = run(&setup, &Input::Scene, 1).unwrap().trace;
    let layout = plan::layout(&setup.sensor.value).unwrap();
    let mut view = View::new(&trace.header, &layout, trace.ledger.length_us);
    let past = trace.events.partition_point(|e| e.t_ns() <= t_us * 1000);
    view.observe(&trace.events[..past]);
    view.now_us = t_us;
    // The trace does not keep every reading: a bump under each contact.
    for contact in view.contacts.clone() {
        let place = view.place(&contact);
        for (taxel, counts) in view.taxels.iter().zip(&mut view.counts) {
            let square = |a: i32, b: i32| (f64::from(a - b) / 1e3).powi(2);
            let away = square(taxel.x, place.x) + square(taxel.y, place.y);
            *counts += contact.counts as f32 * (-away / 30.0).exp() as f32;
        }
    }
    view
}

fn screen(view: &View, columns: u16, rows: u16) -> String {
    let (width, height) = skin_size();
    let raster = Raster::new(&view.taxels, width, height);
    let grid = draw(view, &raster, (columns, rows));
    let rows = grid.cells.chunks(usize::from(columns));
    let row = |cells: &[Cell]| {
        cells
            .iter()
            .filter_map(|cell| cell.symbol)
            .collect::<String>()
    };
    rows.map(|cells| format!("\"{}\"\n", row(cells))).collect()
}

#[test]
fn one_module_and_eight_wires() {
    let mut view = at("sphere-circle", 4_321_000);
    view.buses = vec!["bus 0    18.7 % load, 1600 frames/s, 0 errors".into()];
    view.counts[3] = f32::NAN;
    assert_snapshot!(screen(&view, 80, 24));
}

#[test]
fn a_hand_on_four_buses_with_a_busy_guard() {
    let mut view = at("allegro-four-buses", 3_000_000);
    view.buses = (0..4)
        .map(|b| format!("bus {b}    74.1 % load, 6400 frames/s, 0 errors"))
        .collect();
    let limited = |n: u64| {
        Event::Schedule(Entry {
            at: Instant::from_micros(2_900_000 + n * 10_000),
            board: Board(0),
            channel: Channel(n as u8),
            on: 0,
            off: 80,
            until: Instant::from_micros(2_935_000 + n * 10_000),
            requested: Ticks::new(100),
            requested_until: Instant::from_micros(2_935_000 + n * 10_000),
            current: None,
            reason: Some(Reason::SkinMean),
        })
    };
    view.observe(&(0..6).map(limited).collect::<Vec<_>>());
    assert_snapshot!(screen(&view, 80, 24));
}

#[test]
fn a_screen_that_is_too_small_says_so() {
    let view = at("idle", 1_000_000);
    let text = screen(&view, 60, 10);
    assert!(
        text.contains("80x24 needed, 60x10 here; the run goes on (1.000 s)"),
        "{text}"
    );
}

#[test]
fn any_skin_fits_on_the_raster() {
    for points in [0, 1, 2, 5001] {
        let taxels: Vec<_> = (0..points)
            .map(|n| PlaceUm { x: n * 1000, y: -n })
            .collect();
        let raster = Raster::new(&taxels, 17, 15);
        assert!(
            (1..=17).contains(&raster.columns) && (1..=15).contains(&raster.rows),
            "{raster:?}"
        );
        for place in taxels.iter().chain(&[PlaceUm {
            x: i32::MAX,
            y: i32::MIN,
        }]) {
            let (column, row) = raster.cell(*place);
            assert!(column < raster.columns && row < raster.rows);
        }
        let counts = vec![f32::NAN; points as usize];
        let _ = raster.counts(0, 0, &counts);
    }
}

#[test]
fn keys_choose_among_displays() {
    let asked = Asked::default();
    assert_eq!((asked.display(4), asked.display(0)), (0, 0));
    asked.key(b'\t');
    assert_eq!(asked.display(4), 1);
    asked.key(b'4');
    assert_eq!(asked.display(4), 3);
    asked.key(b'\t');
    assert_eq!(asked.display(4), 0);
    asked.key(b'0');
    assert_eq!(asked.display(10), 9);
    asked.key(b'x');
    assert!(!asked.stop.load(Ordering::Relaxed));
    asked.key(b'q');
    assert!(asked.stop.load(Ordering::Relaxed));
    let mut view = at("idle", 1_000_000);
    view.which = Some((1, 4));
    assert!(screen(&view, 80, 24).contains("display 2 of 4; Tab shows the next"));
}
