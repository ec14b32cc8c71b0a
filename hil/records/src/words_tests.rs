//! Tests of `words.rs`.

use super::*;
use crate::synthetic;

#[test]
fn limiter_events_of_a_wire_fold_and_the_story_is_in_order() {
    let list = happenings(&synthetic::circle(10));
    assert!(list.is_sorted_by_key(|h| h.t_us));
    let limited: Vec<_> = list
        .iter()
        .filter(|h| h.kind == HappeningKind::Limiter)
        .collect();
    assert!(!limited.is_empty() && limited.len() < 10, "{limited:?}");
    assert!(limited.iter().any(|h| h.text.contains("1 refused, worst")));
    assert!(list.iter().any(|h| h.kind == HappeningKind::Break));
    assert!(limited[0].text.starts_with("wire 2 wire-power"));
    assert_eq!(one_line("a\nb\u{b5}"), "a b?");
}
