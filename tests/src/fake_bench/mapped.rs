//! A file as memory that several processes share.

use std::ffi::CStr;
use std::ops::Deref;
use std::ptr::{self, NonNull};

use nix::libc;

use super::{AdapterPage, ClockPage, ScarcePage};

/// What a file may be mapped as.
///
/// # Safety
/// Any bytes are a value of it, and it bears that others change it at any time: atomic integers alone.
#[allow(unsafe_code)]
pub unsafe trait Page: Sync {}

// SAFETY: atomic integers alone.
#[allow(unsafe_code)]
unsafe impl Page for AdapterPage {}
// SAFETY: atomic integers alone.
#[allow(unsafe_code)]
unsafe impl Page for ClockPage {}
// SAFETY: atomic integers alone.
#[allow(unsafe_code)]
unsafe impl Page for ScarcePage {}

/// A page that lies in a file. The file must not shrink while it is mapped.
#[derive(Debug)]
pub struct Mapped<T>(NonNull<T>);

impl<T: Page> Mapped<T> {
    /// Maps a file that is there, which is made as long as the page where it is shorter. Allocates nothing.
    #[allow(unsafe_code)]
    pub fn open(path: &CStr) -> Option<Self> {
        let length = size_of::<T>();
        // SAFETY: the path ends in a zero; descriptor and length are this function's own.
        let place = unsafe {
            let file = libc::open(path.as_ptr(), libc::O_RDWR | libc::O_CLOEXEC);
            if file < 0 {
                return None;
            }
            let mut about: libc::stat = std::mem::zeroed();
            let is_long = libc::fstat(file, &raw mut about) == 0
                && (about.st_size >= length as libc::off_t
                    || libc::ftruncate(file, length as libc::off_t) == 0);
            let access = libc::PROT_READ | libc::PROT_WRITE;
            let place = match is_long {
                true => libc::mmap(ptr::null_mut(), length, access, libc::MAP_SHARED, file, 0),
                false => libc::MAP_FAILED,
            };
            libc::close(file);
            place
        };
        match place == libc::MAP_FAILED {
            true => None,
            false => NonNull::new(place.cast()).map(Self),
        }
    }

    /// The page for as long as the process lives.
    pub fn leak(self) -> *mut T {
        let place = self.0;
        std::mem::forget(self);
        place.as_ptr()
    }
}

impl<T> Deref for Mapped<T> {
    type Target = T;

    #[allow(unsafe_code)]
    fn deref(&self) -> &T {
        // SAFETY: the mapping is long enough, aligned to a page, lives as long as `self`, and holds atomic integers alone.
        unsafe { self.0.as_ref() }
    }
}

impl<T> Drop for Mapped<T> {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        // SAFETY: mapped by `open` with this length; nothing borrows it any more.
        unsafe { libc::munmap(self.0.as_ptr().cast(), size_of::<T>()) };
    }
}

// SAFETY: a page is atomic integers alone, and its place does not depend on a thread.
#[allow(unsafe_code)]
unsafe impl<T: Sync> Send for Mapped<T> {}
// SAFETY: as above.
#[allow(unsafe_code)]
unsafe impl<T: Sync> Sync for Mapped<T> {}
