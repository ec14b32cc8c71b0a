//! Shear is turned into one direction before the network sees it.

use super::*;

#[test]
fn shear_is_turned_wherever_it_points_and_the_normal_axis_stays() {
    let rest = [100.0, 200.0, 300.0];
    for (x, y) in [(3.0, 4.0), (-3.0, 4.0), (5.0, 0.0), (0.0, -5.0)] {
        let means = [100.0 + x, 200.0 + y, 321.0];
        assert_eq!(turned(means, rest), [95.0, 200.0, 321.0], "{x} {y}");
    }
    assert_eq!(turned(rest, rest), rest);
}
