//! Nodes that are device nodes, and the part of sysfs that says which hardware is behind them: a test lays it out as folders
//! of the bench.

use std::ffi::{CStr, c_char, c_int, c_uint};

use nix::libc;
use palpate_tests::fake_bench::{MAJOR, NODE_MODE};

use crate::text::Text;
use crate::{folder, real, text};

/// Stands in for `statx`: a file of a node's mode is a character device, and its length is the number of its adapter.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn statx(
    at: c_int,
    path: *const c_char,
    flags: c_int,
    mask: c_uint,
    about: *mut libc::statx,
) -> c_int {
    let next =
        real!(c"statx" as fn(c_int, *const c_char, c_int, c_uint, *mut libc::statx) -> c_int);
    // SAFETY: handed on as it came.
    let result = unsafe { next(at, path, flags, mask, about) };
    if result == 0 && folder().is_some() {
        // SAFETY: the caller's place, which has just been written.
        let about = unsafe { &mut *about };
        if u32::from(about.stx_mode) == libc::S_IFREG | NODE_MODE {
            about.stx_mode = (libc::S_IFCHR | NODE_MODE) as u16;
            (about.stx_rdev_major, about.stx_rdev_minor) = (MAJOR, about.stx_size as u32);
        }
    }
    result
}

/// Stands in for `realpath`: what sysfs has of adapters lies below the bench's folder.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn realpath(path: *const c_char, place: *mut c_char) -> *mut c_char {
    let next = real!(c"realpath" as fn(*const c_char, *mut c_char) -> *mut c_char);
    let own = folder().and_then(|folder| {
        let path = text(path.cast_mut())?;
        let begin = Text::<32>::new(format_args!("/sys/dev/char/{MAJOR}:"));
        let is_own = path.starts_with(begin.c()?.to_str().ok()?);
        is_own.then(|| Text::<512>::new(format_args!("{folder}{path}")))
    });
    let path = own.as_ref().and_then(Text::c).map_or(path, CStr::as_ptr);
    // SAFETY: handed on as it came, or a path that ends in a zero and lives until after the call.
    unsafe { next(path, place) }
}
