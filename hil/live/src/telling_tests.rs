//! Tests of `telling.rs`.

use std::io::{BufRead, BufReader, pipe};
use std::thread;

use serde_json::Value;

use super::*;

/// A long line.
#[derive(Serialize)]
struct Tick {
    n: u64,
    text: String,
}

impl Tick {
    fn new(n: u64) -> Self {
        Self {
            n,
            text: "x".repeat(1000),
        }
    }
}

impl Say for Tick {
    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{} {}", self.n, self.text)
    }
}

/// More lines than may wait.
const LINES: u64 = 20_000;

#[test]
fn a_reader_that_stops_keeps_nobody_and_is_told_of_at_the_end() {
    let (reader, writer) = pipe().unwrap();
    let mut teller = Teller::to(Telling::Json, writer).unwrap();
    for n in 0..LINES {
        teller.tell(&Tick::new(n)).unwrap();
        teller.flush().unwrap();
    }
    let said = teller.finish(&Tick::new(LINES)).unwrap_err();
    assert_eq!(said.status(), 3);
    assert!(said.to_string().contains("nobody has read it"), "{said}");
    drop(reader);
}

#[test]
fn a_reader_that_goes_on_learns_how_many_lines_it_has_missed() {
    let (reader, writer) = pipe().unwrap();
    let mut teller = Teller::to(Telling::Json, writer).unwrap();
    for n in 0..LINES {
        teller.tell(&Tick::new(n)).unwrap();
    }
    let reading = thread::spawn(move || {
        let lines = BufReader::new(reader).lines();
        let values = lines.map(|line| serde_json::from_str(&line.unwrap()).unwrap());
        values.collect::<Vec<Value>>()
    });
    teller.finish(&Tick::new(LINES)).unwrap();
    let read = reading.join().unwrap();
    let (lost, ticks): (Vec<&Value>, Vec<&Value>) =
        read.iter().partition(|value| value["event"] == "lost");
    assert_eq!(lost.len(), 1);
    assert_eq!(
        lost[0]["lines"].as_u64().unwrap() + ticks.len() as u64,
        LINES + 1
    );
    assert_eq!(ticks.last().unwrap()["n"], LINES, "the last word is there");
}

#[test]
fn a_reader_that_is_gone_is_no_error_and_a_full_disk_is_one() {
    let (reader, writer) = pipe().unwrap();
    drop(reader);
    let mut teller = Teller::to(Telling::Words, writer).unwrap();
    teller.tell(&Tick::new(0)).unwrap();
    teller.flush().unwrap();
    teller.finish(&Tick::new(1)).unwrap();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let mut teller = Teller::to(Telling::Words, full.unwrap()).unwrap();
    teller.tell(&Tick::new(0)).unwrap();
    let said = teller.finish(&Tick::new(1)).unwrap_err().to_string();
    assert!(said.contains("No space left"), "{said}");
}
