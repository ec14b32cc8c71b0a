//! Identity of hardware for locks and stops: the hardware itself, whatever names it goes by.
//!
//! An adapter is the device that sysfs has behind its node. A link to the node is the same adapter, and so is the number
//! that it gets when it is plugged in again. A driver unit is the key that is shared with it, at any address.

use std::fmt;
use std::fs;
use std::io;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};

use nix::sys::stat::{major, minor};
use sha2::{Digest, Sha256};

/// One adapter or driver unit.
#[derive(Clone, Debug)]
pub struct Hardware {
    /// Name that its user gave.
    shown: String,
    /// Name that the hardware has by itself.
    place: String,
    /// The name of its files, without an ending.
    file: String,
}

/// Error for an adapter whose hardware is unknown.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {error}; locks and stops are of the device that /sys has behind it")]
pub struct UnknownHardware {
    /// The device node.
    pub path: String,
    /// Error of the system.
    pub error: io::Error,
}

impl Hardware {
    /// The adapter behind a device node.
    ///
    /// # Errors
    /// [`UnknownHardware`] for a node that is not there, or that sysfs does not know.
    pub fn adapter(node: &Path) -> Result<Self, UnknownHardware> {
        let shown = node.display().to_string();
        let place = device(node).and_then(|device| lasting(&device));
        match place {
            Ok(place) => Ok(Self::new("i2c", shown, place.as_bytes(), place.clone())),
            Err(error) => Err(UnknownHardware { path: shown, error }),
        }
    }

    /// The driver unit that has this key, by the address that its user named.
    pub fn unit(address: &str, key: &[u8; 32]) -> Self {
        let shown = format!("unit {address}");
        Self::new("unit", shown, key, "driver unit".into())
    }

    fn new(kind: &str, shown: String, own: &[u8], place: String) -> Self {
        let digest = Sha256::new_with_prefix(kind).chain_update(own).finalize();
        let digits: String = digest.iter().take(8).map(|b| format!("{b:02x}")).collect();
        Self {
            shown,
            place,
            file: format!("{kind}-{digits}"),
        }
    }

    /// Tells whether both are the same hardware, whatever their names.
    pub fn is(&self, other: &Self) -> bool {
        self.file == other.file
    }

    /// Name that the hardware has by itself: the same under all of its users' names.
    pub(crate) fn place(&self) -> &str {
        &self.place
    }

    /// The name of its files, without an ending.
    pub fn file(&self) -> &str {
        &self.file
    }
}

/// Writes the name that its user gave.
impl fmt::Display for Hardware {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.shown)
    }
}

/// The adapter in sysfs that a node leads to.
fn device(node: &Path) -> io::Result<PathBuf> {
    let about = fs::metadata(node)?;
    if !about.file_type().is_char_device() {
        return Err(io::Error::other("expected a device node"));
    }
    let (major, minor) = (major(about.rdev()), minor(about.rdev()));
    fs::canonicalize(format!("/sys/dev/char/{major}:{minor}/device"))
}

/// A device's path without the numbers that the kernel counts. An adapter and a HID device get new ones whenever they are
/// plugged in, a USB bus may at any start. Each is known by its place among those of its kind below one parent instead.
fn lasting(device: &Path) -> io::Result<String> {
    // A program has made it, and it ends with that program: it has no place.
    if device.starts_with("/sys/devices/virtual") {
        return Ok(device.display().to_string());
    }
    let (mut folder, mut lasting) = (PathBuf::new(), PathBuf::new());
    for part in device {
        let name = part.to_string_lossy();
        match (counted(&name), name.split_once('-')) {
            (Some((kind, number)), _) => {
                lasting.push(format!("{kind}#{}", earlier(&folder, kind, number)?));
            }
            // A port of a hub or a chip on a bus, after the number of that bus.
            (None, Some((bus, port))) if bus.parse::<u32>().is_ok() => {
                lasting.push(format!("#-{port}"));
            }
            _ => lasting.push(part),
        }
        folder.push(part);
    }
    Ok(lasting.display().to_string())
}

/// Number that the kernel has counted, and the text before it: of an adapter, a USB bus, a HID device.
fn counted(name: &str) -> Option<(&str, u64)> {
    let split = |length: usize, radix: u32| {
        let number = u64::from_str_radix(name.get(length..)?, radix).ok()?;
        Some((name.get(..length)?, number))
    };
    // `0003:04D8:00DD.0001`: bus, vendor, product.
    let is_mark = |(at, mark): (usize, u8)| name.as_bytes().get(at) == Some(&mark);
    match name {
        _ if name.starts_with("i2c-") => split(4, 10),
        _ if name.starts_with("usb") => split(3, 10),
        _ if [(4, b':'), (9, b':'), (14, b'.')].into_iter().all(is_mark) => split(15, 16),
        _ => None,
    }
}

/// Number of devices of this kind below a folder that were counted before this one.
fn earlier(folder: &Path, kind: &str, number: u64) -> io::Result<usize> {
    let mut count = 0;
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let name = name.to_string_lossy();
        let other = counted(&name).filter(|(other, _)| *other == kind);
        count += usize::from(other.is_some_and(|(_, other)| other < number));
    }
    Ok(count)
}

#[cfg(test)]
#[path = "hardware_tests.rs"]
mod tests;
