//! Device nodes served to other programs: the emulators behind a bus that the kernel registered.
