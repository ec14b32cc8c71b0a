//! The wording of differences: what changed between two texts of the same shape, times, counts.

use crate::fixed::milli;

/// What names a header's piece: its first word without a digit.
pub(super) fn item_key(piece: &str) -> &str {
    let has_digit = |w: &str| w.bytes().any(|b| b.is_ascii_digit());
    let mut words = piece.split_whitespace();
    words.find(|w| !has_digit(w)).unwrap_or(piece)
}

/// Two texts as one, with what differs written `old -> new` between the words around it.
pub(super) fn change(a: &str, b: &str) -> String {
    let (a, b): (Vec<&str>, Vec<&str>) = (
        a.split_whitespace().collect(),
        b.split_whitespace().collect(),
    );
    let front = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let rest = a.len().min(b.len()) - front;
    let back = a.iter().rev().zip(b.iter().rev());
    let back = back.take(rest).take_while(|(x, y)| x == y).count();
    let middle = |words: &[&str]| match &words[front..words.len() - back] {
        [] => "nothing".to_owned(),
        words => words.join(" "),
    };
    let mut parts = a[..front].to_vec();
    let changed = format!("{} -> {}", middle(&a), middle(&b));
    parts.push(&changed);
    parts.extend(&a[a.len() - back..]);
    parts.join(" ")
}

/// Two rows of a table: each word that differs with its neighbours.
pub(super) fn changes(key: &str, a: &str, b: &str) -> String {
    let strip = |t: &str| -> Vec<String> {
        let rest = t.strip_prefix(key).unwrap_or(t).trim_start_matches(':');
        rest.split_whitespace().map(str::to_owned).collect()
    };
    let (x, y) = (strip(a), strip(b));
    if x.len() != y.len() {
        return format!("{key}: {} -> {}", x.join(" "), y.join(" "));
    }
    let is_word = |w: &&String| {
        w.bytes()
            .next()
            .is_some_and(|b| b.is_ascii_alphabetic() || b == b'%')
    };
    let mut told = Vec::new();
    for (i, (old, new)) in x.iter().zip(&y).enumerate().filter(|(_, (o, n))| o != n) {
        let mut text = String::new();
        let lead: Vec<&str> = x[..i]
            .iter()
            .rev()
            .take_while(is_word)
            .take(2)
            .map(String::as_str)
            .collect();
        for word in lead.iter().rev().filter(|w| !w.ends_with(',')) {
            text.push_str(word);
            text.push(' ');
        }
        let (old, new) = (old.trim_end_matches(','), new.trim_end_matches(','));
        text.push_str(&format!("{old} -> {new}"));
        if let Some(unit) = x.get(i + 1).filter(is_word) {
            text.push(' ');
            text.push_str(unit.trim_end_matches([',', ';']));
        }
        told.push(text);
    }
    format!("{key}: {}", told.join(", "))
}

/// Microseconds as milliseconds, without zeros at the end.
pub(super) fn ms(us: u64) -> String {
    format!("{} ms", short(i64::try_from(us).unwrap_or(i64::MAX)))
}

/// Thousandths without zeros at the end.
pub(super) fn short(thousandths: i64) -> String {
    let text = milli(thousandths);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// As [`short`], with its sign.
pub(super) fn signed(thousandths: i64) -> String {
    let sign = if thousandths >= 0 { "+" } else { "" };
    format!("{sign}{}", short(thousandths))
}

/// `1 burst`, `2 bursts`.
pub(super) fn count(n: usize, what: &str) -> String {
    let s = if n == 1 { "" } else { "s" };
    format!("{n} {what}{s}")
}

/// `0.877 s`.
pub(super) fn at(us: u64) -> String {
    format!("{} s", crate::fixed::seconds(us))
}

/// `a, b and c`.
pub(super) fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_stands_between_what_does_not() {
        assert_eq!(
            change("tau_d 35.000 ms", "tau_d 40.079 ms"),
            "tau_d 35.000 -> 40.079 ms"
        );
        assert_eq!(change("a b", "a b c"), "a b nothing -> c");
        assert_eq!(change("x x", "x x x"), "x x nothing -> x");
        assert_eq!(change("", ""), "nothing -> nothing");
        assert_eq!(item_key("916 in contact"), "in");
        assert_eq!(item_key("12"), "12");
    }

    #[test]
    fn rows_are_told_word_by_word() {
        let key = "at 1 N and 2 mm/s";
        let a = "at 1 N and 2 mm/s: peak duty 1.000 %, energy 3.000 mJ";
        let b = "at 1 N and 2 mm/s: peak duty 1.000 %, energy 4.000 mJ";
        assert_eq!(
            changes(key, a, b),
            "at 1 N and 2 mm/s: energy 3.000 -> 4.000 mJ"
        );
        assert_eq!(ms(5_079), "5.079 ms");
        assert_eq!(ms(5_000), "5 ms");
        assert_eq!(signed(-2_100), "-2.1");
    }
}
