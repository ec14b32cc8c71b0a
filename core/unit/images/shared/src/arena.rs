//! The heap of an image: a fixed piece of memory that is given out once, while the unit is built.

use core::alloc::{GlobalAlloc, Layout};
use core::cell::{Cell, UnsafeCell};
use core::ptr;

/// A heap of `SIZE` bytes for one thread. Nothing is taken back, and once it is closed nothing more is given: an image that
/// allocates in its loop aborts, and its watchdog switches everything off.
#[repr(align(8))]
#[derive(Debug)]
pub struct Arena<const SIZE: usize> {
    memory: UnsafeCell<[u8; SIZE]>,
    used: Cell<usize>,
}

// SAFETY: images have one thread, and no interrupt handler that allocates.
#[allow(unsafe_code, reason = "a global allocator must be `Sync`")]
unsafe impl<const SIZE: usize> Sync for Arena<SIZE> {}

impl<const SIZE: usize> Arena<SIZE> {
    /// A heap of which nothing is used.
    pub const fn new() -> Self {
        Self {
            memory: UnsafeCell::new([0; SIZE]),
            used: Cell::new(0),
        }
    }

    /// Gives nothing more.
    pub fn close(&self) {
        self.used.set(SIZE);
    }
}

impl<const SIZE: usize> Default for Arena<SIZE> {
    fn default() -> Self {
        Self::new()
    }
}

// SAFETY: pieces lie within the memory, are aligned as asked, and never overlap, for `used` only grows.
#[allow(unsafe_code, reason = "a global allocator is unsafe by its trait")]
unsafe impl<const SIZE: usize> GlobalAlloc for Arena<SIZE> {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let base = self.memory.get() as usize;
        let Some(free) = (base + self.used.get()).checked_next_multiple_of(layout.align()) else {
            return ptr::null_mut();
        };
        let start = free - base;
        match start.checked_add(layout.size()) {
            Some(end) if end <= SIZE => {
                self.used.set(end);
                self.memory.get().cast::<u8>().wrapping_add(start)
            }
            _ => ptr::null_mut(),
        }
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[cfg(test)]
#[path = "arena_tests.rs"]
mod tests;
