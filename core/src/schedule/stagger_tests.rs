//! Tests of `stagger.rs`.

use super::*;

#[test]
fn pulses_stay_inside_the_period_and_apart() {
    for channel in 0..16 {
        for width in 0..=Ticks::PER_PERIOD {
            let (on, off) = stagger(Channel(channel), Ticks::new(width));
            assert_eq!(off - on, width);
            assert!(off <= Ticks::PER_PERIOD);
            if width <= 256 {
                assert_eq!(on, 256 * u16::from(channel));
            }
        }
    }
}
