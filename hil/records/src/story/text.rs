//! A story as text, cut to the lines and columns of a golden.

use super::{COLUMNS, DIGEST, GoldenKind, HeadLine, LINES, Story};
use crate::bursts::{Burst, DrivenOutput};
use crate::figures::Figure;
use crate::fixed::{milli, milli_u};
use crate::words::Happening;

/// Most happenings told one by one.
const HAPPENINGS: usize = 40;

/// Heading of the ledger.
pub(super) const LEDGER: &str =
    "ledger                               value               limit                    used";

/// Lines in the making, each cut to [`COLUMNS`].
#[derive(Default)]
struct Text {
    text: String,
    lines: usize,
}

impl Text {
    fn put(&mut self, line: &str) {
        let cut: String = line.chars().take(COLUMNS).collect();
        self.text.push_str(cut.trim_end());
        self.text.push('\n');
        self.lines += 1;
    }

    /// Writes the number of a list's items that have no line.
    fn more(&mut self, count: u64) {
        if count > 0 {
            self.put(&format!("  .. and {count} more"));
        }
    }
}

impl Story {
    /// The golden's text.
    pub fn text(&self) -> String {
        let mut out = Text::default();
        let (title, source) = (self.kind.title(), self.source.word());
        out.put(&format!("palpate {title} of {} ({source})", self.scene));
        self.head.iter().for_each(|line| out.put(&head(line)));
        out.put("");
        match self.kind {
            GoldenKind::Schedule => {
                self.chart.iter().for_each(|line| out.put(line));
                self.events(&mut out);
                out.put("");
                out.put(LEDGER);
                self.figures.iter().for_each(|f| out.put(&figure(f)));
                out.put("");
                self.rows(&mut out);
                out.put("");
                self.list(&mut out);
            }
            GoldenKind::Contacts => {
                self.pad.iter().for_each(|line| out.put(line));
                out.put("");
                self.chart.iter().for_each(|line| out.put(line));
                self.rows(&mut out);
            }
            GoldenKind::Surface => self.rows(&mut out),
        }
        for (of, digest) in &self.digests {
            out.put(&format!("{DIGEST} {of:<8} {digest}"));
        }
        out.text
    }

    fn events(&self, out: &mut Text) {
        let all = self.happening_count();
        out.put(&format!("events: {all}"));
        let listed = self.happenings.len().min(HAPPENINGS);
        for happening in self.happenings.iter().take(listed) {
            out.put(&event(happening));
        }
        out.more(all - listed as u64);
    }

    fn rows(&self, out: &mut Text) {
        out.put(&self.table.heading());
        for row in &self.table.rows {
            out.put(&self.table.row(row));
        }
        out.more(self.table.untold);
    }

    /// The bursts, exactly, as many as fit: with them a difference is told to the microsecond.
    fn list(&self, out: &mut Text) {
        let all = self.burst_count();
        let tau_d_us = self.timing.tau_d_us;
        out.put(&bursts_heading(all, tau_d_us));
        // The digests and the line that counts the rest come after them.
        let most = LINES
            .saturating_sub(out.lines + self.digests.len() + 1)
            .max(1);
        let mut lines = vec![String::new()];
        let mut told = 0;
        let mut before = String::new();
        for burst in &self.bursts {
            let at = onset((burst.from_us, burst.to_us), tau_d_us);
            let text = member(burst);
            let Some(line) = lines.last_mut() else { break };
            let piece = if at == before && !line.is_empty() {
                format!(" {text}")
            } else {
                format!("   {at} {text}")
            };
            if line.len() + piece.len() <= COLUMNS {
                line.push_str(&piece);
            } else if lines.len() < most {
                lines.push(format!("   {at} {text}"));
            } else {
                break;
            }
            before = at;
            told += 1;
        }
        lines
            .iter()
            .filter(|line| !line.is_empty())
            .for_each(|line| out.put(line));
        out.more(all - told);
    }
}

/// An event's line.
pub(super) fn event(happening: &Happening) -> String {
    let when = happening.when();
    let (first, rest) = when.split_once("..").map_or((when.as_str(), ""), |w| w);
    let dots = if rest.is_empty() { "" } else { ".." };
    let when = format!("{first:>8}{dots}{rest} s");
    let kind = happening.kind.word();
    format!("  {when:<18} {kind:<9} {}", happening.text)
}

/// Heading of the bursts: how many there are, and what their lines say.
pub(super) fn bursts_heading(all: u64, tau_d_us: u64) -> String {
    let tau_d = milli_u(tau_d_us);
    format!("bursts: {all}; onset [us], +length [us] where it is not {tau_d} ms, wire:ticks")
}

/// Start of a burst and, where it is not tau_d, its length; all microseconds.
pub(super) fn onset((from_us, to_us): (u64, u64), tau_d_us: u64) -> String {
    let length = to_us - from_us;
    if length == tau_d_us {
        return from_us.to_string();
    }
    format!("{from_us}+{length}")
}

fn head(line: &HeadLine) -> String {
    let colon = if line.label.is_empty() { "" } else { ": " };
    format!("  {}{colon}{}", line.label, line.pieces.join(", "))
}

/// A row of the ledger.
pub(super) fn figure(figure: &Figure) -> String {
    let used = figure
        .used
        .map_or_else(|| "-".to_owned(), |u| format!("{} %", milli(u)));
    let over = if figure.over { "  OVER" } else { "" };
    format!(
        "  {:<26} {:>14} {:<5} {:>14} {used:>23}{over}",
        figure.name,
        figure.text(figure.value),
        figure.unit,
        figure.text(figure.limit),
    )
}

/// One burst: `wire:ticks`, `@board.channel:ticks` for an output that drives no wire, and after less than was
/// asked for `<ticks(why)`.
pub(super) fn member(burst: &Burst) -> String {
    let mut text = match burst.output {
        DrivenOutput::Wire(wire) => format!("{wire}:{}", burst.width),
        DrivenOutput::Pin(board, channel) => format!("@{board}.{channel}:{}", burst.width),
    };
    if let Some(reason) = burst.reason {
        text.push_str(&format!("<{}({})", burst.requested, reason.word()));
    }
    text
}
