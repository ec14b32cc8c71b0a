//! Files that all users of a machine share, in folders where anybody may write: no link is followed, no pipe is waited
//! for, and a file of a newer version is refused.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::Path;

use nix::libc;

/// Opens a file that is there, which may be another user's, to read it and, if it `writes`, to write it.
///
/// # Errors
/// Error of the system; an error for anything but an ordinary file.
pub fn open(path: &Path, writes: bool) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(writes);
    options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    let file = options.open(path)?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::other("expected an ordinary file"));
    }
    Ok(file)
}

/// Makes a file that was not there, for all users whatever the mask of this process.
///
/// # Errors
/// Error of the system.
pub fn create(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    let file = options.read(true).write(true).create_new(true).open(path)?;
    file.set_permissions(Permissions::from_mode(0o666))?;
    Ok(file)
}

/// Opens a file to read and write it, or makes it.
///
/// # Errors
/// Error of the system; an error for anything but an ordinary file.
pub fn open_or_create(path: &Path) -> io::Result<File> {
    let there = || open(path, true);
    match there() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => match create(path) {
            // Another program was faster.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => there(),
            made => made,
        },
        other => other,
    }
}

/// Makes a folder where it is not there yet, with this mode whatever the mask of this process.
///
/// # Errors
/// Error of the system.
pub fn make(folder: &Path, mode: u32) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    fs::create_dir_all(folder)?;
    fs::set_permissions(folder, Permissions::from_mode(mode))
}

/// Refuses a file that begins with the first line of a version above `known`: `KIND VERSION`.
///
/// # Errors
/// Both versions, in words.
pub fn refuse_newer(content: &[u8], kind: &str, known: u32) -> io::Result<()> {
    let first = content.split(|byte| *byte == b'\n').next();
    let first = first.and_then(|line| std::str::from_utf8(line).ok());
    let version = first.and_then(|line| line.strip_prefix(kind)?.trim().parse::<u32>().ok());
    match version {
        Some(found) if found > known => Err(io::Error::other(format!(
            "written by a newer version of this program: expected {kind} {known}, found {found}; use that version"
        ))),
        _ => Ok(()),
    }
}
