//! Tests of `digest.rs`.

use super::*;
use crate::synthetic;
use crate::trace::event;

#[test]
fn one_integer_changes_the_digest() {
    let trace = synthetic::circle(2);
    let before = trace_digest(&trace);
    assert_eq!(before.len(), 16);
    assert_eq!(before, trace_digest(&trace.clone()));
    let mut other = trace.clone();
    other.ledger.energy_uj += 1;
    assert_ne!(before, trace_digest(&other));
    let mut other = trace.clone();
    for event in &mut other.events {
        if let Event::Wire(event::Temperature { milli_c, .. }) = event {
            *milli_c += 1;
            break;
        }
    }
    assert_ne!(before, trace_digest(&other));
    assert_eq!(contacts_digest(&trace), contacts_digest(&other));
    assert_eq!(schedule_digest(&trace), schedule_digest(&other));
}

#[test]
fn known_vector() {
    assert_eq!(short_digest("abc"), "ba7816bf8f01cfea");
}

#[test]
fn a_schedule_in_pieces_has_the_digest_of_the_whole() {
    let trace = synthetic::circle(2);
    let whole = schedule_digest(&trace);
    for size in [1, 7, 100, trace.events.len()] {
        let mut digest = ScheduleDigest::default();
        for piece in trace.events.chunks(size) {
            // Noticed in another order than they happened, as far as they may be late.
            let mut piece = piece.to_vec();
            piece.sort_by_key(|e| std::cmp::Reverse(e.t_ns()));
            let first_ns = piece.iter().map(Event::t_ns).min();
            digest.add(&piece, first_ns.unwrap_or(0));
        }
        assert_eq!(digest.finish(), whole, "{size} at a time");
    }
}
