//! The words of the documentation in the code: a doc comment has to stand alone.

use std::fs;

use super::tidy::{complain, lines_with, production, root};

/// Openings by which a comment continues the sentence of its parent, such as "What it costs."
const CONTINUATIONS: [&str; 21] = [
    "And", "As", "But", "How", "It", "Its", "Not", "Of", "One that", "So", "That", "The same",
    "They", "Those", "What", "When", "Where", "Whether", "Which", "Who", "Why",
];

/// True if a text opens with one of the [`CONTINUATIONS`] as whole words.
fn continues(text: &str) -> bool {
    let is_word = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    CONTINUATIONS
        .iter()
        .any(|opening| text.strip_prefix(opening).is_some_and(is_word))
}

/// The opening of every doc comment in a text with its line, from 1.
fn doc_comments(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut inside = false;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim_start();
        let lines = ["///", "//!"].iter().find_map(|m| line.strip_prefix(m));
        if let Some(opening) = lines.filter(|_| !inside) {
            found.push((number + 1, opening.trim()));
        }
        inside = lines.is_some();
        let blocks = line.split("/** ").skip(1);
        found.extend(blocks.map(|opening| (number + 1, opening)));
    }
    found
}

#[test]
fn doc_comments_and_continuations_are_found() {
    let text = "//! A room.\n//! What it holds.\n\n/// What it costs, J.\nfn cost() {}\n    /// Itself.\n    \
                /// The same.\n\n    //// Where\n choice! { /** How it is. */ Kind {\n  /** A kind. */ One }}\n";
    let openings = [
        (1, "A room."),
        (4, "What it costs, J."),
        (6, "Itself."),
        (10, "How it is. */ Kind {"),
        (11, "A kind. */ One }}"),
    ];
    let mut found = doc_comments(text);
    found.retain(|(_, opening)| !opening.starts_with('/'));
    assert_eq!(found, openings);
    found.retain(|(_, opening)| continues(opening));
    assert_eq!(found, [openings[1], openings[3]]);
}

#[test]
fn doc_comments_stand_alone() {
    let (mut all, mut fragments) = (0, Vec::new());
    for path in production() {
        let text = fs::read_to_string(&path).unwrap();
        let comments = doc_comments(&text);
        all += comments.len();
        let short = path.strip_prefix(root()).unwrap().display().to_string();
        let torn = comments
            .into_iter()
            .filter(|(_, opening)| continues(opening));
        fragments.extend(torn.map(|(line, opening)| format!("{short}:{line}: {opening}")));
    }
    assert!(
        fragments.len() * 100 < all,
        "expected under 1 % of {all} doc comments to continue the sentence of their parent, found {}; write a noun \
         phrase or a third-person verb that stands alone:\n  {}",
        fragments.len(),
        fragments.join("\n  ")
    );
}

#[test]
fn functions_have_names_of_what_they_do() {
    let nameless = [concat!("fn o", "f("), concat!("fn o", "f<")];
    let offences: Vec<String> = lines_with("", &nameless);
    complain("a function's name says what it does or gives", offences);
}
