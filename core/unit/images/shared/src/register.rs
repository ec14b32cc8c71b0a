//! Registers of a machine, by the addresses in its data sheet.
#![allow(unsafe_code, reason = "a register is an address, not an object")]

/// A register of the machine that an image is built for.
#[derive(Clone, Copy, Debug)]
pub struct Register(pub usize);

impl Register {
    /// Value of the register.
    pub fn read(self) -> u32 {
        // SAFETY: images name registers of their machine alone, or memory that no variable has.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Sets the register.
    pub fn write(self, value: u32) {
        // SAFETY: as above; no register that an image writes starts a transfer into memory.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}
