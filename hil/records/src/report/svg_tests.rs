//! Tests of `svg.rs`.

use super::*;

#[test]
fn what_means_something_to_html_is_escaped() {
    assert_eq!(escape("<a b='c'>&\u{7}"), "&lt;a b=&#39;c&#39;&gt;&amp; ");
}

/// Production 2 of XML 1.0 has neither; a parser refuses the whole document.
#[test]
fn characters_that_xml_forbids_are_replaced() {
    assert_eq!(escape("a\u{FFFE}b\u{FFFF}"), "a\u{FFFD}b\u{FFFD}");
    assert_eq!(escape("\u{1F980}\u{FFFD}"), "\u{1F980}\u{FFFD}");
}
