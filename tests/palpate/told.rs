//! What a file shows is compared: any one character that is another is told by `hil diff`, or refused as damage.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use palpate_records::contacts_csv::write_table;
use palpate_records::damage::Damage;
use palpate_records::diff::{Contacts, Tolerance, compare, compare_contacts};
use palpate_records::schedule::write_schedule;
use palpate_records::story::Story;
use palpate_records::trace::{DisplayInfo, Trace};
use proptest::prelude::*;
use proptest::sample::Index;

use crate::goldens::shipped;

/// The text of each golden that ships, by its file's name, without insta's heading.
fn goldens() -> &'static [(String, String)] {
    static ALL: OnceLock<Vec<(String, String)>> = OnceLock::new();
    ALL.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/goldens");
        let files = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
        let golden = |path: &PathBuf| {
            let text = fs::read_to_string(path).unwrap();
            let (_, body) = text.split_once("\n---\n").unwrap();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, body.to_owned())
        };
        let mut paths: Vec<_> = files
            .filter(|p| p.extension().is_some_and(|e| e == "snap"))
            .collect();
        paths.sort();
        paths.iter().map(golden).collect()
    })
}

/// A run of two contacts.
fn trace() -> &'static Trace {
    static RUN: OnceLock<Trace> = OnceLock::new();
    RUN.get_or_init(|| shipped("two-finger-press").trace)
}

/// A text in which one character that can be seen is another, and what was done to it; the first lines stay.
fn altered(text: &str, after: usize, at: Index, with: char) -> Option<(String, String)> {
    let first: usize = text.split_inclusive('\n').take(after).map(str::len).sum();
    let seen = |(_, c): &(usize, char)| c.is_ascii_graphic();
    let places: Vec<usize> = text[first..]
        .char_indices()
        .filter(seen)
        .map(|(place, _)| first + place)
        .collect();
    let place = places[at.index(places.len())];
    let mut other = text.to_owned();
    other.replace_range(place..=place, with.encode_utf8(&mut [0; 4]));
    let line = text[..place].matches('\n').count() + 1;
    let what = format!("line {line}: {} -> {with}", &text[place..=place]);
    (other != text).then_some((other, what))
}

/// Whether a story is told apart from one that was read, if it could be.
fn apart(a: &Story, b: &Result<Story, Damage>) -> bool {
    match b {
        Ok(b) => a.kind != b.kind || !compare(a, b, Tolerance::between(a, b)).is_empty(),
        Err(_) => true,
    }
}

/// The run's golden.
fn golden() -> &'static Story {
    static GOLDEN: OnceLock<Story> = OnceLock::new();
    GOLDEN.get_or_init(|| Story::read(&Story::schedule(trace()).text()).unwrap())
}

/// The run's schedule file as it is written, and as it is read from a text.
fn schedule() -> &'static (String, Story) {
    static FILE: OnceLock<(String, Story)> = OnceLock::new();
    FILE.get_or_init(|| {
        let mut bytes = Vec::new();
        write_schedule(trace(), &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let story = read_schedule(&text).unwrap();
        (text, story)
    })
}

fn read_schedule(text: &str) -> Result<Story, Damage> {
    Story::of_schedule_file(text, |_| trace().header.wires.clone())
}

/// The run's contacts, as those of one display and of several.
fn contacts() -> &'static [String; 2] {
    static TABLES: OnceLock<[String; 2]> = OnceLock::new();
    TABLES.get_or_init(|| {
        let mut trace = trace().clone();
        let table = |trace: &Trace| {
            let mut bytes = Vec::new();
            write_table(trace, &mut bytes).unwrap();
            String::from_utf8(bytes).unwrap()
        };
        let one = table(&trace);
        trace.header.displays = vec![DisplayInfo {
            name: "thumb, \"left\"".to_owned(),
            wires: 8,
            modules: vec![0],
        }];
        [one, table(&trace)]
    })
}

/// How many differences two tables of contacts have.
fn compared(a: &str, b: &str) -> Result<usize, Damage> {
    let open = |text: &str| {
        let mut lines: Vec<String> = text.lines().rev().map(str::to_owned).collect();
        Contacts::new(move || Ok(lines.pop()), |damage| damage)
    };
    let (mut a, mut b) = (open(a)?, open(b)?);
    Ok(compare_contacts(&mut a, &mut b, Tolerance::default())?.len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_character_of_a_golden(
        golden in any::<Index>(),
        at in any::<Index>(),
        with in prop::char::range(' ', '~'),
    ) {
        let (name, text) = golden.get(goldens());
        if let Some((other, what)) = altered(text, 0, at, with) {
            let (a, b) = (Story::read(text).unwrap(), Story::read(&other));
            prop_assert!(apart(&a, &b), "{} {}", name, what);
            if let Ok(b) = b {
                prop_assert!(apart(&b, &Ok(a)), "{} {}", name, what);
            }
        }
    }

    #[test]
    fn any_character_of_a_schedule(
        at in any::<Index>(),
        with in prop::char::range(' ', '~'),
    ) {
        let (text, file) = schedule();
        if let Some((other, what)) = altered(text, 0, at, with) {
            prop_assert!(apart(file, &read_schedule(&other)), "{}", what);
        }
        // A golden shows the records, and less of the header.
        if let Some((other, what)) = altered(text, 1, at, with) {
            prop_assert!(apart(golden(), &read_schedule(&other)), "golden, {}", what);
        }
    }

    #[test]
    fn any_character_of_contacts(
        several in 0_usize..2,
        at in any::<Index>(),
        with in prop::char::range(' ', '~'),
    ) {
        let text = &contacts()[several];
        if let Some((other, what)) = altered(text, 0, at, with) {
            prop_assert_ne!(compared(text, &other), Ok(0), "{}", what);
        }
    }
}

#[test]
fn what_is_the_same_differs_in_nothing() {
    let (_, file) = schedule();
    for (a, b) in [(file, file), (file, golden()), (golden(), file)] {
        assert_eq!(compare(a, b, Tolerance::default()), []);
    }
    for text in contacts() {
        assert_eq!(compared(text, text), Ok(0));
    }
}
