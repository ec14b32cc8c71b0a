//! Values between commas.

use super::*;

#[test]
fn commas_between_brackets_and_quotes_belong_to_a_value() {
    let values = |text| axis(text).unwrap().values;
    assert_eq!(values("a=1, 2,x"), ["1", "2", "x"]);
    assert_eq!(
        values("a=[[0, 1], [2, 3]],[4]"),
        ["[[0, 1], [2, 3]]", "[4]"]
    );
    assert_eq!(
        values("a=\"x,y\",{ b = 1, c = 2 }"),
        ["\"x,y\"", "{ b = 1, c = 2 }"]
    );
    assert_eq!(axis("bench.a = 1").unwrap().key, "bench.a");
    for bad in ["a", "=1", "a=", "a=1,,2", "a=1,\n2"] {
        assert!(axis(bad).is_err(), "{bad}");
    }
}
