//! The chips of one I2C bus, and the displays that hang on them: one segment, so that transfers take each other's time,
//! and what befalls a chip reaches all of its displays.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::display::dac7578::{Dac7578, Level};
use crate::display::i2c::{BusClock, Error as I2cError, I2cHandle, I2cSegment};
use crate::display::pca9685::{Config, Edge, Oscillator, Pca9685};
use crate::time::Nanos;

/// The chips of a bus.
#[derive(Clone, Debug)]
pub struct Rack(Arc<Mutex<Shelf>>);

#[derive(Debug)]
struct Shelf {
    i2c: I2cHandle,
    /// The display on each output, and that display's own number of the chip; by chip and channel.
    owners: Vec<[Option<(usize, usize)>; 16]>,
    /// Edges of its outputs that each display has yet to take, with its own numbers of the chips.
    waiting: Vec<Vec<(usize, Edge)>>,
    /// Changes of converters' outputs that each display has yet to take, with its own numbers of the chips.
    levels: Vec<Vec<(usize, Level)>>,
    /// Displays that hold each chip's OE line cut.
    cut_by: Vec<Vec<usize>>,
    /// Time that all chips have reached.
    now: Nanos,
}

impl Rack {
    /// Chips by 7-bit address and oscillator factor, at rest, with nothing on their outputs; and by 7-bit address the
    /// converter of each, where they have any.
    pub fn new(boards: &[(u8, f64)], converters: &[u8], clock: BusClock) -> Self {
        let chip = |&(address, factor): &(u8, f64)| {
            let oscillator = Oscillator::from_factor(factor);
            Pca9685::new(Config {
                oscillator,
                ..Config::new(address)
            })
        };
        let segment = I2cSegment::new(clock, boards.iter().map(chip).collect())
            .with_converters(converters.iter().copied().map(Dac7578::new).collect());
        Self(Arc::new(Mutex::new(Shelf {
            i2c: I2cHandle::new(segment),
            owners: vec![[None; 16]; boards.len()],
            waiting: Vec::new(),
            levels: Vec::new(),
            cut_by: vec![Vec::new(); boards.len()],
            now: Nanos::ZERO,
        })))
    }

    /// The bus that drivers hold.
    pub fn bus(&self) -> I2cHandle {
        self.shelf().i2c.clone()
    }

    /// Connects a display: for each of its chips the place on this bus, and a bit for each channel that is its own.
    pub(super) fn connect(&self, boards: &[(usize, u16)]) -> Connection {
        let mut shelf = self.shelf();
        let display = shelf.waiting.len();
        shelf.waiting.push(Vec::new());
        shelf.levels.push(Vec::new());
        for (own, (chip, channels)) in boards.iter().enumerate() {
            let owners = shelf.owners.get_mut(*chip).into_iter().flatten();
            for (channel, owner) in owners.enumerate() {
                if channels >> channel & 1 == 1 {
                    *owner = Some((display, own));
                }
            }
        }
        drop(shelf);
        Connection {
            rack: self.clone(),
            display,
            chips: boards.iter().map(|(chip, _)| *chip).collect(),
        }
    }

    fn shelf(&self) -> MutexGuard<'_, Shelf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shelf {
    /// Lets time pass until `to`, once for all displays.
    fn advance(&mut self, to: Nanos) -> Result<(), I2cError> {
        if to <= self.now && self.waiting.len() > 1 {
            return Ok(());
        }
        self.now = self.now.max(to);
        let Self {
            i2c,
            owners,
            waiting,
            ..
        } = self;
        i2c.with(|segment| {
            segment.advance(to, &mut |chip, edge| {
                let owner = owners
                    .get(chip)
                    .and_then(|o| o.get(usize::from(edge.channel.0)));
                if let Some((display, own)) = owner.copied().flatten()
                    && let Some(waiting) = waiting.get_mut(display)
                {
                    waiting.push((own, edge));
                }
            });
        })
    }
}

/// A display on a rack.
#[derive(Debug)]
pub(super) struct Connection {
    rack: Rack,
    display: usize,
    /// Place on the bus of each of the display's chips.
    chips: Vec<usize>,
}

impl Connection {
    /// The bus.
    pub(super) fn bus(&self) -> I2cHandle {
        self.rack.bus()
    }

    /// Time that a transaction has carried the bus to.
    pub(super) fn bus_now(&self) -> Nanos {
        let shelf = self.rack.shelf();
        // Refused only from inside another look at the segment, and there is none here.
        shelf.i2c.with(|segment| segment.now()).unwrap_or_default()
    }

    /// Lets time pass until `to`, and takes the edges of its own outputs until then, in the order of time, with its own
    /// numbers of the chips. What a transaction has carried a chip through beyond `to` comes later.
    ///
    /// # Errors
    /// [`I2cError::BusBusy`] from inside a look at the segment.
    pub(super) fn take(&self, to: Nanos, edges: &mut Vec<(usize, Edge)>) -> Result<(), I2cError> {
        let mut shelf = self.rack.shelf();
        shelf.advance(to)?;
        if let Some(waiting) = shelf.waiting.get_mut(self.display) {
            // Stable: of edges at one instant the lower board comes first.
            waiting.sort_by_key(|(_, edge)| edge.at);
            let due = waiting.partition_point(|(_, edge)| edge.at <= to);
            edges.extend(waiting.drain(..due));
        }
        Ok(())
    }

    /// Takes the changes of its converters' outputs until `to`, in the order of time, with its own numbers of the chips.
    ///
    /// # Errors
    /// The errors of [`Self::take`].
    pub(super) fn take_levels(
        &self,
        to: Nanos,
        levels: &mut Vec<(usize, Level)>,
    ) -> Result<(), I2cError> {
        let mut shelf = self.rack.shelf();
        let Shelf {
            i2c,
            owners,
            levels: waiting,
            ..
        } = &mut *shelf;
        i2c.with(|segment| {
            segment.take_levels(to, &mut |chip, level| {
                let owner = owners
                    .get(chip)
                    .and_then(|o| o.get(usize::from(level.channel.0)));
                if let Some((display, own)) = owner.copied().flatten()
                    && let Some(waiting) = waiting.get_mut(display)
                {
                    waiting.push((own, level));
                }
            });
        })?;
        if let Some(waiting) = waiting.get_mut(self.display) {
            waiting.sort_by_key(|(_, level)| level.at);
            let due = waiting.partition_point(|(_, level)| level.at <= to);
            levels.extend(waiting.drain(..due));
        }
        Ok(())
    }

    /// Cuts the OE lines of its chips, or lets go of them: outputs are on again once no display holds them cut.
    pub(super) fn set_outputs(&self, now: Nanos, enabled: bool) {
        let mut shelf = self.rack.shelf();
        let Shelf { i2c, cut_by, .. } = &mut *shelf;
        // Refused only from inside another look at the segment, and there is none here.
        let _ = i2c.with(|segment| {
            for &number in &self.chips {
                let chip = segment.chips_mut().get_mut(number);
                let Some((chip, cut_by)) = chip.zip(cut_by.get_mut(number)) else {
                    continue;
                };
                cut_by.retain(|display| *display != self.display);
                cut_by.extend((!enabled).then_some(self.display));
                let at = chip.now().max(now);
                chip.set_output_enable_pin(at, !cut_by.is_empty());
            }
        });
    }

    /// Does something to the converter beside one of its chips, by the chip's own number.
    pub(super) fn on_converter(&self, own: usize, work: impl FnOnce(&mut Dac7578)) {
        let number = self.chips.get(own).copied();
        // Refused only from inside another look at the segment, and there is none here.
        let _ = self.bus().with(|segment| {
            number
                .and_then(|n| segment.converters_mut().get_mut(n))
                .map(work)
        });
    }

    /// Does something to one of its chips, by its own number.
    pub(super) fn on_chip(&self, own: usize, work: impl FnOnce(&mut Pca9685)) {
        let number = self.chips.get(own).copied();
        // Refused only from inside another look at the segment, and there is none here.
        let _ = self.bus().with(|segment| {
            number
                .and_then(|n| segment.chips_mut().get_mut(n))
                .map(work)
        });
    }
}
