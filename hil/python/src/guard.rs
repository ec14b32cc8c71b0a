//! Guarded form of a schedule, without a loop or a display.

use palpate_core::contact::Levels;
use palpate_core::guard::Guard;
use palpate_core::schedule::{Entry, Stimulus};
use palpate_core::units::{Board, Duration, Instant, Milliamps, Ticks};
use palpate_records::trace::Event;
use palpate_run::{Failure, build, header, plan};
use pyo3::prelude::*;

use crate::errors::free;
use crate::setup::Setup;
use crate::table::Table;
use crate::tables::{self, About};

/// The most that the guard predicts under any wire: 0.1 mm deep, its mean over 10 s, 0.4 mm deep (degrees C), Henriques'
/// Omega, minutes at 43 degrees C.
type Predicted = (f64, f64, f64, f64, f64);

/// Asks for a stimulus: time (us), wire, width (ticks), length (us).
type Wanted = (u64, u16, u16, u64);

/// Ends stimuli that are over by `at`.
fn expire(guard: &mut Guard, boards: &[Board], at: Instant) {
    while let Some(end) = guard.next_expiry().filter(|end| *end <= at) {
        for board in boards {
            guard.expire(end, *board);
        }
    }
}

/// Guards stimuli that are sorted by time, with the guard of a setup. Those of one time come together.
#[pyfunction]
pub fn guard(
    py: Python<'_>,
    setup: &Bound<'_, Setup>,
    stimuli: Vec<Wanted>,
) -> PyResult<(Table, Predicted)> {
    let setup = setup.get().inner.clone();
    free(py, || {
        let projector = build(&setup, 1, Levels::Off)?;
        let about = About::new(&header(&setup, 1, &projector)?);
        let wires = projector.display().wires();
        let mut boards: Vec<Board> = wires.iter().map(|w| w.board).collect();
        boards.sort_by_key(|board| board.0);
        boards.dedup();
        let peak: Milliamps = plan::milliamps(setup.bench.value.drive.current_ma);
        let mut guard = projector.guard().clone();
        let mut events = Vec::new();
        for together in stimuli.chunk_by(|a, b| a.0 == b.0) {
            let at = Instant::from_micros(together.first().map_or(0, |first| first.0));
            expire(&mut guard, &boards, at);
            for board in &boards {
                let mut of_board = Vec::new();
                for &(_, wire, width, length_us) in together {
                    let owner = wires.get(usize::from(wire)).map(|w| w.board);
                    let owner = owner.ok_or_else(|| {
                        Failure::Input(format!(
                            "wire: expected 0 to {}, found {wire}",
                            wires.len().saturating_sub(1)
                        ))
                    })?;
                    if owner == *board {
                        of_board.push(Stimulus {
                            wire,
                            width: Ticks::new(width),
                            peak,
                            at,
                            until: at + Duration::from_micros(length_us),
                        });
                    }
                }
                if !of_board.is_empty() {
                    guard.admit(at, *board, &of_board, |entry: Entry| {
                        events.push(Event::Schedule(entry));
                    });
                }
            }
        }
        let p = *guard.predicted();
        let predicted = (p.peak_c, p.mean_c, p.deep_c, p.omega, p.cem43_min);
        Ok((tables::stimuli(&events, &about), predicted))
    })
}
