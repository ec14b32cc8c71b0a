//! The page's files belong together.

use super::*;

#[test]
fn what_is_said_otherwise_stands_in_the_page_once() {
    let page = file("/").unwrap();
    for (what, instead) in OTHERWISE {
        assert_eq!(page.text.matches(what).count(), 1, "{what}");
        assert!(page.text("127.0.0.1:1").contains(instead), "{instead}");
    }
    assert!(
        page.text("127.0.0.1:1")
            .contains("connect-src 'self' ws://127.0.0.1:1;")
    );
}

#[test]
fn everything_that_is_imported_is_there() {
    for script in FILES.iter().filter(|file| file.media_type == JAVASCRIPT) {
        for line in script
            .text
            .lines()
            .filter(|line| line.starts_with("import "))
        {
            let name = line
                .split("\"palpate")
                .nth(1)
                .unwrap()
                .trim_end_matches("\";");
            assert!(file(name).is_some(), "{} asks for {name}", script.path);
        }
    }
}
