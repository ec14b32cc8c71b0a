//! Several displays of a bench: a fingertip each, on boards and a supply that they share.

use serde::Deserialize;

use super::{Bench, BenchKind, Output, STATED};
use crate::address::check_chip;
use crate::error::FileError;
use crate::layout::DisplayLayout;
use crate::source::Source;

/// Most displays of a bench, and most boards.
const MOST: usize = 16;

/// One of several displays of a bench: a fingertip.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BenchDisplay {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// A display layout: a built-in name or a file; left out: the bench's `display`, which a real bench then states.
    pub layout: Option<String>,
    /// The emulated person who wears it: a built-in name or a file; left out: the scene's.
    pub person: Option<String>,
    /// The calibration of that person: a built-in name or a file; left out: the scene's.
    pub wearer: Option<String>,
    /// The hand that wears it, lower case with hyphens; left out: all such displays are on one hand.
    pub hand: Option<String>,
    /// One entry per wire; left out of all displays: the outputs of one chip after the other, from 0x40 on. A real
    /// bench states them.
    #[serde(default)]
    pub outputs: Vec<Output>,
}

impl Bench {
    /// Checks the displays, and collects their connections in `outputs`.
    pub(super) fn join_displays(&mut self, source: &Source, adapters: u8) -> Result<(), FileError> {
        if self.displays.is_empty() {
            return Ok(());
        }
        if !self.outputs.is_empty() {
            let expected = "nothing: every one of [[displays]] has its own";
            return Err(source.bad_found("outputs", expected, "outputs of the bench"));
        }
        source.range("displays", &self.displays.len(), 1..=MOST, "displays")?;
        let stated = self.displays.iter().any(|d| !d.outputs.is_empty());
        let mut displays = std::mem::take(&mut self.displays);
        for (index, display) in displays.iter_mut().enumerate() {
            let at = |key: &str| format!("displays[{index}].{key}");
            source.name(&at("name"), &display.name)?;
            if let Some(hand) = &display.hand {
                source.name(&at("hand"), hand)?;
            }
            if self.kind == BenchKind::Real {
                if display.layout.is_none() && !source.states("display") {
                    return Err(source.bad(&at("layout"), STATED));
                }
                if display.outputs.is_empty() {
                    return Err(source.bad(&at("outputs"), STATED));
                }
            }
            let (layout, _) = self.layout_of(source, index, display)?;
            let first = self.outputs.len();
            let wires = layout.wires_mm.len();
            if !stated {
                display.outputs = (first..first + wires).map(Output::nth).collect();
            }
            if display.outputs.len() != wires {
                let expected = format!("{wires} outputs, one per wire of `{}`", layout.name);
                let found = display.outputs.len().to_string();
                return Err(source.bad_found(&at("outputs"), expected, found));
            }
            self.outputs.append(&mut display.outputs.clone());
        }
        self.displays = displays;
        // An emulated bench takes any number of boards and adapters.
        let buses = match self.kind {
            BenchKind::Real => adapters,
            BenchKind::Emulated => MOST as u8,
        };
        self.check_displays(source, buses)?;
        self.check_supply(source)
    }

    /// Checks that every name, and every channel of a board, belongs to one display alone.
    fn check_displays(&self, source: &Source, buses: u8) -> Result<(), FileError> {
        let mut taken: Vec<(Output, &str)> = Vec::new();
        for (index, display) in self.displays.iter().enumerate() {
            let key = format!("displays[{index}]");
            if self.displays[..index]
                .iter()
                .any(|d| d.name == display.name)
            {
                let expected = "a name of its own: another display has this one";
                return Err(source.bad(&format!("{key}.name"), expected));
            }
            for (wire, output) in display.outputs.iter().enumerate() {
                let at = |name: &str| format!("{key}.outputs[{wire}].{name}");
                source.range(&at("bus"), &output.bus, 0..=buses - 1, "")?;
                check_chip(source, &at("board"), output.board)?;
                source.range(&at("channel"), &output.channel, 0..=15, "")?;
                if output.bus != display.outputs[0].bus {
                    let bus = display.outputs[0].bus;
                    let expected = format!("{bus}: the wires of one display are on one bus");
                    return Err(source.bad(&at("bus"), expected));
                }
                if let Some((_, owner)) = taken.iter().find(|(other, _)| other == output) {
                    let expected = format!(
                        "an output of its own: display `{owner}` has channel {} of board 0x{:02x}",
                        output.channel, output.board
                    );
                    return Err(source.bad(&at("channel"), expected));
                }
                taken.push((*output, &display.name));
            }
        }
        let boards = self.boards();
        let expected = format!("at most {MOST} boards");
        let found = boards.to_string();
        let many = || source.bad_found("displays", expected, found);
        (boards <= MOST).then_some(()).ok_or_else(many)
    }

    /// Number of boards that the outputs are on.
    #[must_use]
    pub fn boards(&self) -> usize {
        let boards = self.outputs.iter().map(|o| (o.bus, o.board));
        boards.collect::<std::collections::BTreeSet<_>>().len()
    }

    /// Checks the supply. Boards run asynchronously, so one wire of each may have its current at one instant.
    fn check_supply(&self, source: &Source) -> Result<(), FileError> {
        let (boards, wire) = (self.boards(), self.drive.current_ma);
        let needed = boards as f64 * wire;
        if self.drive.supply_limit_ma >= needed {
            return Ok(());
        }
        let expected = format!(
            "at least {needed} mA: {boards} boards with one wire of {wire} mA each, which are not in step"
        );
        let found = format!("{} mA", self.drive.supply_limit_ma);
        Err(source.bad_found("drive.supply_limit_ma", expected, found))
    }

    /// The layout of a display, and its text.
    pub(crate) fn layout_of(
        &self,
        source: &Source,
        index: usize,
        display: &BenchDisplay,
    ) -> Result<(DisplayLayout, Source), FileError> {
        let (name, key) = match &display.layout {
            Some(name) => (name, format!("displays[{index}].layout")),
            None => (&self.display, "display".to_owned()),
        };
        DisplayLayout::named(name, source, &key)
    }
}
