//! Bursts in figures, as many as fit: with them a difference of two goldens is told to the microsecond.

use super::{COLUMNS, put};
use crate::bursts::{Burst, bursts};
use crate::fixed::milli_u;
use crate::trace::{Header, Trace};

/// One burst: `wire:ticks`, `@board.channel:ticks` for an output that drives no wire, and after less than was
/// asked for `<ticks(why)`.
fn member(burst: &Burst) -> String {
    let mut text = match burst.wire {
        Some(wire) => format!("{wire}:{}", burst.width),
        None => format!("@{}.{}:{}", burst.output.0, burst.output.1, burst.width),
    };
    if let Some(reason) = burst.reason {
        text.push_str(&format!("<{}({})", burst.requested, reason.word()));
    }
    text
}

/// When bursts begin and, where it is not tau_d, for how long they last.
fn when(header: &Header, burst: &Burst) -> String {
    let length = burst.to_us - burst.from_us;
    if length == header.tau_d_us {
        return burst.from_us.to_string();
    }
    format!("{}+{length}", burst.from_us)
}

/// The bursts of a run on at most `most` lines.
pub(super) fn list(out: &mut String, trace: &Trace, most: usize) {
    let all = bursts(trace);
    put(
        out,
        &format!(
            "bursts: {}; onset [us], +length [us] where it is not {} ms, wire:ticks",
            all.len(),
            milli_u(trace.header.tau_d_us)
        ),
    );
    let mut lines = vec![String::new()];
    let mut told = 0;
    let mut head = String::new();
    for burst in &all {
        let at = when(&trace.header, burst);
        let text = member(burst);
        let Some(line) = lines.last_mut() else { break };
        let piece = if at == head && !line.is_empty() {
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
        head = at;
        told += 1;
    }
    for line in lines.iter().filter(|line| !line.is_empty()) {
        put(out, line);
    }
    if told < all.len() {
        put(out, &format!("  .. and {} more", all.len() - told));
    }
}
