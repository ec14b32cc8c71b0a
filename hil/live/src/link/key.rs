//! The file of the key that a driver unit and its host share: 32 bytes in hexadecimal, for its owner's eyes alone.

use std::fs::{File, OpenOptions, Permissions};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::Path;

use palpate_run::Failure;

/// Bytes of a key.
const LENGTH: usize = 32;
/// Any access by users other than the owner.
const OTHERS: u32 = 0o077;

fn failed(path: &Path, e: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("{}: {e}", path.display()))
}

/// Random bytes of the system.
///
/// # Errors
/// [`Failure::Device`] for a system that has none.
pub fn random<const N: usize>() -> Result<[u8; N], Failure> {
    let source = "/dev/urandom";
    let mut bytes = [0; N];
    let read = File::open(source).and_then(|mut file| file.read_exact(&mut bytes));
    read.map_err(|e| Failure::Device(format!("{source}: {e}")))?;
    Ok(bytes)
}

/// Makes a key file that was not there before.
///
/// # Errors
/// [`Failure::Input`] where something stands there, [`Failure::Write`] where it cannot be written.
pub fn make(path: &Path) -> Result<(), Failure> {
    let key: [u8; LENGTH] = random()?;
    let hex: String = key.iter().map(|byte| format!("{byte:02x}")).collect();
    let file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(path);
    let mut file = file.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => failed(
            path,
            "expected a new file, found one: a key that is in use must not be lost",
        ),
        _ => Failure::written(path)(error),
    })?;
    // Whatever the mask of this process: its owner reads and writes it, and no one else.
    let written = file
        .set_permissions(Permissions::from_mode(0o600))
        .and_then(|()| writeln!(file, "{hex}"))
        .and_then(|()| file.sync_all());
    written.map_err(Failure::written(path))
}

/// Reads a key file.
///
/// # Errors
/// [`Failure::Input`] for a file that other users may read, or that holds no key: zeros are the content of memory that
/// nobody has written.
pub fn read(path: &Path) -> Result<[u8; LENGTH], Failure> {
    let file = palpate_files::open(path, "a key (`hil unit --new-key FILE` makes one)")?;
    let mode = file
        .metadata()
        .map_err(|e| failed(path, e))?
        .permissions()
        .mode();
    if mode & OTHERS != 0 {
        return Err(failed(
            path,
            format_args!(
                "expected a file that its owner alone may read, found mode {:03o}: chmod 600 {}",
                mode & 0o777,
                path.display()
            ),
        ));
    }
    let mut text = String::new();
    // One byte more than a key and its line's end, so that a longer file is seen as one.
    let most = 2 * LENGTH as u64 + 3;
    let read = file.take(most).read_to_string(&mut text);
    parse(text.trim_end())
        .filter(|key| read.is_ok() && *key != [0; LENGTH])
        .ok_or_else(|| {
            failed(
                path,
                "expected a key, 64 hexadecimal digits that are not all zero; `hil unit --new-key FILE` makes one",
            )
        })
}

fn parse(text: &str) -> Option<[u8; LENGTH]> {
    let mut key = [0; LENGTH];
    if text.len() != 2 * LENGTH || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    for (byte, digits) in key.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    }
    Some(key)
}

#[cfg(test)]
#[path = "key_tests.rs"]
mod tests;
