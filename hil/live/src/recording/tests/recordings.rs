//! Recordings of real sensors, where they are at hand.

use std::path::{Path, PathBuf};

use palpate_files::{Columns, LayoutFile, Timing, load_layout};

use super::super::*;

fn folder() -> PathBuf {
    std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    )
}

#[test]
fn every_grasp_recording_reads() {
    let Ok(trials) = std::fs::read_dir(folder().join("uskin_grasp")) else {
        println!("skipped: no recordings");
        return;
    };
    let LayoutFile::Sensor(layout) = load_layout("uskin-4x4").unwrap().value else {
        panic!("uskin-4x4 is a sensor");
    };
    let columns = Columns::of_skin(&layout);
    let timing = Timing {
        rate_hz: Some(40.0),
        ..Timing::default()
    };
    let reading = Reading {
        timing,
        ..Reading::default()
    };
    let mut read = 0;
    for trial in trials {
        for finger in ["xela_sensor1.csv", "xela_sensor2.csv"] {
            let path = trial.as_ref().unwrap().path().join(finger);
            let (table, _) = read_taxel_csv(&path, &columns, &reading).unwrap();
            assert!(table.frames() > 100);
            let (mut rows, mut row, mut times) = (table.rows().unwrap(), Vec::new(), Vec::new());
            while let Some(time) = rows.next_row(&mut row).unwrap() {
                times.push(time);
                assert!(row.iter().all(|count| (14_302..=51_571).contains(count)));
            }
            assert_eq!(times[1], 25_000);
            read += 1;
        }
    }
    assert_eq!(read % 2, 0);
    println!("{read} recordings");
}
