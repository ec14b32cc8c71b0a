//! Datagrams between a host and a driver unit: a clear header, a sealed body, a tag. `docs/unit.md` is the description
//! for other languages.
//!
//! The seal is XChaCha20-Poly1305 under a key that host and unit share. The header is the nonce's 24 bytes after the
//! magic, version and kind; all of it is authenticated. A nonce never comes twice under one key: the session's halves
//! are fresh, and the sequence counts the datagrams of each direction.

mod bytes;
mod command;
mod hello;
mod status;

pub use crate::schedule::MOST_PLANNED;
pub use command::{Command, MOST_CURRENT, Planned, Request, Said, Warmth};
pub use hello::{BUSY, HEAT, Hello, INTERNAL, WARMTH};
pub use status::{Face, HELD, State, Status};

use core::fmt;

use chacha20poly1305::{AeadInOut, KeyInit, Tag, XChaCha20Poly1305, XNonce};

/// The version that this code speaks.
pub const VERSION: u8 = 2;
/// First two bytes of every datagram.
pub const MAGIC: [u8; 2] = *b"PU";
/// Bytes of the clear header.
pub const HEADER: usize = 28;
/// Bytes of the tag at the end.
pub const TAG: usize = 16;
/// Most bytes of a datagram: what an Ethernet frame carries after the headers of IPv6 and UDP, and to spare.
pub const MOST: usize = 1400;

/// The bit of a sequence that says that the unit sent it.
pub const FROM_UNIT: u64 = 1 << 63;

/// Kind of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A host asks who is there; no body.
    Knock = 1,
    /// The unit's answer, [`Hello`].
    Hello = 2,
    /// Stimuli to be felt, [`Command`].
    Command = 3,
    /// Report of a unit on a command, [`Status`].
    Status = 4,
}

impl Kind {
    /// Byte in a datagram.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Kind that a datagram's header states; `None` for a datagram too short or of an unknown kind.
    pub fn stated_in(datagram: &[u8]) -> Option<Self> {
        let kinds = [Self::Knock, Self::Hello, Self::Command, Self::Status];
        let number = datagram.get(3)?;
        kinds.into_iter().find(|k| k.number() == *number)
    }

    const fn is_from_unit(self) -> bool {
        matches!(self, Self::Hello | Self::Status)
    }
}

/// The clear part of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Kind of the datagram.
    pub kind: Kind,
    /// The host's half of the session: a number that it never used before with this key.
    pub host: u64,
    /// The unit's half; zero in a knock.
    pub unit: u64,
    /// Counts the datagrams of this sender, below 2^63.
    pub sequence: u64,
}

/// Reason for which a datagram is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// A datagram shorter than header and tag, or longer than [`MOST`].
    #[error("expected a datagram of {} to {MOST} bytes", HEADER + TAG)]
    Length,
    /// A datagram that does not begin with [`MAGIC`].
    #[error("expected a datagram of a driver unit, which begins with \"PU\"")]
    Magic,
    /// A datagram of another version than [`VERSION`].
    #[error(
        "expected version {VERSION} of the link, found {0}: bring host and unit to the same version"
    )]
    Version(u8),
    /// A datagram of no kind, or of one that goes the other way.
    #[error("expected a kind that this end receives, found {0}")]
    Kind(u8),
    /// A tag that does not fit: the key is another, or the datagram was altered on its way.
    #[error("the tag does not fit: expected the key that this unit was given")]
    Forged,
    /// A datagram that was sealed by the right key, with a body that is none of its kind.
    #[error("the body is none of its kind")]
    Body,
    /// A datagram of another session, or one not newer than the newest that was heard.
    #[error("of another session, or not newer than what was heard")]
    Stale,
}

impl Header {
    /// Reads the clear part. It is authentic only once [`Key::open`] has opened the datagram.
    ///
    /// # Errors
    /// [`Refusal`] of a wrong length, magic, version or kind.
    pub fn read(datagram: &[u8]) -> Result<Self, Refusal> {
        if !(HEADER + TAG..=MOST).contains(&datagram.len()) {
            return Err(Refusal::Length);
        }
        let mut reader = bytes::Reader::new(datagram);
        let short = Refusal::Length;
        if [reader.u8().ok_or(short)?, reader.u8().ok_or(short)?] != MAGIC {
            return Err(Refusal::Magic);
        }
        let version = reader.u8().ok_or(short)?;
        if version != VERSION {
            return Err(Refusal::Version(version));
        }
        let number = reader.u8().ok_or(short)?;
        let kind = Kind::stated_in(datagram).ok_or(Refusal::Kind(number))?;
        let host = reader.u64().ok_or(short)?;
        let unit = reader.u64().ok_or(short)?;
        let sequence = reader.u64().ok_or(short)?;
        if (sequence & FROM_UNIT != 0) != kind.is_from_unit() {
            return Err(Refusal::Kind(number));
        }
        Ok(Self {
            kind,
            host,
            unit,
            sequence: sequence & !FROM_UNIT,
        })
    }

    /// Answer to a knock of a version that the unit does not speak: the unit's own version, nothing that is sealed, no
    /// more bytes than came. `None` for any other datagram.
    pub fn other_version(datagram: &[u8]) -> Option<[u8; HEADER + TAG]> {
        let mut reader = bytes::Reader::new(datagram);
        let magic = [reader.u8()?, reader.u8()?];
        let (version, kind, host) = (reader.u8()?, reader.u8()?, reader.u64()?);
        let knocks = magic == MAGIC && version != VERSION && kind == Kind::Knock.number();
        let header = Self {
            kind: Kind::Hello,
            host,
            unit: 0,
            sequence: 0,
        };
        let mut answer = [0; HEADER + TAG];
        answer[..HEADER].copy_from_slice(&header.bytes());
        (knocks && datagram.len() >= answer.len()).then_some(answer)
    }

    fn bytes(&self) -> [u8; HEADER] {
        let mut bytes = [0; HEADER];
        let direction = if self.kind.is_from_unit() {
            FROM_UNIT
        } else {
            0
        };
        let mut writer = bytes::Writer::new(&mut bytes);
        writer.u8(MAGIC[0]);
        writer.u8(MAGIC[1]);
        writer.u8(VERSION);
        writer.u8(self.kind.number());
        writer.u64(self.host);
        writer.u64(self.unit);
        writer.u64(self.sequence & !FROM_UNIT | direction);
        bytes
    }
}

/// A buffer that a datagram is written in.
pub type Buffer = [u8; MOST];

/// The key that a host and its unit share.
#[derive(Clone)]
pub struct Key(XChaCha20Poly1305);

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(..)")
    }
}

/// The part of a header that is the nonce.
fn nonce(header: &[u8; HEADER]) -> XNonce {
    let mut nonce = XNonce::default();
    nonce.copy_from_slice(&header[4..]);
    nonce
}

impl Key {
    /// Key from its 32 bytes.
    pub fn new(bytes: &[u8; 32]) -> Self {
        Self(XChaCha20Poly1305::new(bytes.into()))
    }

    /// Seals the body that `write` puts into the buffer, whose length `write` returns. Returns the datagram.
    pub fn seal<'b>(
        &self,
        header: &Header,
        buffer: &'b mut Buffer,
        write: impl FnOnce(&mut [u8]) -> usize,
    ) -> &'b [u8] {
        let clear = header.bytes();
        buffer[..HEADER].copy_from_slice(&clear);
        let room = &mut buffer[HEADER..MOST - TAG];
        let length = write(room).min(MOST - TAG - HEADER);
        let sealed =
            self.0
                .encrypt_inout_detached(&nonce(&clear), &clear, (&mut room[..length]).into());
        // Refused only for a body of 256 GiB; a tag of zeros is no tag.
        let tag = sealed.unwrap_or_default();
        let end = HEADER + length;
        buffer[end..end + TAG].copy_from_slice(&tag);
        &buffer[..end + TAG]
    }

    /// Opens a datagram in place; returns its body.
    ///
    /// # Errors
    /// [`Refusal::Length`], or [`Refusal::Forged`] with the bytes as they came.
    pub fn open<'d>(&self, datagram: &'d mut [u8]) -> Result<&'d [u8], Refusal> {
        let (clear, rest) = datagram
            .split_first_chunk_mut::<HEADER>()
            .ok_or(Refusal::Length)?;
        let (body, tag) = rest.split_last_chunk_mut::<TAG>().ok_or(Refusal::Length)?;
        let mut wanted = Tag::default();
        wanted.copy_from_slice(tag);
        let opened =
            self.0
                .decrypt_inout_detached(&nonce(clear), &clear[..], (&mut *body).into(), &wanted);
        opened.map(|()| &*body).map_err(|_| Refusal::Forged)
    }
}

#[cfg(test)]
mod tests;
