//! The rig's boards: two PCA9685 on a bus, and what their outputs did; and a Peltier module.

use embedded_hal::i2c::Operation;
use palpate_core::physics::{PeltierParameters, Thermistor};
use palpate_core::units::{Channel, Duration};
use palpate_emulators::display::i2c::{BusClock, Error, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
use palpate_emulators::display::peltier::Peltier;
use palpate_emulators::time::Nanos;
use palpate_image::rig::{Head, Kind, Outcome, Signal};

/// An output that changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// When.
    pub at: Nanos,
    /// Number of its board.
    pub board: usize,
    /// Which output.
    pub channel: Channel,
    /// Whether it is high from then on.
    pub high: bool,
}

/// Air around the sink of the module, degrees C.
const AIR_C: f64 = 25.0;

/// What an image set its bridge to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Current {
    /// When.
    pub at: Nanos,
    /// mA; positive cools the face.
    pub milliamps: i32,
}

/// Boards that an image drives over the rig, and its Peltier module.
#[derive(Debug)]
pub struct Chips {
    segment: I2cSegment,
    /// The module, if there is one.
    pub module: Option<Peltier>,
    /// Whether the OE line is wired.
    pub oe: bool,
    /// The next transfer never ends.
    pub stuck: bool,
    /// No chip answers any more.
    pub dead: bool,
    /// Every change of an output.
    pub levels: Vec<Level>,
    /// Start of every transfer.
    pub transfers: Vec<Nanos>,
    /// When the image started, and started again.
    pub boots: Vec<Nanos>,
    /// Everything that its bridge was set to.
    pub currents: Vec<Current>,
    /// When its thermistors were read.
    pub looks: Vec<Nanos>,
}

/// An answer to a question: time, outcome, bytes.
pub(crate) type Answer = (u64, Outcome, Vec<u8>);

impl Chips {
    /// Two boards at 0x40 and 0x41 on a bus of 400 kbit/s, with an OE line or without.
    pub fn new(oe: bool) -> Self {
        let chips = [0x40, 0x41].map(|address| Pca9685::new(Config::new(address)));
        Self {
            segment: I2cSegment::new(BusClock::Fast, chips.into()),
            module: None,
            oe,
            stuck: false,
            dead: false,
            levels: Vec::new(),
            transfers: Vec::new(),
            boots: Vec::new(),
            currents: Vec::new(),
            looks: Vec::new(),
        }
    }

    /// The same with a Peltier module.
    #[must_use]
    pub fn warm(self) -> Self {
        let (parameters, thermistor) = (PeltierParameters::default(), Thermistor::default());
        Self {
            module: Some(Peltier::new(parameters, thermistor, AIR_C)),
            ..self
        }
    }

    /// Lets time pass until `to`.
    pub fn advance(&mut self, to: Nanos) {
        if let Some(module) = &mut self.module {
            module.advance(to);
        }
        let levels = &mut self.levels;
        self.segment.advance(to, &mut |board, edge| {
            levels.push(Level {
                at: edge.at,
                board,
                channel: edge.channel,
                high: edge.pin == Pin::High,
            });
        });
        // Each chip's are in order of time; both chips' are not.
        self.levels.sort_by_key(|level| level.at);
    }

    /// Whether any output is high now.
    pub fn any_high(&self) -> bool {
        let pins = self.segment.chips().iter().flat_map(Pca9685::pins);
        pins.into_iter().any(|pin| pin == Pin::High)
    }

    /// When an output was last high before `until`, or still is then.
    pub fn last_high(&self, until: Nanos) -> Option<Nanos> {
        let before = self.levels.iter().rev().find(|level| level.at <= until)?;
        let high = before.high || self.any_high();
        Some(if high { until } else { before.at })
    }

    /// Answers what is a question to the boards; `None` for any other.
    pub fn answer(&mut self, head: &Head, bytes: &[u8]) -> Option<Answer> {
        let now = Nanos(head.ns);
        self.advance(now);
        let done = |bytes| Some((head.ns, Outcome::Done, bytes));
        match head.kind()? {
            Kind::Boot => {
                self.boots.push(now);
                done((self.boots.len() as u64).to_le_bytes().to_vec())
            }
            Kind::Oe => {
                if self.oe {
                    for chip in self.segment.chips_mut() {
                        chip.set_output_enable_pin(chip.now(), head.argument > 0);
                    }
                }
                done(Vec::new())
            }
            Kind::Transfer => Some(self.transfer(head, bytes)),
            Kind::Signal => Some(self.signal(head, bytes)),
            Kind::Sensors => {
                let Some(module) = &self.module else {
                    return Some((head.ns, Outcome::Nothing, Vec::new()));
                };
                self.looks.push(now);
                let reading = module.reading();
                let codes = [reading.face.to_le_bytes(), reading.sink.to_le_bytes()];
                let at = reading.at.as_micros() * 1000;
                Some((at, Outcome::Done, codes.concat()))
            }
            Kind::Bridge => {
                let (milliamps, length) = bytes.split_first_chunk()?;
                let length = u32::from_le_bytes(*length.first_chunk()?);
                let milliamps = i32::from_le_bytes(*milliamps);
                self.currents.push(Current { at: now, milliamps });
                if let Some(module) = &mut self.module {
                    module.receive(milliamps, Duration::from_micros(length.into()));
                }
                done(Vec::new())
            }
            _ => None,
        }
    }

    /// A signal of a controller that is the machine's own: all chips are on its bus.
    fn signal(&mut self, head: &Head, bytes: &[u8]) -> Answer {
        let at = Nanos(head.ns);
        let byte = bytes.first().copied().unwrap_or(0);
        let signal = Signal::ALL.get(usize::from(head.argument));
        if signal == Some(&Signal::Start) {
            self.transfers.push(at);
            if std::mem::take(&mut self.stuck) {
                return (u64::MAX, Outcome::Stuck, Vec::new());
            }
        }
        let chips = self.segment.chips_mut().iter_mut();
        let answer = match signal {
            _ if self.dead => 0,
            Some(Signal::Start) => {
                let (address, read) = (byte >> 1, byte & 1 == 1);
                chips.fold(0, |ack, chip| ack | u8::from(chip.start(at, address, read)))
            }
            Some(Signal::Write) => chips.fold(0, |ack, chip| ack | u8::from(chip.write(at, byte))),
            // An open drain: the chip that is not read leaves the line high.
            Some(Signal::Read) => chips.fold(u8::MAX, |read, chip| read & chip.read(at)),
            Some(Signal::Stop) | None => {
                chips.for_each(|chip| chip.stop(at));
                0
            }
        };
        (head.ns, Outcome::Done, vec![answer])
    }

    fn transfer(&mut self, head: &Head, mut bytes: &[u8]) -> Answer {
        self.transfers.push(Nanos(head.ns));
        if std::mem::take(&mut self.stuck) {
            return (u64::MAX, Outcome::Stuck, Vec::new());
        }
        let mut parts: Vec<(bool, Vec<u8>)> = Vec::new();
        while let [write, length, rest @ ..] = bytes {
            let length = usize::from(*length);
            if *write == 0 {
                parts.push((false, vec![0; length]));
                bytes = rest;
            } else {
                let (data, rest) = rest.split_at(length.min(rest.len()));
                parts.push((true, data.to_vec()));
                bytes = rest;
            }
        }
        let each = parts.iter_mut().map(|(write, data)| match write {
            true => Operation::Write(data),
            false => Operation::Read(data),
        });
        let mut operations: Vec<_> = each.collect();
        let result = match self.dead {
            true => Err(Error::AddressNack),
            false => self.segment.transaction(head.argument, &mut operations),
        };
        let outcome = match result {
            Ok(()) => Outcome::Done,
            Err(Error::AddressNack) => Outcome::NoAddress,
            Err(Error::DataNack) => Outcome::NoData,
            Err(Error::ArbitrationLost) => Outcome::Arbitration,
            Err(_) => Outcome::Failed,
        };
        let read = parts.into_iter().filter(|(write, _)| !write);
        let read = read.flat_map(|(_, data)| data).collect();
        (self.segment.now().0, outcome, read)
    }
}
