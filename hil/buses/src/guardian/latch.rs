//! The latched stop: a file that outlives every process and says why outputs were switched off, until a
//! person clears it.
//!
//! A guardian arms it before the first pulse: the record is written, and a stop only renames it. So a stop needs no room on
//! the disk, no memory and no descriptor. A record that is still armed when its guardian is gone is a stop as well: whatever
//! ended both, nobody saw the outputs off.

use std::env;
use std::ffi::CString;
use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use arrayvec::ArrayString;
use nix::errno::Errno;
use nix::fcntl::renameat;
use nix::libc;
use nix::unistd::{UnlinkatFlags, unlinkat};

/// Bytes of a record: a stop writes over what was written when it was armed, byte for byte.
const RECORD: usize = 1024;
/// Bytes of a cause in it.
const CAUSE: usize = 640;
/// The cause of a record that was armed, and that a person finds where neither run nor guardian wrote another.
const ABANDONED: &str = "run and guardian ended without a word";

/// Where a bus's latch lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Latch {
    file: PathBuf,
}

/// What a latch holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Latched {
    /// Why everything was switched off, in words.
    pub cause: String,
    /// When, seconds since 1970.
    pub at_s: u64,
    /// Whether every board was read back as off.
    pub verified: bool,
}

impl Latched {
    /// Why nothing is driven on what has this name, and the way on.
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

/// The folder of what outlives every process: `PALPATE_STATE`, else `/var/lib/palpate` for root, else the user's state folder.
pub fn folder() -> PathBuf {
    if let Some(folder) = env::var_os("PALPATE_STATE") {
        return folder.into();
    }
    if nix::unistd::geteuid().is_root() {
        return "/var/lib/palpate".into();
    }
    let home = || Some(Path::new(&env::var_os("HOME")?).join(".local/state"));
    let state = env::var_os("XDG_STATE_HOME")
        .map(PathBuf::from)
        .or_else(home);
    state.unwrap_or_else(env::temp_dir).join("palpate")
}

/// A record of a stop, padded to its length; a cause that is too long is cut.
fn record(cause: &str, at_s: u64, verified: bool) -> [u8; RECORD] {
    let mut text = ArrayString::<RECORD>::new();
    text.push_str("cause=");
    for letter in cause.chars() {
        let letter = if letter.is_control() { ' ' } else { letter };
        if text.len() + letter.len_utf8() > CAUSE {
            break;
        }
        text.push(letter);
    }
    // Sixty bytes at most: there is room.
    let _ = write!(text, "\nat_s={at_s}\nverified={verified}\n");
    let mut bytes = [b' '; RECORD];
    bytes[..text.len()].copy_from_slice(text.as_bytes());
    bytes[RECORD - 1] = b'\n';
    bytes
}

impl Latch {
    /// The latch of an adapter, by its node's name.
    pub fn of(bus: &Path) -> Self {
        Self::within(&folder(), bus)
    }

    fn within(folder: &Path, bus: &Path) -> Self {
        let name = bus.display().to_string();
        let name = name.trim_start_matches('/').replace('/', "-");
        Self {
            file: folder.join(format!("{name}.stop")),
        }
    }

    /// Where its record lies while a guardian keeps watch.
    fn armed(&self) -> PathBuf {
        self.file.with_extension("armed")
    }

    /// What it holds; `None` when it is clear. What cannot be read counts as latched.
    pub fn read(&self) -> Option<Latched> {
        read(&self.file)
    }

    /// The same, and what an earlier guardian left armed: for one that holds the bus's lock, so that no guardian lives.
    pub fn read_locked(&self) -> Option<Latched> {
        self.read().or_else(|| read(&self.armed()))
    }

    /// Prepares a stop: its record is on the disk, everything that latching needs is open.
    ///
    /// # Errors
    /// What the system says, with the folder and what to do.
    pub fn arm(&self) -> Result<Armed, String> {
        let folder = self.file.parent().unwrap_or(Path::new("/"));
        self.opened(folder).map_err(|error| {
            let folder = folder.display();
            format!(
                "{folder}: a stop of the run could not be kept there: {error}; make it with `install -d {folder}`, or name another folder in PALPATE_STATE"
            )
        })
    }

    fn opened(&self, folder: &Path) -> io::Result<Armed> {
        fs::create_dir_all(folder)?;
        let name = |path: &Path| {
            let name = path.file_name().unwrap_or_default();
            CString::new(name.as_bytes()).map_err(io::Error::other)
        };
        let armed = self.armed();
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true);
        let file = options.custom_flags(libc::O_NOFOLLOW).open(&armed)?;
        file.write_all_at(&record(ABANDONED, now_s(), false), 0)?;
        file.sync_all()?;
        let opened = Armed {
            folder: File::open(folder)?,
            record: file,
            armed: name(&armed)?,
            stop: name(&self.file)?,
            first: None,
            renamed: false,
        };
        opened.folder.sync_all()?;
        Ok(opened)
    }

    /// Latches. A first cause is kept; a later one only says whether boards are off by now.
    ///
    /// # Errors
    /// What the system says.
    pub fn set(&self, cause: &str, verified: bool) -> io::Result<()> {
        let first = self.read();
        let mut armed = self.opened(self.file.parent().unwrap_or(Path::new("/")))?;
        armed.first = first.map(|held| (short(&held.cause), held.at_s));
        Ok(armed.latch(cause, verified)?)
    }

    /// Clears it: a person's decision.
    ///
    /// # Errors
    /// What the system says.
    pub fn clear(&self) -> io::Result<()> {
        for file in [self.armed(), self.file.clone()] {
            match fs::remove_file(file) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }
}

fn read(file: &Path) -> Option<Latched> {
    let text = match fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
        Err(error) => format!("cause={} cannot be read: {error}", file.display()),
    };
    let value = |key: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once('='));
        lines.find(|(name, _)| *name == key).map(|(_, value)| value)
    };
    Some(Latched {
        cause: value("cause").unwrap_or("not told").to_owned(),
        at_s: value("at_s").and_then(|t| t.parse().ok()).unwrap_or(0),
        verified: value("verified") == Some("true"),
    })
}

/// A cause, cut to what a record holds.
fn short(cause: &str) -> ArrayString<CAUSE> {
    let mut text = ArrayString::new();
    let whole = |letter: char| text.try_push(letter).is_ok();
    cause.chars().all(whole);
    text
}

/// A stop that only has to be renamed: nothing is allocated or opened any more.
#[derive(Debug)]
pub struct Armed {
    folder: File,
    record: File,
    armed: CString,
    stop: CString,
    /// Cause and time of the stop that is latched.
    first: Option<(ArrayString<CAUSE>, u64)>,
    renamed: bool,
}

impl Armed {
    /// Latches the stop. A first cause is kept; a later one only says whether boards are off by now.
    ///
    /// # Errors
    /// What the system says. Where the record could not be written anew, but renamed, the stop is latched without its cause.
    pub fn latch(&mut self, cause: &str, verified: bool) -> Result<(), Errno> {
        let (cause, at_s) = self.first.get_or_insert_with(|| (short(cause), now_s()));
        let written = self.record.write_all_at(&record(cause, *at_s, verified), 0);
        let written = written.and_then(|()| self.record.sync_data());
        if !self.renamed {
            renameat(&self.folder, &*self.armed, &self.folder, &*self.stop)?;
            self.renamed = true;
        }
        let synced = nix::unistd::fsync(self.folder.as_fd());
        written.map_err(|error| error.raw_os_error().map_or(Errno::EIO, Errno::from_raw))?;
        synced
    }

    /// Takes the record away: the outputs were seen off, and no stop is latched.
    pub fn disarm(&self) {
        // What is left armed is found by the next run, which refuses.
        let _ = unlinkat(&self.folder, &*self.armed, UnlinkatFlags::NoRemoveDir);
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
