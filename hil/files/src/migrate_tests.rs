//! Tests of `migrate.rs`.

use super::*;
use crate::check_source;

const HEADING: &str = "name = \"mine\"\ndescription = \"d\" # a remark\n";

fn texts(body: &str) -> (String, usize) {
    let source = Source::new("f.toml", format!("{HEADING}{body}"));
    let found = migrated(&source).unwrap();
    let checked = check_source(Source::new("f.toml", &*found.text));
    assert_eq!(checked.errors, [], "{}", found.text);
    assert!(found.text.starts_with(HEADING), "{}", found.text);
    (found.text, found.changes.len())
}

#[test]
fn a_key_that_went_becomes_a_comment_wherever_it_stands() {
    for body in [
        "length_s = 2.0\n[illusion]\nsmallest_step = 0.2 # felt\nmodel = \"energy\"\n",
        "length_s = 2.0\nillusion.smallest_step = 0.2\n",
        "length_s = 2.0\nillusion = { smallest_step = 0.2, model = \"energy\" }\n",
        "length_s = 2.0\nillusion = { model = \"energy\", smallest_step = 0.2 }\n",
    ] {
        let (text, changes) = texts(body);
        assert_eq!(changes, 1, "{text}");
        let energy = |text: &str| text.contains("model = \"energy\"");
        assert_eq!(energy(&text), energy(body), "{text}");
    }
    let (text, _) = texts("length_s = 2.0\nillusion.smallest_step = 0.2\n");
    assert!(
        text.ends_with("\n# illusion.smallest_step = 0.2\n"),
        "{text}"
    );
}

#[test]
fn a_wire_of_the_cosine_follows_play() {
    let wire = palpate_fixtures::wire("final-75um").unwrap();
    for law in [
        "hysteresis = { law = \"cosine\", pieces = 8 }\n",
        "hysteresis.law = \"cosine\"\nhysteresis.pieces = 8\n",
    ] {
        let source = Source::new("w.toml", format!("{law}{wire}"));
        let found = migrated(&source).unwrap();
        let checked = check_source(Source::new("w.toml", found.text));
        assert_eq!((checked.errors, found.changes.len()), (vec![], 1));
    }
    assert_eq!(migrated(&Source::new("w.toml", wire)), None);
}
