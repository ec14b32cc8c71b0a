//! Shipped files and bad files.

mod bad_scene;
mod bad_toml;
mod shipped;
mod touches;
