//! Meaning of the controller's error frames (`linux/can/error.h`), and the tally of one interface.

use nix::libc;

/// Counts of everything that has happened on one interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Data frames received.
    pub frames: u64,
    /// Frames the kernel dropped because this program was too slow (SO_RXQ_OVFL).
    pub dropped: u64,
    /// Frames that found this program's own queue full.
    pub discarded: u64,
    /// Times that the controller's receive buffer ran over; it does not tell how many frames that cost.
    pub overruns: u64,
    /// Packets that are no data frame with an 11-bit identifier.
    pub other: u64,
    /// Error frames about the bus: bits, stuffing, form, acknowledgement, arbitration.
    pub bus_errors: u64,
    /// Times the controller went bus-off.
    pub bus_off: u64,
    /// Times that the controller was restarted.
    pub restarts: u64,
    /// Frames with a time stamp of the controller.
    pub hardware_stamps: u64,
}

/// Change of the controller's state, by an error frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The controller has left the bus.
    BusOff,
    /// The controller is back.
    Restarted,
    /// The controller's error counters are high: no node acknowledges, or the wiring is bad.
    Passive,
}

impl Tally {
    /// Counts an error frame.
    pub fn error(&mut self, class: u32, data: [u8; 8]) -> Option<Change> {
        let has = |bit: u32| class & bit != 0;
        let noise = [
            libc::CAN_ERR_LOSTARB,
            libc::CAN_ERR_PROT,
            libc::CAN_ERR_TRX,
            libc::CAN_ERR_ACK,
            libc::CAN_ERR_BUSERROR,
        ];
        self.bus_errors += u64::from(noise.into_iter().any(has));
        let controller = i32::from(if has(libc::CAN_ERR_CRTL) { data[1] } else { 0 });
        self.overruns += u64::from(controller & libc::CAN_ERR_CRTL_RX_OVERFLOW != 0);
        if has(libc::CAN_ERR_BUSOFF) {
            self.bus_off += 1;
            return Some(Change::BusOff);
        }
        if has(libc::CAN_ERR_RESTARTED) {
            self.restarts += 1;
            return Some(Change::Restarted);
        }
        let passive = libc::CAN_ERR_CRTL_RX_PASSIVE | libc::CAN_ERR_CRTL_TX_PASSIVE;
        (controller & passive != 0).then_some(Change::Passive)
    }

    /// Takes over the kernel's cumulative count, which wraps; returns how many are new.
    pub fn drops(&mut self, last: &mut u32, count: u32) -> u64 {
        let new = u64::from(count.wrapping_sub(*last));
        *last = count;
        self.dropped += new;
        new
    }
}

#[cfg(test)]
#[path = "errors_tests.rs"]
mod tests;
