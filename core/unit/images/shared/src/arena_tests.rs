//! Tests of `arena.rs`.

#![allow(unsafe_code, reason = "an allocator's methods are unsafe")]

use super::*;

#[test]
fn pieces_are_apart_and_aligned_until_the_heap_is_full_or_closed() {
    let heap = Arena::<64>::new();
    let take = |size, align| unsafe { heap.alloc(Layout::from_size_align(size, align).unwrap()) };
    let first = take(3, 1) as usize;
    let second = take(8, 8) as usize;
    assert!(second >= first + 3 && second.is_multiple_of(8));
    assert!(take(64, 1).is_null());
    assert!(take(usize::MAX / 2, 1).is_null());
    assert!(!take(1, 1).is_null());
    heap.close();
    assert!(take(1, 1).is_null());
}
