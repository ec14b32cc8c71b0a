//! Strokes made into recordings: one module whose readings go on from stroke to stroke, as on a desk.

use palpate_core::codec::uskin::Reading;
use palpate_core::random::RandomStream;

use super::vibration::{ACCELEROMETER_HZ, told};
use super::{Habits, SurfaceStroke, SurfaceTexture};
use crate::sensor::{EmulatedModule, ModuleConfig};
use crate::time::Nanos;

/// Samples of a recording: 2 s at 100 Hz, as in the thesis.
pub const SAMPLES: usize = 200;
/// Length of a recording.
const LENGTH: Nanos = Nanos(2 * NANOS_PER_SECOND);
const NANOS_PER_SECOND: u64 = 1_000_000_000;
/// The module hangs in the air between two strokes for as long, so that nothing of the last is left.
const PAUSE: Nanos = Nanos(500_000_000);

/// One stroke's readings: a row for each sample, a reading for each taxel, in the order of the layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    /// Number of the stroke over its texture.
    pub number: u32,
    /// The readings.
    pub rows: Vec<Vec<Reading>>,
    /// Readings of an accelerometer on the finger, counts along the module's axes, [`ACCELEROMETER_HZ`] of them per
    /// second; empty where there is none.
    pub acceleration: Vec<[i16; 3]>,
}

/// A person with a flat module in hand.
pub struct Explorer {
    module: EmulatedModule,
    habits: Habits,
    dead: Option<usize>,
    seed: u64,
    period: Nanos,
    is_shaken: bool,
    now: Nanos,
}

impl Explorer {
    /// An explorer whose module has one `dead` taxel, which answers its rest value whatever happens, or none.
    pub fn new(habits: Habits, dead: Option<usize>, seed: u64) -> Self {
        let config = ModuleConfig {
            seed,
            ..ModuleConfig::default()
        };
        Self {
            module: EmulatedModule::new(config),
            habits,
            dead,
            seed,
            period: Nanos(LENGTH.0 / SAMPLES as u64),
            is_shaken: false,
            now: Nanos::ZERO,
        }
    }

    /// Returns the explorer with the taxels read at another rate, 1 to 1000 Hz, as no CAN board of the module does. It
    /// shows what the silicone lets through and 100 Hz do not.
    #[must_use]
    pub fn with_rate(self, hz: u32) -> Self {
        let period = Nanos(1_000_000_000 / u64::from(hz.clamp(1, 1000)));
        Self { period, ..self }
    }

    /// Returns the explorer with an accelerometer beside the taxels.
    #[must_use]
    pub fn with_accelerometer(self) -> Self {
        Self {
            is_shaken: true,
            ..self
        }
    }

    /// Strokes once over `texture`, from just before the impact, for 2 s.
    pub fn stroke(&mut self, texture: &SurfaceTexture, number: u32) -> Recording {
        let span = (self.now, LENGTH.as_secs_f64());
        let lag = self.module.config().mechanics.lag_s;
        let stroke = SurfaceStroke::new(texture, &self.habits, (self.seed, number), span, lag);
        let acceleration = match self.is_shaken {
            true => self.acceleration(&stroke, &format!("{number} over {}", texture.name)),
            false => Vec::new(),
        };
        self.module.touch(Box::new(stroke));
        let samples = LENGTH.0 / self.period.0;
        let mut rows = Vec::with_capacity(samples as usize);
        for _ in 0..samples {
            let mut row = Vec::new();
            self.module.sample(self.now, &mut row);
            self.silence(&mut row);
            rows.push(row);
            self.now = self.now + self.period;
        }
        self.now = self.now + PAUSE;
        Recording {
            number,
            rows,
            acceleration,
        }
    }

    fn acceleration(&self, stroke: &SurfaceStroke, which: &str) -> Vec<[i16; 3]> {
        let mut noise = RandomStream::new(self.seed, &format!("accelerometer in stroke {which}"));
        let hz = u64::from(ACCELEROMETER_HZ);
        (0..LENGTH.0 * hz / NANOS_PER_SECOND)
            .map(|n| self.now + Nanos(n * NANOS_PER_SECOND / hz))
            .map(|at| told(stroke.acceleration(at), &mut noise))
            .collect()
    }

    fn silence(&self, row: &mut [Reading]) {
        let Some(dead) = self.dead else { return };
        if let (Some(reading), Some(rest)) = (row.get_mut(dead), self.module.rest(dead)) {
            let [x, y, z] = rest.map(|counts| counts as u16);
            *reading = Reading { x, y, z };
        }
    }
}
