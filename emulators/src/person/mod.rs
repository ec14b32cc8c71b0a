//! The person: how each wire touches, what is felt of the wires' motion, and how textures are rated.

pub mod channels;
pub mod contact;
pub mod panel;
