//! What a golden shows is compared: a change of each part of a text, and the words that tell it.

use super::*;
use crate::synthetic;
use crate::trace::Trace;

/// The words for a text in which one piece is another.
fn told(text: &str, from: &str, to: &str) -> Vec<String> {
    assert!(text.contains(from), "{from} in {text}");
    let other = text.replacen(from, to, 1);
    let (a, b) = (Story::read(text).unwrap(), Story::read(&other).unwrap());
    let found = compare(&a, &b, Tolerance::default());
    assert!(found.iter().all(|d| d.meaning), "{from}: {found:?}");
    found.into_iter().map(|d| d.text).collect()
}

/// A short run, every burst of which has its line.
fn schedule() -> (Trace, String) {
    let trace = synthetic::circle(1);
    let text = Story::schedule(&trace).text();
    (trace, text)
}

/// A line of a text.
fn line<'a>(text: &'a str, with: &str) -> &'a str {
    let line = text.lines().find(|line| line.contains(with));
    line.unwrap_or_else(|| panic!("no {with} in {text}"))
}

/// The same text with another last character.
fn altered(text: &str) -> String {
    let (rest, last) = text.split_at(text.len() - 1);
    format!("{rest}{}", if last == "7" { "8" } else { "7" })
}

#[test]
fn charts_are_compared_row_by_row_and_by_their_scale() {
    let (_, text) = schedule();
    let contacts = line(&text, "    contacts ");
    // Of 80 quanta of 10 ms the last.
    let (last, is) = (&contacts[contacts.len() - 1..], altered(contacts));
    let words =
        format!("strip chart: 1 character of contacts differs, first `{last}` -> `7` at 0.790 s");
    assert_eq!(told(&text, contacts, &is), [words]);
    let scale = line(&text, "strip chart: ");
    let (begin, widest) = scale.rsplit_once("9 is ").unwrap();
    let found = told(&text, scale, &scale.replace("10.000 ms", "20.000 ms"));
    let words = begin.replace("10.000 ms", "10.000 -> 20.000 ms");
    assert_eq!(found, [format!("{words}9 is {widest}")]);
    let found = told(&text, scale, &format!("{begin}9 is 99 ticks"));
    let ticks = widest.trim_end_matches(" ticks");
    assert_eq!(found, [format!("{begin}9 is {ticks} -> 99 ticks")]);
    for row in ["wire 5", "events"] {
        let marks = line(&text, &format!("      {row} "));
        let found = told(&text, marks, &altered(marks));
        let words = format!("strip chart: 1 character of {row} differs, first `");
        assert!(
            found.len() == 1 && found[0].starts_with(&words),
            "{found:?}"
        );
    }
    let ruler = line(&text, "0.000 |");
    let found = told(&text, ruler, &ruler.replacen("| ", " |", 1));
    let words = "strip chart: `0.000 |";
    assert!(found.len() == 1 && found[0].starts_with(words), "{found:?}");
}

#[test]
fn a_request_is_compared_beside_what_was_applied() {
    let (trace, text) = schedule();
    let limited = crate::bursts::bursts(&trace);
    let limited = limited.iter().find(|b| b.reason.is_some()).unwrap();
    let asked = format!("{}<{}(", limited.width, limited.requested);
    let found = told(&text, &asked, &format!("{}<4000(", limited.width));
    let by = 4000 - i32::from(limited.requested);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with(&format!("requests for wire 2 change by +{by} ticks (")),
        "{found:?}"
    );
    // Its line among the events says the same in other words.
    let event = line(&text, " limiter   ");
    let found = told(&text, event, &event.replace(" ticks", " tacks"));
    assert!(
        found[0].starts_with("new: limiter at ") && found[1].starts_with("gone: limiter at "),
        "{found:?}"
    );
}

#[test]
fn tables_are_compared_column_by_column() {
    let (_, text) = schedule();
    let row = line(&text, "     3     0:3 ");
    for (from, to, words) in [
        ("  0:3 ", "  1:3 ", "wire 3: output 0:3 -> 1:3"),
        ("+0.00", "+0.01", "wire 3: x +0.00 -> +0.01 mm"),
        ("+14.25", "-14.25", "wire 3: y +14.25 -> -14.25 mm"),
    ] {
        assert_eq!(told(&text, row, &row.replacen(from, to, 1)), [words]);
    }
    let cells: Vec<&str> = row.split_whitespace().collect();
    for (column, name, unit) in [
        (4, "bursts", ""),
        (5, "limited", ""),
        (6, "on", " s"),
        (7, "widest", ""),
        (8, "mean duty", " %"),
        (9, "hottest", " C"),
    ] {
        let (was, is) = (cells[column], altered(cells[column]));
        // Behind the cells before it.
        let place = cells[..column].iter().fold(0, |from, cell| {
            from + row[from..].find(cell).unwrap() + cell.len()
        });
        let changed = format!("{}{}", &row[..place], row[place..].replacen(was, &is, 1));
        let words = format!("wire 3: {name} {was} -> {is}{unit}");
        assert_eq!(told(&text, row, &changed), [words], "{changed}");
    }
}

#[test]
fn parts_used_units_and_places_of_a_map_are_compared() {
    let (trace, text) = schedule();
    let margin = line(&text, "  supply current");
    let percent = margin.split_whitespace().rev().nth(1).unwrap();
    let found = told(&text, margin, &margin.replace(percent, &altered(percent)));
    assert_eq!(found.len(), 1, "{found:?}");
    let is = found[0].strip_prefix("supply current ");
    assert!(is.is_some_and(|is| is.ends_with(" % used")), "{found:?}");
    let unit = told(&text, margin, &margin.replacen(" A ", " V ", 1));
    assert!(unit[0].ends_with(" A -> V"), "{unit:?}");
    let contacts = Story::contacts(&trace).text();
    let found = told(&contacts, "+--", "+-8");
    assert_eq!(
        found,
        ["pad: 1 character differs, first `-` -> `8` in line 2, column 5"]
    );
}

#[test]
fn of_lists_that_are_cut_the_last_lines_and_the_counts_are_compared() {
    let text = Story::schedule(&synthetic::circle(60)).text();
    let story = Story::read(&text).unwrap();
    let last = story.bursts.last().unwrap();
    assert!(story.bursts_untold > 0);
    let told = |a: &Story, b: &Story| -> Vec<String> {
        let found = compare(a, b, Tolerance::default());
        found.into_iter().map(|d| d.text).collect()
    };
    let mut other = story.clone();
    other.bursts.last_mut().unwrap().width += 1;
    let words = format!("pulses of {} change by +1 ticks", last.output);
    let found = told(&story, &other);
    assert!(found.iter().any(|t| t.starts_with(&words)), "{found:?}");
    let mut other = story.clone();
    other.bursts_untold += 1;
    let found = told(&story, &other);
    let words = "bursts differ after ";
    assert!(found.iter().any(|t| t.starts_with(words)), "{found:?}");
    // The same of events and rows.
    let mut cut = story.clone();
    cut.happenings_untold = 3;
    let mut other = cut.clone();
    other.happenings.last_mut().unwrap().text.push('!');
    let found = told(&cut, &other);
    assert!(found.iter().any(|t| t.starts_with("new: ")), "{found:?}");
    let mut other = cut.clone();
    other.happenings_untold = 4;
    other.table.untold = 2;
    let all = story.happenings.len() + 3;
    let events = format!("{all} -> {} events, and the same ones have a line", all + 1);
    let rows = "rows beyond those listed: 0 -> 2".to_owned();
    assert_eq!(told(&cut, &other), [rows, events]);
}

#[test]
fn bands_hold_for_every_measured_number_and_for_no_setting() {
    let tolerance = Tolerance::HARDWARE;
    for (a, b, same) in [
        ("rmse 0.194 mm", "rmse 0.690 mm", true),
        ("rmse 0.194 mm", "rmse 0.695 mm", false),
        ("from 0.831 s", "from 0.833 s", true),
        ("from 0.831 s", "from 0.834 s", false),
        ("hottest 40.000 C", "hottest 41.999 C", true),
        ("hottest 40.000 C", "hottest 42.200 C", false),
        ("levels 1..3", "levels 2..3", true),
        ("levels 1..3", "levels 3..3", false),
        ("916 in contact", "915 in contact", true),
        ("person a", "person b", false),
        ("rmse 0.194 mm", "rmse nan mm", false),
    ] {
        assert_eq!(tolerance.alike(a, b), same, "{a}, {b}");
        assert!(!Tolerance::default().alike(a, b));
    }
    let real = |text: &str| Story::read(&text.replacen("(emulated)", "(real)", 1)).unwrap();
    let (_, text) = schedule();
    let other = text.replacen("length 1.000 s", "length 1.001 s", 1);
    assert_eq!(compare(&real(&text), &real(&other), tolerance), []);
    let other = text.replacen("SOA 58.500 ms", "SOA 58.501 ms", 1);
    let found = compare(&real(&text), &real(&other), tolerance);
    assert_eq!(found[0].text, "SOA 58.500 -> 58.501 ms");
}
