//! Voice coils on the channels of a sound card: every coil gets what the card plays, sample by sample.

use crate::haptic::card::CardHandle;
use crate::haptic::contact::Contact;
use crate::haptic::lra::LraParameters;
use crate::haptic::voice_coil::VoiceCoil;
use crate::person::vibration::Shake;
use crate::time::Nanos;

use super::MotorTotals;

/// Channels of a card, with the amplifiers behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Frames per second.
    pub rate_hz: u32,
    /// Frequency of the sine on them, Hz: that of the coils' motion.
    pub sine_hz: f64,
    /// Voltage behind the amplifier of a sample at full scale, V.
    pub full_scale_v: f64,
    /// Samples in a frame.
    pub width: usize,
    /// Channel of each coil.
    pub of: Vec<u8>,
}

/// Equal voice coils on a sound card.
#[derive(Debug)]
pub struct Coils {
    card: CardHandle,
    channels: Channels,
    coils: Vec<VoiceCoil>,
    /// The frame that plays.
    frame: Vec<i16>,
    /// Frames so far.
    frames: u64,
    /// Frames of silence since each coil had a sample.
    silent: Vec<u32>,
}

impl Coils {
    /// Coils at rest.
    pub fn new(parameters: LraParameters, card: CardHandle, channels: Channels) -> Self {
        let count = channels.of.len();
        Self {
            coils: vec![VoiceCoil::new(parameters, channels.rate_hz); count],
            frame: vec![0; channels.width],
            frames: 0,
            silent: vec![0; count],
            card,
            channels,
        }
    }

    /// Plays every frame before `to`, and tells how the coils move then.
    pub(super) fn play(
        &mut self,
        to: Nanos,
        contact: &Contact,
        shakes: &mut [Shake],
        totals: &mut MotorTotals,
    ) {
        let Self { channels, .. } = self;
        let hz = channels.sine_hz;
        let per_count = channels.full_scale_v / f64::from(i16::MAX);
        let frames = u128::from(to.0) * u128::from(channels.rate_hz) / 1_000_000_000;
        let gain = 1e6 * contact.gain(hz);
        shakes.iter_mut().for_each(|shake| shake.driven = false);
        let mut card = self.card.card();
        while u128::from(self.frames) < frames {
            self.frames += 1;
            card.play(&mut self.frame);
            let each = self.coils.iter_mut().zip(&mut self.silent);
            let each = each.zip(&channels.of).zip(&mut *shakes);
            for (((coil, silent), channel), shake) in each {
                let count = self.frame[usize::from(*channel)];
                if count == 0 {
                    *silent += 1;
                    continue;
                }
                coil.silence(std::mem::take(silent));
                let volts = per_count * f64::from(count);
                coil.sample(volts);
                shake.driven = true;
                totals.drive_v = totals.drive_v.max(volts.abs());
                // At every sample, so that the peak of a beat between sine and resonance counts.
                totals.contactor_um = totals.contactor_um.max(gain * coil.x_m().abs());
            }
        }
        drop(card);
        let each = self.coils.iter_mut().zip(&mut self.silent).zip(shakes);
        for ((coil, silent), shake) in each {
            coil.silence(std::mem::take(silent));
            coil.warm();
            (shake.um, shake.hz) = (gain * coil.amplitude_m(hz), hz);
            totals.coil_rise_k = totals.coil_rise_k.max(coil.coil.rise_k());
        }
    }

    /// A coil by its actuator's number.
    pub fn coil_mut(&mut self, motor: usize) -> Option<&mut VoiceCoil> {
        self.coils.get_mut(motor)
    }

    /// Samples in a frame of the card.
    pub const fn width(&self) -> usize {
        self.channels.width
    }

    /// The card.
    pub const fn card(&self) -> &CardHandle {
        &self.card
    }
}
