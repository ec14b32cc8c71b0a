//! CAN sockets: a datagram socket of the bench's folder in the place of each, which takes frames as the kernel hands them over.

use std::ffi::{CStr, c_char, c_int, c_void};

use nix::libc;

use crate::text::Text;
use crate::{fail, folder, real};

/// Sockets that one interface may have at a time.
const SOCKETS: usize = 16;

/// Stands in for `socket`.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn socket(domain: c_int, kind: c_int, protocol: c_int) -> c_int {
    let next = real!(c"socket" as fn(c_int, c_int, c_int) -> c_int);
    let flags = kind & (libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK);
    let asked = match domain == libc::AF_CAN && folder().is_some() {
        true => (libc::AF_UNIX, libc::SOCK_DGRAM | flags, 0),
        false => (domain, kind, protocol),
    };
    // SAFETY: numbers alone.
    unsafe { next(asked.0, asked.1, asked.2) }
}

/// Stands in for `bind`. A CAN socket gets the file `NAME.rx` of its interface, or `NAME-1.rx` and so on while others live:
/// each hears the interface.
///
/// # Safety
/// As that: `length` bytes of an address lie at `address`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bind(
    fd: c_int,
    address: *const libc::sockaddr,
    length: libc::socklen_t,
) -> c_int {
    let next = real!(c"bind" as fn(c_int, *const libc::sockaddr, libc::socklen_t) -> c_int);
    // SAFETY: every address begins with its family.
    let is_can = unsafe { c_int::from((*address).sa_family) } == libc::AF_CAN;
    let Some(folder) = folder().filter(|_| is_can) else {
        // SAFETY: handed on as it came.
        return unsafe { next(fd, address, length) };
    };
    let mut name = [0 as c_char; libc::IF_NAMESIZE];
    // SAFETY: an address of this family has an interface's number; the place is as long as any name.
    let name = unsafe {
        let can = &*address.cast::<libc::sockaddr_can>();
        libc::if_indextoname(can.can_ifindex as u32, name.as_mut_ptr());
        CStr::from_ptr(name.as_ptr()).to_str().unwrap_or_default()
    };
    if name.is_empty() {
        return fail(libc::ENODEV);
    }
    for number in 0..SOCKETS {
        let path = match number {
            0 => Text::<108>::new(format_args!("{folder}/{name}.rx")),
            n => Text::new(format_args!("{folder}/{name}-{n}.rx")),
        };
        let Some(path) = path.c() else {
            return fail(libc::ENAMETOOLONG);
        };
        // SAFETY: numbers, for which zero is a value.
        let mut place: libc::sockaddr_un = unsafe { std::mem::zeroed() };
        place.sun_family = libc::AF_UNIX as u16;
        for (to, from) in place.sun_path.iter_mut().zip(path.to_bytes()) {
            *to = *from as c_char;
        }
        if !is_heard(&place) {
            // SAFETY: the path ends in a zero; the address lives until after the call.
            return unsafe {
                libc::unlink(path.as_ptr());
                next(fd, (&raw const place).cast(), size_of_val(&place) as u32)
            };
        }
    }
    fail(libc::EADDRINUSE)
}

/// Whether a socket that lives is bound there.
fn is_heard(place: &libc::sockaddr_un) -> bool {
    // SAFETY: numbers, and an address that lives until after the call; the descriptor is this function's own.
    unsafe {
        let probe = libc::socket(libc::AF_UNIX, libc::SOCK_DGRAM | libc::SOCK_CLOEXEC, 0);
        let place = (&raw const *place).cast();
        let reached = libc::connect(probe, place, size_of::<libc::sockaddr_un>() as u32);
        let errno = *libc::__errno_location();
        libc::close(probe);
        reached == 0 || ![libc::ENOENT, libc::ECONNREFUSED].contains(&errno)
    }
}

/// Stands in for `setsockopt`: what only a CAN socket knows is granted.
///
/// # Safety
/// As that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn setsockopt(
    fd: c_int,
    level: c_int,
    option: c_int,
    value: *const c_void,
    length: libc::socklen_t,
) -> c_int {
    let can_only = match level {
        libc::SOL_CAN_RAW => true,
        libc::SOL_SOCKET => [libc::SO_RXQ_OVFL, libc::SO_TIMESTAMPING].contains(&option),
        _ => false,
    };
    if can_only && folder().is_some() {
        return 0;
    }
    let next =
        real!(c"setsockopt" as fn(c_int, c_int, c_int, *const c_void, libc::socklen_t) -> c_int);
    // SAFETY: handed on as it came.
    unsafe { next(fd, level, option, value, length) }
}
