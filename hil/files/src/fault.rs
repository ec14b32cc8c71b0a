//! Faults of a scene: their kinds, places and times. `docs/faults.md` describes the effect of each.

use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident = $text:literal [$($key:literal)*] [$($optional:literal)*]),+ $(,)?) => {
        /// Kinds of faults.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        pub enum FaultKind { $($(#[$doc])* #[serde(rename = $text)] $variant),+ }

        impl FaultKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The kind's name in a scene.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }

            /// Keys that the kind needs, and keys that it may have.
            const fn keys(self) -> (&'static [&'static str], &'static [&'static str]) {
                match self { $(Self::$variant => (&[$($key),*], &[$($optional),*])),+ }
            }
        }
    };
}

kinds! {
    /// Random loss of CAN frames.
    FramesLost = "frames-lost" ["rate"] [],
    /// CAN frames that arrive twice.
    FramesDuplicated = "frames-duplicated" ["rate"] [],
    /// CAN frames that arrive late, after newer ones.
    FramesLate = "frames-late" ["rate" "late_ms"] [],
    /// CAN frames that arrive with a bit turned over.
    FramesCorrupted = "frames-corrupted" ["rate"] [],
    /// CAN frames that arrive cut short.
    FramesShort = "frames-short" ["rate"] [],
    /// Frames that error frames destroy on the wire.
    ErrorFrames = "error-frames" ["bus" "count"] [],
    /// A taxel that repeats its value.
    TaxelFrozen = "taxel-frozen" ["module" "taxel"] [],
    /// A taxel that sends zeros.
    ZeroTriplets = "zero-triplets" ["module" "taxel"] [],
    /// Silence of one SDA line of a board.
    SdaDead = "sda-dead" ["module" "line"] [],
    /// A board that believes it carries another model: the lower half of its rows reads zero.
    WrongModel = "wrong-model" ["module"] [],
    /// A board that sends under another one's number.
    SameAddress = "same-address" ["module" "with"] [],
    /// A board that loses power for 0.1 s, or until `until_s`.
    BoardReboot = "board-reboot" ["module"] [],
    /// A board without power before `at_s`.
    LateStart = "late-start" ["module"] [],
    /// A board's controller, or the host's on a bus, that goes bus-off.
    BusOff = "bus-off" [] ["module" "bus"],
    /// A board's clock that runs fast or slow.
    ClockDrift = "clock-drift" ["module" "ppm"] [],
    /// A chip that does not acknowledge its address.
    I2cAddressNack = "i2c-address-nack" [] ["rate" "bus"],
    /// A data byte that is not acknowledged: half an update arrives.
    I2cDataNack = "i2c-data-nack" [] ["rate" "bus"],
    /// A bus that another controller wins.
    I2cArbitrationLoss = "i2c-arbitration-loss" [] ["rate" "bus"],
    /// An adapter that fails after the transfer.
    I2cEio = "i2c-eio" [] ["rate" "bus"],
    /// A clock that is held low for `stretch_ms`.
    I2cStretch = "i2c-stretch" ["stretch_ms"] ["rate" "bus"],
    /// A line that is stuck low.
    I2cStuck = "i2c-stuck" [] ["bus"],
    /// A PCA9685 that falls back to its reset values.
    BrownOut = "brown-out" ["board"] [],
    /// A PCA9685's oscillator that runs at `factor` times its nominal frequency.
    Oscillator = "oscillator" ["board" "factor"] [],
    /// A clock on a PCA9685's EXTCLK pin that stops.
    ClockStopped = "clock-stopped" ["board"] [],
    /// A wire's amplifier that conducts whatever its input: a shorted transistor.
    AmplifierStuckOn = "amplifier-stuck-on" ["wire"] [],
    /// A broken wire or plug.
    OpenWire = "open-wire" ["wire"] [],
    /// A converter without a supply.
    ConverterDead = "converter-dead" ["board"] [],
    /// A converter that loses its supply for a moment and falls back to zero.
    ConverterBrownOut = "converter-brown-out" ["board"] [],
    /// A converter's output that keeps its current, whatever is written and acknowledged.
    ConverterStuck = "converter-stuck" ["wire"] [],
    /// A converter's output whose highest bit turns over.
    ConverterFlipped = "converter-flipped" ["wire"] [],
    /// A network to a driver unit that is gone, both ways.
    LinkOutage = "link-outage" [] [],
    /// A network to a driver unit with a worse radio.
    LinkRough = "link-rough" [] [],
    /// A broken lead of the thermistor in a Peltier module's face.
    FaceSensorOpen = "face-sensor-open" [] [],
    /// Leads of that thermistor that touch.
    FaceSensorShort = "face-sensor-short" [] [],
    /// A converter of a Peltier module's thermistors that stands still.
    FaceSensorStale = "face-sensor-stale" [] [],
    /// A shorted transistor of a Peltier module's bridge: it heats with all that its supply gives.
    BridgeShorted = "bridge-shorted" [] [],
    /// A broken coil or lead of a motor.
    MotorOpen = "motor-open" ["motor"] [],
    /// A motor whose mass is jammed.
    MotorStuck = "motor-stuck" ["motor"] [],
    /// A motor's driver that is too hot, and drives nothing.
    DriverHot = "driver-hot" ["motor"] [],
    /// The I2C switch before a motor's driver, whose channels stay as they are.
    SwitchStuck = "switch-stuck" ["motor"] [],
    /// A motor's coil that is covered, and loses heat ten times worse.
    CoilHot = "coil-hot" ["motor"] [],
    /// A sound card that runs out of samples.
    AudioUnderrun = "audio-underrun" [] [],
    /// A sound card that plays nothing and takes no samples.
    AudioStalled = "audio-stalled" [] [],
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Start, seconds.
    pub at_s: f64,
    /// End, seconds; left out: the end of the run, or at once for a fault that happens once.
    pub until_s: Option<f64>,
    /// The kind of fault.
    pub kind: FaultKind,
    /// Probability per frame or transfer; left out where that is allowed: the next transfer, once.
    pub rate: Option<f64>,
    /// Delay of frames, milliseconds.
    pub late_ms: Option<f64>,
    /// Number of times.
    pub count: Option<u32>,
    /// A sensor module, counted from zero: its board.
    pub module: Option<usize>,
    /// A taxel of that module.
    pub taxel: Option<usize>,
    /// An SDA line (row) of that module.
    pub line: Option<u8>,
    /// The module whose board's number is taken.
    pub with: Option<usize>,
    /// A sensor bus; for an I2C fault the boards' bus, all of them if left out.
    pub bus: Option<u8>,
    /// A PCA9685, counted from zero in the order of buses and addresses.
    pub board: Option<usize>,
    /// A wire, counted from zero over all displays, the first display's wires first.
    pub wire: Option<usize>,
    /// A motor, counted from zero in the display's order.
    pub motor: Option<usize>,
    /// Deviation of the clock, parts per million; positive is fast.
    pub ppm: Option<f64>,
    /// Share of the nominal frequency.
    pub factor: Option<f64>,
    /// Time for which the clock is held, milliseconds.
    pub stretch_ms: Option<f64>,
}

impl FaultKind {
    /// Returns true if it happens to a Peltier module.
    #[must_use]
    pub fn is_of_heat(self) -> bool {
        (Self::FaceSensorOpen..=Self::BridgeShorted).contains(&self)
    }

    /// Returns true if it happens to a motor of a bench's `[haptics]`, or to its driver.
    #[must_use]
    pub fn is_of_motors(self) -> bool {
        self >= Self::MotorOpen
    }

    /// Returns true if it happens to a sound card.
    #[must_use]
    pub fn is_of_audio(self) -> bool {
        self >= Self::AudioUnderrun
    }

    /// Returns true if it happens to an I2C bus, whatever is on it.
    #[must_use]
    pub fn is_of_i2c(self) -> bool {
        (Self::I2cAddressNack..=Self::I2cStuck).contains(&self)
    }

    /// Returns true if it happens to a converter of a bench's `[dac]`.
    #[must_use]
    pub fn is_of_converters(self) -> bool {
        (Self::ConverterDead..=Self::ConverterFlipped).contains(&self)
    }

    /// Returns true if it happens to sensor boards or their buses.
    #[must_use]
    pub fn is_of_sensors(self) -> bool {
        self < Self::I2cAddressNack
    }

    /// Tells whether the fault is one of the display's side: boards, their bus, amplifiers, wires.
    #[must_use]
    pub fn is_of_display(self) -> bool {
        !self.is_of_sensors()
    }
}

impl Fault {
    /// Keys that the fault states, with their values.
    fn given(&self) -> Vec<(&'static str, f64)> {
        let whole = |n: Option<usize>| n.map(|n| n as f64);
        [
            ("rate", self.rate),
            ("late_ms", self.late_ms),
            ("count", self.count.map(f64::from)),
            ("module", whole(self.module)),
            ("taxel", whole(self.taxel)),
            ("line", self.line.map(f64::from)),
            ("with", whole(self.with)),
            ("bus", self.bus.map(f64::from)),
            ("board", whole(self.board)),
            ("wire", whole(self.wire)),
            ("motor", whole(self.motor)),
            ("ppm", self.ppm),
            ("factor", self.factor),
            ("stretch_ms", self.stretch_ms),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key, value?)))
        .collect()
    }

    /// The fault in words: its kind and its keys.
    #[must_use]
    pub fn words(&self) -> String {
        let keys = self.given().into_iter();
        let keys: String = keys.map(|(key, v)| format!(" {key} {v}")).collect();
        format!("{}{keys}", self.kind.name())
    }

    /// Checks the fault that stands under `key`.
    pub(super) fn check(&self, source: &Source, key: &str, length_s: f64) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        bounds!(source, key, self;
            at_s: 0.0..=length_s, "s";
            until_s: self.at_s..=length_s, "s")?;
        let (needed, optional) = self.kind.keys();
        let given = self.given();
        let name = self.kind.name();
        for wanted in needed {
            if !given.iter().any(|(k, _)| k == wanted) {
                return Err(source.bad(&at(wanted), format!("a value, for `{name}`")));
            }
        }
        for (k, value) in &given {
            if !needed.contains(k) && !optional.contains(k) {
                return Err(source.bad(&at(k), format!("no such key for `{name}`")));
            }
            let (low, high) = match *k {
                "rate" => (0.0, 1.0),
                "late_ms" | "stretch_ms" => (0.001, 10_000.0),
                "count" => (1.0, 100_000.0),
                "ppm" => (-500_000.0, 500_000.0),
                "factor" => (0.5, 2.0),
                _ => continue,
            };
            source.range(&at(k), value, low..=high, "")?;
        }
        if self.kind == FaultKind::BusOff && self.module.is_some() == self.bus.is_some() {
            return Err(source.bad(&at("module"), "either module (its board) or bus (the host)"));
        }
        Ok(())
    }
}
