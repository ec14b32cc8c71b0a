//! A temperature beyond the model has no number.

use super::*;

#[test]
fn a_temperature_beyond_the_model_has_no_number() {
    assert_eq!(words(Some(34.86), TISSUE_C), "34.9 C");
    assert_eq!(words(Some(100.0), TISSUE_C), "100.0 C");
    assert_eq!(words(None, TISSUE_C), "-");
    for beyond in [1202.1, f64::INFINITY, f64::NAN] {
        let told = words(Some(beyond), TISSUE_C);
        assert_eq!(told, "beyond the model (over 100 C)");
        assert_eq!(known(beyond, WIRE_C), None);
        assert_eq!(on_page(beyond, WIRE_C), "> 400 \u{b0}C");
    }
}
