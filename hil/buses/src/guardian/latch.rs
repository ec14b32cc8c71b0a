//! The latched stop: a file that outlives every process and says why outputs were switched off, until a
//! person clears it.

use std::env;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

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

/// The folder of latches: `PALPATE_STATE`, else `/var/lib/palpate` for root, else the user's state folder.
fn folder() -> PathBuf {
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

    /// What it holds; `None` when it is clear. What cannot be read counts as latched.
    pub fn read(&self) -> Option<Latched> {
        let text = match fs::read_to_string(&self.file) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return None,
            Err(error) => format!("cause={} cannot be read: {error}", self.file.display()),
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

    /// Latches. A first cause is kept; a later one only says whether boards are off by now.
    ///
    /// # Errors
    /// What the system says.
    pub fn set(&self, cause: &str, verified: bool) -> io::Result<()> {
        let first = self.read();
        let now = fs_time();
        let (cause, at_s) = match &first {
            Some(first) => (first.cause.as_str(), first.at_s),
            None => (cause, now),
        };
        let cause = cause.replace(['\n', '\r'], " ");
        let folder = self.file.parent().unwrap_or(Path::new("/"));
        fs::create_dir_all(folder)?;
        let partial = self
            .file
            .with_extension(format!("{}.partial", std::process::id()));
        let mut file = fs::File::create(&partial)?;
        write!(file, "cause={cause}\nat_s={at_s}\nverified={verified}\n")?;
        file.sync_all()?;
        fs::rename(&partial, &self.file)
    }

    /// Clears it: a person's decision.
    ///
    /// # Errors
    /// What the system says.
    pub fn clear(&self) -> io::Result<()> {
        match fs::remove_file(&self.file) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

/// The time of day, seconds since 1970; zero before that.
#[allow(clippy::disallowed_methods)] // for people: it says when, and nothing depends on it
fn fs_time() -> u64 {
    let now = std::time::SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |d| d.as_secs())
}

#[cfg(test)]
#[path = "latch_tests.rs"]
mod tests;
