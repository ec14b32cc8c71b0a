//! The loop behind a page: a session of an emulated bench that a page opens, touches, steps and saves.
//!
//! A request is JSON text and so is its answer ([`Page::answer`]). The module for browsers ([`module`]) hands both over
//! through one buffer; it imports nothing, so the same file works in a page, a worker and node.

pub mod module;
mod open;
mod page;
mod played;
mod request;
mod run;
mod shelves;

pub use page::Page;
