//! The page's files belong together.

use super::*;

#[test]
fn what_is_said_otherwise_stands_in_the_page_once() {
    let page = file("/").unwrap();
    for over in [Page::Live, Page::Recording] {
        let text = page.text("127.0.0.1:1", over);
        for (what, instead) in over.otherwise() {
            assert_eq!(page.text.matches(what).count(), 1, "{what}");
            assert!(text.contains(instead), "{instead}");
        }
        assert!(text.contains("connect-src 'self' ws://127.0.0.1:1;"));
        assert_eq!(text.contains("frame-src"), over == Page::Recording);
    }
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
