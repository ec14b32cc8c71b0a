//! Wires as they stand at one moment: copied at once, looked at later and perhaps on another thread. No run without a page
//! asks for them.

use palpate_core::units::Milliamps;

use super::WornDisplay;
use super::rise::Rise;
use super::totals::DisplayTotals;
use crate::display::solver::record::Peaks;
use crate::display::wire::Wire;
use crate::time::Nanos;

/// A display's wires at one moment.
#[derive(Clone, Debug)]
pub struct Standing {
    now: Nanos,
    wires: Vec<Wire>,
    /// Rise of the skin by a warm face, K.
    rise_k: f64,
    books: Option<Books>,
}

/// Figures beside the wires from which totals are made.
#[derive(Clone, Debug)]
struct Books {
    peak_supply: Milliamps,
    warmed: Option<Rise>,
}

impl Standing {
    pub(super) fn new(display: &WornDisplay, with_books: bool) -> Self {
        let copy = if with_books {
            Wire::ahead_with_books
        } else {
            Wire::ahead
        };
        Self {
            now: display.now,
            wires: display.worn.wires.iter().map(copy).collect(),
            rise_k: display.warmed.as_ref().map_or(0.0, |rise| rise.k),
            books: with_books.then(|| Books {
                peak_supply: display.supply.peak().0,
                warmed: display.warmed.clone(),
            }),
        }
    }

    /// Each wire and the tissue 0.1 mm under it, degrees C.
    pub fn warmth_c(&self) -> Vec<[f64; 2]> {
        let look = |wire: &Wire| {
            let [wire_c, tissue_c] = wire.glance(self.now);
            [wire_c, tissue_c + self.rise_k]
        };
        self.wires.iter().map(look).collect()
    }

    /// Totals of the run so far; `None` without the books.
    pub fn totals(&self) -> Option<DisplayTotals> {
        let books = self.books.as_ref()?;
        let mut wires = self.wires.clone();
        let mut floor = Peaks::NONE;
        for wire in &wires {
            floor.raise(&wire.solver().peaks_floor());
        }
        let totals = DisplayTotals::new(&mut wires, &floor, books.peak_supply, self.now);
        Some(match &books.warmed {
            Some(rise) => rise.total(totals),
            None => totals,
        })
    }
}
