//! A bench's `[dac]`: converters that set the currents of the amplifiers.

use palpate_core::codec::dac7578::{ADDRESSES, BROADCAST_ADDRESS, CHANNELS};
use palpate_core::codec::link::MOST_CURRENT;

use super::{Bench, Output};
use crate::error::FileError;
use crate::settings::{bounds, settings};
use crate::source::Source;

settings! {
    /// A DAC7578 beside each board, which sets the current of that board's outputs 0 to 7; `drive.current_ma` is then the current
    /// at its full scale. Left out: the amplifiers have that current and no other.
    pub struct BenchDac {
        /// The converters' I2C addresses, 0x48 to 0x4f: one per board, in the order of the boards' buses and addresses.
        pub addresses: Vec<u8> = vec![*ADDRESSES.start()],
        /// Shortest pulse, microseconds: a weaker level has less current instead.
        pub shortest_us: f64 = 50.0,
        /// Largest deviation of a current from what was set, a part of that.
        pub gain_tolerance: f64 = 0.01,
        /// Largest deviation beside that, mA.
        pub offset_tolerance_ma: f64 = 5.0,
        /// Current of an emulated amplifier over what was set, within the tolerance.
        pub gain: f64 = 1.0,
        /// Current that it adds to that, mA, within the tolerance.
        pub offset_ma: f64 = 0.0,
    }

    /// One converter, and amplifiers of one per cent: resistors and reference of half a per cent each.
    default
}

impl BenchDac {
    fn check(&self, source: &Source) -> Result<(), FileError> {
        let (gain, offset) = (self.gain_tolerance, self.offset_tolerance_ma);
        bounds!(source, "dac", self;
            shortest_us: 0.0..=200.0, "us";
            gain_tolerance: 0.0..=0.2;
            offset_tolerance_ma: 0.0..=100.0, "mA";
            gain: 1.0 - gain..=1.0 + gain;
            offset_ma: -offset..=offset, "mA")
    }

    /// The most current that flows at a setting, mA.
    fn most_ma(&self, set_ma: f64) -> f64 {
        set_ma * (1.0 + self.gain_tolerance) + self.offset_tolerance_ma
    }
}

impl Bench {
    /// Checks the converters against the outputs, which are known by then.
    pub(super) fn check_dac(&self, source: &Source) -> Result<(), FileError> {
        let Some(dac) = &self.dac else {
            return Ok(());
        };
        dac.check(source)?;
        self.check_addresses(source, dac)?;
        if self.unit.is_some() && self.drive.current_ma > f64::from(MOST_CURRENT) {
            let expected =
                format!("at most {MOST_CURRENT} mA with [unit]: its link carries no more");
            let found = format!("{} mA", self.drive.current_ma);
            return Err(source.bad_found("drive.current_ma", expected, found));
        }
        self.check_most(source, dac)
    }

    /// The most that an amplifier gives, mA.
    #[must_use]
    pub fn most_ma(&self) -> f64 {
        let set = self.drive.current_ma;
        self.dac.as_ref().map_or(set, |dac| dac.most_ma(set).ceil())
    }

    /// The bus of each board, in the order of the converters' addresses.
    fn bus_of_boards(&self) -> Vec<u8> {
        let boards = self.outputs.iter().map(|o| (o.bus, o.board));
        let boards: std::collections::BTreeSet<_> = boards.collect();
        boards.into_iter().map(|(bus, _)| bus).collect()
    }

    /// Checks that each board has a converter, at an address that nothing else on the bus answers to, and each wire
    /// an output of one.
    fn check_addresses(&self, source: &Source, dac: &BenchDac) -> Result<(), FileError> {
        for (index, output) in self.outputs.iter().enumerate() {
            let key = |name: &str| match (source.states("outputs"), &*self.displays) {
                (true, _) => format!("outputs[{index}].{name}"),
                (false, []) => "display".to_owned(),
                (false, _) => "displays".to_owned(),
            };
            if output.channel >= CHANNELS {
                let expected = "channels 0 to 7 with [dac]: a DAC7578 has eight outputs";
                return Err(source.bad(&key("channel"), expected));
            }
            if output.board == BROADCAST_ADDRESS {
                let expected = "another address than 0x47 with [dac]: every DAC7578 obeys that";
                return Err(source.bad(&key("board"), expected));
            }
        }
        let buses = self.bus_of_boards();
        let (boards, found) = (buses.len(), dac.addresses.len());
        if boards != found {
            let expected = format!("as many addresses as boards, {boards}");
            return Err(source.bad_found("dac.addresses", expected, found.to_string()));
        }
        for (index, address) in dac.addresses.iter().enumerate() {
            let key = format!("dac.addresses[{index}]");
            if !ADDRESSES.contains(address) {
                let expected = "0x48 to 0x4f, which the pins ADDR0 and ADDR1 give";
                return Err(source.bad_found(&key, expected, format!("{address:#04x}")));
            }
            let here = |o: &&Output| (o.bus, o.board) == (buses[index], *address);
            let board = self.outputs.iter().find(here).is_some();
            let mut before = buses.iter().zip(&dac.addresses).take(index);
            if board || before.any(|other| other == (&buses[index], address)) {
                let expected =
                    format!("an address of its own: another chip answers at {address:#04x}");
                return Err(source.bad_found(&key, expected, format!("{address:#04x}")));
            }
        }
        Ok(())
    }

    /// Checks that the supply bears the least load at one instant: one wire, at the most that its amplifier gives.
    fn check_most(&self, source: &Source, dac: &BenchDac) -> Result<(), FileError> {
        let (set, supply) = (self.drive.current_ma, self.drive.supply_limit_ma);
        // Boards of several displays are not in step.
        let together = if self.displays.is_empty() {
            1
        } else {
            self.boards()
        };
        let most = together as f64 * self.most_ma();
        if supply >= most {
            return Ok(());
        }
        let wires = if together == 1 {
            "one wire".into()
        } else {
            format!("a wire of each of {together} boards")
        };
        let expected = format!(
            "at least {most} mA: {wires} set to {set} mA, {} % and {} mA more by [dac]",
            dac.gain_tolerance * 100.0,
            dac.offset_tolerance_ma
        );
        Err(source.bad_found("drive.supply_limit_ma", expected, format!("{supply} mA")))
    }
}
