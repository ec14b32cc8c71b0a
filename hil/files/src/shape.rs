//! JSON texts of one shape: messages of a sensor differ in their numbers alone, and those need no tree of values.

use serde_json::Value;

use super::objects::flatten;

/// Longest number that is taken as it stands, bytes.
const LONGEST: usize = 17;

/// The text around the numbers of an object, and the order in which a table has them.
#[derive(Debug)]
pub(super) struct Shape {
    /// Texts before each number, and behind the last one.
    around: Vec<Vec<u8>>,
    /// For each column the place of its number in the text.
    order: Vec<usize>,
    /// Bounds of the numbers of the text under way.
    bounds: Vec<(usize, usize)>,
}

impl Shape {
    /// The shape of a JSON text whose numbers have these names; none where it has other numbers as well, such as those in texts.
    pub(super) fn find(json: &[u8], names: &[String]) -> Option<Self> {
        let (mut around, mut piece, mut counted) = (Vec::new(), Vec::new(), Vec::new());
        let (mut at, mut in_text) = (0, false);
        while let Some(byte) = json.get(at) {
            let length = if in_text { 0 } else { number(&json[at..]) };
            if length > 0 {
                // in place of each number its place: the tree of values tells where it puts them
                counted.extend_from_slice(&piece);
                counted.extend(around.len().to_string().bytes());
                around.push(std::mem::take(&mut piece));
                at += length;
                continue;
            }
            in_text ^= *byte == b'"';
            let width = if in_text && *byte == b'\\' { 2 } else { 1 };
            piece.extend(json.iter().skip(at).take(width));
            at += width;
        }
        counted.extend_from_slice(&piece);
        let count = around.len();
        around.push(piece);
        let value: Value = serde_json::from_slice(&counted).ok()?;
        let mut leaves = Vec::new();
        flatten("", &value, &mut leaves);
        let is_same = leaves.len() == count && leaves.iter().map(|l| &l.0).eq(names);
        let order: Option<Vec<usize>> =
            leaves.iter().map(|(_, place)| place.parse().ok()).collect();
        let mut places = order.clone()?;
        places.sort_unstable();
        // a number that is only in part one of ours has another place
        let is_whole = is_same && places.into_iter().eq(0..count);
        Some(Self {
            order: order.filter(|_| is_whole)?,
            around,
            bounds: Vec::new(),
        })
    }

    /// Adds the numbers of a text, each with `,` in front; false where the text has another shape.
    pub(super) fn add(&mut self, json: &[u8], row: &mut Vec<u8>) -> bool {
        self.bounds.clear();
        let mut at = 0;
        for (place, piece) in self.around.iter().enumerate() {
            if !json[at..].starts_with(piece) {
                return false;
            }
            at += piece.len();
            if place < self.order.len() {
                let length = number(&json[at..]);
                if length == 0 {
                    return false;
                }
                self.bounds.push((at, at + length));
                at += length;
            }
        }
        if at < json.len() {
            return false;
        }
        for place in &self.order {
            let (from, to) = self.bounds[*place];
            row.push(b',');
            row.extend_from_slice(&json[from..to]);
        }
        true
    }
}

/// Length of a number at the beginning of a text; 0 for none, and for one that a table writes in another way.
fn number(json: &[u8]) -> usize {
    let digits = |from: usize| {
        json.iter()
            .skip(from)
            .take_while(|b| b.is_ascii_digit())
            .count()
    };
    let sign = usize::from(json.first() == Some(&b'-'));
    let whole = digits(sign);
    let mut length = sign + whole;
    let is_fraction = json.get(length) == Some(&b'.');
    if is_fraction {
        let places = digits(length + 1);
        length += 1 + places;
        if places == 0 {
            return 0;
        }
    }
    let begins_zero = json.get(sign) == Some(&b'0');
    let is_odd = begins_zero && (whole > 1 || (sign > 0 && !is_fraction));
    let goes_on = matches!(json.get(length), Some(b'e' | b'E'));
    if whole == 0 || is_odd || goes_on || length > LONGEST {
        return 0;
    }
    length
}

#[cfg(test)]
#[path = "shape_tests.rs"]
mod tests;
