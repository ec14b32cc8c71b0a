//! The result at a glance: the first figures of the page.

use super::svg::escape;
use crate::felt::{FeltBand, felt_level, felt_scores};
use crate::margin::{Limited, Margin};
use crate::measure::path_error;
use crate::model;
use crate::trace::{Trace, event};
use std::fmt::Write;

/// A figure with what belongs to it.
struct Tile {
    name: &'static str,
    value: String,
    more: String,
    /// Marks a figure to look at.
    warns: bool,
}

fn tile(name: &'static str, value: String, more: String) -> Tile {
    Tile {
        name,
        value,
        more,
        warns: false,
    }
}

/// Writes the figures; those without a value in the run are left out.
pub(super) fn tiles(page: &mut String, trace: &Trace, band: Option<&FeltBand>) {
    let ledger = &trace.ledger;
    let driven = ledger.driven;
    let tiles = [
        onsets(trace),
        level(trace, band),
        felt_error(trace),
        path_error(trace).map(|errors| {
            let more = format!("RMSE; {} at most", mm(errors.max_um));
            tile("path error", mm(errors.rmse_um), more)
        }),
        ledger.margin(Limited::SkinPeak).map(skin),
        ledger.margins.first().map(most_used),
        Some(Tile {
            warns: driven.limiter_events > 0,
            ..tile(
                "limiter events",
                driven.limiter_events.to_string(),
                format!("of {} stimuli", driven.stimuli),
            )
        }),
    ];
    page.push_str("<dl class=\"result\">");
    for tile in tiles.into_iter().flatten() {
        let class = if tile.warns { " class=\"warns\"" } else { "" };
        let _ = write!(
            page,
            "<div{class}><dt>{}</dt><dd>{} <small>{}</small></dd></div>",
            tile.name,
            escape(&tile.value),
            escape(&tile.more)
        );
    }
    page.push_str("</dl>\n");
}

/// Number of felt onsets among those with one contact.
fn onsets(trace: &Trace) -> Option<Tile> {
    let all = trace.each::<event::Felt>().count();
    let felt = trace.each::<event::Felt>().filter(|onset| onset.is_felt());
    let felt = felt.count();
    (all > 0).then(|| Tile {
        warns: felt < all,
        ..tile(
            "felt",
            format!("{felt} of {all}"),
            "onsets with one contact".to_owned(),
        )
    })
}

fn level(trace: &Trace, band: Option<&FeltBand>) -> Option<Tile> {
    let level = felt_level(trace)?;
    let um = f64::from(level.skin_median_nm) * 1e-3;
    let mut more = format!("and {um:.1} um of the skin, median inside the wires");
    if let Some([low, _, high]) = band.map(|band| band.level_db) {
        let _ = write!(more, "; band {low:+.1} to {high:+.1} dB");
    }
    let db = f64::from(level.median_mdb) * 1e-3;
    Some(Tile {
        warns: level.median_mdb < 0,
        ..tile("felt level", format!("{db:+.1} dB"), more)
    })
}

fn mm(um: u64) -> String {
    format!("{:.2} mm", um as f64 * 1e-3)
}

/// The felt error of all onsets, and of those inside the wires.
fn felt_error(trace: &Trace) -> Option<Tile> {
    // Without a true path there is nothing to hold the felt path against.
    trace.each::<event::Truth>().next()?;
    let [energy, _] = felt_scores(trace);
    let all = energy.everywhere?;
    let more = match energy.errors {
        Some(inside) if inside.count < all.count => {
            format!(
                "RMSE; {} of the {} inside the wires",
                mm(inside.rmse_um),
                inside.count
            )
        }
        _ => format!("RMSE; {} at most", mm(all.max_um)),
    };
    Some(tile("felt error", mm(all.rmse_um), more))
}

fn skin(of: &Margin) -> Tile {
    let more = format!("limit {:.0} \u{b0}C, 0.1 mm deep in the model", of.limit());
    Tile {
        warns: of.over(),
        ..tile(
            "hottest skin",
            model::on_page(of.worst(), model::TISSUE_C),
            more,
        )
    }
}

fn most_used(of: &Margin) -> Tile {
    Tile {
        warns: of.over(),
        ..tile("most used limit", of.used_words(), of.of.name().to_owned())
    }
}
