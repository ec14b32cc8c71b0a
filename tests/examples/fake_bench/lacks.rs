//! What a program lacks: memory, threads, descriptors, a disk for its stops. Also which start of the machine a file tells it.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::atomic::Ordering;

use nix::libc::{self, mode_t, off_t, size_t, ssize_t};

use palpate_tests::fake_bench::BOOT_ID;

use crate::text::Text;
use crate::{SCARCE, STATE, fail, folder, lacks, nap, page, path_of, real, text};

// What glibc calls its own functions: they take part in no search by name, which would want memory itself.
unsafe extern "C" {
    fn __libc_malloc(size: size_t) -> *mut c_void;
    fn __libc_calloc(count: size_t, size: size_t) -> *mut c_void;
    fn __libc_realloc(held: *mut c_void, size: size_t) -> *mut c_void;
    fn __libc_memalign(alignment: size_t, size: size_t) -> *mut c_void;
}

/// Memory, or none for a program that lacks it.
fn memory(get: impl FnOnce() -> *mut c_void) -> *mut c_void {
    if lacks(|scarce| &scarce.memory) {
        fail(libc::ENOMEM);
        return ptr::null_mut();
    }
    get()
}

/// Stands in for `malloc`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn malloc(size: size_t) -> *mut c_void {
    // SAFETY: handed on as it came.
    memory(|| unsafe { __libc_malloc(size) })
}

/// Stands in for `calloc`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn calloc(count: size_t, size: size_t) -> *mut c_void {
    // SAFETY: handed on as it came.
    memory(|| unsafe { __libc_calloc(count, size) })
}

/// Stands in for `realloc`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn realloc(held: *mut c_void, size: size_t) -> *mut c_void {
    // SAFETY: handed on as it came.
    memory(|| unsafe { __libc_realloc(held, size) })
}

/// Stands in for `aligned_alloc`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn aligned_alloc(alignment: size_t, size: size_t) -> *mut c_void {
    // SAFETY: handed on as it came.
    memory(|| unsafe { __libc_memalign(alignment, size) })
}

/// Stands in for `posix_memalign`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn posix_memalign(
    place: *mut *mut c_void,
    alignment: size_t,
    size: size_t,
) -> c_int {
    // SAFETY: handed on as it came.
    let got = memory(|| unsafe { __libc_memalign(alignment, size) });
    if got.is_null() {
        return libc::ENOMEM;
    }
    // SAFETY: the caller's place.
    unsafe { *place = got };
    0
}

/// Stands in for `pthread_create`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pthread_create(
    thread: *mut libc::pthread_t,
    attributes: *const libc::pthread_attr_t,
    start: extern "C" fn(*mut c_void) -> *mut c_void,
    argument: *mut c_void,
) -> c_int {
    if lacks(|scarce| &scarce.threads) {
        return libc::EAGAIN;
    }
    type Start = extern "C" fn(*mut c_void) -> *mut c_void;
    let next = real!(
        c"pthread_create"
            as fn(*mut libc::pthread_t, *const libc::pthread_attr_t, Start, *mut c_void) -> c_int
    );
    // SAFETY: handed on as it came.
    unsafe { next(thread, attributes, start, argument) }
}

/// Whether a path lies in the folder of stops.
fn is_state(path: &str) -> bool {
    let folder = text(STATE.load(Ordering::Acquire));
    folder.is_some_and(|folder| path.starts_with(folder))
}

/// Why an access to the folder of stops fails, once it has hung for as long as it is to. Which path it is for is looked
/// up where something is wrong with the disk, and not else.
fn disk(is_there: impl FnOnce() -> bool, opens: bool) -> Result<(), c_int> {
    let hangs = || match opens {
        true => lacks(|scarce| &scarce.open_hangs),
        false => lacks(|scarce| &scarce.disk_hangs),
    };
    let fails = || lacks(|scarce| &scarce.disk_fails);
    if !(hangs() || fails()) || !is_there() {
        return Ok(());
    }
    while hangs() {
        nap();
    }
    let errno = page(&SCARCE).map_or(0, |scarce| scarce.disk_errno.load(Ordering::Acquire));
    // A full disk opens what it cannot write.
    match fails() && (!opens || errno as c_int == libc::EROFS) {
        true => Err(errno as c_int),
        false => Ok(()),
    }
}

/// The same for what a descriptor leads to.
fn disk_of(fd: c_int) -> Result<(), c_int> {
    disk(|| path_of(fd, &mut [0; 512]).is_some_and(is_state), false)
}

/// Whether a file may be opened: a descriptor is there, and the disk plays along.
fn may_open(path: *const c_char, flags: c_int) -> Result<(), c_int> {
    if lacks(|scarce| &scarce.descriptors) {
        return Err(libc::EMFILE);
    }
    let reads = flags & libc::O_ACCMODE == libc::O_RDONLY && flags & libc::O_CREAT == 0;
    let is_there = || {
        // SAFETY: the caller's path ends in a zero.
        let path = unsafe { CStr::from_ptr(path) };
        path.to_str().is_ok_and(is_state)
    };
    let hangs = lacks(|scarce| &scarce.open_hangs);
    match reads && !hangs {
        true => Ok(()),
        false => disk(is_there, true),
    }
}

/// The bench's own file of which start of the machine this is, where it has one and this path is the kernel's.
fn start_of(path: *const c_char) -> Option<Text<512>> {
    // SAFETY: the caller's path ends in a zero.
    let is_kernel_s = unsafe { CStr::from_ptr(path) } == c"/proc/sys/kernel/random/boot_id";
    let folder = folder().filter(|_| is_kernel_s)?;
    let own = Text::new(format_args!("{folder}/{BOOT_ID}"));
    // SAFETY: the path ends in a zero.
    let is_there = unsafe { libc::access(own.c()?.as_ptr(), libc::F_OK) } == 0;
    is_there.then_some(own)
}

/// Functions that open a file.
macro_rules! opens {
    ($($name:ident, $c:literal, ($($at:ident)?);)*) => {$(
        /// Stands in for the function of this name.
        ///
        /// # Safety
        /// As that.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            $($at: c_int,)?
            path: *const c_char,
            flags: c_int,
            mode: mode_t,
        ) -> c_int {
            if let Err(errno) = may_open(path, flags) {
                return fail(errno);
            }
            let own = start_of(path);
            let path = own.as_ref().and_then(Text::c).map_or(path, CStr::as_ptr);
            let next = real!($c as fn($(opens!(@int $at),)? *const c_char, c_int, mode_t) -> c_int);
            // SAFETY: handed on as it came, or a path that ends in a zero and lives until after the call.
            unsafe { next($($at,)? path, flags, mode) }
        }
    )*};
    (@int $at:ident) => { c_int };
}

opens! {
    open, c"open", ();
    open64, c"open64", ();
    openat, c"openat", (folder);
    openat64, c"openat64", (folder);
}

/// Stands in for `dup`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dup(fd: c_int) -> c_int {
    if lacks(|scarce| &scarce.descriptors) {
        return fail(libc::EMFILE);
    }
    let next = real!(c"dup" as fn(c_int) -> c_int);
    // SAFETY: handed on as it came.
    unsafe { next(fd) }
}

/// Functions that do many things to a descriptor; one of them is to double it.
macro_rules! controls {
    ($($name:ident, $c:literal;)*) => {$(
        /// Stands in for the function of this name.
        ///
        /// # Safety
        /// As that.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(fd: c_int, command: c_int, argument: usize) -> c_int {
            let doubles = [libc::F_DUPFD, libc::F_DUPFD_CLOEXEC].contains(&command);
            if doubles && lacks(|scarce| &scarce.descriptors) {
                return fail(libc::EMFILE);
            }
            let next = real!($c as fn(c_int, c_int, usize) -> c_int);
            // SAFETY: handed on as it came.
            unsafe { next(fd, command, argument) }
        }
    )*};
}

controls! {
    fcntl, c"fcntl";
    fcntl64, c"fcntl64";
}

/// Functions that write to a descriptor, or wait until what was written is kept.
macro_rules! writes {
    ($($name:ident, $c:literal, ($($argument:ident: $kind:ty),*) -> $result:ty;)*) => {$(
        /// Stands in for the function of this name.
        ///
        /// # Safety
        /// As that.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(fd: c_int, $($argument: $kind),*) -> $result {
            if let Err(errno) = disk_of(fd) {
                return fail(errno) as $result;
            }
            let next = real!($c as fn(c_int, $($kind),*) -> $result);
            // SAFETY: handed on as it came.
            unsafe { next(fd, $($argument),*) }
        }
    )*};
}

writes! {
    write, c"write", (bytes: *const c_void, count: size_t) -> ssize_t;
    writev, c"writev", (parts: *const libc::iovec, count: c_int) -> ssize_t;
    pwrite, c"pwrite", (bytes: *const c_void, count: size_t, offset: off_t) -> ssize_t;
    pwrite64, c"pwrite64", (bytes: *const c_void, count: size_t, offset: off_t) -> ssize_t;
    fsync, c"fsync", () -> c_int;
    fdatasync, c"fdatasync", () -> c_int;
}

/// Whether a file may get a path as its name.
fn may_rename(to: *const c_char) -> Result<(), c_int> {
    // SAFETY: the caller's path ends in a zero.
    disk(
        || unsafe { CStr::from_ptr(to) }.to_str().is_ok_and(is_state),
        false,
    )
}

/// Stands in for `rename`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    if let Err(errno) = may_rename(to) {
        return fail(errno);
    }
    let next = real!(c"rename" as fn(*const c_char, *const c_char) -> c_int);
    // SAFETY: handed on as it came.
    unsafe { next(from, to) }
}

/// Stands in for `renameat`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn renameat(
    from_folder: c_int,
    from: *const c_char,
    to_folder: c_int,
    to: *const c_char,
) -> c_int {
    if let Err(errno) = may_rename(to) {
        return fail(errno);
    }
    let next = real!(c"renameat" as fn(c_int, *const c_char, c_int, *const c_char) -> c_int);
    // SAFETY: handed on as it came.
    unsafe { next(from_folder, from, to_folder, to) }
}
