//! Motors of a bench in the terms of guard, driver and emulator.

use palpate_core::driver::{
    Audio, AudioPlan, AudioPlanError, HapticCalibration, HapticChannel, HapticMotor,
};
use palpate_core::guard::MotorLimits;
use palpate_core::units::Duration;
use palpate_emulators::haptic::card::{Card, CardHandle};
use palpate_emulators::haptic::contact::Contact;
use palpate_emulators::haptic::erm::{Erm, ErmParameters};
use palpate_emulators::haptic::lra::{Lra, LraParameters};
use palpate_emulators::haptic::voice_coil::steady_m;
use palpate_emulators::haptic::{Coil, Motor};
use palpate_emulators::motors::{Channels, Coils, MotorPlace, WornMotors};
use palpate_emulators::person::channels::Person;
use palpate_files::{BenchHaptics, HapticDriver, MotorKind, Setup};

use super::person::with_area;

/// Peak of a sine of 1 V RMS, V.
const PEAK: f64 = core::f64::consts::SQRT_2;

/// A motor at rest.
pub fn motor(haptics: &BenchHaptics) -> Motor {
    match haptics.kind {
        // A voice coil is a resonator too.
        MotorKind::Lra | MotorKind::VoiceCoil => Motor::Lra(Lra::new(lra(haptics))),
        MotorKind::Erm => Motor::Erm(Erm::new(ErmParameters {
            ohm: haptics.ohm,
            ..ErmParameters::COIN_10MM
        })),
    }
}

const fn lra(haptics: &BenchHaptics) -> LraParameters {
    LraParameters {
        resonance_hz: haptics.resonance_hz,
        mass_kg: haptics.moving_g * 1e-3,
        quality: haptics.quality,
        force_n_a: haptics.force_n_a,
        ohm: haptics.ohm,
    }
}

/// The motors' faces on skin.
pub const fn contact(haptics: &BenchHaptics) -> Contact {
    Contact {
        case_kg: haptics.case_g * 1e-3,
        moving_kg: haptics.moving_g * 1e-3,
        face_m: haptics.face_mm * 1e-3,
        skin_n_m: haptics.skin_n_m,
        skin_ns_m: haptics.skin_ns_m,
    }
}

/// Limits of the motors, and what the guard predicts them by.
pub fn limits(haptics: &BenchHaptics) -> MotorLimits {
    let coil = Coil::new(haptics.ohm);
    let steady = |metres: f64, hz: f64| 1e6 * metres * contact(haptics).gain(hz);
    let audio = haptics.audio.clone().unwrap_or_default();
    let mut overdrive_s = haptics.overdrive_ms * 1e-3;
    let (per_volt, overdrive_v) = match haptics.kind {
        MotorKind::Lra => {
            let lra = lra(haptics);
            let um = steady(lra.steady_m(PEAK), lra.resonance_hz);
            (um, haptics.overdrive_v / PEAK)
        }
        MotorKind::VoiceCoil => {
            let hz = audio.sine_hz;
            // A card knows no overdrive, but its ramps lie outside of what is booked.
            overdrive_s = audio.ramp_ms * 1e-3;
            let beat = 1.0 + (hz / haptics.resonance_hz).max(1.0);
            let um = steady(steady_m(&lra(haptics), PEAK, hz), hz);
            (beat * um, haptics.full_v)
        }
        // Its amplitude is the same at every speed.
        MotorKind::Erm => {
            let um = 1e6 * ErmParameters::COIN_10MM.unbalance_m;
            (um / haptics.rated_v, haptics.overdrive_v)
        }
    };
    MotorLimits {
        rated_v: haptics.full_v,
        overdrive_v,
        overdrive_s,
        travel_um_v: per_volt,
        travel_um: haptics.travel_um,
        rise_k_v2: coil.kelvin_per_watt / haptics.ohm,
        coil_s: coil.warming_s,
        rise_k: haptics.coil_rise_k,
        burst: Duration::from_micros((haptics.burst_ms * 1e3).round() as u64),
        duty: haptics.duty,
    }
}

/// The switch before each driver, and its channel; `None` for one alone on the bus.
pub fn behind(haptics: &BenchHaptics) -> Vec<Option<(u8, u8)>> {
    haptics.drivers.iter().map(before).collect()
}

fn before(driver: &HapticDriver) -> Option<(u8, u8)> {
    driver.switch.map(|switch| (switch, driver.channel))
}

/// The drivers of the motors.
pub fn channels(haptics: &BenchHaptics) -> Vec<HapticChannel> {
    let motor = match haptics.kind {
        MotorKind::Lra | MotorKind::VoiceCoil => HapticMotor::Lra {
            rated_v: haptics.full_v,
            overdrive_v: haptics.overdrive_v,
            resonance_hz: haptics.resonance_hz,
        },
        MotorKind::Erm => HapticMotor::Erm {
            rated_v: haptics.full_v,
            overdrive_v: haptics.overdrive_v,
        },
    };
    let [compensation, back_emf, gain] = haptics.calibration;
    let channel = |driver: &HapticDriver| HapticChannel {
        behind: before(driver),
        motor,
        calibration: HapticCalibration {
            compensation,
            back_emf,
            gain,
        },
    };
    haptics.drivers.iter().map(channel).collect()
}

/// Motors at rest at these places, nobody's yet; with the driver of their sound card where they are on one.
///
/// # Errors
/// [`AudioPlanError`] for a card that cannot be.
pub fn worn(
    haptics: &BenchHaptics,
    places: &[MotorPlace],
) -> Result<(WornMotors, Option<Audio<CardHandle>>), AudioPlanError> {
    let contact = contact(haptics);
    let Some(audio) = &haptics.audio else {
        return Ok((WornMotors::new(&motor(haptics), contact, places), None));
    };
    let frames = |ms: f64| (f64::from(audio.rate_hz) * ms * 1e-3).round() as u32; // at most 19200
    let plan = AudioPlan {
        rate_hz: audio.rate_hz,
        sine_hz: audio.sine_hz,
        ramp: frames(audio.ramp_ms),
        full: haptics.full_v * PEAK / audio.full_scale_v,
        channels: audio.channels.clone(),
    };
    let channels = Channels {
        rate_hz: plan.rate_hz,
        sine_hz: plan.sine_hz,
        full_scale_v: audio.full_scale_v,
        width: plan.width(),
        of: plan.channels.clone(),
    };
    let card = CardHandle::new(Card::new(plan.width(), frames(audio.buffer_ms)));
    let driver = Audio::new(card.clone(), plan)?;
    let coils = Coils::new(lra(haptics), card, channels);
    Ok((WornMotors::on_card(coils, contact, places), Some(driver)))
}

/// Largest voltage that what drives the motors can give, V peak.
pub fn peak_v(haptics: &BenchHaptics) -> f64 {
    match haptics.audio {
        Some(_) => haptics.full_v * PEAK,
        None => haptics.overdrive_v,
    }
}

/// Places of the motors on the finger.
pub fn places(setup: &Setup, haptics: &BenchHaptics) -> Vec<MotorPlace> {
    let drivers = haptics.drivers.iter();
    let places = drivers.zip(&setup.display.value.wires_mm);
    let place = |(driver, [x, y]): (&HapticDriver, &[f64; 2])| MotorPlace {
        at_mm: (*x, *y),
        behind: before(driver),
    };
    places.map(place).collect()
}

/// The emulated person of a setup, with faces of motors on the skin.
pub fn wearer(setup: &Setup, haptics: &BenchHaptics) -> Person {
    with_area(&setup.person.value, contact(haptics).area_cm2())
}
