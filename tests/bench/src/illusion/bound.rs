//! Bound of a felt path's error: the error that a law is allowed, and that of the contact path that it is given.

use palpate_core::illusion::Map;
use palpate_core::units::Point;
use palpate_records::measure::path_error;
use palpate_records::trace::{Event, Ledger, PlaceUm, Trace, event};

/// A felt error beside its bound, mm RMSE.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bound {
    /// Error of the contact path, mapped to the display.
    pub(super) path_mm: f64,
    /// The law's part and the path's, added in squares; none is required of some benches.
    pub(super) most_mm: Option<f64>,
    felt_mm: f64,
}

impl Bound {
    /// Bound of a run that is `felt_mm` off, by a law that may be `law_mm` off; `None` where no path is known.
    pub(super) fn of(trace: &Trace, map: &Map, felt_mm: f64, law_mm: Option<f64>) -> Option<Self> {
        let path_mm = path_mm(trace, map)?;
        let most_mm = law_mm.map(|law| law.hypot(path_mm));
        Some(Self {
            path_mm,
            most_mm,
            felt_mm,
        })
    }

    /// Returns true if the error is within the bound, where there is one.
    pub(super) fn is_met(&self) -> Option<bool> {
        self.most_mm.map(|most| self.felt_mm <= most)
    }

    /// Share of the bound that is used up, or of the path's error where there is no bound.
    fn used(&self) -> f64 {
        let used = self.felt_mm / self.most_mm.unwrap_or(self.path_mm);
        if used.is_nan() { f64::INFINITY } else { used }
    }

    /// The one that is used up further.
    pub(super) fn worse(self, other: Self) -> Self {
        if self.used() >= other.used() {
            self
        } else {
            other
        }
    }
}

/// Error of the contact path on the display, mm RMSE: contacts and touches mapped, each axis by its scale.
fn path_mm(trace: &Trace, map: &Map) -> Option<f64> {
    let mm = |um: i32| um as f32 * 1e-3;
    let mapped = |p: PlaceUm| PlaceUm::from(map.apply(Point::new(mm(p.x), mm(p.y))));
    let on_display = |event: &Event| {
        let mut event = event.clone();
        match &mut event {
            Event::Contact(event::Contact { place, .. })
            | Event::Truth(event::Truth { place, .. }) => *place = mapped(*place),
            _ => return None,
        }
        Some(event)
    };
    let on_display = Trace {
        header: trace.header.clone(),
        events: trace.events.iter().filter_map(on_display).collect(),
        ledger: Ledger::default(),
    };
    Some(path_error(&on_display)?.rmse_um as f64 * 1e-3)
}

#[cfg(test)]
#[path = "bound_tests.rs"]
mod tests;
