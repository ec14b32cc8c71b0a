//! A scene's faults: what goes wrong, where, from when until when. `docs/faults.md` says what each does.

use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident = $text:literal [$($key:literal)*] [$($optional:literal)*]),+ $(,)?) => {
        /// What goes wrong.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        pub enum FaultKind { $($(#[$doc])* #[serde(rename = $text)] $variant),+ }

        impl FaultKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Its name in a scene.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }

            /// The keys it needs, and those it may have.
            const fn keys(self) -> (&'static [&'static str], &'static [&'static str]) {
                match self { $(Self::$variant => (&[$($key),*], &[$($optional),*])),+ }
            }
        }
    };
}

kinds! {
    /// CAN frames are lost at random.
    FramesLost = "frames-lost" ["rate"] [],
    /// CAN frames arrive twice.
    FramesDuplicated = "frames-duplicated" ["rate"] [],
    /// CAN frames arrive late, after newer ones.
    FramesLate = "frames-late" ["rate" "late_ms"] [],
    /// CAN frames arrive with a bit turned over.
    FramesCorrupted = "frames-corrupted" ["rate"] [],
    /// CAN frames arrive cut short.
    FramesShort = "frames-short" ["rate"] [],
    /// Frames are destroyed on the wire by error frames.
    ErrorFrames = "error-frames" ["bus" "count"] [],
    /// A taxel repeats its value.
    TaxelFrozen = "taxel-frozen" ["module" "taxel"] [],
    /// A taxel sends zeros.
    ZeroTriplets = "zero-triplets" ["module" "taxel"] [],
    /// Nothing comes from one SDA line of a board.
    SdaDead = "sda-dead" ["module" "line"] [],
    /// A board believes it carries another model: the lower half of its rows reads zero.
    WrongModel = "wrong-model" ["module"] [],
    /// A board sends under another one's number.
    SameAddress = "same-address" ["module" "with"] [],
    /// A board loses power for 0.1 s, or until `until_s`.
    BoardReboot = "board-reboot" ["module"] [],
    /// A board has no power before `at_s`.
    LateStart = "late-start" ["module"] [],
    /// A board's controller, or the host's on a bus, goes bus-off.
    BusOff = "bus-off" [] ["module" "bus"],
    /// A board's clock runs fast or slow.
    ClockDrift = "clock-drift" ["module" "ppm"] [],
    /// A chip does not acknowledge its address.
    I2cAddressNack = "i2c-address-nack" [] ["rate" "bus"],
    /// A data byte is not acknowledged: half an update arrives.
    I2cDataNack = "i2c-data-nack" [] ["rate" "bus"],
    /// Another controller wins the bus.
    I2cArbitrationLoss = "i2c-arbitration-loss" [] ["rate" "bus"],
    /// The adapter fails after the transfer.
    I2cEio = "i2c-eio" [] ["rate" "bus"],
    /// The clock is held low for `stretch_ms`.
    I2cStretch = "i2c-stretch" ["stretch_ms"] ["rate" "bus"],
    /// A line is stuck low.
    I2cStuck = "i2c-stuck" [] ["bus"],
    /// A PCA9685 falls back to its reset values.
    BrownOut = "brown-out" ["board"] [],
    /// A PCA9685's oscillator runs at `factor` times its nominal frequency.
    Oscillator = "oscillator" ["board" "factor"] [],
    /// The clock on a PCA9685's EXTCLK pin stops.
    ClockStopped = "clock-stopped" ["board"] [],
    /// A wire's amplifier conducts whatever its input says: a shorted transistor.
    AmplifierStuckOn = "amplifier-stuck-on" ["wire"] [],
    /// A wire or its plug is broken.
    OpenWire = "open-wire" ["wire"] [],
    /// A converter has no supply.
    ConverterDead = "converter-dead" ["board"] [],
    /// A converter loses its supply for a moment and falls back to zero.
    ConverterBrownOut = "converter-brown-out" ["board"] [],
    /// A converter's output keeps its current, whatever is written and acknowledged.
    ConverterStuck = "converter-stuck" ["wire"] [],
    /// The highest bit of a converter's output turns over.
    ConverterFlipped = "converter-flipped" ["wire"] [],
    /// The network to a driver unit is gone, both ways.
    LinkOutage = "link-outage" [] [],
    /// The network to a driver unit is that of a worse radio.
    LinkRough = "link-rough" [] [],
    /// A lead of the thermistor in a Peltier module's face is broken.
    FaceSensorOpen = "face-sensor-open" [] [],
    /// The leads of that thermistor touch.
    FaceSensorShort = "face-sensor-short" [] [],
    /// The converter of a Peltier module's thermistors stands still.
    FaceSensorStale = "face-sensor-stale" [] [],
    /// A transistor of a Peltier module's bridge is shorted: it heats with all that its supply gives.
    BridgeShorted = "bridge-shorted" [] [],
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// When it begins, seconds.
    pub at_s: f64,
    /// When it ends; left out: with the run, or at once for what happens once.
    pub until_s: Option<f64>,
    /// What goes wrong.
    pub kind: FaultKind,
    /// Probability a frame or transfer; left out where it may be: the next transfer, once.
    pub rate: Option<f64>,
    /// How late frames are, milliseconds.
    pub late_ms: Option<f64>,
    /// How often.
    pub count: Option<u32>,
    /// A sensor module, counted from zero: its board.
    pub module: Option<usize>,
    /// A taxel of that module.
    pub taxel: Option<usize>,
    /// An SDA line (row) of that module.
    pub line: Option<u8>,
    /// The module whose board's number is taken.
    pub with: Option<usize>,
    /// A sensor bus; of an I2C fault the boards' bus, all of them if left out.
    pub bus: Option<u8>,
    /// A PCA9685, counted from zero in the order of buses and addresses.
    pub board: Option<usize>,
    /// A wire, counted from zero: of several displays first those of the first one.
    pub wire: Option<usize>,
    /// Parts per million, positive is fast.
    pub ppm: Option<f64>,
    /// Of the nominal frequency.
    pub factor: Option<f64>,
    /// How long the clock is held, milliseconds.
    pub stretch_ms: Option<f64>,
}

impl FaultKind {
    /// Whether it happens to a Peltier module.
    #[must_use]
    pub fn is_of_heat(self) -> bool {
        self >= Self::FaceSensorOpen
    }

    /// Whether it happens to a converter of a bench's `[dac]`.
    #[must_use]
    pub fn is_of_converters(self) -> bool {
        (Self::ConverterDead..=Self::ConverterFlipped).contains(&self)
    }

    /// Whether it happens to sensor boards or their buses.
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
    /// The keys that are there, with their values.
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
