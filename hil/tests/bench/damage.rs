//! Damage to a file that outlives a run: it is cut, a byte of it changes, or another version of the program wrote it.

use std::fs;
use std::path::PathBuf;

use crate::campaign::Draws;

/// Bytes of a ledger's file before its version.
const MAGIC: usize = 8;
/// Bytes of the sum at its end.
const SUM: usize = 8;

/// How a file is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// It ends at a random byte.
    Cut,
    /// A random byte becomes another.
    Byte,
    /// An older version wrote it.
    Older,
    /// A newer version wrote it.
    Newer,
}

impl Damage {
    /// Draws one.
    pub fn draw(draws: &mut Draws) -> Self {
        draws.pick(&[Self::Cut, Self::Byte, Self::Older, Self::Newer])
    }

    /// The version that takes the place of 1.
    const fn version(self) -> Option<u8> {
        match self {
            Self::Older => Some(0),
            Self::Newer => Some(2),
            Self::Cut | Self::Byte => None,
        }
    }
}

/// A file with the bytes that it had.
pub struct Kept {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl Kept {
    /// Reads a file.
    pub fn read(path: PathBuf) -> Self {
        let bytes = fs::read(&path).unwrap();
        Self { path, bytes }
    }

    /// Gives the file its bytes back.
    pub fn restore(&self) {
        self.write(&self.bytes);
    }

    // In place: it stays its owner's, for all users.
    fn write(&self, bytes: &[u8]) {
        fs::write(&self.path, bytes).unwrap();
    }

    /// Damages a file of the ledger.
    pub fn harm_ledger(&self, damage: Damage, draws: &mut Draws) {
        let mut bytes = self.harmed(damage, draws);
        let Some(version) = damage.version().filter(|_| bytes.len() > MAGIC + SUM) else {
            return self.write(&bytes);
        };
        bytes[MAGIC] = version;
        // What another version writes is whole.
        let end = bytes.len() - SUM;
        let sum = bytes[..end]
            .iter()
            .fold(0xCBF2_9CE4_8422_2325_u64, |sum, byte| {
                (sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3)
            });
        bytes[end..].copy_from_slice(&sum.to_le_bytes());
        self.write(&bytes);
    }

    /// Damages a file whose first line ends with its version: a record or a lock.
    pub fn harm_record(&self, damage: Damage, draws: &mut Draws) {
        let mut bytes = self.harmed(damage, draws);
        let line = bytes.iter().position(|byte| *byte == b'\n');
        if let (Some(version), Some(line)) = (damage.version(), line.filter(|line| *line > 0)) {
            bytes[line - 1] = b'0' + version;
        }
        self.write(&bytes);
    }

    fn harmed(&self, damage: Damage, draws: &mut Draws) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        match damage {
            Damage::Cut => bytes.truncate(draws.below(bytes.len().max(1) as u64) as usize),
            Damage::Byte if !bytes.is_empty() => {
                let place = draws.below(bytes.len() as u64) as usize;
                bytes[place] ^= 1 + draws.below(255) as u8;
            }
            _ => {}
        }
        bytes
    }
}
