//! Shipped files, bad files, and values in place of a file's own.

mod bad_scene;
mod bad_toml;
mod converters;
mod displays;
mod evidence;
mod mutations;
mod overrides;
mod people;
mod shipped;
mod touches;
mod transducers;
