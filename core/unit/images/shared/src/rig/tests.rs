//! Tests of `rig`.

use super::*;

#[test]
fn a_head_comes_back() {
    let head = Head {
        ns: 0x0123_4567_89AB_CDEF,
        what: Kind::Transfer as u8,
        argument: 0x41,
        length: 1400,
    };
    assert_eq!(Head::read(&head.bytes()), head);
    for (number, kind) in (0..).zip(Kind::ALL) {
        assert_eq!(
            (
                kind as u8,
                Head {
                    what: number,
                    ..head
                }
                .kind()
            ),
            (number, Some(kind))
        );
    }
    for (number, outcome) in (0..).zip(Outcome::ALL) {
        let head = Head {
            what: number,
            ..head
        };
        assert_eq!((outcome as u8, head.outcome()), (number, Some(outcome)));
    }
}
