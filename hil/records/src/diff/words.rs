//! The wording of differences: what changed between two texts of the same shape, times, counts.

use crate::bursts::DrivenOutput;
use crate::fixed::milli;

/// Key of a header's piece: its first word without a digit.
pub(super) fn item_key(piece: &str) -> &str {
    let has_digit = |w: &str| w.bytes().any(|b| b.is_ascii_digit());
    let mut words = piece.split_whitespace();
    words.find(|w| !has_digit(w)).unwrap_or(piece)
}

/// Two texts as one, with what differs written `old -> new` between the words around it.
pub(super) fn change(first: &str, second: &str) -> String {
    let (a, b): (Vec<&str>, Vec<&str>) = (
        first.split_whitespace().collect(),
        second.split_whitespace().collect(),
    );
    if a == b && first != second {
        return format!("`{first}` -> `{second}`");
    }
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

/// The wire of a row's name; `None` for another name.
pub(super) fn wire(name: &str) -> Option<DrivenOutput> {
    let index = name.strip_prefix("wire ")?.parse().ok()?;
    Some(DrivenOutput::Wire(index))
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

/// Thousandths without zeros at the end, with their sign.
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
#[path = "words_tests.rs"]
mod tests;
