//! `/dev/uhid`: a HID device made of bytes (`linux/uhid.h`). The kernel binds its driver for an MCP2221 to
//! it, and that driver registers an I2C adapter like any other.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock, Weak};
use std::time::Duration;

use nix::libc;

use super::mcp2221::REPORT;

/// Size of `struct uhid_event`.
const EVENT: usize = 4380;
const DATA_MAX: usize = 4096;
/// Pause between two looks for the kernel's own account of the bridge.
const LOOK: Duration = Duration::from_millis(5);

const DESTROY: u32 = 1;
const OUTPUT: u32 = 6;
const GET_REPORT: u32 = 9;
const GET_REPORT_REPLY: u32 = 10;
const CREATE2: u32 = 11;
const INPUT2: u32 = 12;
const SET_REPORT: u32 = 13;
const SET_REPORT_REPLY: u32 = 14;

const BUS_USB: u16 = 3;
const MICROCHIP: u32 = 0x04D8;
const MCP2221: u32 = 0x00DD;

/// 64 bytes in, 64 bytes out, vendor-defined: the bridge's own report descriptor.
const DESCRIPTOR: [u8; 27] = [
    0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x09, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,
    0x95, 0x40, 0x81, 0x02, 0x09, 0x01, 0x95, 0x40, 0x91, 0x02, 0xC0,
];

/// Request of the kernel to the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// A report for the device.
    Report(Vec<u8>),
    /// A control transfer that this device does not know; the number belongs into the refusal.
    Get(u32),
    /// A control transfer in the other direction that this device does not know; the number belongs into the refusal.
    Set(u32),
    /// Start, stop, open or close: nothing to do.
    Notice,
}

impl Request {
    /// Reads an event as the kernel writes it; lengths that do not fit count as shorter ones.
    pub fn decode(event: &[u8]) -> Self {
        let word = |at: usize| {
            let bytes = event.get(at..at + 4).and_then(|b| b.try_into().ok());
            u32::from_le_bytes(bytes.unwrap_or_default())
        };
        match word(0) {
            OUTPUT => {
                let size = event.get(4 + DATA_MAX..4 + DATA_MAX + 2);
                let size = size.and_then(|b| b.try_into().ok()).map(u16::from_le_bytes);
                let size = usize::from(size.unwrap_or(0)).min(DATA_MAX);
                Self::Report(event.get(4..4 + size).unwrap_or_default().to_vec())
            }
            GET_REPORT => Self::Get(word(4)),
            SET_REPORT => Self::Set(word(4)),
            _ => Self::Notice,
        }
    }
}

/// An event with its type and its content.
fn event(kind: u32, rest: &[&[u8]]) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    rest.iter().for_each(|part| bytes.extend_from_slice(part));
    bytes
}

/// A text in a field of `N` bytes.
fn field<const N: usize>(text: &str) -> [u8; N] {
    let mut bytes = [0; N];
    let length = text.len().min(N - 1);
    bytes[..length].copy_from_slice(&text.as_bytes()[..length]);
    bytes
}

/// A report of the device.
fn input(report: &[u8; REPORT]) -> Vec<u8> {
    event(INPUT2, &[&(REPORT as u16).to_le_bytes(), report])
}

/// Request that introduces the device; `unique` tells it from others of its kind.
fn create(unique: &str) -> Vec<u8> {
    event(
        CREATE2,
        &[
            &field::<128>("Palpate emulated MCP2221"),
            &field::<64>("palpate"),
            &field::<64>(unique),
            &(DESCRIPTOR.len() as u16).to_le_bytes(),
            &BUS_USB.to_le_bytes(),
            &MICROCHIP.to_le_bytes(),
            &MCP2221.to_le_bytes(),
            &0x0100_u32.to_le_bytes(),
            &0_u32.to_le_bytes(),
            &DESCRIPTOR,
        ],
    )
}

/// A bridge that the kernel knows of, until it is dropped.
#[derive(Debug)]
pub struct Uhid {
    file: File,
    /// The bridge in sysfs, once the driver has taken it.
    device: Arc<OnceLock<PathBuf>>,
    buffer: Vec<u8>,
}

impl Uhid {
    /// Plugs the bridge in.
    ///
    /// # Errors
    /// Error of `/dev/uhid`: not there without the module, not ours without permission.
    pub fn plug() -> io::Result<Self> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(libc::O_NONBLOCK | libc::O_CLOEXEC)
            .open("/dev/uhid")?;
        let unique = format!("palpate-{}", std::process::id());
        let mut this = Self {
            file,
            device: Arc::default(),
            buffer: vec![0; EVENT],
        };
        this.file.write_all(&create(&unique))?;
        // A thread of its own: sysfs tells whose device it is only when the driver is done with it, and the driver
        // waits for this bridge's answers.
        let found = Arc::downgrade(&this.device);
        std::thread::Builder::new()
            .name("bridge".into())
            .spawn(move || search(&unique, &found))?;
        Ok(this)
    }

    /// The next request; `None` when there is none now.
    ///
    /// # Errors
    /// Error of `/dev/uhid`.
    pub fn receive(&mut self) -> io::Result<Option<Request>> {
        loop {
            match self.file.read(&mut self.buffer) {
                Ok(length) => {
                    return Ok(Some(Request::decode(&self.buffer[..length])));
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if e.kind() == ErrorKind::WouldBlock => return Ok(None),
                Err(e) => return Err(e),
            }
        }
    }

    /// Gives the kernel a report.
    ///
    /// # Errors
    /// Error of `/dev/uhid`.
    pub fn send(&mut self, report: &[u8; REPORT]) -> io::Result<()> {
        self.file.write_all(&input(report))
    }

    /// Refuses a control transfer with EIO.
    ///
    /// # Errors
    /// Error of `/dev/uhid`.
    pub fn refuse(&mut self, request: &Request) -> io::Result<()> {
        let error = (libc::EIO as u16).to_le_bytes();
        let reply = match request {
            Request::Get(id) => event(GET_REPORT_REPLY, &[&id.to_le_bytes(), &error, &[0; 2]]),
            Request::Set(id) => event(SET_REPORT_REPLY, &[&id.to_le_bytes(), &error]),
            Request::Report(_) | Request::Notice => return Ok(()),
        };
        self.file.write_all(&reply)
    }

    /// The node of the adapter that the kernel made of this bridge; `None` as long as there is none.
    pub fn node(&self) -> Option<PathBuf> {
        self.made("i2c-")
    }

    /// The node of the GPIO chip that the kernel made of this bridge's pins.
    pub fn gpio(&self) -> Option<PathBuf> {
        self.made("gpiochip")
    }

    /// Node that the kernel made of this bridge, by the beginning of its name.
    fn made(&self, prefix: &str) -> Option<PathBuf> {
        let entries = std::fs::read_dir(self.device.get()?).ok()?.flatten();
        let names = entries.map(|e| e.file_name().to_string_lossy().into_owned());
        let name = names.into_iter().find(|n| n.starts_with(prefix))?;
        let node = Path::new("/dev").join(name);
        node.exists().then_some(node)
    }
}

/// Looks for the bridge of this name until it is there or the caller has gone.
#[allow(clippy::disallowed_methods)] // a thread of its own, and nothing depends on when it looks
fn search(unique: &str, found: &Weak<OnceLock<PathBuf>>) {
    let ours = format!("HID_UNIQ={unique}");
    let is_ours = |device: &PathBuf| {
        let about = std::fs::read_to_string(device.join("uevent"));
        about.is_ok_and(|text| text.lines().any(|line| line == ours))
    };
    while let Some(found) = found.upgrade() {
        let devices = std::fs::read_dir("/sys/devices/virtual/misc/uhid");
        let mut devices = devices.into_iter().flatten().flatten().map(|d| d.path());
        if let Some(device) = devices.find(is_ours) {
            let _ = found.set(device);
            return;
        }
        std::thread::sleep(LOOK);
    }
}

impl AsFd for Uhid {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

impl Drop for Uhid {
    /// The kernel takes the adapter away, also when the program is killed.
    fn drop(&mut self) {
        let _ = self.file.write_all(&event(DESTROY, &[]));
    }
}
