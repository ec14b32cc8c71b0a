//! The page's files belong together.

use super::*;

#[test]
fn what_is_said_otherwise_stands_in_the_page_once() {
    for over in [Page::Live, Page::Recording, Page::Study] {
        let page = file("/", over).unwrap();
        let text = page.text("127.0.0.1:1", over, false);
        for (what, instead) in over.otherwise() {
            assert_eq!(page.text.matches(what).count(), 1, "{what}");
            assert!(text.contains(instead), "{instead}");
        }
        assert!(text.contains("connect-src 'self' ws://127.0.0.1:1;"));
        assert_eq!(text.contains("frame-src"), over == Page::Recording);
        let open = text.replace("<body ", "<body data-token ");
        assert_ne!(text, open);
        assert_eq!(page.text("127.0.0.1:1", over, true), open);
    }
}

#[test]
fn everything_that_is_imported_is_there() {
    let live = FILES.iter().map(|file| (file, Page::Live));
    let study = STUDY.iter().map(|file| (file, Page::Study));
    for (script, page) in live
        .chain(study)
        .filter(|(file, _)| file.media_type == JAVASCRIPT)
    {
        for line in script
            .text
            .lines()
            .filter(|line| line.starts_with("import "))
        {
            let folder = script
                .path
                .rsplit_once('/')
                .map_or("", |(folder, _)| folder);
            let name = match line.split_once("\"./") {
                Some((_, beside)) => format!("{folder}/{beside}"),
                None => line.split("\"palpate").nth(1).unwrap().to_owned(),
            };
            let name = name.trim_end_matches("\";");
            assert!(
                file(name, page).is_some(),
                "{} asks for {name}",
                script.path
            );
        }
    }
}

#[test]
fn the_page_of_a_notebook_has_all_that_it_loads() {
    let (page, scripts) = notebook();
    for part in [
        "<body class=\"notebook\">",
        "<style>",
        "import \"palpate/notebook.js\"",
        "script-src data:",
        "{ \"imports\": { \"palpate/\": \"./\" } }",
    ] {
        assert_eq!(page.matches(part).count(), 1, "{part}");
    }
    assert!(!page.contains("main.js") && !page.contains("href=\"style.css\""));
    for (script, text) in &scripts {
        for line in text.lines().filter(|line| line.starts_with("import ")) {
            let asked = line.split("\"palpate/").nth(1).unwrap();
            let asked = asked.trim_end_matches("\";");
            let there = scripts.iter().any(|(name, _)| *name == asked);
            assert!(there, "{script} asks for {asked}");
        }
    }
}
