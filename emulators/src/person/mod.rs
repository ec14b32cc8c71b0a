//! The person, who feels a part of what moves on a finger and rates textures.

pub mod channels;
pub mod panel;
pub mod vibration;
