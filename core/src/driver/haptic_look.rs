//! Drivers of motors as another program may have left them: looked at, brought to rest, identified.

use embedded_hal::i2c::I2c;

use super::haptics::complain;
use super::{HapticFault, Haptics};
use crate::codec::drv2605::{self as regs, mode, status};

impl<I: I2c> Haptics<I> {
    /// Tells whether a driver's output may move its motor, by its registers alone: a level in real-time playback, a run of GO,
    /// or an input pin. Changes nothing of the driver.
    ///
    /// # Errors
    /// [`HapticFault`] of a driver or switch that does not answer.
    pub fn is_driving(&mut self, number: u8) -> Result<bool, HapticFault> {
        let found = self.read_all(number, regs::MODE)?;
        let [set, level, go] =
            [regs::MODE, regs::RTP_INPUT, regs::GO].map(|register| found[usize::from(register)]);
        let plays = match set & mode::KIND {
            mode::REAL_TIME => level != 0,
            mode::TRIGGER | mode::DIAGNOSE | mode::CALIBRATE => go & 1 != 0,
            _ => true,
        };
        Ok(set & mode::STANDBY == 0 && plays)
    }

    /// Brings a driver to rest in whatever state another program has left it: no level, and standby where that is not all.
    ///
    /// # Errors
    /// [`HapticFault`] of a driver or switch that does not answer.
    pub fn silence(&mut self, number: u8) -> Result<(), HapticFault> {
        self.set(number, 0)?;
        let found = self.read_all(number, regs::MODE)?;
        let [set, formats] =
            [regs::MODE, regs::CONTROL3].map(|register| found[usize::from(register)]);
        match (set, formats) {
            (mode::REAL_TIME, regs::SIGNED_LEVELS) => Ok(()),
            _ => self.write(number, regs::MODE, mode::STANDBY),
        }
    }

    /// Checks that a DRV2605L answers at an actuator's place and complains of nothing, and that none answers while every
    /// channel of the switches is closed. Reading its flags ends them; nothing else of the driver changes.
    ///
    /// # Errors
    /// [`HapticFault`] with what is wrong there.
    pub fn identify(&mut self, number: u8) -> Result<(), HapticFault> {
        if self.state(number)?.behind.is_some() {
            self.selected = None;
            self.close_others(number, None)?;
            let mut got = [0];
            let beside = self.i2c.write_read(regs::ADDRESS, &[regs::MODE], &mut got);
            if beside.is_ok() {
                return Err(HapticFault::Beside(number));
            }
        }
        let found = self.read(number, regs::STATUS)?;
        match found >> status::DEVICE {
            status::DRV2605L => complain(number, found),
            device => Err(HapticFault::Device(number, device)),
        }
    }
}
