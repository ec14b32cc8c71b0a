//! Shipped files, bad files, recordings.

mod bad_csv;
mod bad_scene;
mod bad_toml;
mod recordings;
mod shipped;
mod touches;
