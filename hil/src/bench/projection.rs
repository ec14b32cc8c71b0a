//! The whole loop on one 4x4 module: 16 CAN frames in, contacts, and stimuli out when they are due.

use std::convert::Infallible;
use std::error::Error;
use std::hint::black_box;
use std::io;

use embedded_hal::i2c::{ErrorType, I2c, Operation};
use palpate_core::bus::{Actuators, Received, SensorBus};
use palpate_core::contact::{LevelTable, Levels};
use palpate_core::driver::Pca9685Bank;
use palpate_core::guard::Guarded;
use palpate_core::projector::{Observer, Projector};
use palpate_core::schedule::Entry;
use palpate_core::skin::Module;
use palpate_core::units::{Duration, Instant};
use palpate_core::wire::can::CanFrame;
use palpate_core::wire::uskin::{IdProfile, Reading, Wiring, encode};
use palpate_hil::files::Setup;
use palpate_hil::plan;

use crate::frames::{self, ROUND};
use crate::timing::{Samples, row, time};

/// A bus that holds one scan.
struct OneScan {
    frames: Vec<CanFrame>,
    at: Instant,
    taken: usize,
}

impl SensorBus for OneScan {
    type Error = Infallible;

    fn receive(&mut self) -> Result<Option<Received>, Infallible> {
        let frame = self.frames.get(self.taken).copied();
        self.taken += 1;
        Ok(frame.map(|frame| Received {
            at: self.at,
            bus: 0,
            frame,
        }))
    }

    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Actuators that do nothing.
struct Nothing;

impl Actuators for Nothing {
    type Error = Infallible;

    fn apply(&mut self, update: &Guarded) -> Result<(), Infallible> {
        black_box(update);
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// An I2C bus without time and without chips.
struct NullBus;

impl ErrorType for NullBus {
    type Error = Infallible;
}

impl I2c for NullBus {
    fn transaction(
        &mut self,
        _address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Infallible> {
        black_box(operations);
        Ok(())
    }
}

/// Counts what the loop sends, so that its calls can be told apart.
struct Counted<A> {
    inner: A,
    updates: usize,
    channels: usize,
}

impl<A: Actuators> Actuators for Counted<A> {
    type Error = A::Error;

    fn apply(&mut self, update: &Guarded) -> Result<(), A::Error> {
        self.updates += 1;
        self.channels += update.channels().iter().flatten().count();
        self.inner.apply(update)
    }

    fn all_off(&mut self) -> Result<(), A::Error> {
        self.inner.all_off()
    }
}

/// What the guard let through.
#[derive(Default)]
struct Tally {
    stimuli: usize,
    limited: usize,
}

impl Observer for Tally {
    fn entry(&mut self, entry: &Entry) {
        self.stimuli += usize::from(entry.width().get() > 0);
        self.limited += usize::from(entry.reason.is_some());
    }
}

/// Times of one run of the loop, by what was due.
#[derive(Default)]
struct Times {
    quiet: Samples,
    ended: Samples,
    onset: Samples,
    channels: usize,
    tally: Tally,
    onsets: usize,
}

/// Polls at every scan, stimulus end and onset, a scan of 16 frames waiting each time.
fn run<A: Actuators>(
    projector: &mut Projector,
    scans: &[Vec<CanFrame>],
    rest: &[Vec<CanFrame>],
    actuators: A,
    count: usize,
) -> Result<Times, Box<dyn Error>> {
    let mut actuators = Counted {
        inner: actuators,
        updates: 0,
        channels: 0,
    };
    let mut bus = OneScan {
        frames: Vec::with_capacity(16),
        at: Instant::ZERO,
        taken: 0,
    };
    let (mut times, mut now, mut next_scan) = (Times::default(), Instant::ZERO, Instant::ZERO);
    let mut tally = Tally::default();
    for step in 0..count {
        let source = match step.checked_sub(rest.len()) {
            None => &rest[step],
            Some(touched) => &scans[touched % ROUND],
        };
        bus.frames.clone_from(source);
        (bus.at, bus.taken) = (now, 0);
        let before = actuators.updates;
        let (us, polled) = time(|| projector.poll(now, &mut bus, &mut actuators, &mut tally));
        let onset = polled.map_err(|e| format!("the loop failed: {e:?}"))?;
        times.onsets += usize::from(onset);
        // The first tenth warms up.
        if step >= count / 10 {
            match (onset, actuators.updates > before) {
                (true, _) => times.onset.push(us),
                (false, true) => times.ended.push(us),
                (false, false) => times.quiet.push(us),
            }
        }
        if now >= next_scan {
            next_scan = now + Duration::from_micros(10_000);
        }
        now = projector.next().min(next_scan).max(now + TICK);
    }
    let compressed = projector.work().means as usize;
    if compressed != count - rest.len() {
        return Err(format!("{compressed} of {count} scans had a contact").into());
    }
    times.channels = actuators.channels;
    times.tally = tally;
    Ok(times)
}

/// Virtual time never stands still.
const TICK: Duration = Duration::from_micros(1);

/// The default scene's loop with `touched` taxels always in contact.
fn projector() -> Result<Projector, Box<dyn Error>> {
    let setup = Setup::load("sphere-along", "emulated")?;
    let strengths: Vec<f32> = (0..200).map(|i| 300.0 + 10.0 * i as f32).collect();
    let levels = Levels::Table(LevelTable::from_intensities(&strengths, 10)?);
    Ok(Projector::new(plan::plan(&setup, 1, levels)?)?)
}

/// The 16 frames of one scan in the order of the wire.
fn on_the_wire(board: u8, counts: &[[u16; 3]]) -> Option<Vec<CanFrame>> {
    let wiring = Wiring::FLAT;
    let frame = |n| {
        let place = wiring.nth(n)?;
        let [x, y, z] = *counts.get(wiring.taxel(place)?.1)?;
        encode(IdProfile::Current, board, place, Reading { x, y, z })
    };
    (0..wiring.taxels()).map(frame).collect()
}

/// What the measured loop had to do.
pub struct Load {
    /// Wires driven at an onset, mean.
    pub stimuli: f64,
    /// Stimuli that the guard changed or refused.
    pub limited: usize,
}

/// Measures the loop over actuators that do nothing and over the real driver on a bus that does nothing.
///
/// # Errors
/// Fixtures that do not fit together, a closed standard output.
pub fn bench() -> Result<Load, Box<dyn Error>> {
    const STEPS: usize = 60_000;
    let setup = Setup::load("sphere-along", "emulated")?;
    let layout = plan::layout(&setup.sensor.value)?;
    let address = layout.modules().first().and_then(Module::address);
    let board = address
        .ok_or("the default scene's module has no board")?
        .board;
    let wire = |range: std::ops::Range<usize>, touched: usize| {
        range
            .map(|f| on_the_wire(board, &frames::counts(&layout, f, &[touched])))
            .collect::<Option<Vec<_>>>()
            .ok_or("a taxel has no identifier")
    };
    let rest = wire(0..setup.scene.value.reference_frames as usize + 1, 0)?;
    let scans = wire(0..ROUND, 12)?;

    let none = run(&mut projector()?, &scans, &rest, Nothing, STEPS)?;
    let prescale = plan::prescale(&setup.bench.value)?;
    let bank = Pca9685Bank::new(NullBus, &plan::boards(&setup.bench.value), prescale);
    let driver = run(&mut projector()?, &scans, &rest, bank, STEPS)?;
    if none.channels == 0 || none.channels != driver.channels {
        let (a, b) = (none.channels, driver.channels);
        return Err(format!("the loop wrote {a} channels, with a driver {b}").into());
    }
    print(&none, &driver)?;
    Ok(Load {
        stimuli: driver.tally.stimuli as f64 / driver.onsets as f64,
        limited: driver.tally.limited,
    })
}

fn print(none: &Times, driver: &Times) -> io::Result<()> {
    row("loop, 16 frames in, nothing due", &none.quiet, Some(2.0))?;
    row("loop, a stimulus ends", &none.ended, Some(8.0))?;
    row("loop, an onset, no driver", &none.onset, Some(8.0))?;
    row(
        "loop, a stimulus ends, PCA9685 driver",
        &driver.ended,
        Some(8.0),
    )?;
    row("loop, an onset, PCA9685 driver", &driver.onset, Some(8.0))
}
