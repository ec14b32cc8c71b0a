//! The driver unit on a Raspberry Pi Pico: SDA on GPIO 4, SCL on GPIO 5, the chips'
//! OE on GPIO 6, datagrams over USB. A Peltier module has the bridge's SHDN on GPIO
//! 7, its CTLI on GPIO 8, and thermistors of face and sink on GPIO 26 and 27.
#![no_std]
#![no_main]

use core::ptr::addr_of_mut;

use cortex_m::singleton;
use palpate_image::serve;
use palpate_image::udp::{Bytes, Memory, NO_BYTES, Udp};
use palpate_image_rp2040::{
    Bridge, HEAP, Machine, STEPS, Serial, Settled, now, regulator, settings,
};
use palpate_unit::Unit;
use rp2040_hal::adc::AdcPin;
use rp2040_hal::clocks::{Clock, init_clocks_and_plls};
use rp2040_hal::fugit::{ExtU32, RateExtU32};
use rp2040_hal::gpio::{FunctionI2C, Pin, PinState, Pins, PullUp};
use rp2040_hal::pwm::Slices;
use rp2040_hal::rosc::RingOscillator;
use rp2040_hal::usb::UsbBus;
use rp2040_hal::{Adc, I2C, Sio, Watchdog, entry, pac};
use smoltcp::wire::{Ipv4Address, Ipv4Cidr};
use usb_device::bus::UsbBusAllocator;

#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_GENERIC_03H;

/// The unit's address on its line.
const ADDRESS: Ipv4Cidr = Ipv4Cidr::new(Ipv4Address::new(192, 168, 7, 2), 24);
/// The board's crystal.
const CRYSTAL_HZ: u32 = 12_000_000;

static mut MEMORY: Memory = Memory::new();
static mut BYTES: Bytes = NO_BYTES;

#[entry]
fn main() -> ! {
    let Some(mut pac) = pac::Peripherals::take() else {
        panic!("taken once");
    };
    let sio = Sio::new(pac.SIO);
    let bank = (pac.IO_BANK0, pac.PADS_BANK0, sio.gpio_bank0);
    let pins = Pins::new(bank.0, bank.1, bank.2, &mut pac.RESETS);
    // Outputs off before anything else; the unit then says so to the chips.
    let oe = pins.gpio6.into_push_pull_output_in_state(PinState::High);
    let shutdown = pins.gpio7.into_push_pull_output_in_state(PinState::Low);
    let mut watchdog = Watchdog::new(pac.WATCHDOG);
    let Ok(clocks) = init_clocks_and_plls(
        CRYSTAL_HZ,
        pac.XOSC,
        pac.CLOCKS,
        pac.PLL_SYS,
        pac.PLL_USB,
        &mut pac.RESETS,
        &mut watchdog,
    ) else {
        panic!("no clocks");
    };
    // It counts the crystal's clock, so that it cannot begin earlier. A hang lasts for 40 ms at most.
    watchdog.start(40.millis());
    let sda: Pin<_, FunctionI2C, PullUp> = pins.gpio4.reconfigure();
    let scl: Pin<_, FunctionI2C, PullUp> = pins.gpio5.reconfigure();
    let system = clocks.system_clock.freq();
    let bus = Settled(I2C::i2c0(
        pac.I2C0,
        sda,
        scl,
        400.kHz(),
        &mut pac.RESETS,
        system,
    ));
    let mut slice = Slices::new(pac.PWM, &mut pac.RESETS).pwm4;
    slice.set_top(STEPS - 1);
    slice.enable();
    slice.channel_a.output_to(pins.gpio8);
    let (Ok(face), Ok(sink)) = (
        AdcPin::new(pins.gpio26.into_floating_input()),
        AdcPin::new(pins.gpio27.into_floating_input()),
    ) else {
        panic!("pins of the converter");
    };
    let bridge = Bridge {
        control: slice.channel_a,
        shutdown,
        thermistors: (Adc::new(pac.ADC, &mut pac.RESETS), face, sink),
    };
    let usb = UsbBus::new(
        pac.USBCTRL_REGS,
        pac.USBCTRL_DPRAM,
        clocks.usb_clock,
        true,
        &mut pac.RESETS,
    );
    let Some(usb) = singleton!(: UsbBusAllocator<UsbBus> = UsbBusAllocator::new(usb)) else {
        panic!("once");
    };
    let settings = settings(random(&RingOscillator::new(pac.ROSC).initialize()));
    let module = regulator().map(|regulator| (bridge, regulator));
    let Ok(unit) = Unit::warming(&settings, (bus, oe), module) else {
        panic!("settings that no unit can have");
    };
    // SAFETY: the one use of each.
    let memory = unsafe { (&mut *addr_of_mut!(MEMORY), &mut *addr_of_mut!(BYTES)) };
    let mut link = Udp::start(Serial::new(usb), now, ADDRESS, memory);
    HEAP.close();
    serve(unit, &mut Machine(watchdog), &mut link)
}

/// 64 bits of the ring oscillator, each of 32 looks: one look alone may be like the last.
fn random(oscillator: &RingOscillator<rp2040_hal::rosc::Enabled>) -> u64 {
    (0..64).fold(0, |bits, _| {
        let odd = (0..32).fold(false, |odd, _| odd ^ oscillator.get_random_bit());
        bits << 1 | u64::from(odd)
    })
}
