//! A file of the ledger. Its content is whole and of this version, or it is not believed. It is written to a neighbour
//! and renamed, so that a death leaves the old or the new.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};
use palpate_core::units::Duration;

use super::LedgerError;
use crate::pacer::RunClock;
use crate::shared_file::{create, make, open, open_or_create};

/// First bytes of a file.
const MAGIC: &[u8; 8] = b"palpheat";
/// Mode of the folder: every user may put a new file in place of another user's.
const MODE: u32 = 0o777;
/// Version of the layout: grows when a byte changes its meaning.
const VERSION: u32 = 1;
/// Bytes of the magic, the version and the payload's length.
const HEAD: usize = 16;
/// Bytes of the checksum at the end.
const TAIL: usize = 8;
/// Longest file, bytes: 4096 wires.
const MOST: u64 = 4 << 20;
/// Tries of a file that a run which has ended may still hold: for two seconds.
const TRIES: u32 = 200;
/// The pause between two tries.
const LOOK: Duration = Duration::from_millis(10);

/// FNV-1a checksum of 64 bits: a change of any single byte changes it.
pub(super) fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |sum, byte| {
        (sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3)
    })
}

/// A file, and its content when it was read last.
#[derive(Debug)]
pub(super) struct Account {
    file: PathBuf,
    read: Option<Vec<u8>>,
}

/// An account that no other program can write.
#[derive(Debug)]
pub(super) struct Held {
    account: Account,
    folder: File,
    _lock: Flock<File>,
}

impl Account {
    /// Reads an account of this name.
    ///
    /// # Errors
    /// [`LedgerError::Unreadable`].
    pub(super) fn open(folder: &Path, name: &str) -> Result<Self, LedgerError> {
        let mut account = Self {
            file: folder.join(name),
            read: None,
        };
        account.read = account.bytes()?;
        Ok(account)
    }

    /// Bytes that the account holds; `None` where nothing was kept yet.
    ///
    /// # Errors
    /// [`LedgerError::Unreadable`].
    pub(super) fn payload(&self) -> Result<Option<&[u8]>, LedgerError> {
        let read = self.read.as_deref().map(parse).transpose();
        read.map_err(|why| self.unreadable(why))
    }

    /// Error for an account that cannot be read.
    pub(super) fn unreadable(&self, why: impl Into<String>) -> LedgerError {
        LedgerError::Unreadable {
            file: self.file.clone(),
            why: why.into(),
        }
    }

    fn bytes(&self) -> Result<Option<Vec<u8>>, LedgerError> {
        let mut bytes = Vec::new();
        let read = open(&self.file, false).and_then(|file| file.take(MOST).read_to_end(&mut bytes));
        match read {
            Ok(_) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(self.unreadable(error.to_string())),
        }
    }

    /// Keeps every other program from writing the account.
    ///
    /// # Errors
    /// [`LedgerError::Folder`], [`LedgerError::Held`], and [`LedgerError::Changed`] where the content is no longer the
    /// one that was read.
    pub(super) fn hold(self) -> Result<Held, LedgerError> {
        let (folder, lock) = self.lock()?;
        if self.bytes()? != self.read {
            return Err(LedgerError::Changed(self.file));
        }
        Ok(Held {
            account: self,
            folder,
            _lock: lock,
        })
    }

    /// Takes the file of this name away; whether there was one.
    ///
    /// # Errors
    /// [`LedgerError::Folder`] and [`LedgerError::Held`].
    pub(super) fn forget(folder: &Path, name: &str) -> Result<bool, LedgerError> {
        let account = Self {
            file: folder.join(name),
            read: None,
        };
        if fs::symlink_metadata(&account.file).is_err() {
            return Ok(false);
        }
        let (folder, _lock) = account.lock()?;
        let removed = fs::remove_file(&account.file).and_then(|()| folder.sync_all());
        removed.map_err(|error| account.refused(error))?;
        Ok(true)
    }

    fn lock(&self) -> Result<(File, Flock<File>), LedgerError> {
        let opened = || -> io::Result<(File, File)> {
            let folder = self.folder();
            make(folder, MODE)?;
            Ok((File::open(folder)?, open_or_create(&self.beside("lock"))?))
        };
        let (folder, mut file) = opened().map_err(|error| self.refused(error))?;
        let clock = RunClock::start();
        for _ in 0..TRIES {
            match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
                Ok(lock) => return Ok((folder, lock)),
                Err((back, Errno::EWOULDBLOCK)) => file = back,
                Err((_, errno)) => return Err(self.refused(errno.into())),
            }
            clock.sleep_until(clock.now() + LOOK);
        }
        Err(LedgerError::Held(self.file.clone()))
    }

    fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new("/"))
    }

    fn refused(&self, error: io::Error) -> LedgerError {
        LedgerError::Folder {
            folder: self.folder().to_owned(),
            error,
        }
    }

    /// A neighbour of the file.
    fn beside(&self, ending: &str) -> PathBuf {
        let mut name = self.file.clone().into_os_string();
        name.push(".");
        name.push(ending);
        name.into()
    }
}

impl Held {
    /// Replaces the content; it is on the disk when this returns.
    ///
    /// # Errors
    /// Error of the system; the file holds the old or the new content then.
    pub(super) fn write(&self, payload: &[u8]) -> io::Result<()> {
        let neighbour = self.account.beside("new");
        // A neighbour that cannot be taken away is still there when another is made.
        let _ = fs::remove_file(&neighbour);
        let mut file = create(&neighbour)?;
        file.write_all(&whole(payload))?;
        file.sync_all()?;
        fs::rename(&neighbour, &self.account.file)?;
        self.folder.sync_all()
    }
}

/// Bytes of a file with this payload.
fn whole(payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + payload.len() + TAIL);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u32).to_le_bytes());
    bytes.extend_from_slice(payload);
    bytes.extend_from_slice(&checksum(&bytes).to_le_bytes());
    bytes
}

/// Payload of a file's bytes, or the reason why they are not believed.
fn parse(bytes: &[u8]) -> Result<&[u8], String> {
    let cut = || "it is cut or damaged".to_owned();
    let number = |at: usize| -> Option<u32> {
        let bytes = bytes.get(at..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    };
    if !bytes.starts_with(MAGIC) {
        return Err(cut());
    }
    let version = number(MAGIC.len()).ok_or_else(cut)?;
    if version != VERSION {
        return Err(format!(
            "expected version {VERSION}, found {version}: another version of this program wrote it"
        ));
    }
    let length = number(MAGIC.len() + 4).ok_or_else(cut)? as usize;
    let (told, sum) = bytes.split_last_chunk::<TAIL>().ok_or_else(cut)?;
    let payload = told.get(HEAD..).filter(|payload| payload.len() == length);
    let payload = payload.ok_or_else(cut)?;
    match checksum(told) == u64::from_le_bytes(*sum) {
        true => Ok(payload),
        false => Err(cut()),
    }
}

#[cfg(test)]
#[path = "account_tests.rs"]
mod tests;
