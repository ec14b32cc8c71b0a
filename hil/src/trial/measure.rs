//! Measured values of a trial: each with its unit and, where the scene or the limit table has one, its limit.

use palpate_records::model;
use palpate_records::trace::{Trace, event};

use palpate_files::{Expect, Setup};
use palpate_run::{Onsets, Outcome};

/// Limit of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// The value may be no larger.
    AtMost(f64),
    /// The value may be no smaller.
    AtLeast(f64),
}

/// One measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct Measure {
    /// Name of the value.
    pub name: String,
    /// Number; `None` where the bench does not measure it, or there was nothing to measure.
    pub value: Option<f64>,
    /// Unit of the value; empty for a count.
    pub unit: &'static str,
    /// Limit of the value, if it has one.
    pub bound: Option<Bound>,
    /// Capability that this bench lacks for the value.
    pub lacking: Option<&'static str>,
}

impl Measure {
    fn new(name: &str, value: Option<f64>, unit: &'static str, most: Option<f64>) -> Self {
        Self {
            name: name.to_owned(),
            value,
            unit,
            bound: most.map(Bound::AtMost),
            lacking: None,
        }
    }

    /// Tells whether the value counts as good: within its bound, or without one, or not measurable on this bench.
    pub fn good(&self) -> bool {
        if self.lacking.is_some() {
            return true;
        }
        match (self.bound, self.value) {
            (None, _) => true,
            (Some(_), None) => false,
            // NaN is within no bound.
            (Some(Bound::AtMost(most)), Some(value)) => value <= most,
            (Some(Bound::AtLeast(least)), Some(value)) => value >= least,
        }
    }

    /// Number and unit.
    fn with_unit(&self, value: f64) -> String {
        let number = if self.unit.is_empty() {
            format!("{value:.0}")
        } else {
            format!("{value:.3}")
        };
        format!("{number} {}", self.unit).trim_end().to_owned()
    }

    /// `<= 0.500 mm`.
    pub fn bound_text(&self) -> Option<String> {
        Some(match self.bound? {
            Bound::AtMost(most) => format!("<= {}", self.with_unit(most)),
            Bound::AtLeast(least) => format!(">= {}", self.with_unit(least)),
        })
    }

    /// `path error 0.194 mm <= 0.500 mm`.
    pub fn words(&self) -> String {
        let value = match (self.value, self.lacking) {
            (_, Some(lacking)) => return format!("{}: bench lacks {lacking}", self.name),
            (Some(value), None) => self.with_unit(value),
            (None, None) => "nothing measured".to_owned(),
        };
        match self.bound_text() {
            Some(bound) => format!("{} {value} {bound}", self.name),
            None => format!("{} {value}", self.name),
        }
    }

    /// Complaint about a value beyond its bound.
    pub fn wrong(&self) -> Option<String> {
        let bound = self.bound_text()?;
        if self.good() {
            return None;
        }
        let found = match self.value {
            Some(value) => self.with_unit(value),
            None => "nothing measured".to_owned(),
        };
        Some(format!("{}: expected {bound}, found {found}", self.name))
    }
}

/// Tells whether a scene expects anything.
pub fn expects_anything(expect: &Expect) -> bool {
    *expect != Expect::default()
}

/// Most contacts of any frame.
fn contacts_max(trace: &Trace) -> u32 {
    let (mut most, mut count, mut now) = (0, 0, None);
    for event::Contact { frame, .. } in trace.each() {
        count = if now == Some(*frame) { count + 1 } else { 1 };
        now = Some(*frame);
        most = most.max(count);
    }
    most
}

/// The share of onsets that were felt, and of touched ones beyond the pad, against what a scene expects of them.
fn shares(expect: &Expect, onsets: &Onsets, is_real: bool) -> [Measure; 2] {
    let share = |part: u64, whole: u64| (whole > 0).then(|| 100.0 * part as f64 / whole as f64);
    let felt = onsets.felt.and_then(|felt| share(felt, onsets.meant));
    let mut felt = Measure::new("share of onsets felt", felt, "%", None);
    felt.bound = expect
        .felt_share_min
        .map(|least| Bound::AtLeast(100.0 * least));
    felt.lacking = felt.bound.filter(|_| is_real).map(|_| "an emulated person");
    let off = share(onsets.off_pad, onsets.touched);
    let most = expect.off_pad_share_max.map(|most| 100.0 * most);
    [
        felt,
        Measure::new("share of touches off the pad", off, "%", most),
    ]
}

/// Values that a finished run measured, what the scene expects first.
pub fn measures(setup: &Setup, outcome: &Outcome) -> Vec<Measure> {
    let expect = &setup.scene.value.expect;
    let summary = &outcome.summary;
    let is_real = setup.bench.value.is_hardware();
    let path = summary.path_error_mm;
    let felt = summary.felt_error_mm.rmse;
    let everywhere = summary.felt_error_mm.everywhere.map(|e| e.rmse);
    let mut all = vec![
        Measure::new(
            "path error RMSE",
            path.map(|p| p.rmse),
            "mm",
            expect.path_rmse_mm,
        ),
        Measure::new(
            "path error at most",
            path.map(|p| p.max),
            "mm",
            expect.path_max_mm,
        ),
        Measure::new("felt error RMSE", felt, "mm", expect.felt_rmse_mm),
        Measure::new("felt error RMSE over all onsets", everywhere, "mm", None),
    ];
    if is_real {
        for measure in &mut all {
            measure.lacking = measure.bound.map(|_| "a known path");
        }
    }
    all.extend(shares(expect, &summary.onsets, is_real));
    // What is neither expected nor measured says nothing.
    all.retain(|m| m.bound.is_some() || m.value.is_some());
    let count = |n: u32| Some(f64::from(n));
    all.push(Measure::new(
        "contacts in a frame",
        count(contacts_max(&outcome.trace)),
        "",
        expect.contacts_max.map(f64::from),
    ));
    all.push(Measure::new(
        "limiter events",
        count(summary.limiter_events),
        "",
        expect.limiter_events_max.map(f64::from),
    ));
    let over = summary.margins.iter().filter(|m| m.over()).count();
    if expect.over_limit {
        let mut passed = Measure::new("limits exceeded", Some(over as f64), "", None);
        passed.bound = Some(Bound::AtLeast(1.0));
        if is_real {
            passed.lacking = Some("a measured finger");
        }
        all.push(passed);
    }
    for margin in &summary.margins {
        let limit = (!expect.over_limit).then_some(margin.limit());
        let (of, worst) = (margin.of, margin.worst());
        all.push(Measure::new(of.name(), Some(worst), of.unit(), limit));
    }
    let wire_c = summary.hottest_wire_c;
    let wire_c = wire_c.and_then(|c| model::known(c, model::WIRE_C));
    all.extend(
        [
            ("energy", summary.energy_mj, "mJ"),
            ("hottest wire", wire_c, "C"),
            ("stimuli", Some(summary.stimuli as f64), ""),
        ]
        .into_iter()
        .filter(|(_, value, _)| value.is_some())
        .map(|(name, value, unit)| Measure::new(name, value, unit, None)),
    );
    all
}

#[cfg(test)]
#[path = "measure_tests.rs"]
mod tests;
