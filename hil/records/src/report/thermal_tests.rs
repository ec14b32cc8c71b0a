//! Tests of `thermal.rs`.

use super::*;
use crate::synthetic;

#[test]
fn the_page_takes_any_temperature() {
    let odd = Warmth {
        t_s: 1.0,
        wire_c: f64::NAN,
        shallow_c: 1e6,
        deep_c: f64::INFINITY,
        mean_c: -40.0,
    };
    for trace in [synthetic::empty(), synthetic::circle(1)] {
        let mut page = String::new();
        section(&mut page, &trace, &[odd, odd]);
        assert!(!page.contains("NaN") && !page.contains("inf\""));
        let open = page.matches("<section>").count();
        assert_eq!((open, page.matches("</section>").count()), (1, 1));
    }
}
