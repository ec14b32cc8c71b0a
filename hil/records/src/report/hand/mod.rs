//! The report of a run with several displays: one page with the robot's hand and the wearer's drawn, what every finger
//! came to, and a link to the page of each.

mod cards;
mod drawing;
mod lanes;
mod skeleton;

use std::fmt::Write;

use super::{foot, page, tables};
use crate::trace::Trace;
use crate::verdict::Conclusion;

/// A module of the robot's skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pad {
    /// Name of the module in the layout.
    pub name: String,
    /// Centre of the module in the plane of the whole skin, mm.
    pub place_mm: [f64; 2],
    /// Places of the taxels that are read, from the module's centre, mm.
    pub taxels_mm: Vec<[f64; 2]>,
}

/// Results of a finger.
#[derive(Clone, Copy, Debug)]
pub struct FingerReport<'a> {
    /// Name of the finger's display.
    pub name: &'a str,
    /// File of the finger's own page, beside this one.
    pub file: &'a str,
    /// Run of the finger: boards and modules by the numbers of bench and skin.
    pub trace: &'a Trace,
    /// Modules of the finger by their numbers in the skin; the first drives unless all are merged.
    pub modules: &'a [usize],
    /// `true` where all modules of the finger drive, as one skin in the plane of all.
    pub merged: bool,
    /// Conclusion of the finger's run.
    pub conclusion: &'a Conclusion,
}

impl FingerReport<'_> {
    /// Tells whether contacts of this module drive the display.
    fn drives(&self, module: u16) -> bool {
        self.merged || self.modules.first() == Some(&usize::from(module))
    }
}

/// Content of a hand's page.
#[derive(Clone, Copy, Debug)]
pub struct HandReport<'a> {
    /// The run of all fingers.
    pub trace: &'a Trace,
    /// Every module of the skin.
    pub pads: &'a [Pad],
    /// Every finger, in the bench's order.
    pub fingers: &'a [FingerReport<'a>],
    /// Making of the page, such as command, date and host: names and values.
    pub made: &'a [(&'static str, String)],
    /// Conclusion of the run.
    pub conclusion: &'a Conclusion,
}

/// The page of a hand, which needs no other file; it links to the fingers' own pages.
pub fn hand_html(hand: &HandReport<'_>) -> String {
    let mut page = String::with_capacity(512 * 1024);
    page.push_str(&page::head(&tables::title(&hand.trace.header.scene)));
    tables::heading(&mut page, hand.trace);
    tables::verdict(&mut page, hand.trace, Some(hand.conclusion));
    drawing::section(&mut page, hand);
    lanes::section(&mut page, hand);
    cards::section(&mut page, hand);
    tables::ledger(&mut page, hand.trace);
    tables::events(&mut page, hand.trace);
    tables::made(&mut page, hand.trace, hand.made);
    page + &foot(hand.trace, "")
}

/// A file's name as a link from a page beside it.
fn link(file: &str) -> String {
    let mut out = String::from("./");
    for byte in file.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => {
                out.push(char::from(byte));
            }
            other => {
                let _ = write!(out, "%{other:02X}");
            }
        }
    }
    out
}

#[cfg(test)]
#[path = "hand_tests.rs"]
mod tests;
