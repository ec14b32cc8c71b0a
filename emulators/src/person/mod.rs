//! The person: what is felt of the wires' motion, and how textures are rated.

pub mod channels;
pub mod panel;
