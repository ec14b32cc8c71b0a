//! Happenings of a run in words: one line each, neighbours of a kind folded into one.

use crate::bursts::{DrivenOutput, bursts};
use crate::fixed::{milli, milli_u, place, seconds};
use crate::trace::{Event, Trace, event};

palpate_core::listed! {
    /// Kind of a happening.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum HappeningKind: word {
        /// The guard applied something other than what was requested.
        Limiter = "limiter",
        /// A board went off as a whole.
        AllOff = "all-off",
        /// An onset at which nothing was felt.
        Break = "break",
        /// A board's period changed.
        PreScale = "pre-scale",
        /// A line of the run's own.
        Note = "note",
    }
}

impl HappeningKind {
    /// Mark in a strip chart.
    pub const fn mark(self) -> u8 {
        match self {
            Self::Limiter => b'!',
            Self::AllOff => b'X',
            Self::Break => b'B',
            Self::PreScale => b'P',
            Self::Note => b'n',
        }
    }
}

/// One line of the story.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Happening {
    /// Start, microseconds.
    pub t_us: u64,
    /// Last time, microseconds; `t_us` if it happened once.
    pub last_us: u64,
    /// Kind of the happening.
    pub kind: HappeningKind,
    /// Text, without the time.
    pub text: String,
}

impl Happening {
    /// Time in seconds: `0.058`, or `0.058..0.117`.
    pub fn when(&self) -> String {
        if self.last_us > self.t_us {
            format!("{}..{}", seconds(self.t_us), seconds(self.last_us))
        } else {
            seconds(self.t_us)
        }
    }
}

/// Happenings worth a line, in order of time. Limiter events of one wire and reason, and breaks, that
/// follow one another within four onsets are one happening.
pub fn happenings(trace: &Trace) -> Vec<Happening> {
    let gap_us = trace.header.soa_us.saturating_mul(4).max(1);
    let mut list = limiter(trace, gap_us);
    list.extend(breaks(trace, gap_us));
    for event in &trace.events {
        let (t_us, kind, text) = match event {
            Event::AllOff(e) => (
                e.t_us,
                HappeningKind::AllOff,
                format!("board {} off: {}", e.board, e.cause),
            ),
            Event::PreScale(e) => (
                e.t_us,
                HappeningKind::PreScale,
                format!("board {} set to {}", e.board, e.pre_scale),
            ),
            Event::Note(note) => (note.t_us, HappeningKind::Note, one_line(&note.text)),
            _ => continue,
        };
        list.push(Happening {
            t_us,
            last_us: t_us,
            kind,
            text,
        });
    }
    list.sort_by_key(|h| (h.t_us, h.kind));
    list
}

/// A window of texture in words.
pub fn texture(window: &event::Latent) -> String {
    let z: Vec<String> = window.z_milli.iter().map(|z| milli((*z).into())).collect();
    let rough = milli_u(window.rough_permille.into());
    let rate = window.rate_mhz / 1000;
    format!("z {}, roughness {rough}, {rate} Hz", z.join(" "))
}

fn limiter(trace: &Trace, gap_us: u64) -> Vec<Happening> {
    struct Limited {
        output: DrivenOutput,
        word: &'static str,
        first: u64,
        last: u64,
        count: u64,
        refused: u64,
        worst: (u16, u16),
    }
    let mut runs: Vec<Limited> = Vec::new();
    for burst in bursts(trace) {
        let Some(reason) = burst.reason else { continue };
        let word = reason.word();
        let same = runs
            .iter_mut()
            .rev()
            .take(64)
            .find(|r| r.output == burst.output && r.word == word)
            .filter(|r| burst.from_us.saturating_sub(r.last) <= gap_us);
        let cut = (burst.requested, burst.width);
        let refused = u64::from(burst.width == 0);
        match same {
            Some(run) => {
                run.last = burst.from_us;
                run.count += 1;
                run.refused += refused;
                if cut.0.saturating_sub(cut.1) > run.worst.0.saturating_sub(run.worst.1) {
                    run.worst = cut;
                }
            }
            None => runs.push(Limited {
                output: burst.output,
                word,
                first: burst.from_us,
                last: burst.from_us,
                count: 1,
                refused,
                worst: cut,
            }),
        }
    }
    runs.into_iter()
        .map(|r| {
            let many = match (r.count, r.refused) {
                (1, 0) => String::new(),
                (1, _) => "refused, ".to_owned(),
                (n, 0) => format!("{n} bursts, worst "),
                (n, refused) => format!("{n} bursts, {refused} refused, worst "),
            };
            let (asked, given) = r.worst;
            Happening {
                t_us: r.first,
                last_us: r.last,
                kind: HappeningKind::Limiter,
                text: format!("{} {}: {many}{asked} -> {given} ticks", r.output, r.word),
            }
        })
        .collect()
}

fn breaks(trace: &Trace, gap_us: u64) -> Vec<Happening> {
    let mut list: Vec<(Happening, u64)> = Vec::new();
    for felt in trace.each::<event::Felt>().filter(|felt| felt.is_break()) {
        let t_us = felt.t_us;
        match list.last_mut() {
            Some((last, count)) if t_us.saturating_sub(last.last_us) <= gap_us => {
                last.last_us = t_us;
                *count += 1;
            }
            _ => list.push((
                Happening {
                    t_us,
                    last_us: t_us,
                    kind: HappeningKind::Break,
                    text: format!("nothing felt from {}", place(felt.target)),
                },
                1,
            )),
        }
    }
    list.into_iter()
        .map(|(mut happening, count)| {
            if count > 1 {
                happening.text.push_str(&format!(", {count} onsets"));
            }
            happening
        })
        .collect()
}

/// Printable ASCII on one line: what a golden may hold, whatever a note says.
pub fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\n' | '\r' | '\t' => ' ',
            c if c.is_ascii() && !c.is_ascii_control() => c,
            _ => '?',
        })
        .collect()
}

#[cfg(test)]
#[path = "words_tests.rs"]
mod tests;
