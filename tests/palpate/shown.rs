//! Code that a page shows is an example's own, which CI compiles and runs. The line before a block links to the file.

use std::fs;
use std::path::Path;

/// Pages whose Rust code is all from files.
const PAGES: [&str; 4] = [
    "core/README.md",
    "docs/emulators.md",
    "emulators/README.md",
    "hil/run/README.md",
];

/// A text without the indentation of its lines: a page shows the inside of a function from the margin.
fn unindented(text: &str) -> String {
    let lines = text.lines().map(|line| format!("{}\n", line.trim()));
    lines.collect()
}

/// The file that a line links to last, where it announces a block.
fn announced(line: &str) -> Option<&str> {
    let (_, link) = line.strip_suffix(':')?.rsplit_once("](")?;
    Some(link.split_once(')')?.0)
}

#[test]
fn code_that_a_page_shows_is_in_the_file_it_links_to() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for page in PAGES.map(|page| root.join(page)) {
        let text = fs::read_to_string(&page).unwrap();
        let fenced: Vec<&str> = text.split("\n```").collect();
        let mut shown = 0;
        for pair in fenced.chunks_exact(2) {
            // Between a command and its output stands nothing.
            let before = pair[0].trim_end().lines().last().unwrap_or_default();
            let (language, code) = pair[1].split_once('\n').unwrap();
            let at = format!("{}: {before}", page.display());
            let Some(file) = announced(before) else {
                assert!(!language.starts_with("rust"), "{at}: names no file");
                continue;
            };
            let file = fs::read_to_string(page.parent().unwrap().join(file)).unwrap();
            assert!(
                format!("\n{}", unindented(&file)).contains(&format!("\n{}", unindented(code))),
                "{at}: the file has other text"
            );
            shown += 1;
        }
        assert!(shown > 1, "{}: shows nothing", page.display());
    }
}
