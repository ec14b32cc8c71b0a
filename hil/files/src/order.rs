//! The order of columns by their names: numbers in them count, and the axes x, y, z; where they stand in the file does not.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Columns whose names differ by numbers, and by axes, alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Group {
    /// The name with `#` in place of its numbers, and `?` in place of the axis.
    pub(super) pattern: String,
    /// Places in the file, in the order of the numbers and, within a number, of the axes.
    pub(super) places: Vec<usize>,
    /// True if the names say the axis.
    pub(super) has_axes: bool,
}

impl Group {
    /// True if the file has the columns in another order.
    pub(super) fn is_mended(&self) -> bool {
        !self.places.is_sorted()
    }
}

/// Numbers and places of the columns of one shape.
type Numbered = Vec<(Vec<u64>, usize)>;

/// The groups among columns, the first in the file first.
pub(super) fn groups<'n>(columns: impl Iterator<Item = (usize, &'n str)>) -> Vec<Group> {
    let mut shapes: BTreeMap<String, Numbered> = BTreeMap::new();
    for (place, name) in columns {
        if let Some((shape, numbers)) = shape(name) {
            shapes.entry(shape).or_default().push((numbers, place));
        }
    }
    for columns in shapes.values_mut() {
        columns.sort();
    }
    shapes.retain(|_, columns| columns.windows(2).all(|pair| pair[0].0 != pair[1].0));
    let mut taken = BTreeSet::new();
    let mut groups = Vec::new();
    for shape in shapes.keys() {
        if taken.contains(shape) {
            continue;
        }
        if let Some((pattern, axes)) = axes(shape, &shapes) {
            let columns = axes.iter().map(|shape| shapes[shape].as_slice());
            groups.push(Group {
                pattern,
                places: woven(&columns.collect::<Vec<_>>()),
                has_axes: true,
            });
            taken.extend(axes);
        }
    }
    for (shape, columns) in shapes {
        if !taken.contains(&shape) {
            groups.push(Group {
                places: columns.iter().map(|(_, place)| *place).collect(),
                pattern: shape,
                has_axes: false,
            });
        }
    }
    groups.sort_by_key(|group| group.places.iter().min().copied());
    groups
}

/// The name with `#` for each number in it, and the numbers; none where it has none.
fn shape(name: &str) -> Option<(String, Vec<u64>)> {
    let (mut shape, mut numbers) = (String::new(), Vec::new());
    let mut rest = name;
    while let Some(begin) = rest.find(|c: char| c.is_ascii_digit()) {
        let (text, from) = rest.split_at(begin);
        let end = from.find(|c: char| !c.is_ascii_digit());
        let (digits, after) = from.split_at(end.unwrap_or(from.len()));
        shape.push_str(text);
        shape.push('#');
        numbers.push(digits.parse().ok()?);
        rest = after;
    }
    shape.push_str(rest);
    (!numbers.is_empty()).then_some((shape, numbers))
}

/// The last number in a name.
pub(super) fn number_in(name: &str) -> Option<u64> {
    shape(name)?.1.pop()
}

/// The three shapes that differ from each other by an axis, with as many columns of the same numbers; the pattern they share.
fn axes(shape: &str, shapes: &BTreeMap<String, Numbered>) -> Option<(String, [String; 3])> {
    let numbers = |shape: &String| -> Option<Vec<&Vec<u64>>> {
        Some(shapes.get(shape)?.iter().map(|(n, _)| n).collect())
    };
    for (place, letter) in shape.char_indices().rev() {
        let variants = match letter {
            'x' => ["x", "y", "z"],
            'X' => ["X", "Y", "Z"],
            _ => continue,
        };
        let with = |letter: &str| {
            let mut variant = shape.to_owned();
            variant.replace_range(place..=place, letter);
            variant
        };
        let variants = variants.map(with);
        let [x, y, z] = variants.each_ref().map(&numbers);
        if x.is_some() && x == y && y == z {
            return Some((with("?"), variants));
        }
    }
    None
}

/// x, y and z of the first number, then of the next.
fn woven(axes: &[&[(Vec<u64>, usize)]]) -> Vec<usize> {
    let count = axes.first().map_or(0, |x| x.len());
    let of = |number: usize| {
        axes.iter()
            .filter_map(move |axis| Some(axis.get(number)?.1))
    };
    (0..count).flat_map(of).collect()
}

/// Names that makers give to values that they have computed from counts.
const COMPUTED: [&str; 4] = ["force", "newton", "calib", "temp"];

/// True if a name is one of values that were computed from counts.
pub(super) fn is_computed(name: &str) -> bool {
    let lower = name.to_lowercase();
    COMPUTED.iter().any(|word| lower.contains(word))
}

/// A choice between groups as people would make it.
pub(super) fn listed(groups: &[&Group]) -> String {
    let mut text = String::new();
    for group in groups {
        let comma = if text.is_empty() { "" } else { ", " };
        // A string takes whatever is written.
        let _ = write!(text, "{comma}{} of `{}`", group.places.len(), group.pattern);
    }
    text
}

#[cfg(test)]
#[path = "order_tests.rs"]
mod tests;
