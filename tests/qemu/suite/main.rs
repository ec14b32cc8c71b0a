//! The driver unit's images in QEMU. `ci/unit` builds them and runs this; `PALPATE_IMAGES` is the folder of what it built,
//! `target/images` by default.

mod decisions;
mod machines;
mod ratchets;
mod sessions;
mod udp;
