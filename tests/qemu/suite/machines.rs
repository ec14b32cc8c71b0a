//! The machines, their images, and what most tests begin with.

use std::path::{Path, PathBuf};

use palpate_core::units::Duration;
use palpate_emulators::network::Profile;
use palpate_qemu::{Chips, Host, Lockstep, Machine};

/// The key that `ci/unit` builds the images with.
pub use super::held::KEY;

/// QEMU's RISC-V board without its atomics and floats, as an ESP32-C3 is, with the memory of a Feather M0.
pub const VIRT: Machine = Machine {
    name: "virt",
    program: "qemu-system-riscv32",
    arguments: &[
        "-M",
        "virt",
        "-cpu",
        "rv32,f=off,d=off,a=off",
        "-m",
        "8M",
        "-bios",
        "none",
    ],
    beside: &[],
    card: &[
        "-netdev",
        "user,id=n0,hostfwd=udp:127.0.0.1:PORT-:4000",
        "-device",
        "virtio-net-device,netdev=n0,bus=virtio-mmio-bus.0",
    ],
    target: "riscv32imc-unknown-none-elf",
    shift: 3,
    tick_ns: 1,
    memory: (0x8010_0000, 32 * 1024),
};

/// A Raspberry Pi Pico in rp2040js: its own I2C controller, and packets on its serial port. `ci/unit` names the script and
/// the library.
pub const PICO: Machine = Machine {
    name: "rp2040",
    program: "node",
    arguments: &[],
    beside: &["PALPATE_PICO", "PALPATE_RP2040JS"],
    card: &[],
    target: "thumbv6m-none-eabi",
    shift: 3,
    tick_ns: 1000,
    memory: (0x2000_0000, 256 * 1024),
};

/// A test in QEMU for every function named.
macro_rules! in_qemu {
    ($($test:ident)*) => {
        mod virt {
            $(#[test] fn $test() { super::$test(crate::machines::VIRT); })*
        }
    };
}
pub(crate) use in_qemu;

/// An image's file, the newest of either compiler's.
pub fn image(machine: &Machine, program: &str) -> PathBuf {
    let built = std::env::var_os("PALPATE_IMAGES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/images"),
        PathBuf::from,
    );
    let folders = [built.join("web"), built];
    let files = folders.iter().map(|folder| {
        let release = folder.join(machine.target).join("release");
        release.join(program)
    });
    let newest = files.max_by_key(|path| path.metadata().and_then(|m| m.modified()).ok());
    let path = newest.unwrap_or_default();
    assert!(
        path.exists(),
        "{}: expected an image; ci/unit builds it",
        path.display()
    );
    path.canonicalize().unwrap()
}

/// The image of a unit whose datagrams are the rig's.
pub fn lockstep(machine: &Machine) -> PathBuf {
    let program = if machine.is_qemu() {
        "lockstep"
    } else {
        "pico"
    };
    image(machine, program)
}

/// A unit and a host that have met, over a quiet network.
pub fn met(machine: Machine, oe: bool) -> Lockstep {
    // Pins of a processor are there in any case.
    match machine.is_qemu() {
        true => met_on(machine, Chips::new(oe)),
        false => met_on(machine, Chips::new(oe).warm()),
    }
}

/// The same over these chips.
pub fn met_on(machine: Machine, chips: Chips) -> Lockstep {
    let host = Host::new(&KEY, 1, Profile::WIRE).unwrap();
    let image = lockstep(&machine);
    let mut run = Lockstep::start(machine, &image, (chips, host)).unwrap();
    // A port over USB is found first.
    for _ in 0..5 {
        run.run(Duration::from_millis(200)).unwrap();
        if run.host.driver.ready(run.host.now()).is_ok() {
            return run;
        }
    }
    panic!("{}: host and unit have not met", machine.name);
}
