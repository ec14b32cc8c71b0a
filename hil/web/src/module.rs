//! Exports of the WebAssembly module: one buffer for texts, and a call.
//!
//! No pointer is followed here: the page writes into the buffer's memory and reads from it, between calls.
#![allow(unsafe_code)] // an exported name counts as unsafe, since two of a name would clash

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::page::Page;

/// The page, and the text that goes in or comes out.
static HELD: Mutex<Option<(Page, Vec<u8>)>> = Mutex::new(None);

fn held() -> MutexGuard<'static, Option<(Page, Vec<u8>)>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes room for a text of `length` bytes, and returns where it goes. Memory may have grown: look at it anew.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_room(length: usize) -> *mut u8 {
    let mut held = held();
    let (_, text) = held.get_or_insert_default();
    text.clear();
    text.resize(length, 0);
    text.as_mut_ptr()
}

/// Answers the request in the buffer, and returns the answer's length. [`palpate_text`] gives its address.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_call() -> usize {
    let mut held = held();
    let (page, text) = held.get_or_insert_default();
    let answer = page.answer(&String::from_utf8_lossy(text));
    *text = answer.into_bytes();
    text.len()
}

/// Takes the bytes in the buffer as the texture model that is not built in.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_model() {
    let mut held = held();
    let (_, text) = held.get_or_insert_default();
    palpate_fixtures::fetched(std::mem::take(text));
}

/// Address of the newest answer.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_text() -> *const u8 {
    let mut held = held();
    let (_, text) = held.get_or_insert_default();
    text.as_ptr()
}
