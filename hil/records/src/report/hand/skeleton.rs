//! Places of the fingers of a drawn hand: a right hand, or a left one, with its palm towards the reader. Millimetres.
//!
//! A skin's layout says where modules are in a plane, not how a hand is built. So the hand is drawn after a person's,
//! by the names of its fingers; names that no hand has stand side by side.

/// Distance of two fingers' axes.
const PITCH: f64 = 40.0;
/// Length of a palm below the knuckles.
const PALM: f64 = 84.0;
/// A thumb's direction: 37 degrees off the others'.
const ASIDE: (f64, f64) = (0.6, 0.8);

/// A finger: its axis starts at its base and points to its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Digit {
    /// Index of the finger among the page's.
    pub finger: usize,
    base: (f64, f64),
    /// The axis's direction, a unit vector.
    axis: (f64, f64),
    /// Length from base to tip.
    pub length: f64,
}

impl Digit {
    /// Place on the page of a point `across` to the right of the axis and `along` it from the base.
    pub fn at(&self, (across, along): (f64, f64)) -> (f64, f64) {
        let (x, y) = self.axis;
        (
            self.base.0 + across * y + along * x,
            self.base.1 - across * x + along * y,
        )
    }
}

/// A hand to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hand {
    /// Name of the hand, such as `left`; empty for the only one.
    pub name: &'static str,
    /// Fingers of the hand.
    pub digits: Vec<Digit>,
    /// The palm's left, lower, right and upper edge.
    pub palm: [f64; 4],
}

/// A finger's place in a right hand from the left, and its length; `None` for a name that no hand has.
fn anatomy(name: &str) -> Option<(u8, f64)> {
    match name {
        "little" => Some((0, 82.0)),
        "ring" => Some((1, 98.0)),
        "middle" => Some((2, 104.0)),
        "index" => Some((3, 96.0)),
        "thumb" => Some((4, 86.0)),
        _ => None,
    }
}

/// A name's hand, and the rest of it.
fn side(name: &str) -> (&'static str, &str) {
    for side in ["left", "right"] {
        if let Some(rest) = name.strip_prefix(side).and_then(|n| n.strip_prefix('-')) {
            return (side, rest);
        }
    }
    ("", name)
}

/// The hands of fingers with these names, each at least so long.
pub(super) fn hands(names: &[&str], least: &[f64]) -> Vec<Hand> {
    let mut sides: Vec<&'static str> = Vec::new();
    for name in names {
        let (side, _) = side(name);
        if !sides.contains(&side) {
            sides.push(side);
        }
    }
    sides.into_iter().map(|s| hand(s, names, least)).collect()
}

fn hand(name: &'static str, names: &[&str], least: &[f64]) -> Hand {
    let own = names.iter().enumerate().filter(|(_, n)| side(n).0 == name);
    let mut own: Vec<(usize, Option<(u8, f64)>)> =
        own.map(|(f, n)| (f, anatomy(side(n).1))).collect();
    let known = own.iter().all(|(_, a)| a.is_some());
    let mirrored = name == "left";
    if known {
        own.sort_by_key(|(_, a)| a.map_or(0, |(place, _)| place));
        if mirrored {
            own.reverse();
        }
    }
    let is_thumb = |a: &Option<(u8, f64)>| known && a.is_some_and(|(place, _)| place == 4);
    let straight = own.iter().filter(|(_, a)| !is_thumb(a)).count();
    let half = PITCH * straight.max(1) as f64 / 2.0;
    let mut left = -half + PITCH / 2.0;
    let mut digits = Vec::new();
    for (finger, anatomy) in own {
        let usual = anatomy.filter(|_| known).map_or(98.0, |(_, length)| length);
        let length = usual.max(least.get(finger).copied().unwrap_or(0.0));
        let (base, axis) = if is_thumb(&anatomy) {
            let out = if mirrored { -1.0 } else { 1.0 };
            (
                (out * (half - 14.0), -PALM * 0.62),
                (out * ASIDE.0, ASIDE.1),
            )
        } else {
            left += PITCH;
            ((left - PITCH, -12.0), (0.0, 1.0))
        };
        digits.push(Digit {
            finger,
            base,
            axis,
            length,
        });
    }
    Hand {
        name,
        digits,
        palm: [-half + 2.0, -PALM, half - 2.0, 0.0],
    }
}

#[cfg(test)]
#[path = "skeleton_tests.rs"]
mod tests;
