//! The machines, their images, and what most tests begin with.

use std::path::{Path, PathBuf};

use palpate_core::units::Duration;
use palpate_emulators::network::Profile;
use palpate_qemu::{Chips, Host, Lockstep, Machine};

/// The key that `ci/unit` builds the images with.
pub const KEY: [u8; 32] = [9; 32];

/// The Stellaris board with the memory of a Feather M0.
pub const LM3S6965EVB: Machine = Machine {
    name: "lm3s6965evb",
    program: "qemu-system-arm",
    arguments: &["-M", "lm3s6965evb"],
    target: "thumbv6m-none-eabi",
    shift: 5,
    tick_ns: 20,
    memory: (0x2000_0000, 32 * 1024),
};

/// An image's file.
pub fn image(machine: &Machine, program: &str) -> PathBuf {
    let built = std::env::var_os("PALPATE_IMAGES").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/images"),
        PathBuf::from,
    );
    let path = built.join(machine.target).join("release").join(program);
    assert!(
        path.exists(),
        "{}: expected an image; ci/unit builds it",
        path.display()
    );
    path.canonicalize().unwrap()
}

/// A unit and a host that have met, over a quiet network.
pub fn met(machine: Machine, oe: bool) -> Lockstep {
    let host = Host::new(&KEY, 1, Profile::WIRE).unwrap();
    let image = image(&machine, "lockstep");
    let mut run = Lockstep::start(machine, &image, (Chips::new(oe), host)).unwrap();
    run.run(Duration::from_millis(200)).unwrap();
    assert_eq!(run.host.driver.ready(run.host.now()), Ok(()));
    run
}
