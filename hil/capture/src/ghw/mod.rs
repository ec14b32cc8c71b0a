//! GHW dumps, the waveforms that GHDL writes of signals in VHDL.
//!
//! A dump has sections: names, types, a hierarchy of signals, their values at the beginning, and cycles of changes. It is read in
//! one pass, so that the memory is that of its names and edges. Only signals of one bit are kept. A dump ends with a
//! directory, without which it is unfinished.

mod hierarchy;
mod input;
mod types;

use std::collections::BTreeMap;
use std::io::Read;

use palpate_files::FileError;

use self::input::Input;
use self::types::{Scalar, Types};
use super::declared::{Declared, Wrong};
use super::dump::level;
use super::edges::Capture;
use super::{MOST_CHANGES, too_long};

/// Femtoseconds of a nanosecond. A dump counts femtoseconds.
const FS_PER_NS: u64 = 1_000_000;
/// Sections before the values, as the directory counts them: names, types, types known well, the hierarchy and its end.
const HEAD_SECTIONS: u32 = 5;

/// A dump as far as it was read.
struct Dump<R> {
    input: Input<R>,
    types: Types,
    declared: Declared<u32>,
    /// Numbers and kinds of all scalars, in the order of their values.
    scalars: Vec<(u32, Scalar)>,
    sections: u32,
    zero: Option<i64>,
    /// Time of the cycle that is read, femtoseconds since the first.
    now: u64,
    /// Levels at that time by the places of their signals. The last cycle of several at one time counts.
    levels: BTreeMap<usize, Option<bool>>,
    changes: usize,
}

/// Reads a dump.
///
/// # Errors
/// [`FileError`] for a damaged or unfinished dump, and more changes than are held.
pub(super) fn read(label: &str, input: impl Read) -> Result<Capture, FileError> {
    let told = |(expected, found): Wrong| FileError::whole(label, expected, found);
    let mut dump = Dump::declared(Input::new(input)).map_err(told)?;
    dump.sections().map_err(told)?;
    if dump.changes > MOST_CHANGES {
        return Err(too_long(label, None));
    }
    let end_ns = dump.now / FS_PER_NS;
    Ok(Capture::of_dump(dump.declared.signals, 1, end_ns))
}

impl<R: Read> Dump<R> {
    /// Reads all but the values.
    fn declared(mut input: Input<R>) -> Result<Self, Wrong> {
        input.expect(b"GHDLwave\n\x10\0")?;
        let version = input.byte()?;
        let order = input.byte()?;
        let _sizes: [u8; 2] = input.take()?;
        input.expect(&[0])?;
        if version > 1 || !matches!(order, 1 | 2) {
            return Err(input.wrong());
        }
        input.is_big_endian = order == 2;
        let names = types::names(&mut input)?;
        let types = Types::read(&mut input, version)?;
        let (declared, scalars) = hierarchy::declared(&mut input, &names, &types)?;
        Ok(Self {
            input,
            types,
            declared,
            scalars,
            sections: HEAD_SECTIONS,
            zero: None,
            now: 0,
            levels: BTreeMap::new(),
            changes: 0,
        })
    }

    /// Reads values up to the end, or until there are more changes than are held.
    fn sections(&mut self) -> Result<(), Wrong> {
        while self.changes <= MOST_CHANGES {
            self.input.part = "values of all signals, cycles, then a directory";
            self.sections = self.sections.saturating_add(1);
            match &self.input.take()? {
                b"SNP\0" => self.snapshot()?,
                b"CYC\0" => self.cycles()?,
                b"DIR\0" if self.zero.is_some() => return self.directory(),
                _ => return Err(self.input.wrong()),
            }
        }
        Ok(())
    }

    /// Reads the values of all signals at a time.
    fn snapshot(&mut self) -> Result<(), Wrong> {
        self.input.part = "a whole snapshot of all values";
        self.input.expect(&[0; 4])?;
        let time = self.input.wide()?;
        self.advance(time)?;
        for index in 0..self.scalars.len() {
            self.value(index)?;
        }
        self.input.expect(b"ESN\0")
    }

    /// Reads cycles. Each has the signals that change, by their distances, and the time to the next.
    fn cycles(&mut self) -> Result<(), Wrong> {
        self.input.part = "whole cycles of changes in the order of time";
        let mut time = self.input.wide()?;
        while self.changes <= MOST_CHANGES {
            self.advance(time)?;
            let mut number = 0_u64;
            loop {
                match self.input.number()? {
                    0 => break,
                    distance => number = number.saturating_add(distance),
                }
                self.value(usize::try_from(number - 1).unwrap_or(usize::MAX))?;
            }
            match self.input.signed()? {
                -1 => return self.input.expect(b"ECY\0"),
                step => time = time.checked_add(step).ok_or_else(|| self.input.wrong())?,
            }
        }
        Ok(())
    }

    /// Goes on to a time.
    fn advance(&mut self, time: i64) -> Result<(), Wrong> {
        let zero = *self.zero.get_or_insert(time);
        let since = time.checked_sub(zero).and_then(|fs| u64::try_from(fs).ok());
        let since = since.filter(|since| *since >= self.now);
        let since = since.ok_or_else(|| self.input.wrong())?;
        if since > self.now {
            self.take_levels();
        }
        self.now = since;
        Ok(())
    }

    /// Takes the levels of the time that is over.
    fn take_levels(&mut self) {
        let ns = self.now / FS_PER_NS;
        while let Some((place, level)) = self.levels.pop_first() {
            let signal = &mut self.declared.signals[place];
            self.changes += usize::from(signal.change(ns, level));
        }
    }

    /// Reads a value.
    fn value(&mut self, index: usize) -> Result<(), Wrong> {
        let scalar = self.scalars.get(index).copied();
        let (number, scalar) = scalar.ok_or_else(|| self.input.wrong())?;
        match scalar {
            Scalar::Integer => _ = self.input.signed()?,
            Scalar::Real => _ = self.input.take::<8>()?,
            Scalar::Literal(enumeration) => {
                let literal = self.input.byte()?;
                let literals = self.types.literals(enumeration);
                if u64::from(literal) >= literals.count {
                    return Err(self.input.wrong());
                }
                if let Some(place) = self.declared.place(&number) {
                    let sign = literals.signs[usize::from(literal)];
                    self.levels.insert(place, level(sign).flatten());
                }
            }
        }
        Ok(())
    }

    /// Reads the directory and the end of the file.
    fn directory(&mut self) -> Result<(), Wrong> {
        self.take_levels();
        self.input.part = "a whole directory at the end of the file";
        let _order: [u8; 4] = self.input.take()?;
        if self.input.word()? != self.sections {
            return Err(self.input.wrong());
        }
        for _ in 0..self.sections {
            let _entry: [u8; 8] = self.input.take()?;
        }
        self.input.expect(b"EOD\0TAI\0")?;
        let _order_and_place: [u8; 8] = self.input.take()?;
        self.input.end()
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod writer;
