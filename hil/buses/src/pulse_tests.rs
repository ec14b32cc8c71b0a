//! Rounds of several loops: what holds a heartbeat back, and what does not.

use nix::sys::socket::{AddressFamily, SockFlag, SockType, recv, socketpair};

use super::*;

#[test]
fn a_loop_that_hangs_holds_the_heartbeat_back() {
    let round = Round::new(3);
    let [a, b, c] = [0, 1, 2].map(Round::bit);
    assert!(!round.turned(a) && !round.turned(b));
    assert!(round.turned(c), "all have turned");
    // The third hangs: no turns of the others make up for it.
    for _ in 0..1000 {
        assert!(!round.turned(a) && !round.turned(b));
    }
    assert!(round.turned(c), "it goes on");
}

#[test]
fn a_loop_that_has_ended_is_not_waited_for_and_none_beats_for_nobody() {
    let round = Round::new(2);
    round.ended(0);
    assert!(round.turned(Round::bit(1)));
    round.ended(1);
    assert!(!round.turned(Round::bit(1)), "all have ended");
}

#[test]
fn only_loops_that_wait_count_as_alive() {
    let (ours, theirs) = socketpair(
        AddressFamily::Unix,
        SockType::SeqPacket,
        None,
        SockFlag::SOCK_CLOEXEC,
    )
    .unwrap();
    let heard = || {
        let mut packet = [0; 4];
        recv(theirs.as_raw_fd(), &mut packet, MsgFlags::MSG_DONTWAIT).is_ok()
    };
    let round = Arc::new(Round::new(2));
    let waiting = Arc::new(AtomicU32::new(Round::bit(0)));
    let pulse = Pulse::new(Arc::new(ours), b'.').among(Arc::clone(&round), Arc::clone(&waiting));
    pulse.beat();
    assert!(!heard(), "the second loop has not been seen");
    assert!(
        round.turned(Round::bit(1)),
        "the first one waits, the second turns"
    );
    pulse.beat();
    assert!(!heard(), "a new round");
    waiting.fetch_or(Round::bit(1), Ordering::Relaxed);
    pulse.beat();
    assert!(heard(), "both wait for the bus");
}

/// A heartbeat says that every loop has been seen since the one before, whatever the order of turns.
#[test]
fn between_two_heartbeats_every_loop_has_turned() {
    for order in 0..3u32.pow(8) {
        let round = Round::new(3);
        let mut seen = 0;
        for step in 0..8 {
            let turned = Round::bit((order / 3u32.pow(step) % 3) as usize);
            seen |= turned;
            let due = round.turned(turned);
            assert_eq!(due, seen == 0b111, "order {order}, step {step}");
            if due {
                seen = 0;
            }
        }
    }
}
