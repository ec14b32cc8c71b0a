//! What a trace amounts to: errors, tallies and the ledger's rows, all in integers.

use crate::bursts::{Burst, bursts};
use crate::fixed::{distance2_um, milli};
use crate::trace::{Event, PlaceUm, Trace};
use palpate_core::units::Ticks;
use std::collections::BTreeMap;

/// Distances from what should be to what was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    /// Root of the mean square, micrometres, rounded down.
    pub rmse_um: u64,
    /// The largest, micrometres, rounded down.
    pub max_um: u64,
    /// How many were measured.
    pub count: u64,
}

/// Collects squared distances.
#[derive(Default)]
pub(crate) struct Sum {
    squares: u128,
    max: u64,
    count: u64,
}

impl Sum {
    pub(crate) fn add(&mut self, squared_um: u64) {
        self.squares = self.squares.saturating_add(u128::from(squared_um));
        self.max = self.max.max(squared_um);
        self.count += 1;
    }

    pub(crate) fn errors(&self) -> Option<Errors> {
        let mean = self.squares.checked_div(u128::from(self.count))?;
        Some(Errors {
            rmse_um: u64::try_from(mean).unwrap_or(u64::MAX).isqrt(),
            max_um: self.max.isqrt(),
            count: self.count,
        })
    }
}

/// Contact path against the true path, sensor space: for each truth the nearest contact of the same
/// scan. `None` where no truth met a contact.
pub fn path_error(trace: &Trace) -> Option<Errors> {
    let mut contacts: BTreeMap<u64, Vec<PlaceUm>> = BTreeMap::new();
    for event in &trace.events {
        if let Event::Contact { t_us, place, .. } = event {
            contacts.entry(*t_us).or_default().push(*place);
        }
    }
    let mut sum = Sum::default();
    for event in &trace.events {
        if let Event::Truth { t_us, place, .. } = event {
            let nearest = contacts
                .get(t_us)
                .and_then(|c| c.iter().map(|p| distance2_um(*p, *place)).min());
            if let Some(squared) = nearest {
                sum.add(squared);
            }
        }
    }
    sum.errors()
}

/// Length of the run, microseconds: what the ledger says, or the last event where it says nothing.
pub fn length_us(trace: &Trace) -> u64 {
    if trace.ledger.length_us > 0 {
        return trace.ledger.length_us;
    }
    let last = trace.events.iter().map(|e| e.t_ns() / 1000).max();
    last.unwrap_or(0)
}

/// What one wire did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireTally {
    /// Bursts with a width above zero.
    pub bursts: u64,
    /// Bursts in which something else than the request was applied, refusals among them.
    pub limited: u64,
    /// Time within bursts, microseconds.
    pub burst_us: u64,
    /// Time the pulses of those bursts were high, nanoseconds (the share of the period, not edges).
    pub high_ns: u64,
    /// Widest pulse, ticks.
    pub widest: u16,
    /// Hottest sample, thousandths of a degree Celsius.
    pub hottest_milli_c: Option<i32>,
}

/// One tally a wire of the display, in its order.
pub fn wire_tallies(trace: &Trace) -> Vec<WireTally> {
    let mut tallies = vec![WireTally::default(); trace.header.wires.len()];
    for burst in bursts(trace) {
        let Some(tally) = burst.wire.and_then(|w| tallies.get_mut(usize::from(w))) else {
            continue;
        };
        tally.limited += u64::from(burst.reason.is_some());
        if burst.width == 0 {
            continue;
        }
        let span = burst.to_us - burst.from_us;
        tally.bursts += 1;
        tally.burst_us = tally.burst_us.saturating_add(span);
        let high =
            u128::from(span) * 1000 * u128::from(burst.width) / u128::from(Ticks::PER_PERIOD);
        let high = u64::try_from(high).unwrap_or(u64::MAX);
        tally.high_ns = tally.high_ns.saturating_add(high);
        tally.widest = tally.widest.max(burst.width);
    }
    for event in &trace.events {
        if let Event::Wire { wire, milli_c, .. } = event
            && let Some(tally) = tallies.get_mut(usize::from(*wire))
        {
            tally.hottest_milli_c = tally.hottest_milli_c.max(Some(*milli_c));
        }
    }
    tallies
}

/// One measured value of a run beside its limit. Values and limits are thousandths of the unit, or
/// whole counts where the unit is empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What was measured.
    pub name: &'static str,
    /// How much; `None` where nothing measured it.
    pub value: Option<i64>,
    /// Unit, empty for a count.
    pub unit: &'static str,
    /// The limit in force, if there is one.
    pub limit: Option<i64>,
}

impl Row {
    fn text(&self, value: Option<i64>) -> String {
        match value {
            None => "-".to_owned(),
            Some(v) if self.unit.is_empty() => v.to_string(),
            Some(v) => milli(v),
        }
    }

    /// The value as it is printed; `-` where there is none.
    pub fn value_text(&self) -> String {
        self.text(self.value)
    }

    /// The limit as it is printed; `-` where there is none.
    pub fn limit_text(&self) -> String {
        self.text(self.limit)
    }

    /// Whether the value lies above its limit.
    pub fn over(&self) -> bool {
        matches!((self.value, self.limit), (Some(v), Some(l)) if v > l)
    }

    /// The value in percent of its limit.
    pub fn percent(&self) -> Option<i64> {
        let (value, limit) = (self.value?, self.limit.filter(|l| *l > 0)?);
        Some(value.saturating_mul(100) / limit)
    }
}

/// The ledger's rows: energy, duty, current, temperature, each against its limit.
pub fn ledger_rows(trace: &Trace) -> Vec<Row> {
    let (ledger, limits) = (&trace.ledger, &trace.header.limits);
    let all = bursts(trace);
    let on: Vec<&Burst> = all.iter().filter(|b| b.width > 0).collect();
    let widest = on.iter().map(|b| b.width).max();
    let longest = on.iter().map(|b| b.to_us - b.from_us).max();
    let tick_ns = trace.header.pre_scale.tick_ns();
    let row = |name, value, unit, limit| Row {
        name,
        value,
        unit,
        limit,
    };
    let mean_uw = (u128::from(ledger.energy_uj) * 1_000_000)
        .checked_div(u128::from(length_us(trace)))
        .map(|uw| i64::try_from(uw).unwrap_or(i64::MAX));
    vec![
        row("stimuli", Some(on.len() as i64), "", None),
        row(
            "limiter events",
            Some(i64::from(ledger.limiter_events)),
            "",
            None,
        ),
        row(
            "widest pulse",
            widest.map(|w| signed(u64::from(w) * tick_ns)),
            "us",
            limits.pulse_ns.map(signed),
        ),
        row(
            "largest duty",
            widest.map(|w| i64::from(w) * 100_000 / i64::from(Ticks::PER_PERIOD)),
            "%",
            None,
        ),
        row(
            "longest burst",
            longest.map(signed),
            "ms",
            limits.burst_us.map(signed),
        ),
        row(
            "peak supply current",
            Some(i64::from(ledger.peak_supply_ma)),
            "A",
            limits.supply_ma.map(i64::from),
        ),
        row("energy", Some(signed(ledger.energy_uj)), "mJ", None),
        row(
            "mean power",
            mean_uw,
            "mW",
            limits.fingertip_uw.map(i64::from),
        ),
        row(
            "hottest wire",
            ledger.hottest_wire.map(|(c, _)| i64::from(c)),
            "degC",
            None,
        ),
        row(
            "hottest skin",
            ledger.hottest_skin_milli_c.map(i64::from),
            "degC",
            limits.skin_milli_c.map(i64::from),
        ),
    ]
}

fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn errors_take_the_nearest_contact_of_the_same_scan() {
        let mut trace = synthetic::empty();
        let contact = |t_us, x| Event::Contact {
            t_us,
            frame: 0,
            module: 0,
            contact: 1,
            place: PlaceUm { x, y: 0 },
            intensity_milli: 0,
            level: 1,
            members: 1,
        };
        let truth = |t_us| Event::Truth {
            t_us,
            place: PlaceUm { x: 0, y: 4_000 },
            force_mn: 1,
        };
        trace.events = vec![
            truth(10),
            contact(10, 3_000),
            contact(10, 90_000),
            truth(20),
            contact(30, 0),
        ];
        let expected = Errors {
            rmse_um: 5_000,
            max_um: 5_000,
            count: 1,
        };
        assert_eq!(path_error(&trace), Some(expected));
        assert_eq!(path_error(&synthetic::empty()), None);
    }

    #[test]
    fn ledger_rows_know_their_limits() {
        let mut trace = synthetic::circle(2);
        let rows = ledger_rows(&trace);
        let pulse = rows.iter().find(|r| r.name == "widest pulse").unwrap();
        assert_eq!(pulse.limit_text(), "200.000");
        assert!(!pulse.over() && pulse.percent().unwrap() <= 100);
        trace.header.limits.pulse_ns = Some(1);
        assert!(ledger_rows(&trace).iter().any(Row::over));
        assert!(!ledger_rows(&synthetic::empty()).iter().any(Row::over));
    }
}
