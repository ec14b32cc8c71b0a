//! Emulators served to other programs: frames on a CAN interface, chips behind a node that the kernel made, and the
//! waiting between them. The owner decides on content and time.

pub mod can;
pub mod mcp2221;
pub mod uhid;
pub mod wait;
