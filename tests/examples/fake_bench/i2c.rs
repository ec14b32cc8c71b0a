//! I2C adapters: what `i2c-dev` answers, for descriptors of the bench's files.

use std::ffi::{c_int, c_ulong, c_void};
use std::sync::atomic::Ordering;

use nix::libc;
use palpate_core::codec::pca9685 as regs;
use palpate_tests::fake_bench::{ADAPTERS, AdapterPage, Chip, Mode, State};

use crate::{BUSES, clock, fail, folder, nap, page, path_of, real};

/// Requests of `linux/i2c-dev.h`.
const I2C: std::ops::Range<c_ulong> = 0x0700..0x0800;
const I2C_FUNCS: c_ulong = 0x0705;
const I2C_RDWR: c_ulong = 0x0707;
/// I2C_FUNC_I2C and I2C_FUNC_SMBUS_EMUL of `linux/i2c.h`.
const FUNCTIONS: c_ulong = 0x0EFF_0009;
/// A message that reads.
const READS: u16 = 1;

/// `struct i2c_msg`.
#[repr(C)]
struct Message {
    address: u16,
    flags: u16,
    length: u16,
    bytes: *mut u8,
}

impl Message {
    fn bytes(&mut self) -> &mut [u8] {
        if self.length == 0 {
            return &mut [];
        }
        // SAFETY: the caller of the request lends so many bytes there, to nobody else, until it has its answer.
        unsafe { std::slice::from_raw_parts_mut(self.bytes, self.length.into()) }
    }
}

/// `struct i2c_rdwr_ioctl_data`.
#[repr(C)]
struct Transfer {
    messages: *mut Message,
    count: u32,
}

/// Whose a descriptor is.
enum Whose {
    /// None of the bench's.
    Other,
    /// An adapter's that is no longer where it was.
    Gone,
    Adapter(&'static AdapterPage),
}

fn whose(fd: c_int) -> Whose {
    let mut place = [0; 512];
    let own = folder().and_then(|folder| {
        let path = path_of(fd, &mut place)?;
        path.strip_prefix(folder)?.strip_prefix("/i2c-")
    });
    let Some(name) = own else {
        return Whose::Other;
    };
    let number = name.parse().ok().filter(|n: &usize| *n < ADAPTERS);
    match number.and_then(|n| page(&BUSES[n])) {
        Some(page) => Whose::Adapter(page),
        None => Whose::Gone,
    }
}

/// Stands in for `ioctl`.
///
/// # Safety
/// As that: `argument` is what the request takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ioctl(fd: c_int, request: c_ulong, argument: *mut c_void) -> c_int {
    let adapter = match I2C.contains(&request) {
        true => whose(fd),
        false => Whose::Other,
    };
    let page = match adapter {
        Whose::Adapter(page) => page,
        Whose::Gone => return fail(libc::ENODEV),
        Whose::Other => {
            let next = real!(c"ioctl" as fn(c_int, c_ulong, *mut c_void) -> c_int);
            // SAFETY: handed on as it came.
            return unsafe { next(fd, request, argument) };
        }
    };
    match request {
        I2C_FUNCS => {
            // SAFETY: this request takes the place of an unsigned long.
            unsafe { *argument.cast::<c_ulong>() = FUNCTIONS };
            0
        }
        I2C_RDWR => {
            // SAFETY: this request takes a description of messages, and lends them until it returns.
            let messages = unsafe {
                let transfer = &*argument.cast::<Transfer>();
                std::slice::from_raw_parts_mut(transfer.messages, transfer.count as usize)
            };
            match transfer(page, messages) {
                Ok(()) => messages.len() as c_int,
                Err(errno) => fail(errno),
            }
        }
        _ => 0,
    }
}

/// Carries a transfer out as the adapter's page says.
fn transfer(page: &AdapterPage, messages: &mut [Message]) -> Result<(), c_int> {
    page.count();
    while page.mode() == Mode::Hangs {
        nap();
    }
    let mode = page.mode();
    if let Mode::Fails(errno) = mode {
        return Err(errno.into());
    }
    let absent = page.absent.load(Ordering::Acquire);
    let done = page.change(clock::raw_ns, |state| {
        messages
            .iter_mut()
            .try_for_each(|message| exchange(state, absent, message, mode == Mode::Lies))
    });
    clock::pass_us(page.late_us.load(Ordering::Acquire));
    done
}

/// One message; a refusal where no chip acknowledges it.
fn exchange(
    state: &mut State,
    absent: u32,
    message: &mut Message,
    lies: bool,
) -> Result<(), c_int> {
    let (address, reads) = (message.address as u8, message.flags & READS != 0);
    let bytes = message.bytes();
    let there = state.chips.iter_mut().enumerate();
    let there = there.filter(|(n, chip)| absent >> n & 1 == 0 && chip.address != 0);
    let mut is_heard = state.switch.exchange(address, reads, bytes);
    for (_, chip) in there {
        if (address, &*bytes) == (regs::SOFTWARE_RESET.0, &[regs::SOFTWARE_RESET.1]) {
            *chip = Chip::new(chip.address);
        } else if !chip.answers(address) {
            continue;
        } else if reads {
            chip.read(bytes);
        } else {
            chip.write(bytes);
        }
        is_heard = true;
    }
    if reads && lies {
        bytes.iter_mut().for_each(|byte| *byte ^= 0x55);
    }
    match is_heard {
        true => Ok(()),
        false => Err(libc::ENXIO),
    }
}
