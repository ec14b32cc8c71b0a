//! The ledger as it is printed: each total, and each margin, as a value with its unit and limit.

use crate::fixed::{milli, thousandths};
use crate::margin::Margin;
use crate::trace::Trace;
use palpate_core::units::Ticks;

/// A total or a margin to the thousandth, as goldens and reports print it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name of the measured quantity.
    pub name: String,
    /// Value in thousandths of the unit; `None` where nothing measured it.
    pub value: Option<i64>,
    /// Unit, empty for a count.
    pub unit: String,
    /// The limit in force, thousandths of the unit, if there is one.
    pub limit: Option<i64>,
    /// Part of the limit that was used, thousandths of a percent.
    pub used: Option<i64>,
    /// `true` where the limit was passed.
    pub over: bool,
}

impl Figure {
    fn total(name: &str, value: Option<i64>, unit: &str) -> Self {
        Self {
            name: name.to_owned(),
            value,
            unit: unit.to_owned(),
            limit: None,
            used: None,
            over: false,
        }
    }

    fn count(name: &str, value: u64) -> Self {
        let most = i64::MAX / 1000;
        let count = i64::try_from(value).unwrap_or(most).min(most);
        Self::total(name, Some(count * 1000), "")
    }

    fn of_margin(margin: &Margin) -> Self {
        let milli = |nano: i64| (nano.saturating_add(nano.signum() * 500_000)) / 1_000_000;
        Self {
            name: margin.of.name().to_owned(),
            value: Some(milli(margin.worst_nano)),
            unit: margin.of.unit().to_owned(),
            limit: Some(milli(margin.limit_nano)),
            used: margin.used_milli_percent(),
            over: margin.over(),
        }
    }

    /// A value in its unit as it is printed; `-` for none.
    pub fn text(&self, value: Option<i64>) -> String {
        match value {
            None => "-".to_owned(),
            Some(v) if self.unit.is_empty() => (v / 1000).to_string(),
            Some(v) => milli(v),
        }
    }

    /// Value that [`Figure::text`] printed; `None` for another text.
    pub(crate) fn read(text: &str) -> Option<Option<i64>> {
        match text {
            "-" => Some(None),
            text => thousandths(text).map(Some),
        }
    }
}

/// The totals, then the margins, the most used up first.
pub fn figures(trace: &Trace) -> Vec<Figure> {
    let ledger = &trace.ledger;
    let duty = i64::from(ledger.driven.widest) * 100_000 / i64::from(Ticks::PER_PERIOD);
    let energy = i64::try_from(ledger.energy_uj).unwrap_or(i64::MAX);
    let hottest = ledger.hottest_wire.map(|(milli_c, _)| i64::from(milli_c));
    let mut all = vec![
        Figure::count("stimuli", ledger.driven.stimuli),
        Figure::count("limiter events", ledger.driven.limiter_events.into()),
    ];
    match trace.header.motors {
        true => all.push(Figure::total("largest level", Some(duty), "%")),
        false => all.extend([
            Figure::total("largest duty", Some(duty), "%"),
            Figure::total("energy", Some(energy), "mJ"),
            Figure::total("hottest wire", hottest, "C"),
        ]),
    }
    all.extend(ledger.margins.iter().map(Figure::of_margin));
    all
}

#[cfg(test)]
#[path = "figures_tests.rs"]
mod tests;
