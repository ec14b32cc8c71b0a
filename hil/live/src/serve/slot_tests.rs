//! What a page gets that does not keep up.

use std::time::Duration;

use super::*;

fn text(text: &str) -> Arc<str> {
    text.into()
}

/// Next message of a page, as its text.
fn taken(slot: &Slot) -> Option<Arc<str>> {
    slot.take().map(|message| text(message.to_text().unwrap()))
}

#[test]
fn a_page_that_is_slow_gets_everything_it_is_told_and_of_pictures_the_newest() {
    let slot = Slot::default();
    slot.show(0, &text("1"));
    slot.tell(text("hello"));
    slot.show(0, &text("2"));
    slot.show(1, &text("of another display"));
    slot.show(0, &text("3"));
    slot.tell(text("over"));
    let got: Vec<_> = (0..3).filter_map(|_| taken(&slot)).collect();
    assert_eq!(got, [text("hello"), text("over"), text("3")]);
    slot.show(0, &text("of a run that is over"));
    slot.forget();
    slot.show(0, &text("4"));
    assert_eq!(taken(&slot), Some(text("4")));
    slot.close();
    assert_eq!(taken(&slot), None);
}

#[test]
fn the_end_of_a_run_waits_for_no_page_for_long() {
    let slot = Slot::default();
    slot.tell(text("over"));
    // Nothing takes it.
    slot.drained(Duration::from_millis(20));
    slot.close();
    slot.drained(Duration::from_secs(3600));
}
