//! A CAN driver of one's own under test: frames in, arbitration, an error and bus-off on an emulated segment.
//!
//! `cargo run -p palpate-emulators --example can`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use embedded_can::blocking::Can;
use embedded_can::{Frame, Id, StandardId};
use palpate_core::codec::can::CanFrame;
use palpate_emulators::sensor::board::BoardConfig;
use palpate_emulators::sensor::can::{CanSegment, ErrorClass, NodeConfig};
use palpate_emulators::sensor::port::HostPort;
use palpate_emulators::sensor::rig::{Handle, SkinBus};
use palpate_emulators::sensor::{EmulatedModule, ModuleConfig};

const COMMAND: StandardId = StandardId::new(0x200).expect("11 bits");

/// The driver under test: the taxels of an MTB3 board, over any CAN controller.
struct Skin<C>(C);

impl<C: Can> Skin<C> {
    fn start(&mut self) -> Result<(), C::Error> {
        let command = C::Frame::new(COMMAND, &[7, 0]).expect("two bytes");
        self.0.transmit(&command)
    }

    /// Waits for a taxel; returns its identifier and its normal count.
    fn reading(&mut self) -> Result<(u16, u16), C::Error> {
        loop {
            let frame = self.0.receive()?;
            let (id, data) = (frame.id(), frame.data());
            if let (Id::Standard(id), &[_, _, _, _, _, high, low, ..]) = (id, data) {
                return Ok((id.as_raw(), u16::from_be_bytes([high, low])));
            }
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // At 1 Mbit/s: a board of sixteen taxels, the host, a node of one's own, and one that only listens.
    let mut bus = SkinBus::new(1_000_000);
    let module = EmulatedModule::new(ModuleConfig::default());
    bus.add_board(BoardConfig::default(), vec![module])?;
    let host = bus.host();
    let [motor, sniffer] = [(); 2].map(|()| bus.segment_mut().attach(NodeConfig::default()));
    let rig = Handle::new(vec![bus]);
    let mut skin = Skin(HostPort::new(rig.clone(), 0));

    // Frames in: virtual time passes until one comes.
    skin.start()?;
    let (taxel, count) = skin.reading()?;
    println!("{:>7} us  taxel {taxel:03x} reads {count}", now(&rig));

    // Arbitration: the board's controller is a queue, and the motor's frame goes before the first higher identifier.
    let turn = CanFrame::new(0x181, &[90]).ok_or("too long")?;
    on(&rig, |segment| segment.send(motor, &turn))?;
    for _ in 1..16 {
        skin.reading()?;
    }
    let heard = on(&rig, |segment| {
        let frames = std::iter::from_fn(|| segment.receive(sniffer));
        let ids: Vec<String> = frames.map(|(_, f)| format!("{:03x}", f.id())).collect();
        ids.join(" ")
    });
    println!("{:>7} us  on the wire: {heard}", now(&rig));

    // An error destroys the next frame, and its controller sends it again: the driver misses nothing.
    on(&rig, |segment| segment.inject(ErrorClass::Crc));
    let (taxel, count) = skin.reading()?;
    let errors = on(&rig, |segment| segment.statistics().errors);
    assert_eq!(errors[ErrorClass::Crc as usize], 1);
    println!(
        "{:>7} us  taxel {taxel:03x} reads {count}, after an error",
        now(&rig)
    );

    // Bus-off: the host neither hears nor sends until it restarts.
    on(&rig, |segment| segment.force_bus_off(host));
    if let (Err(heard), Err(sent)) = (skin.reading(), skin.start()) {
        println!("{:>7} us  receive: {heard}; transmit: {sent}", now(&rig));
    }
    on(&rig, |segment| segment.restart(host));
    let (taxel, count) = skin.reading()?;
    println!("{:>7} us  taxel {taxel:03x} reads {count}", now(&rig));
    Ok(())
}

/// Looks at the segment, or disturbs it.
fn on<T>(rig: &Handle, work: impl FnOnce(&mut CanSegment) -> T) -> T {
    rig.with(|buses| work(buses[0].segment_mut()))
}

fn now(rig: &Handle) -> u64 {
    on(rig, |segment| segment.now().as_micros())
}
