//! The few system calls that no safe crate has: I2C adapter functions and time-out, real-time priority
//! (and locked memory and core dumps, which belong beside them).
//! Each `unsafe` stands alone with its reason.

use std::os::fd::{AsRawFd, BorrowedFd};

use nix::errno::Errno;
use nix::libc;
use nix::sys::mman::{MlockAllFlags, mlockall};
use nix::sys::prctl;
use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};

/// `I2C_TIMEOUT` of `linux/i2c-dev.h`: units of 10 ms.
const I2C_TIMEOUT: libc::Ioctl = 0x0702;
/// `I2C_RETRIES`.
const I2C_RETRIES: libc::Ioctl = 0x0701;
/// `I2C_SLAVE`.
const I2C_SLAVE: libc::Ioctl = 0x0703;
/// `I2C_FUNCS`: writes an unsigned long.
const I2C_FUNCS: libc::Ioctl = 0x0705;

/// An ioctl whose argument is a number, not a pointer.
#[allow(unsafe_code)]
fn number(fd: BorrowedFd<'_>, request: libc::Ioctl, value: libc::c_ulong) -> Result<(), Errno> {
    // SAFETY: the three requests used here take a number by value and touch no memory of ours.
    let result = unsafe { libc::ioctl(fd.as_raw_fd(), request, value) };
    Errno::result(result).map(drop)
}

/// Sets the adapter's limit for one transfer, in units of 10 ms. Adapters may round it up, or not know it at all.
///
/// # Errors
/// Error of the device.
pub fn set_i2c_timeout(fd: BorrowedFd<'_>, units_10ms: u32) -> Result<(), Errno> {
    number(fd, I2C_TIMEOUT, units_10ms.into())
}

/// Sets the number of the adapter's own tries: it cannot know which writes may be repeated.
///
/// # Errors
/// Error of the device.
pub fn set_i2c_retries(fd: BorrowedFd<'_>, retries: u32) -> Result<(), Errno> {
    number(fd, I2C_RETRIES, retries.into())
}

/// Claims an address as `i2c-dev` does: `EBUSY` while a kernel driver holds it.
///
/// # Errors
/// Error of the device.
pub fn claim_address(fd: BorrowedFd<'_>, address: u8) -> Result<(), Errno> {
    number(fd, I2C_SLAVE, address.into())
}

/// Functions of the adapter: bits `I2C_FUNC_*` of `linux/i2c.h`.
///
/// # Errors
/// Error of the device; `ENOTTY` for a node that is no I2C adapter.
#[allow(unsafe_code)]
pub fn i2c_functions(fd: BorrowedFd<'_>) -> Result<libc::c_ulong, Errno> {
    let mut functions: libc::c_ulong = 0;
    // SAFETY: I2C_FUNCS writes one unsigned long through the pointer, which lives until after the call.
    let result = unsafe { libc::ioctl(fd.as_raw_fd(), I2C_FUNCS, &raw mut functions) };
    Errno::result(result).map(|_| functions)
}

/// Real-time priority (SCHED_FIFO, 1 to 99) for the calling thread.
///
/// # Errors
/// `EPERM` without CAP_SYS_NICE or an rtprio limit that allows it.
#[allow(unsafe_code)]
pub fn set_fifo_priority(priority: u8) -> Result<(), Errno> {
    // SAFETY: integers, for which zero is a value. musl's structure has more of them than glibc's.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    parameters.sched_priority = priority.into();
    // Not `sched_setscheduler`: in musl that one always fails with ENOSYS.
    // SAFETY: the calling thread is there; the structure is read during the call only.
    let result = unsafe {
        libc::pthread_setschedparam(
            libc::pthread_self(),
            libc::SCHED_FIFO,
            &raw const parameters,
        )
    };
    match result {
        0 => Ok(()),
        error => Err(Errno::from_raw(error)),
    }
}

/// The real-time priority of the calling thread (SCHED_FIFO, 1 to 99), where it has one.
#[allow(unsafe_code)]
pub fn fifo_priority() -> Option<u8> {
    let mut policy = 0;
    // SAFETY: integers, for which zero is a value.
    let mut parameters: libc::sched_param = unsafe { std::mem::zeroed() };
    // SAFETY: the calling thread is there; both places are written during the call only.
    let result = unsafe {
        libc::pthread_getschedparam(libc::pthread_self(), &raw mut policy, &raw mut parameters)
    };
    let is_known = result == 0 && policy == libc::SCHED_FIFO;
    u8::try_from(parameters.sched_priority)
        .ok()
        .filter(|_| is_known)
}

/// Forbids core dumps of this program: while one is written the program counts as alive, its sockets stay open, and a
/// caller that waits for its end waits.
///
/// # Errors
/// Error of the system.
pub fn forbid_core_dumps() -> Result<(), Errno> {
    prctl::set_dumpable(false)
}

/// Bytes of memory that may be locked; `None` for all of it.
pub fn lock_memory_limit() -> Option<u64> {
    let (soft, _) = getrlimit(Resource::RLIMIT_MEMLOCK).ok()?;
    (soft != RLIM_INFINITY && !nix::unistd::geteuid().is_root()).then_some(soft)
}

/// Memory that is never paged out, for the whole program.
///
/// # Errors
/// `EPERM` or `ENOMEM` without CAP_IPC_LOCK or a memlock limit that allows it.
pub fn lock_memory() -> Result<(), Errno> {
    mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE)
}

/// Ends the locking of memory: later mappings are not refused for its sake.
pub fn unlock_memory() {
    let _ = nix::sys::mman::munlockall();
}

/// Ignores every signal that can be ignored, but SIGTERM: a process that only switches off is ended by nothing else.
#[allow(unsafe_code)]
pub fn ignore_signals() {
    for number in 1..=libc::SIGRTMAX() {
        let needed = [
            libc::SIGTERM,
            libc::SIGCHLD,
            libc::SIGSEGV,
            libc::SIGBUS,
            libc::SIGILL,
            libc::SIGFPE,
            libc::SIGABRT,
        ];
        if !needed.contains(&number) {
            // SAFETY: no handler is installed. A number that the system keeps to itself is refused, and changes nothing.
            unsafe { libc::signal(number, libc::SIG_IGN) };
        }
    }
}

/// Touches `BYTES` bytes of the calling thread's stack, so that they are there without a page fault later.
#[inline(never)]
pub fn touch_stack<const BYTES: usize>() {
    let mut bytes = [0_u8; BYTES];
    for page in bytes.chunks_mut(1024) {
        page[0] = std::hint::black_box(1);
    }
    std::hint::black_box(&bytes);
}
