//! How far a run's contacts lie from the touch, as the display has it.

use palpate_core::contact::Levels;
use palpate_core::illusion::Map;
use palpate_core::units::Point;
use palpate_files::Setup;
use palpate_records::trace::{Event, PlaceUm, Trace};
use palpate_run::{Failure, plan};

/// A setup's map from sensor to display.
///
/// # Errors
/// [`Failure`] where the setup's files do not fit together.
pub(super) fn map(setup: &Setup) -> Result<Map, Failure> {
    Ok(plan::untextured(setup, 1, Levels::Off)?.map)
}

/// Root mean square distance, display mm, from the mapped touch to the nearest mapped contact of the same scan; NaN where
/// no scan had both. The miss of a law comes on top.
pub(super) fn error_mm(trace: &Trace, map: &Map) -> f64 {
    let place = |p: PlaceUm| map.apply(Point::new(p.x as f32 * 1e-3, p.y as f32 * 1e-3));
    let contacts: Vec<(u64, Point)> = (trace.events.iter())
        .filter_map(|event| match event {
            Event::Contact { t_us, place: p, .. } => Some((*t_us, place(*p))),
            _ => None,
        })
        .collect();
    let nearest = |t: u64, touch: Point| {
        let from = contacts.partition_point(|(at, _)| *at < t);
        let same = contacts[from..].iter().take_while(|(at, _)| *at == t);
        same.map(|(_, p)| f64::from(p.distance(touch)))
            .min_by(f64::total_cmp)
    };
    let misses = trace.events.iter().filter_map(|event| match event {
        Event::Truth { t_us, place: p, .. } => nearest(*t_us, place(*p)),
        _ => None,
    });
    let (sum, count) = misses.fold((0.0, 0.0), |(sum, n), mm| (sum + mm * mm, n + 1.0));
    f64::sqrt(sum / count)
}

#[cfg(test)]
#[path = "path_tests.rs"]
mod tests;
