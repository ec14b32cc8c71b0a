//! Motors on a finger, and the person who wears them: the counterpart of [`WornDisplay`](crate::worn::WornDisplay).

mod coils;

pub use coils::{Channels, Coils};
use palpate_core::physics::ParameterError;

use crate::display::i2c::{BusClock, Error, I2cHandle, I2cSegment};
use crate::haptic::contact::Contact;
use crate::haptic::drv2605::Drv2605;
use crate::haptic::exposure::Exposure;
use crate::haptic::tca9548a::Tca9548a;
use crate::haptic::{Drive, Motor};
use crate::person::channels::{Felt, Person};
use crate::person::vibration::{Feeler, Shake};
use crate::time::Nanos;

/// Time between two looks at the motors: less than their half periods.
pub const LOOK: Nanos = Nanos::from_micros(1000);

/// A motor's place on the finger, and the switch and channel before its driver; `None` for one alone on the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorPlace {
    /// Place on the unrolled display, mm.
    pub at_mm: (f64, f64),
    /// Address of the switch, and the channel.
    pub behind: Option<(u8, u8)>,
}

/// The most that came of the motors so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorTotals {
    /// Largest amplitude of a contactor, um.
    pub contactor_um: f64,
    /// Warmest coil, K above the air.
    pub coil_rise_k: f64,
    /// Largest drive of a motor, V peak.
    pub drive_v: f64,
}

/// Drivers, motors and contactors on a person's finger.
#[derive(Debug)]
pub struct WornMotors {
    bus: I2cHandle,
    places: Vec<MotorPlace>,
    contact: Contact,
    feeler: Option<Feeler>,
    exposure: Exposure,
    totals: MotorTotals,
    now: Nanos,
    shakes: Vec<Shake>,
    /// Voice coils on a sound card, in place of chips on the bus.
    coils: Option<Coils>,
}

impl WornMotors {
    /// Equal motors at these places, at rest, behind drivers and switches.
    pub fn new(motor: &Motor, contact: Contact, places: &[MotorPlace]) -> Self {
        let mut muxes: Vec<(u8, Tca9548a)> = Vec::new();
        let mut alone = Vec::new();
        for place in places {
            let chip = Drv2605::new(motor.clone());
            let Some((address, channel)) = place.behind else {
                alone.push(chip);
                continue;
            };
            let found = muxes.iter().position(|(own, _)| *own == address);
            let found = found.unwrap_or_else(|| {
                muxes.push((address, Tca9548a::new(address)));
                muxes.len() - 1
            });
            let (_, mux) = muxes.swap_remove(found);
            muxes.push((address, mux.with(usize::from(channel), chip)));
        }
        let muxes = muxes.into_iter().map(|(_, mux)| mux).collect();
        let segment = I2cSegment::new(BusClock::Fast, Vec::new()).with_haptics(muxes, alone);
        Self::on(segment, contact, places, None)
    }

    /// Voice coils at these places, at rest, on the channels of a sound card. Nothing is on the bus.
    pub fn on_card(coils: Coils, contact: Contact, places: &[MotorPlace]) -> Self {
        let empty = I2cSegment::new(BusClock::Fast, Vec::new());
        Self::on(empty, contact, places, Some(coils))
    }

    fn on(
        segment: I2cSegment,
        contact: Contact,
        places: &[MotorPlace],
        coils: Option<Coils>,
    ) -> Self {
        Self {
            bus: I2cHandle::new(segment),
            places: places.to_vec(),
            contact,
            feeler: None,
            exposure: Exposure::default(),
            totals: MotorTotals::default(),
            now: Nanos::ZERO,
            shakes: vec![Shake::default(); places.len()],
            coils,
        }
    }

    /// The bus that a driver holds.
    pub fn bus(&self) -> I2cHandle {
        self.bus.clone()
    }

    /// A person feels the contactors from here on.
    ///
    /// # Errors
    /// A threshold of the person that cannot be, by name.
    pub fn worn_by(&mut self, person: Person) -> Result<(), ParameterError> {
        let places: Vec<_> = self.places.iter().map(|place| place.at_mm).collect();
        self.feeler = Some(Feeler::new(person, &places)?);
        Ok(())
    }

    /// Lets time pass until `to`.
    ///
    /// # Errors
    /// [`Error::BusBusy`] from inside a look at the segment.
    pub fn advance(&mut self, to: Nanos) -> Result<(), Error> {
        while self.now < to {
            let end = to.min(self.now + LOOK);
            let seconds = end.since(self.now).as_secs_f64();
            self.bus
                .with(|segment| segment.advance(end, &mut |_, _| ()))?;
            match &mut self.coils {
                Some(coils) => {
                    coils.play(end, &self.contact, &mut self.shakes, &mut self.totals);
                }
                None => self.look()?,
            }
            for shake in &self.shakes {
                self.exposure.add(1e-6 * shake.um, shake.hz, seconds);
            }
            if let Some(feeler) = &mut self.feeler {
                feeler.pass(&self.shakes, seconds);
            }
            self.now = end;
        }
        Ok(())
    }

    /// Time up to which the motors have moved.
    pub const fn now(&self) -> Nanos {
        self.now
    }

    /// Takes the motors' motion for that of the step that ends now.
    fn look(&mut self) -> Result<(), Error> {
        let (contact, totals) = (&self.contact, &mut self.totals);
        let (places, shakes) = (&self.places, &mut self.shakes);
        self.bus.with(|segment| {
            for (place, shake) in places.iter().zip(&mut *shakes) {
                let Some(chip) = chip_at(segment, place.behind) else {
                    continue;
                };
                let (motor, hz) = (chip.motor(), chip.motor().hz());
                let gain = match motor {
                    Motor::Lra(_) => contact.gain(hz),
                    // The amplitude of a rotating motor is that of what it shakes.
                    Motor::Erm(_) => 1.0,
                };
                *shake = Shake {
                    um: 1e6 * gain * motor.amplitude_m(),
                    hz,
                    driven: *chip.output() != Drive::Open && *chip.output() != Drive::Steady(0.0),
                };
                totals.contactor_um = totals.contactor_um.max(shake.um);
                totals.coil_rise_k = totals.coil_rise_k.max(motor.coil_rise_k());
                if let Drive::Wave { peak: volts, .. } | Drive::Steady(volts) = *chip.output() {
                    totals.drive_v = totals.drive_v.max(volts.abs());
                }
            }
        })
    }

    /// The voice coils, where the bench has them.
    pub const fn coils_mut(&mut self) -> Option<&mut Coils> {
        self.coils.as_mut()
    }

    /// Does something to a motor's driver; nothing where there is none of this number.
    ///
    /// # Errors
    /// [`Error::BusBusy`] from inside a look at the segment.
    pub fn on_chip(&self, motor: usize, work: impl FnOnce(&mut Drv2605)) -> Result<(), Error> {
        let Some(place) = self.places.get(motor) else {
            return Ok(());
        };
        self.bus.with(|segment| {
            if let Some(chip) = chip_at(segment, place.behind) {
                work(chip);
            }
        })
    }

    /// Does something to the switch before a motor's driver; nothing where there is none.
    ///
    /// # Errors
    /// [`Error::BusBusy`] from inside a look at the segment.
    pub fn on_switch(&self, motor: usize, work: impl FnOnce(&mut Tca9548a)) -> Result<(), Error> {
        let behind = self.places.get(motor).and_then(|place| place.behind);
        self.bus.with(|segment| {
            let mut switches = segment.muxes_mut().iter_mut();
            let found = switches.find(|mux| behind.is_some_and(|own| own.0 == mux.address()));
            if let Some(switch) = found {
                work(switch);
            }
        })
    }

    /// Takes the stimulus that the person met since the last onset, felt or not, and begins the next one.
    pub fn onset(&mut self) -> Option<Felt> {
        self.feeler.as_mut().and_then(Feeler::onset)
    }

    /// The most that came of the motors so far.
    pub const fn totals(&self) -> MotorTotals {
        self.totals
    }

    /// Exposure of the hand so far.
    pub const fn exposure(&self) -> Exposure {
        self.exposure
    }
}

/// The driver behind a channel of a switch, or alone.
fn chip_at(segment: &mut I2cSegment, behind: Option<(u8, u8)>) -> Option<&mut Drv2605> {
    let Some((address, channel)) = behind else {
        return segment.haptics_mut().first_mut();
    };
    let mux = segment.muxes_mut().iter_mut();
    let mux = mux.into_iter().find(|mux| mux.address() == address)?;
    let mut chips = mux.chips_mut();
    let found = chips.find(|(own, _)| *own == usize::from(channel))?;
    Some(found.1)
}
