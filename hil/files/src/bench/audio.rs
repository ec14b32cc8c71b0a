//! A bench's `[haptics.audio]`: the sound card whose channels drive voice coils.

use crate::error::FileError;
use crate::settings::{bounds, settings};
use crate::source::Source;

settings! {
    /// A sound card of 16 bits with an amplifier behind each channel.
    pub struct BenchAudio {
        /// Frames per second.
        pub rate_hz: u32 = 48_000,
        /// Frequency of the sine on every channel, Hz.
        pub sine_hz: f64 = 250.0,
        /// Peak voltage behind the amplifier of a sample at full scale: measure it, and leave its volume alone.
        pub full_scale_v: f64 = 2.0,
        /// Time in which a channel goes from nothing to its highest level, ms.
        pub ramp_ms: f64 = 4.0,
        /// Time between a frame and its sound: what the card has in its buffers, ms.
        pub buffer_ms: f64 = 10.0,
        /// Channel of the card for each coil, counted from 0, in the display's order; left out: one after the other.
        pub channels: Vec<u8>,
    }

    /// A USB card of 7.1 channels: voltage and buffer are assumed.
    default
}

/// Most channels of a card.
const WIDEST: u8 = 32;

impl BenchAudio {
    /// Checks the card of this many coils, whose highest level is `full_v`, V RMS.
    pub(super) fn check(
        &mut self,
        source: &Source,
        coils: usize,
        full_v: f64,
    ) -> Result<(), FileError> {
        let table = "haptics.audio";
        bounds!(source, table, self;
            rate_hz: 8000..=192_000, "Hz";
            sine_hz: 20.0..=1000.0, "Hz";
            full_scale_v: 0.01..=50.0, "V";
            ramp_ms: 0.5..=50.0, "ms";
            buffer_ms: 2.0..=100.0, "ms")?;
        let peak = full_v * std::f64::consts::SQRT_2;
        if peak > self.full_scale_v {
            let key = format!("{table}.full_scale_v");
            let expected =
                format!("at least {peak:.3} V, the peak of haptics.full_v: samples go no higher");
            return Err(source.bad(&key, expected));
        }
        if self.channels.is_empty() {
            self.channels = (0..WIDEST).take(coils).collect();
        }
        for (coil, channel) in self.channels.iter().enumerate() {
            let key = format!("{table}.channels[{coil}]");
            source.range(&key, channel, 0..=WIDEST - 1, "")?;
            let before = self.channels[..coil].iter();
            if let Some(other) = before.clone().position(|other| other == channel) {
                let expected = format!("a channel of its own: coil {other} has this channel");
                return Err(source.bad(&key, expected));
            }
        }
        if self.channels.len() == coils {
            return Ok(());
        }
        let found = self.channels.len().to_string();
        let expected = format!("{coils} channels, one for each place of the display");
        Err(source.bad_found(&format!("{table}.channels"), expected, found))
    }
}
