//! Emulators served to other programs: frames on a CAN interface, chips behind a node that the kernel
//! made, and the waiting between them. What is served, and when, is the owner's business.

pub mod can;
pub mod mcp2221;
pub mod uhid;
pub mod wait;
