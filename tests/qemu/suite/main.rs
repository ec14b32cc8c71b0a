//! The driver unit's images in QEMU. `ci/unit` builds them and runs this; `PALPATE_IMAGES` is the folder of what it built,
//! `target/images` by default.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod decisions;
mod face;
/// What holds for the model and the process as well.
#[path = "../../../hil/tests/unit/suite.rs"]
mod held;
mod machines;
mod ratchets;
mod sessions;
mod subject;
mod udp;
#[path = "../../../hil/tests/unit/warmth.rs"]
mod warmth;
