//! Tests of `desk.rs`: what of all that pages say waits for the session.

use super::*;

fn showing(view: u64) -> State {
    let mut state = State::default();
    (0..view).for_each(|_| {
        state.participant.change(|_| {});
    });
    state
}

#[test]
fn words_of_the_experimenter_wait_up_to_a_bound() {
    let mut state = State::default();
    let note = |n: usize| Heard::Note(n.to_string());
    assert!((0..MOST_WAITING).all(|n| state.wait(note(n))));
    for one_more in [note(0), Heard::Laid, Heard::Void("why".into())] {
        assert!(!state.wait(one_more));
    }
    assert_eq!(state.heard.len(), MOST_WAITING);
    // What is heard in any case, once each.
    for _ in 0..1000 {
        assert!(state.wait(Heard::Stop) && state.wait(Heard::Lost));
    }
    assert_eq!(state.heard.len(), MOST_WAITING + 2);
    state.heard.pop_front();
    state.heard.pop_front();
    state.heard.pop_front();
    assert!(state.wait(note(0)));
}

#[test]
fn the_first_reply_to_the_newest_view_waits_alone() {
    let mut state = showing(2);
    for (view, chosen) in [(1, 7), (2, 0), (2, 1), (9, 2), (1, 3)] {
        assert!(state.wait(Heard::Reply(view, Reply::Chosen(chosen))));
    }
    assert_eq!(state.heard, [Heard::Reply(2, Reply::Chosen(0))]);
    // It was to a view that is gone.
    state.participant.change(|_| {});
    assert!(state.wait(Heard::Reply(3, Reply::Read)));
    assert_eq!(state.heard, [Heard::Reply(3, Reply::Read)]);
}

#[test]
fn who_has_another_ones_page_has_another_ones_token() {
    let far = "0.0.0.0:0".parse().unwrap();
    let token = |url: &str| url.split_once("#token=").unwrap().1.to_owned();
    let desk = Desk::open(far).unwrap();
    assert!(desk.experimenter_url.contains("/experimenter#"));
    assert_ne!(token(&desk.url), token(&desk.experimenter_url));
}
