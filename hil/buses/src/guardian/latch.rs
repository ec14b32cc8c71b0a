//! The latched stop: a record that outlives every process and holds the cause for which outputs were switched off,
//! until a person clears it.
//!
//! It is armed before the first pulse, under the lock of its hardware, and a stop only writes over it. A stop therefore
//! needs no room on the disk, no memory and no descriptor. A record that is armed while no program holds the lock is a
//! stop as well: no program saw the outputs off, whatever ended the run. A record is never deleted, only marked as clear:
//! every user can clear it, and no user needs a right to the folder of another's.

use std::env;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use arrayvec::ArrayString;
use nix::errno::Errno;
use nix::unistd::{AccessFlags, access};

use crate::hardware::Hardware;
use crate::lock::BusLock;
use crate::shared_file::{create, make, open, refuse_newer};

/// The version of a record that this code writes.
const VERSION: u32 = 1;
/// Kind of file, at the beginning of a record's first line.
const KIND: &str = "palpate-stop";
/// Bytes of a record: each is written over the last one, byte for byte.
const RECORD: usize = 1024;
/// Bytes of a cause in a record.
const CAUSE: usize = 640;
/// Bytes of the hardware's place in it.
const PLACE: usize = 240;
/// Path of the folder of all users.
const SYSTEM: &str = "/var/lib/palpate";
/// Mode of that folder: everybody may add a record there, and take away none of another user.
const MODE: u32 = 0o1777;

/// Kind of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// No stop.
    Clear,
    /// A run is on, or has ended without a word.
    Armed,
    /// A stop.
    Stopped,
}

impl State {
    const ALL: [Self; 3] = [Self::Clear, Self::Armed, Self::Stopped];

    const fn word(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Armed => "armed",
            Self::Stopped => "stopped",
        }
    }
}

/// The latch of hardware.
#[derive(Clone, Debug)]
pub struct Latch {
    hardware: Hardware,
    file: PathBuf,
    /// The system's file, where a stop counts as well when `PALPATE_STATE` names another folder.
    system: Option<PathBuf>,
}

/// A stop that a latch holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Latched {
    /// Cause for which everything was switched off, in words.
    pub cause: String,
    /// Time of the stop, seconds since 1970.
    pub at_s: u64,
    /// `true` where every board was read back as off.
    pub verified: bool,
}

impl Latched {
    /// Words that refuse to drive the hardware of this name, with the way on.
    pub fn refusal(&self, name: &dyn std::fmt::Display) -> String {
        let known = match self.verified {
            true => "everything was switched off",
            false => "not everything was known to be off",
        };
        format!(
            "{name}: stopped earlier: {}; {known}. Look at the bench, then clear the stop with `hil off --unlatch`",
            self.cause
        )
    }
}

/// Folder of records that outlive every process: the one that `PALPATE_STATE` names, else that of all users.
pub(crate) fn folder() -> PathBuf {
    folder_by(env::var_os("PALPATE_STATE"))
}

fn folder_by(named: Option<OsString>) -> PathBuf {
    let named = named.map(PathBuf::from);
    // A folder that depends on where a program is started loses its stops and heat.
    let named = named.filter(|folder| folder.is_absolute());
    named.unwrap_or_else(|| SYSTEM.into())
}

/// Command by which stops and heat can be kept in a folder.
pub(crate) fn remedy(folder: &Path) -> String {
    format!("sudo install -d -m {MODE:o} {}", folder.display())
}

/// The folder of stops, where this program may write to it or make it.
///
/// # Errors
/// The reason, and the command that mends it.
pub fn stops_folder() -> Result<PathBuf, (String, String)> {
    let folder = folder();
    let there = folder.ancestors().find(|folder| folder.exists());
    let there = there.unwrap_or(Path::new("/"));
    match access(there, AccessFlags::W_OK.union(AccessFlags::X_OK)) {
        Ok(()) => Ok(folder),
        Err(errno) => Err((
            format!(
                "{}: a stop could not be kept there: {}",
                folder.display(),
                errno.desc()
            ),
            remedy(&folder),
        )),
    }
}

impl Latch {
    /// The latch of an adapter or a driver unit.
    pub fn new(hardware: &Hardware) -> Self {
        Self::within(&folder(), hardware)
    }

    fn within(folder: &Path, hardware: &Hardware) -> Self {
        let name = format!("{}.stop", hardware.file());
        let system = Path::new(SYSTEM);
        Self {
            hardware: hardware.clone(),
            file: folder.join(&name),
            system: (folder != system).then(|| system.join(name)),
        }
    }

    fn files(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.file).chain(&self.system)
    }

    /// Stop that the latch holds; `None` when it is clear or a run is on. An unreadable record counts as a stop.
    pub fn read(&self) -> Option<Latched> {
        self.found(false)
    }

    /// Stop that the latch holds, or that an earlier run left armed: under its hardware's lock no run is on.
    pub fn read_locked(&self, _lock: &BusLock) -> Option<Latched> {
        self.found(true)
    }

    /// Reads as [`Self::read_locked`] where nobody holds the lock, else as [`Self::read`].
    pub fn look(&self) -> Option<Latched> {
        match BusLock::take(&self.hardware) {
            Ok(lock) => self.read_locked(&lock),
            Err(_) => self.read(),
        }
    }

    fn found(&self, armed: bool) -> Option<Latched> {
        self.files().find_map(|file| {
            let (state, held) = load(file)?;
            (armed || state == State::Stopped).then_some(held)
        })
    }

    /// Prepares a stop: its record is on the disk and open. `ended` is the cause where nobody writes another.
    ///
    /// # Errors
    /// Error of the system, with the folder and the remedy.
    pub fn arm(&self, _lock: &BusLock, ended: &str) -> Result<Armed, String> {
        let folder = self.file.parent().unwrap_or(Path::new("/"));
        self.opened(folder, ended).map_err(|error| {
            format!(
                "{}: a stop of the run could not be kept there: {error}; a folder for all users is made with `{}`",
                folder.display(),
                remedy(folder)
            )
        })
    }

    fn opened(&self, folder: &Path, ended: &str) -> io::Result<Armed> {
        make(folder, MODE)?;
        let (record, is_new) = match open(&self.file, true) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => (create(&self.file)?, true),
            there => (there?, false),
        };
        let armed = Armed {
            record,
            place: short(self.hardware.place()),
            first: None,
        };
        let mut kept = armed
            .write(State::Armed, &short(ended), now_s(), false)
            .and_then(|()| armed.record.sync_all());
        if is_new {
            kept = kept.and_then(|()| File::open(folder)?.sync_all());
        }
        if kept.is_err() {
            // Nothing will be driven: the rest of the record is no stop.
            armed.disarm();
            if is_new {
                let _ = fs::remove_file(&self.file);
            }
        }
        kept.map(|()| armed)
    }

    /// Clears the latch: a person's decision.
    ///
    /// # Errors
    /// Error of the system; an error for a record of a newer version.
    pub fn clear(&self, _lock: &BusLock) -> io::Result<()> {
        for file in self.files() {
            let record = match open(file, true) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                there => there?,
            };
            refuse_newer(&content(&record)?, KIND, VERSION)?;
            let cleared = Armed {
                record,
                place: short(self.hardware.place()),
                first: None,
            };
            cleared.record.set_len(RECORD as u64)?;
            cleared.write(State::Clear, &short(""), now_s(), true)?;
            cleared.record.sync_all()?;
        }
        Ok(())
    }
}

/// Bytes of a file, up to one more than a record has.
fn content(file: &File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(RECORD as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// State and stop of a record; `None` for one that is clear or absent. An unreadable record is a stop.
fn load(path: &Path) -> Option<(State, Latched)> {
    let stop = |cause: String| {
        let held = Latched {
            cause: format!("{}: {cause}", path.display()),
            at_s: 0,
            verified: false,
        };
        (State::Stopped, held)
    };
    let read = open(path, false).and_then(|file| {
        let bytes = content(&file)?;
        refuse_newer(&bytes, KIND, VERSION).map(|()| bytes)
    });
    let said = match read {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
        Err(error) => stop(format!("cannot be read: {error}")),
        Ok(bytes) => parse(&bytes).unwrap_or_else(|| stop("the record is damaged".into())),
    };
    Some(said).filter(|(state, _)| *state != State::Clear)
}

/// State and stop of a whole record of this version.
fn parse(bytes: &[u8]) -> Option<(State, Latched)> {
    let text = std::str::from_utf8(bytes).ok()?;
    let first = format!("{KIND} {VERSION}");
    if bytes.len() != RECORD || text.lines().next()? != first {
        return None;
    }
    let value = |key: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once('='));
        lines.find(|(name, _)| *name == key).map(|(_, value)| value)
    };
    let word = value("state")?;
    let state = State::ALL.into_iter().find(|state| state.word() == word)?;
    let held = Latched {
        cause: value("cause")?.to_owned(),
        at_s: value("at_s")?.parse().ok()?,
        verified: value("verified")? == "true",
    };
    Some((state, held))
}

/// A text on one line, cut to so many bytes.
fn short<const N: usize>(text: &str) -> ArrayString<N> {
    let mut cut = ArrayString::new();
    for letter in text.chars() {
        let letter = if letter.is_control() { ' ' } else { letter };
        if cut.try_push(letter).is_err() {
            break;
        }
    }
    cut
}

/// A record that is open: nothing is allocated or opened any more.
#[derive(Debug)]
pub struct Armed {
    record: File,
    place: ArrayString<PLACE>,
    /// Cause and time of the stop that is latched.
    first: Option<(ArrayString<CAUSE>, u64)>,
}

impl Armed {
    /// Latches the stop. A first cause is kept; a later one only updates whether boards are off.
    ///
    /// # Errors
    /// Error of the system. The record stays armed then, which is a stop without its cause.
    pub fn latch(&mut self, cause: &str, verified: bool) -> Result<(), Errno> {
        let (cause, at_s) = *self.first.get_or_insert_with(|| (short(cause), now_s()));
        let written = self
            .write(State::Stopped, &cause, at_s, verified)
            .and_then(|()| self.record.sync_data());
        written.map_err(|error| error.raw_os_error().map_or(Errno::EIO, Errno::from_raw))
    }

    /// Clears the record, unless a stop is latched: the outputs were seen off.
    pub fn disarm(&self) {
        if self.first.is_none() {
            // The next run finds a record that stays armed, and refuses.
            let _ = self.write(State::Clear, &short(""), now_s(), true);
        }
    }

    fn write(
        &self,
        state: State,
        cause: &ArrayString<CAUSE>,
        at_s: u64,
        verified: bool,
    ) -> io::Result<()> {
        let mut text = ArrayString::<RECORD>::new();
        let (word, place) = (state.word(), &self.place);
        // At most 967 bytes: there is room.
        let _ = write!(
            text,
            "{KIND} {VERSION}\nstate={word}\nat_s={at_s}\nverified={verified}\nhardware={place}\ncause={cause}\n"
        );
        let mut bytes = [b' '; RECORD];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        bytes[RECORD - 1] = b'\n';
        self.record.write_all_at(&bytes, 0)
    }
}

/// The time of day, seconds since 1970; zero before that.
#[allow(clippy::disallowed_methods)] // for people: it says when, and nothing depends on it
fn now_s() -> u64 {
    let now = std::time::SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |d| d.as_secs())
}

#[cfg(test)]
#[path = "latch_tests.rs"]
mod tests;
