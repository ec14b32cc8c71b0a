//! The bench of an image in QEMU: emulated chips in another process, two named pipes, one question and one answer at a
//! time. The image reaches the pipes by semihosting: its processor and its clock stand still until the answer is there, so
//! that runs repeat to the microsecond.
//!
//! | at | bytes | question |
//! |---|---|---|
//! | 0 | 8 | the image's clock, ns |
//! | 8 | 1 | [`Kind`] |
//! | 9 | 1 | its argument: an address, a level |
//! | 10 | 2 | bytes that follow |
//!
//! | at | bytes | answer |
//! |---|---|---|
//! | 0 | 8 | a time, ns: the end of a transfer, the next look for a datagram, a conversion |
//! | 8 | 1 | [`Outcome`] |
//! | 9 | 1 | 0 |
//! | 10 | 2 | bytes that follow |
//!
//! The bytes of a transfer are its operations: 0 and a length for a read; 1, a length and the data for a write.

mod bridge;
mod client;
#[cfg(target_os = "none")]
mod pipes;
mod programs;

pub use bridge::{Bridge, Gone};
pub use client::{Bus, BusError, Network, Oe, Rig, Wires};
#[cfg(target_os = "none")]
pub use pipes::Pipes;
pub use programs::{ADDRESSES, LIMITS, WIRES, guard, lockstep, unit};

/// Bytes before those of a question or an answer.
pub const HEAD: usize = 12;
/// Name of the pipe that carries questions, in the folder where QEMU runs.
pub const QUESTIONS: &core::ffi::CStr = c"questions";
/// Name of the pipe that carries answers.
pub const ANSWERS: &core::ffi::CStr = c"answers";

/// Question of an image to its rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Asks first of all for a number that no start had before, 8 bytes.
    Boot,
    /// Sets the level of the OE line.
    Oe,
    /// A transfer with this address.
    Transfer,
    /// Asks for a datagram that waits.
    Receive,
    /// Sends a datagram.
    Send,
    /// Asks for the next question to the guard.
    Ask,
    /// Tells the guard's answer: how far the clock counted, 4 bytes, and the answer.
    Tell,
    /// A signal on the bus, for a machine that has an I2C controller of its own: a [`Signal`] with its byte. The answer is a
    /// byte that was read, or 1 for an acknowledgement.
    Signal,
    /// Asks for the codes of both thermistors of the Peltier module. The answer's time is that of the conversion; 2
    /// bytes per code, the face's first. [`Outcome::Nothing`] says that the rig has no module.
    Sensors,
    /// Sets the bridge's current from now on: mA in 4 bytes, signed, positive where it cools; and its length in us, 4
    /// bytes, after which the bridge lets go by itself.
    Bridge,
}

/// Signal of a controller on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Signal {
    /// START, or START again: the address, with 1 in its last bit to read.
    Start,
    /// A byte to the chip.
    Write,
    /// A byte from the chip.
    Read,
    /// STOP.
    Stop,
}

impl Signal {
    /// Every signal, by its number.
    pub const ALL: [Self; 4] = [Self::Start, Self::Write, Self::Read, Self::Stop];
}

impl Kind {
    /// Every kind, by its number.
    pub const ALL: [Self; 10] = [
        Self::Boot,
        Self::Oe,
        Self::Transfer,
        Self::Receive,
        Self::Send,
        Self::Ask,
        Self::Tell,
        Self::Signal,
        Self::Sensors,
        Self::Bridge,
    ];
}

/// Outcome of a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// Done; what was asked for follows.
    Done,
    /// No chip at this address.
    NoAddress,
    /// A byte was refused.
    NoData,
    /// Another master has the bus.
    Arbitration,
    /// The bus failed.
    Failed,
    /// The clock line is held low for ever: the transfer never ends.
    Stuck,
    /// The thing that was asked for is not there.
    Nothing,
}

impl Outcome {
    const ALL: [Self; 7] = [
        Self::Done,
        Self::NoAddress,
        Self::NoData,
        Self::Arbitration,
        Self::Failed,
        Self::Stuck,
        Self::Nothing,
    ];
}

/// The head of a question or an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// Nanoseconds.
    pub ns: u64,
    /// [`Kind`] or [`Outcome`].
    pub what: u8,
    /// The argument of a question.
    pub argument: u8,
    /// Bytes that follow.
    pub length: u16,
}

impl Head {
    /// Bytes of the head.
    pub fn bytes(&self) -> [u8; HEAD] {
        let mut bytes = [0; HEAD];
        bytes[..8].copy_from_slice(&self.ns.to_le_bytes());
        (bytes[8], bytes[9]) = (self.what, self.argument);
        bytes[10..].copy_from_slice(&self.length.to_le_bytes());
        bytes
    }

    /// Reads a head from its bytes.
    pub fn read(bytes: &[u8; HEAD]) -> Self {
        let [a, b, c, d, e, f, g, h, what, argument, low, high] = *bytes;
        Self {
            ns: u64::from_le_bytes([a, b, c, d, e, f, g, h]),
            what,
            argument,
            length: u16::from_le_bytes([low, high]),
        }
    }

    /// Kind of a question; `None` for a number that no kind has.
    pub fn kind(&self) -> Option<Kind> {
        Kind::ALL.get(usize::from(self.what)).copied()
    }

    /// Outcome of an answer; `None` for a number that no outcome has.
    pub fn outcome(&self) -> Option<Outcome> {
        Outcome::ALL.get(usize::from(self.what)).copied()
    }
}

#[cfg(test)]
mod tests;
