//! The values of a settings file, as digests take them.

use super::*;

fn values(text: &str) -> String {
    Source::new("a.toml", text).values()
}

#[test]
fn comments_spaces_and_the_order_of_keys_change_no_values() {
    let plain = values("a = 1\nb = [1, 2]\n[c]\nd = \"x\"\n");
    for same in [
        "# said\nb = [ 1, # one\n 2 ]\na=1\n[c]\nd = 'x'\n",
        "c.d = \"x\"\na = 1\nb = [1,2,]\n",
        "a = 1\nb = [1, 2]\nc = { d = \"x\" }",
    ] {
        assert_eq!(values(same), plain, "{same}");
    }
}

#[test]
fn other_values_are_other_values() {
    let texts = [
        "a = [1, 2]",
        "a = [12]",
        "a = [1.0, 2]",
        "a = [\"1\", 2]",
        "a = [[1], 2]",
        "a = [1, 2]\nb = []",
        "a = [1, 2]\nb = {}",
        "a = \"1 2 \"",
        "a = [10:32:00, 1, 2]",
        "a = [\"32:00 1 2 \"]",
        "a = true",
        "a = \"true \"",
    ];
    for (n, one) in texts.iter().enumerate() {
        for other in &texts[..n] {
            assert_ne!(values(one), values(other), "{one} | {other}");
        }
    }
}
