//! A bench of hardware that is not there, as a library that is preloaded under the program: I2C adapters with chips of
//! regular files and their places in sysfs, CAN sockets of UNIX sockets, clocks that lose time, and memory, threads,
//! descriptors and disks that fail. The pages by which a test commands it are described in `palpate_tests::fake_bench`.
//!
//! Each function stands in for one of the C library, which it calls in every case that is none of the bench's. Nothing
//! here allocates or panics: it is called from wherever the program is. Without the folder in the environment it changes
//! nothing.
//!
//! Functions that C declares with variable arguments are defined with as many as they take at most: where this library
//! runs both are passed in the same registers.
#![cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
#![allow(
    unsafe_code,
    reason = "a function of the C library is unsafe by its type"
)]

#[path = "fake_bench/can.rs"]
mod can;
#[path = "fake_bench/clock.rs"]
mod clock;
#[path = "fake_bench/i2c.rs"]
mod i2c;
#[path = "fake_bench/lacks.rs"]
mod lacks;
#[path = "fake_bench/sysfs.rs"]
mod sysfs;
#[path = "fake_bench/text.rs"]
mod text;

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicPtr, AtomicU32, Ordering};

use nix::libc;
use palpate_tests::fake_bench::{
    ADAPTERS, AdapterPage, ClockPage, GUARDIAN, Mapped, Page, RUN, ScarcePage,
};

use text::Text;

/// The function of the C library that a function here stands in for.
macro_rules! real {
    ($name:literal as fn($($argument:ty),* $(,)?) -> $result:ty) => {{
        static FOUND: std::sync::atomic::AtomicPtr<std::ffi::c_void> =
            std::sync::atomic::AtomicPtr::new(std::ptr::null_mut());
        let found = $crate::next(&FOUND, $name);
        // SAFETY: the C library declares the function of this name with these arguments.
        unsafe {
            std::mem::transmute::<*mut std::ffi::c_void, unsafe extern "C" fn($($argument),*) -> $result>(found)
        }
    }};
}
pub(crate) use real;

/// The next function of this name after this library's, looked for once.
fn next(found: &AtomicPtr<c_void>, name: &CStr) -> *mut c_void {
    let held = found.load(Ordering::Acquire);
    if !held.is_null() {
        return held;
    }
    // SAFETY: the name ends in a zero.
    let looked = unsafe { libc::dlsym(libc::RTLD_NEXT, name.as_ptr()) };
    if looked.is_null() {
        // SAFETY: ends the process; a program that calls what no library has would not have started.
        unsafe { libc::abort() };
    }
    found.store(looked, Ordering::Release);
    looked
}

/// The bench's folder and the folder of stops, as the environment holds them: it lives as long as the process.
static FOLDER: AtomicPtr<c_char> = AtomicPtr::new(ptr::null_mut());
static STATE: AtomicPtr<c_char> = AtomicPtr::new(ptr::null_mut());
static CLOCK: AtomicPtr<ClockPage> = AtomicPtr::new(ptr::null_mut());
static SCARCE: AtomicPtr<ScarcePage> = AtomicPtr::new(ptr::null_mut());
static BUSES: [AtomicPtr<AdapterPage>; ADAPTERS] =
    [const { AtomicPtr::new(ptr::null_mut()) }; ADAPTERS];
/// Whether this process is the guardian or another.
static ROLE: AtomicU32 = AtomicU32::new(0);

/// Called by the loader before the program's `main`.
#[used]
#[unsafe(link_section = ".init_array")]
static BEGIN: extern "C" fn(c_int, *const *const c_char, *const *const c_char) = begin;

extern "C" fn begin(count: c_int, words: *const *const c_char, _environment: *const *const c_char) {
    // SAFETY: the names end in a zero, and nothing changes the environment of the program.
    let variable = |name: &CStr| unsafe { libc::getenv(name.as_ptr()) };
    let folder = variable(c"PALPATE_FAKE_BENCH");
    let Some(name) = text(folder) else {
        return;
    };
    let is_guardian = count > 1 && {
        // SAFETY: the loader hands over `count` words.
        let word = unsafe { *words.add(1) };
        text(word.cast_mut()) == Some("guardian")
    };
    ROLE.store(if is_guardian { GUARDIAN } else { RUN }, Ordering::Release);
    STATE.store(variable(c"PALPATE_STATE"), Ordering::Release);
    for (number, place) in BUSES.iter().enumerate() {
        let path = Text::<512>::new(format_args!("{name}/i2c-{number}.state"));
        place.store(mapped(&path), Ordering::Release);
    }
    CLOCK.store(
        mapped(&Text::<512>::new(format_args!("{name}/clock.state"))),
        Ordering::Release,
    );
    SCARCE.store(
        mapped(&Text::<512>::new(format_args!("{name}/scarce.state"))),
        Ordering::Release,
    );
    FOLDER.store(folder, Ordering::Release);
}

/// A page that is there from the start: nothing is opened once the program runs, and may lack descriptors.
fn mapped<T: Page>(path: &Text<512>) -> *mut T {
    let page = path.c().and_then(Mapped::<T>::open);
    page.map_or(ptr::null_mut(), Mapped::leak)
}

/// A page, where the bench has it.
fn page<T: Page>(place: &AtomicPtr<T>) -> Option<&'static T> {
    // SAFETY: none, or a page that stays mapped for as long as the process lives.
    unsafe { place.load(Ordering::Acquire).as_ref() }
}

/// A text of the environment or of the command line.
fn text(words: *mut c_char) -> Option<&'static str> {
    if words.is_null() {
        return None;
    }
    // SAFETY: both end in a zero and stay where the loader has put them.
    unsafe { CStr::from_ptr(words) }.to_str().ok()
}

/// The bench's folder; none where there is no bench.
fn folder() -> Option<&'static str> {
    text(FOLDER.load(Ordering::Acquire))
}

/// Whether this process lacks something.
fn lacks(what: impl Fn(&ScarcePage) -> &AtomicU32) -> bool {
    page(&SCARCE).is_some_and(|scarce| {
        what(scarce).load(Ordering::Acquire) & ROLE.load(Ordering::Acquire) != 0
    })
}

/// The failure of a function: its error number is set, and it returns -1.
fn fail(errno: c_int) -> c_int {
    // SAFETY: the place of this thread's error number is always there.
    unsafe { *libc::__errno_location() = errno };
    -1
}

/// Sleeps by the true clock for a fifth of a millisecond, whatever becomes of it.
fn nap() {
    let span = libc::timespec {
        tv_sec: 0,
        tv_nsec: 200_000,
    };
    let sleep = real!(c"nanosleep" as fn(*const libc::timespec, *mut libc::timespec) -> c_int);
    // SAFETY: the span lives until after the call; what is left of it is not asked for.
    unsafe { sleep(&raw const span, ptr::null_mut()) };
}

/// Where a descriptor leads, written into `place`.
fn path_of(fd: c_int, place: &mut [u8; 512]) -> Option<&str> {
    let link = Text::<64>::new(format_args!("/proc/self/fd/{fd}"));
    let link = link.c()?;
    // SAFETY: the link's name ends in a zero, the place has the length that is told.
    let length = unsafe { libc::readlink(link.as_ptr(), place.as_mut_ptr().cast(), place.len()) };
    let bytes = place.get(..usize::try_from(length).ok()?)?;
    std::str::from_utf8(bytes).ok()
}
