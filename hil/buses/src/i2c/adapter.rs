//! A Linux I2C adapter: one descriptor of `/dev/i2c-N` for all addresses, checked when it is opened and
//! opened again after it was unplugged.

use std::fs::{self, File, OpenOptions};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use i2cdev::core::{I2CMessage, I2CTransfer};
use i2cdev::linux::{LinuxI2CBus, LinuxI2CError, LinuxI2CMessage};
use nix::errno::Errno;
use nix::libc::{self, c_ulong};

use super::{Adapter, FaultKind};
use crate::sys;

/// `I2C_FUNC_I2C` of `linux/i2c.h`: whole transfers, which an update of 65 bytes needs.
const FUNC_I2C: c_ulong = 1;
/// Longest time of one transfer, in units of 10 ms, where the adapter lets us say so: a full update of 65 bytes takes
/// 6 ms at 100 kHz.
const TIMEOUT_10MS: u32 = 2;

/// Error of an adapter that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct AdapterError {
    /// The device node.
    pub path: String,
    /// Reason, and the command that mends it.
    pub reason: String,
}

/// An adapter behind a device node.
#[derive(Debug)]
pub struct LinuxAdapter {
    path: PathBuf,
    bus: Option<LinuxI2CBus>,
    /// Number of the device that the path led to when it was opened.
    device: u64,
}

/// Error of a node that cannot be opened, with the remedy.
fn unopened(path: &Path, errno: Errno) -> AdapterError {
    let reason = match errno {
        Errno::ENOENT => "no such device; `ls /dev/i2c-*` shows what is there, `modprobe i2c-dev` makes the nodes, `i2cdetect -l` names the adapters".into(),
        Errno::EACCES | Errno::EPERM => {
            "not allowed; `usermod -aG i2c $USER` and a new login, or run as root".into()
        }
        other => other.desc().to_owned(),
    };
    AdapterError {
        path: path.display().to_string(),
        reason,
    }
}

impl LinuxAdapter {
    /// Opens an adapter and checks that it can do whole transfers and that no kernel driver holds one of
    /// these addresses. Nothing is sent.
    ///
    /// # Errors
    /// [`AdapterError`] with the reason and its remedy.
    pub fn open(path: &Path, addresses: &[u8]) -> Result<Self, AdapterError> {
        let fail = |reason: String| AdapterError {
            path: path.display().to_string(),
            reason,
        };
        let mut adapter = Self {
            path: path.to_owned(),
            bus: None,
            device: 0,
        };
        adapter.reopen().map_err(|e| unopened(path, e))?;
        // The address is a property of the descriptor: claims are made on one of their own.
        let node = open_node(path).map_err(|e| unopened(path, e))?;
        let functions = sys::i2c_functions(node.as_fd()).map_err(|e| match e {
            Errno::ENOTTY | Errno::EINVAL => fail("is no I2C adapter".into()),
            other => fail(other.desc().into()),
        })?;
        if functions & FUNC_I2C == 0 {
            return Err(fail(
                "speaks SMBus only; an update needs I2C_FUNC_I2C (`i2cdetect -F` shows it)".into(),
            ));
        }
        for &address in addresses {
            if sys::claim_address(node.as_fd(), address) == Err(Errno::EBUSY) {
                let device = format!("{}-{address:04x}", number(path).unwrap_or_default());
                return Err(fail(format!(
                    "a kernel driver holds address {address:#04x}; `echo {device} > /sys/bus/i2c/devices/{device}/driver/unbind`"
                )));
            }
        }
        Ok(adapter)
    }

    /// Opens the node again: after an adapter came back.
    fn reopen(&mut self) -> Result<(), Errno> {
        self.bus = None;
        self.device = device(&self.path);
        let bus = LinuxI2CBus::new(&self.path).map_err(|e| errno(&e))?;
        if let Ok(node) = nix::unistd::dup(borrowed(&bus)) {
            // Some adapters know neither; our own limit stands in any case.
            let _ = sys::set_i2c_timeout(node.as_fd(), TIMEOUT_10MS);
            let _ = sys::set_i2c_retries(node.as_fd(), 0);
        }
        self.bus = Some(bus);
        Ok(())
    }
}

/// The device that a path leads to; zero for none.
fn device(path: &Path) -> u64 {
    fs::metadata(path).map_or(0, |about| about.rdev())
}

/// The bus's descriptor, which i2cdev lends only as a number.
#[allow(unsafe_code)]
fn borrowed(bus: &LinuxI2CBus) -> std::os::fd::BorrowedFd<'_> {
    // SAFETY: the descriptor belongs to `bus`, which outlives the borrow.
    unsafe { std::os::fd::BorrowedFd::borrow_raw(bus.as_raw_fd()) }
}

/// A descriptor of the node that no child process inherits.
fn open_node(path: &Path) -> Result<File, Errno> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).custom_flags(libc::O_CLOEXEC);
    let opened = options.open(path);
    opened.map_err(|e| e.raw_os_error().map_or(Errno::EIO, Errno::from_raw))
}

fn errno(error: &LinuxI2CError) -> Errno {
    match error {
        LinuxI2CError::Errno(number) => Errno::from_raw(*number),
        LinuxI2CError::Io(error) => error.raw_os_error().map_or(Errno::EIO, Errno::from_raw),
    }
}

/// The N of `/dev/i2c-N`.
pub fn number(path: &Path) -> Option<u32> {
    let real = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let name = real.file_name()?.to_str()?;
    name.strip_prefix("i2c-")?.parse().ok()
}

impl Adapter for LinuxAdapter {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Closes a node that is no longer there. The kernel keeps an adapter that was unplugged, and its number, for
    /// as long as anybody has it open: held on to, it would never come back.
    fn rest(&mut self) {
        if self.bus.is_some() && device(&self.path) != self.device {
            self.bus = None;
        }
    }

    fn transfer(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind> {
        self.rest();
        if self.bus.is_none() {
            self.reopen().map_err(|e| match e {
                // The node lies there without an adapter behind it, or is not there.
                Errno::ENXIO => FaultKind::Gone,
                other => other.into(),
            })?;
        }
        let Some(bus) = &mut self.bus else {
            return Err(FaultKind::Gone);
        };
        let to = u16::from(address);
        let result = match (write.is_empty(), read.is_empty()) {
            (_, true) => bus.transfer(&mut [LinuxI2CMessage::write(write).with_address(to)]),
            (true, false) => bus.transfer(&mut [LinuxI2CMessage::read(read).with_address(to)]),
            (false, false) => bus.transfer(&mut [
                LinuxI2CMessage::write(write).with_address(to),
                LinuxI2CMessage::read(read).with_address(to),
            ]),
        };
        result.map(drop).map_err(|error| {
            let kind = FaultKind::from(errno(&error));
            if kind == FaultKind::Gone {
                self.bus = None;
            }
            kind
        })
    }
}

#[cfg(test)]
#[path = "adapter_tests.rs"]
mod tests;
