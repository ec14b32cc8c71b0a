//! The loop allocates nothing: an allocator that counts, and ten seconds of frames through `poll`.

#![allow(unsafe_code)] // a global allocator cannot be had without

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::convert::Infallible;
use std::sync::Arc;

use embedded_can::ErrorKind;
use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::codec::uskin::Reading;
use palpate_core::codec::uskin::{ALL_BOARDS, Command, Wiring, encode};
use palpate_core::contact::{LevelTable, Levels};
use palpate_core::driver::Actuators;
use palpate_core::guard::Guarded;
use palpate_core::projector::{Observer, Projector, TextureReport};
use palpate_core::skin::CanSkin;
use palpate_core::texture::{Activation, Control, Draw, Encoder, Pulses, Stream};
use palpate_core::units::{Duration, Instant, Prescale};
use palpate_files::{FeltBy, Setup};
use palpate_run::plan::plan;
use palpate_tests::seeded::{Seeded, stroke};

mod unit;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is being torn down has no counter any more, and no test either.
        let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[derive(Debug)]
struct Never(Infallible);

impl std::fmt::Display for Never {
    fn fmt(&self, _f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {}
    }
}

impl std::error::Error for Never {}

impl embedded_can::Error for Never {
    fn kind(&self) -> ErrorKind {
        match self.0 {}
    }
}

/// Frames made beforehand, handed out as time comes.
struct Tape {
    frames: Vec<Received>,
    next: usize,
    now: Instant,
}

impl CanBus for Tape {
    type Error = Never;

    fn receive(&mut self) -> Result<Option<Received>, Never> {
        let frame = self
            .frames
            .get(self.next)
            .copied()
            .filter(|f| f.at <= self.now);
        self.next += usize::from(frame.is_some());
        Ok(frame)
    }

    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), Never> {
        Ok(())
    }
}

#[derive(Default)]
struct Count(u64);

impl Actuators for Count {
    type Error = Infallible;

    fn apply(&mut self, _update: &Guarded) -> Result<(), Infallible> {
        self.0 += 1;
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A touch that wanders over the pad after half a second, with lost and foreign frames in between.
fn tape() -> Tape {
    let mut frames = Vec::new();
    for scan in 0..1000u64 {
        let (cx, cy) = (
            libm::sin(scan as f64 * 0.02) * 1.5,
            libm::cos(scan as f64 * 0.013) * 1.5,
        );
        for k in 0..16u64 {
            let place = Wiring::FLAT.nth(k as usize).unwrap();
            let (_, taxel) = Wiring::FLAT.taxel(place).unwrap();
            let (dx, dy) = ((taxel % 4) as f64 - 1.5 - cx, 1.5 - (taxel / 4) as f64 - cy);
            let press = if scan > 60 {
                400.0 * libm::exp(-(dx * dx + dy * dy))
            } else {
                0.0
            };
            let noise = ((scan * 31 + k * 17) % 5) as u16;
            let reading = Reading {
                x: 32_800 + noise,
                y: 32_800 - noise,
                z: 37_400 + press as u16,
            };
            let at = Instant::from_micros(scan * 10_000 + (k + 1) * 116);
            if (scan * 16 + k) % 97 != 0 {
                let frame = encode(4, place, reading).unwrap();
                frames.push(Received { at, bus: 0, frame });
            }
            if scan % 100 == 50 && k == 7 {
                let frame = Command {
                    board: ALL_BOARDS,
                    start: true,
                }
                .encode()
                .unwrap();
                frames.push(Received { at, bus: 0, frame });
            }
        }
    }
    Tape {
        frames,
        next: 0,
        now: Instant::ZERO,
    }
}

#[test]
fn the_loop_allocates_nothing() {
    for (scene, kc) in [
        ("sphere-along", 1),
        ("two-finger-press", 2),
        ("two-finger-press", 4),
    ] {
        let mut setup = Setup::load(scene, "emulated").unwrap();
        setup.scene.value.compression.kc = kc;
        let table = LevelTable::from_intensities(&[10.0, 100.0, 200.0, 300.0, 400.0], 4).unwrap();
        let mut projector = Projector::new(plan(&setup, 1, Levels::Table(table)).unwrap()).unwrap();
        let mut skin = CanSkin::new(projector.layout(), tape());
        let (mut count, mut now, mut left) = (Count::default(), Instant::ZERO, 0);
        let before = ALLOCATIONS.with(Cell::get);
        while now < Instant::from_micros(10_000_000) {
            skin.bus_mut().now = now;
            projector.poll(now, &mut skin, &mut count, &mut ()).unwrap();
            let until = now + projector.timing().duration;
            left += u64::from(projector.guard().budget(0, now, until).is_some());
            left += u64::from(projector.guard().second_uw(0, now).is_some());
            now = projector.next().min(now + Duration::from_millis(3));
        }
        let spent = ALLOCATIONS.with(Cell::get) - before;
        assert!(left > 1000, "{scene}: {left} budgets were read");
        assert!(
            count.0 > 150,
            "{scene}: only {} updates: the loop was idle",
            count.0
        );
        assert_eq!(spent, 0, "{scene}, K_C = {kc}: allocations in the loop");
    }
}

/// A second of touch makes a window: from then on pulses run, or bursts are thinned out.
#[test]
fn the_loop_with_a_texture_allocates_nothing() {
    for carrier in [FeltBy::Display, FeltBy::Contacts] {
        let mut setup = Setup::load("texture-wood", "emulated").unwrap();
        setup.scene.value.texture.as_mut().unwrap().carrier = carrier;
        let mut projector = Projector::new(plan(&setup, 1, Levels::Off).unwrap()).unwrap();
        let mut skin = CanSkin::new(projector.layout(), tape());
        let (mut count, mut now) = (Count::default(), Instant::ZERO);
        let mut seen = Windows(0);
        let before = ALLOCATIONS.with(Cell::get);
        while now < Instant::from_micros(10_000_000) {
            skin.bus_mut().now = now;
            projector
                .poll(now, &mut skin, &mut count, &mut seen)
                .unwrap();
            now = projector.next().min(now + Duration::from_millis(3));
        }
        let spent = ALLOCATIONS.with(Cell::get) - before;
        assert!(seen.0 > 60 && count.0 > 200, "{} {}", seen.0, count.0);
        assert_eq!(spent, 0, "{carrier:?}");
    }
}

/// Counts windows of texture.
struct Windows(u32);

impl Observer for Windows {
    fn texture(&mut self, _: &TextureReport<'_>) {
        self.0 += 1;
    }
}

#[test]
fn textures_allocate_nothing_once_made() {
    let model = Seeded::thesis(1);
    let encoder = Arc::new(model.with(Encoder::new).unwrap());
    let values = stroke(1, 150, 45);
    let (mut room, mut stream) = (encoder.room(), Stream::new(encoder.clone(), 1));
    let second = Duration::from_millis(1000);
    let activation = Activation::new(0.1, 0.8, Duration::ZERO, second).unwrap();
    let mut pulses = Pulses::new(
        activation,
        Draw::Bernoulli,
        Prescale::new(30),
        &[0.0, 1.0],
        1,
    );
    let control = Control {
        delta_mu: second,
        sigma: second,
        rate_mhz: 150_000,
    };
    let before = ALLOCATIONS.with(Cell::get);
    let mut ended = 0;
    for sample in values.chunks_exact(45) {
        ended += usize::from(stream.push(sample, true).unwrap().is_some());
        pulses.next(&control);
    }
    encoder.encode(&mut room, &values[..4500]).unwrap();
    let spent = ALLOCATIONS.with(Cell::get) - before;
    assert_eq!((ended, spent), (51, 0));
}
