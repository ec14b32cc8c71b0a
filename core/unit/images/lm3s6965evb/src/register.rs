//! Registers of the LM3S6965, by their addresses in its data sheet.

/// A register of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Register(pub usize);

impl Register {
    /// Its value.
    pub fn read(self) -> u32 {
        // SAFETY: the addresses in this package are registers of this machine; reading them touches no memory of Rust's.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Sets it.
    pub fn write(self, value: u32) {
        // SAFETY: as above; no register here starts a transfer into memory.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}
