//! Clocks that lose time or stand still, for reading and for waiting. What happens on the bench is dated by the true ones.

use std::ffi::{c_int, c_long};
use std::sync::atomic::Ordering;

use nix::libc::{self, clockid_t, timespec};
use palpate_tests::fake_bench::ClockPage;

use crate::{CLOCK, nap, page, real};

const SECOND: i64 = 1_000_000_000;
/// Of FUTEX_WAIT_BITSET, which waits until a time of CLOCK_MONOTONIC, and of its flag for another clock.
const FUTEX_COMMAND: usize = 0x7F;
const FUTEX_WAIT_BITSET: usize = 9;
const FUTEX_CLOCK_REALTIME: usize = 256;

fn nanoseconds(time: timespec) -> i64 {
    time.tv_sec
        .saturating_mul(SECOND)
        .saturating_add(time.tv_nsec)
}

fn time(nanoseconds: i64) -> timespec {
    let nanoseconds = nanoseconds.max(0);
    timespec {
        tv_sec: nanoseconds / SECOND,
        tv_nsec: nanoseconds % SECOND,
    }
}

/// A true clock.
fn true_ns(clock: clockid_t) -> i64 {
    let mut now = time(0);
    let next = real!(c"clock_gettime" as fn(clockid_t, *mut timespec) -> c_int);
    // SAFETY: the place lives until after the call.
    unsafe { next(clock, &raw mut now) };
    nanoseconds(now)
}

/// CLOCK_MONOTONIC_RAW, which dates the record.
pub fn raw_ns() -> u64 {
    true_ns(libc::CLOCK_MONOTONIC_RAW).unsigned_abs()
}

/// Lets so many microseconds pass by the true clock.
pub fn pass_us(microseconds: u32) {
    if microseconds == 0 {
        return;
    }
    let until = time(true_ns(libc::CLOCK_MONOTONIC) + i64::from(microseconds) * 1000);
    while sleep(
        libc::CLOCK_MONOTONIC,
        libc::TIMER_ABSTIME,
        &until,
        std::ptr::null_mut(),
    ) == libc::EINTR
    {}
}

fn sleep(clock: clockid_t, flags: c_int, span: &timespec, left: *mut timespec) -> c_int {
    let next =
        real!(c"clock_nanosleep" as fn(clockid_t, c_int, *const timespec, *mut timespec) -> c_int);
    // SAFETY: the span lives until after the call; `left` is none, or a place that the caller lends.
    unsafe { next(clock, flags, span, left) }
}

/// How far the program's CLOCK_MONOTONIC is behind the true one.
fn behind(page: &ClockPage) -> i64 {
    let now = true_ns(libc::CLOCK_MONOTONIC);
    now.saturating_sub(page.monotonic(now))
}

/// Stands in for `clock_gettime`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clock_gettime(clock: clockid_t, now: *mut timespec) -> c_int {
    let next = real!(c"clock_gettime" as fn(clockid_t, *mut timespec) -> c_int);
    // SAFETY: handed on as it came.
    let result = unsafe { next(clock, now) };
    let Some(page) = page(&CLOCK).filter(|_| result == 0) else {
        return result;
    };
    // SAFETY: the caller's place, which has just been written.
    let now = unsafe { &mut *now };
    match clock {
        libc::CLOCK_MONOTONIC => *now = time(page.monotonic(nanoseconds(*now))),
        libc::CLOCK_BOOTTIME => *now = time(page.uptime(nanoseconds(*now))),
        libc::CLOCK_REALTIME => {
            *now = time(nanoseconds(*now) + page.realtime_ns.load(Ordering::Acquire));
        }
        _ => {}
    }
    result
}

/// Stands in for `clock_nanosleep`: until a time of the program's clock.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn clock_nanosleep(
    clock: clockid_t,
    flags: c_int,
    span: *const timespec,
    left: *mut timespec,
) -> c_int {
    // SAFETY: the caller's span.
    let asked = unsafe { *span };
    let is_absolute = clock == libc::CLOCK_MONOTONIC && flags & libc::TIMER_ABSTIME != 0;
    let Some(page) = page(&CLOCK).filter(|_| is_absolute) else {
        return sleep(clock, flags, &asked, left);
    };
    loop {
        // A clock that stands still has an end that nobody knows.
        while page.still_ns.load(Ordering::Acquire) != 0 {
            nap();
        }
        let until = time(nanoseconds(asked).saturating_add(behind(page)));
        let result = sleep(clock, flags, &until, left);
        let now = page.monotonic(true_ns(libc::CLOCK_MONOTONIC));
        // Time that was lost in the meantime is waited for as well.
        if result != 0 || now >= nanoseconds(asked) {
            return result;
        }
    }
}

/// Stands in for `syscall`, by which threads wait for each other until a time of CLOCK_MONOTONIC.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn syscall(
    number: c_long,
    a: usize,
    b: usize,
    c: usize,
    d: usize,
    e: usize,
    f: usize,
) -> c_long {
    let next = real!(c"syscall" as fn(c_long, usize, usize, usize, usize, usize, usize) -> c_long);
    let waits = number == libc::SYS_futex
        && b & FUTEX_COMMAND == FUTEX_WAIT_BITSET
        && b & FUTEX_CLOCK_REALTIME == 0
        && d != 0;
    let Some(page) = page(&CLOCK).filter(|_| waits) else {
        // SAFETY: handed on as it came.
        return unsafe { next(number, a, b, c, d, e, f) };
    };
    // SAFETY: this call takes the place of a time there.
    let asked = unsafe { *(d as *const timespec) };
    let until = time(nanoseconds(asked).saturating_add(behind(page)));
    // SAFETY: handed on with a time that lives until after the call.
    unsafe { next(number, a, b, c, (&raw const until) as usize, e, f) }
}
