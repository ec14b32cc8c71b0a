//! What a fake bench and its tests share: pages of memory. Through them a test says what goes wrong around the program,
//! and learns what the chips were told. The library that is preloaded under the program is the example `fake_bench`.

mod chip;
mod mapped;
mod page;
mod switch;

pub use chip::{Chip, State};
pub use mapped::{Mapped, Page};
pub use page::{AdapterPage, Change, Mode};
pub use switch::Switch;

use std::sync::atomic::{AtomicI64, AtomicU32, Ordering};

/// The variable of the environment that names a bench's folder. Without it the library changes nothing.
pub const FOLDER: &str = "PALPATE_FAKE_BENCH";
/// Adapters that a bench may have: `i2c-0` and so on, each with a page `i2c-0.state` beside it.
pub const ADAPTERS: usize = 8;
/// The mode of an adapter's node, a regular file as long as the number of the adapter: to the program it is a device node
/// of [`MAJOR`] and that number.
pub const NODE_MODE: u32 = 0o1666;
/// The major number of I2C adapters. `sys/dev/char/MAJOR:NUMBER/device` in the bench's folder leads to the device.
pub const MAJOR: u32 = 89;
/// The file of the bench's folder that stands in for the kernel's name of this start of the machine, if there is one.
pub const BOOT_ID: &str = "boot_id";
/// Chips that an adapter may have.
pub const CHIPS: usize = 4;

/// Says that the guardian lacks something.
pub const GUARDIAN: u32 = 1;
/// Says that a program other than the guardian lacks something.
pub const RUN: u32 = 2;

/// The clocks that the program reads: the file `clock.state`.
#[repr(C)]
#[derive(Debug, Default)]
pub struct ClockPage {
    /// What CLOCK_MONOTONIC has lost, nanoseconds: CLOCK_BOOTTIME keeps it.
    pub lost_ns: AtomicI64,
    /// What is added to CLOCK_REALTIME, nanoseconds.
    pub realtime_ns: AtomicI64,
    /// Where CLOCK_MONOTONIC stands still, nanoseconds; zero while it goes.
    pub still_ns: AtomicI64,
    /// When the machine was started, nanoseconds of the true clocks: CLOCK_MONOTONIC and CLOCK_BOOTTIME count from then.
    pub started_ns: AtomicI64,
}

impl ClockPage {
    /// What CLOCK_MONOTONIC is to the program when it truly is this.
    pub fn monotonic(&self, real_ns: i64) -> i64 {
        match self.still_ns.load(Ordering::Acquire) {
            0 => self
                .uptime(real_ns)
                .saturating_sub(self.lost_ns.load(Ordering::Acquire)),
            still => still,
        }
    }

    /// The value that CLOCK_BOOTTIME has for the program at a true time.
    pub fn uptime(&self, real_ns: i64) -> i64 {
        real_ns.saturating_sub(self.started_ns.load(Ordering::Acquire))
    }
}

/// What a program lacks: the file `scarce.state`. Each is [`GUARDIAN`], [`RUN`], both together, or zero for nobody.
#[repr(C)]
#[derive(Debug, Default)]
pub struct ScarcePage {
    /// Those that get no memory.
    pub memory: AtomicU32,
    /// Those that get no thread.
    pub threads: AtomicU32,
    /// Those that get no descriptor.
    pub descriptors: AtomicU32,
    /// Those whose writes to the state folder hang until this is lifted.
    pub disk_hangs: AtomicU32,
    /// Those that hang as soon as they open a file of the state folder.
    pub open_hangs: AtomicU32,
    /// Those whose writes to the state folder fail.
    pub disk_fails: AtomicU32,
    /// The error number with which they do.
    pub disk_errno: AtomicU32,
}
