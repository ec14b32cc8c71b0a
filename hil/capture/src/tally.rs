//! Comparison of one output's pulses with its bursts.

use std::collections::BTreeMap;

use super::align::Pulses;
use super::plan::{Burst, Output, Plan, Span, chains, is_busy};

/// Comparison of one output's pulses with its bursts.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Bursts that the window touches.
    pub(super) planned: usize,
    /// Planned bursts that the capture has whole.
    pub(super) seen: usize,
    /// Each train in the window, and whether the capture has it whole.
    pub(super) trains: Vec<(Span, bool)>,
    /// Worst deviation of a pulse's width.
    pub(super) width_us: Option<f64>,
    /// Worst deviation from the other pulses of its board.
    pub(super) phase_us: Option<f64>,
    /// Periods without a pulse between two pulses.
    pub(super) blank: u64,
    /// Pulses that the plan needs and the capture lacks, blank periods among them.
    pub(super) missing: u64,
    /// Pulses where nothing is planned.
    pub(super) stray: u64,
    /// Shortest planned pulse, nanoseconds.
    pub(super) shortest_ns: Option<f64>,
}

/// The capture's clock against the run's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    /// Time of the run at the capture's start, nanoseconds, for one board.
    pub(super) offset: f64,
    /// The capture's length, nanoseconds.
    pub(super) length: f64,
    /// The board's true period, nanoseconds.
    pub(super) period: f64,
    /// Resolution of the capture's times, nanoseconds.
    pub(super) resolution: f64,
}

/// First pulses' distance from their place in the period, for each board and burst.
pub(super) type Grids = BTreeMap<(u8, u64), f64>;

fn raise(worst: &mut Option<f64>, value: f64) {
    *worst = Some(worst.map_or(value, |w| w.max(value)));
}

/// Counts and measures one output.
pub(super) fn tally(
    plan: &Plan,
    output: Output,
    (pulses, unseen): (&Pulses, &[(f64, f64)]),
    clock: Clock,
    window: Span,
    grids: &mut Grids,
) -> Tally {
    let period = clock.period;
    let tick = period / 4096.0;
    let (begin, end) = (clock.offset, clock.offset + clock.length);
    let early = clock.resolution.max(1.0);
    let mut tally = Tally::default();
    let mut rest = pulses.iter().map(|p| (p.0 + begin, p.1)).peekable();
    let planned = plan.get(&output).map_or(&[][..], Vec::as_slice);
    let mut index = 0;
    for chain in chains(planned) {
        let ([first, ..], [.., last]) = (chain, chain) else {
            continue;
        };
        index += chain.len();
        let next = planned.get(index).map_or(f64::INFINITY, |b| b.from_ns);
        let until = (last.to_ns + 1.25 * period).min(next);
        while let Some(pulse) = rest.next_if(|p| p.0 < first.from_ns - early) {
            tally.stray += u64::from(window.touches(pulse.0, pulse.0 + pulse.1));
        }
        let mut train = Pulses::new();
        while let Some(pulse) = rest.next_if(|p| p.0 < until) {
            train.push(pulse);
        }
        if !window.touches(first.from_ns, last.to_ns) {
            continue;
        }
        tally.planned += chain.len();
        let busy = is_busy(plan, output, first.from_ns, period);
        let lost = lost(chain, &train, period, busy);
        // Captures of edges end with the last edge: a train that is all there needs no time after it.
        let whole = lost.at_end == 0 && !train.is_empty();
        let unclear = train.is_empty() && busy && last.to_ns - first.from_ns < period;
        let lost_sight = (unseen.iter())
            .any(|(from, to)| from + begin < last.to_ns && to + begin > first.from_ns);
        let seen =
            first.from_ns >= begin - early && (until <= end || whole) && !(unclear || lost_sight);
        let span = Span {
            from_ns: first.from_ns,
            to_ns: last.to_ns,
        };
        tally.trains.push((span, seen));
        if !seen {
            continue;
        }
        tally.seen += chain.len();
        tally.blank += lost.between;
        tally.missing += lost.at_start + lost.between + lost.at_end;
        tally.measure(chain, &train, tick, output.0, grids);
    }
    tally.stray += rest.filter(|p| window.touches(p.0, p.0 + p.1)).count() as u64;
    tally
}

impl Tally {
    /// Widths, and places in the period, of a train's pulses.
    fn measure(
        &mut self,
        chain: &[Burst],
        train: &Pulses,
        tick: f64,
        board: u8,
        grids: &mut Grids,
    ) {
        for burst in chain {
            let width = burst.width * tick;
            self.shortest_ns = Some(self.shortest_ns.map_or(width, |s| s.min(width)));
        }
        let mut former = usize::MAX;
        for (rise, width) in train {
            let at = chain.partition_point(|b| b.from_ns <= *rise).max(1) - 1;
            let burst = &chain[at];
            // The first pulse after a change may still be one of the width before.
            let before = at.checked_sub(1).filter(|_| former != at);
            former = at;
            let off = |b: &Burst| (width - b.width * tick).abs() / 1e3;
            let deviation = before.map_or(f64::INFINITY, |index| off(&chain[index]));
            raise(&mut self.width_us, deviation.min(off(burst)));
            let place = rise - burst.on * tick;
            let grid = *grids.entry((board, burst.from_ns as u64)).or_insert(place);
            let turns = (place - grid) / (tick * 4096.0);
            let phase = (turns - turns.round()) * tick * 4096.0;
            if before.is_none() {
                raise(&mut self.phase_us, phase.abs() / 1e3);
            }
        }
    }
}

/// Pulses that a train lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Lost {
    at_start: u64,
    between: u64,
    at_end: u64,
}

/// The counter's periods in which an output is driven have a pulse each. They begin with the burst where the
/// counter stood still, else with the counter's next period, and end with the period in which the burst ends.
fn lost(chain: &[Burst], train: &Pulses, period: f64, busy: bool) -> Lost {
    let ([first, ..], [.., last]) = (chain, chain) else {
        return Lost::default();
    };
    // What a driver's own delays may shift is not asked of the last period: an eighth of it.
    let must = last.to_ns - period / 8.0;
    let cycle = |rise: f64, burst: &Burst| rise - burst.on * period / 4096.0;
    let whole = |periods: f64| periods.ceil().max(0.0) as u64;
    let ([head, ..], [.., tail]) = (train.as_slice(), train.as_slice()) else {
        return Lost {
            at_end: whole((must - first.from_ns) / period).max(1),
            ..Lost::default()
        };
    };
    let late = cycle(head.0, first) - first.from_ns;
    let allowed = if busy { 1.25 } else { 0.9 } * period;
    let gaps = train.windows(2).map(|p| (p[1].0 - p[0].0) / period);
    Lost {
        at_start: whole((late - allowed) / period),
        between: gaps.map(|g| (g.round() - 1.0).max(0.0) as u64).sum(),
        at_end: whole((must - cycle(tail.0, last)) / period).saturating_sub(1),
    }
}
