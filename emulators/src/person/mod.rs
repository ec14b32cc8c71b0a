//! The person, who feels a part of the wires' motion and rates textures.

pub mod channels;
pub mod panel;
