//! What the skin's rest takes of memory: bytes for each taxel, and nothing more once it is made.

#![allow(unsafe_code)] // a global allocator cannot be had without
#![allow(clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, System};
use std::cell::Cell;

use palpate_core::random::RandomStream;
use palpate_core::skin::{
    Baseline, BaselinePhase, BaselineSettings, Layout, Module, Scan, ThresholdRule,
};
use palpate_core::units::{Duration, Instant};

thread_local! {
    static BYTES: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: std::alloc::Layout) -> *mut u8 {
        let _ = BYTES.try_with(|n| n.set(n.get() + layout.size()));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: std::alloc::Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn allocated(what: impl FnOnce()) -> usize {
    let before = BYTES.get();
    what();
    BYTES.get() - before
}

fn baseline(layout: &Layout) -> Baseline {
    let settings = BaselineSettings {
        threshold: ThresholdRule::PerTaxel {
            sigmas: 6.0,
            floor: 20.0,
        },
        drift: Some(Duration::from_millis(5000)),
        ..Default::default()
    };
    Baseline::new(layout, settings).unwrap()
}

fn pad(rows: u16) -> Layout {
    Layout::single(Module::grid("pad", rows, 20, 4.7).unwrap()).unwrap()
}

#[test]
fn a_taxel_has_the_bytes_that_the_documentation_states() {
    let (few, many) = (pad(10), pad(20));
    let of = |layout: &Layout| allocated(|| drop(baseline(layout)));
    let each = (of(&many) - of(&few)) / (many.taxels() - few.taxels());
    let text = include_str!("../../docs/compression.md");
    let stated = format!("Each taxel has {each} bytes of state for this");
    assert!(text.contains(&stated), "expected `{stated}`");
}

#[test]
fn frames_allocate_nothing_once_it_is_made() {
    let layout = pad(2);
    let mut init = baseline(&layout);
    let mut frame = init.frame(&layout);
    let (mut scan, mut noise) = (Scan::new(&layout), RandomStream::new(1, "noise"));
    let mut counts = vec![[0; 3]; layout.taxels()];
    let mut touched = 0;
    let bytes = allocated(|| {
        for k in 0..6000u64 {
            // The first reference finds the skin touched.
            let is_touched = (k / 300) % 2 == 1 || (3..8).contains(&k);
            for (i, row) in counts.iter_mut().enumerate() {
                let press = if is_touched && (5..9).contains(&i) {
                    900
                } else {
                    0
                };
                let drift = (k / 10) as u16;
                *row = [33_000, 33_000, 37_000 + drift + press]
                    .map(|c| c + (noise.uniform() * 4.0) as u16);
            }
            scan.load(Instant::from_micros(k * 10_000), &counts)
                .unwrap();
            match k {
                2000 => init.rezero(),
                4000 => init.doubt(0),
                _ => {}
            }
            if init.phase() != BaselinePhase::Ready {
                init.feed(&scan);
                continue;
            }
            init.mask(&mut frame);
            init.advance(&scan, &mut frame).unwrap();
            touched += frame.contacts().len();
        }
    });
    assert!(touched > 1000, "{touched}");
    assert_eq!(bytes, 0);
}
