//! Common parts of comparisons of schedules: a file that is held as a whole, and the wires of a bench.

use std::fs::File;
use std::path::Path;

use palpate_files::{FileError, LayoutFile, Lines, load_bench, load_layout};

use palpate_live::output::note;
use palpate_live::progress::Progress;
use palpate_records::trace::{PlaceUm, WireInfo};

/// Most bytes of a golden or schedule that is held to be compared, with about three times as many for what it says.
pub(super) const MOST: u64 = 12 << 20;

/// A golden or schedule, without the tail of NULs that a power cut leaves, which a note names.
///
/// # Errors
/// A file that cannot be read, or is longer than 12 MiB.
pub(super) fn read_log(mut lines: Lines<File>) -> Result<String, FileError> {
    let label = lines.label().to_owned();
    let _shown = Progress::reading(Path::new(&label));
    let mut text = String::new();
    while let Some((number, line)) = lines.advance()? {
        if text.len() as u64 + line.len() as u64 > MOST {
            return Err(FileError {
                line: Some(number),
                ..FileError::whole(
                    &label,
                    format!("a file of at most {MOST} bytes"),
                    "more (compare parts of it)",
                )
            });
        }
        text.push_str(line);
        text.push('\n');
    }
    if let Some(text) = lines.note() {
        note(&text);
    }
    Ok(text)
}

/// The wires of a built-in bench; none of another one, whose outputs are then told by board and channel.
pub(super) fn wires(bench: &str) -> Vec<WireInfo> {
    if !palpate_fixtures::bench_names().any(|name| name == bench) {
        return Vec::new();
    }
    let Ok(bench) = load_bench(bench) else {
        return Vec::new();
    };
    let bench = bench.value;
    let places = match load_layout(&bench.display).map(|l| l.value) {
        Ok(LayoutFile::Display(display)) => display.wires_mm,
        _ => Vec::new(),
    };
    let boards = palpate_run::plan::boards(&bench);
    let um = |mm: f64| (mm * 1e3).round() as i32;
    let wires = bench.outputs.iter().enumerate().map(|(index, output)| {
        let board = boards.iter().position(|b| *b == output.board).unwrap_or(0);
        let place = places
            .get(index)
            .map_or_else(PlaceUm::default, |p| PlaceUm {
                x: um(p[0]),
                y: um(p[1]),
            });
        WireInfo {
            place,
            board: board as u8, // at most 16
            channel: output.channel,
        }
    });
    wires.collect()
}
