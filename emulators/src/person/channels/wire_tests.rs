//! A wire at rest against the long way.

use super::*;
use palpate_core::random::RandomStream;

#[test]
fn what_rests_is_what_the_long_way_comes_to() {
    let mut shared = Shared {
        rule: Gauss::new(),
        tables: Tables::default(),
        vectors: Vectors::widest(),
    };
    let (mut quick, mut slow) = (WireFilter::default(), WireFilter::default());
    let mut lengths = RandomStream::new(4, "rests");
    for n in 0..500 {
        let seconds = 0.2 * lengths.uniform() * lengths.uniform();
        let mut terms = [0.0; MODES];
        assert!(quick.rests(&terms));
        quick.rest(seconds);
        slow.move_on(&mut shared, &Stretch::rest(seconds), &mut terms, seconds);
        // All digits: text of floats is exact.
        let [a, b] = [&quick, &slow].map(|w| format!("{:?} {:?}", w.passed.last(), w.met));
        assert_eq!(a, b, "piece {n}");
        assert!(quick.rests(&terms) && slow.rests(&terms), "piece {n}");
        let of = |w: &WireFilter| [w.now_s, w.swollen, w.energy].map(f64::to_bits);
        assert_eq!(of(&quick), of(&slow), "piece {n}");
        if n % 7 == 0 {
            quick.settle();
            slow.settle();
        }
    }
    // A wire that has moved does not rest, however little still rings.
    quick.lift(1e-9);
    assert!(!quick.rests(&[0.0; MODES]));
}
