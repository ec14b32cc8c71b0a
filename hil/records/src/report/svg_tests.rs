//! Tests of `svg.rs`.

use super::*;

#[test]
fn what_means_something_to_html_is_escaped() {
    assert_eq!(escape("<a b='c'>&\u{7}"), "&lt;a b=&#39;c&#39;&gt;&amp; ");
}
