//! Known defects of published drivers: the emulator must show every one (document: last section).
//!
//! pwm-pca9685 1.0.0 itself, over traffic as linux-embedded-hal sends it; Adafruit's library and the Linux
//! kernel's driver as the bytes they send.

use super::*;
use pwm_pca9685::{Channel as Ch, Error as PwmError, Pca9685 as Driver, ProgrammableAddress};

fn driver(bench: &Bench) -> Driver<I2cHandle> {
    Driver::new(bench.bus.clone(), ADDRESS).unwrap()
}

#[test]
fn pwm_pca9685_drives_a_channel() {
    let mut bench = Bench::linux(Config::new(ADDRESS));
    let mut pwm = driver(&bench);
    pwm.set_prescale(100).unwrap();
    pwm.enable().unwrap();
    pwm.set_channel_on_off(Ch::C0, 0, 1024).unwrap();
    bench.wait_us(600);
    assert_eq!(bench.read(map::PRE_SCALE), 100);
    assert_eq!(bench.duty(0, 4096 * 101 * 40), 0.25);
}

#[test]
fn pwm_pca9685_writes_sub_addresses_and_all_call_unshifted() {
    for (kind, register, bit) in [
        (ProgrammableAddress::Subaddress1, 2, 0x08),
        (ProgrammableAddress::Subaddress2, 3, 0x04),
        (ProgrammableAddress::Subaddress3, 4, 0x02),
        (ProgrammableAddress::AllCall, 5, 0x01),
    ] {
        let mut bench = Bench::linux(Config::new(ADDRESS));
        let mut pwm = driver(&bench);
        pwm.set_programmable_address(kind, 0x5A).unwrap();
        pwm.enable_programmable_address(kind).unwrap();
        assert_eq!(bench.read(register), 0x5A, "should be 0xB4");
        assert_eq!(bench.read(map::MODE1) & bit, bit);
        assert_eq!(bench.try_write(0x5A, &[0]), Err(Error::AddressNack));
        bench.try_write(0x2D, &[0]).unwrap(); // where it really is now
    }
}

#[test]
fn pwm_pca9685_refuses_70() {
    let bench = Bench::linux(Config::new(0x70));
    let refused = Driver::new(bench.bus.clone(), 0x70);
    assert!(matches!(refused, Err(PwmError::InvalidInputData)));
}

#[test]
fn pwm_pca9685_set_prescale_leaves_outputs_paused() {
    let mut bench = Bench::linux(Config::new(ADDRESS));
    let mut pwm = driver(&bench);
    pwm.enable().unwrap();
    pwm.set_channel_on_off(Ch::C0, 0, 2048).unwrap();
    bench.wait_us(20_000);
    assert!(bench.duty(0, 10 * PERIOD) > 0.49);
    pwm.set_prescale(50).unwrap();
    bench.wait_us(20_000);
    assert_eq!(bench.duty(0, 20 * PERIOD), 0.0);
    assert_eq!(bench.read(map::MODE1) & 0x80, 0x80);
    // The driver's own restart() mends it.
    let mut delay = bench.bus.clone();
    pwm.restart(&mut delay).unwrap();
    let period = 4096 * 51 * 40;
    assert!((bench.duty(0, 10 * period) - 0.5).abs() < 0.05);
}

#[test]
fn adafruit_reset_resets_nothing_and_the_old_stimulus_goes_on_after_a_reboot() {
    let mut bench = Bench::awake();
    bench.channel(4, 0, 2048); // what ran when the controller rebooted
    bench.wait_us(7_000);
    bench.write(&[map::MODE1, 0x80]); // reset()
    bench.wait_us(10_000);
    assert_eq!(bench.read(map::led(4) + 3), 0x08, "the old stimulus");
    assert_eq!(bench.read(map::MODE1), 0x00);
    assert_eq!(bench.duty(4, PERIOD), 0.5);
    // setPWMFreq() of begin(): sleep, prescale, wake, 5 ms, restart.
    let old = bench.read(map::MODE1);
    bench.write(&[map::MODE1, old & !0x80 | 0x10]);
    bench.write(&[map::PRE_SCALE, 121]);
    bench.write(&[map::MODE1, old]);
    bench.wait_us(5_000);
    bench.write(&[map::MODE1, old | 0xA0]);
    let period = 4096 * 122 * 40;
    bench.wait_us(30_000);
    assert_eq!(bench.duty(4, period), 0.5, "resumed at the new frequency");
}

#[test]
fn adafruit_set_pwm_freq_resumes_with_the_new_prescale_even_in_mid_cycle() {
    // A slow board: 5 ms is less than a cycle, RESTART comes before the end that would have set it.
    let mut bench = Bench::one();
    bench.write(&[map::PRE_SCALE, 121]);
    bench.wake();
    bench.channel(0, 0, 2048);
    for bytes in [[map::MODE1, 0x30], [map::PRE_SCALE, 30], [map::MODE1, 0x20]] {
        bench.write(&bytes);
    }
    bench.wait_us(5_000);
    bench.write(&[map::MODE1, 0xA0]);
    assert_eq!(bench.duty(0, PERIOD), 0.5);
}

#[test]
fn linux_pwm_pca9685_writes_a_register_a_transfer_and_tears_the_update() {
    // regmap_write() of LEDn_ON_L, ON_H, OFF_L, OFF_H, each with its own STOP; 0/100 to 512/612.
    let torn = |bench: &mut Bench, at: u64| {
        bench.wait_ns(at);
        for bytes in [[6, 0], [7, 2], [8, 100], [9, 2]] {
            bench.write(&bytes);
        }
        bench.forget();
        bench.wait_ns(3 * PERIOD);
        let edges = bench.take(0);
        let width = |p: &[(u64, bool)]| if p[0].1 { p[1].0 - p[0].0 } else { 0 };
        edges.windows(2).map(width).max().unwrap()
    };
    let widest = (0..400)
        .map(|k| {
            let mut bench = Bench::awake();
            bench.channel(0, 0, 100);
            torn(&mut bench, PERIOD / 2 + k * PERIOD / 400)
        })
        .max()
        .unwrap();
    assert!(
        widest > 3000 * TICK,
        "{} ticks at full power",
        widest / TICK
    );
}

#[test]
fn linux_pwm_pca9685_clears_all_call_at_probe() {
    let mut bench = Bench::one();
    // probe: reset the sub-address and all-call bits, MODE1 = SLEEP kept.
    let mode1 = bench.read(map::MODE1) & !(0x01 | 0x08 | 0x04 | 0x02);
    bench.write(&[map::MODE1, mode1]);
    assert_eq!(bench.try_write(0x70, &[0]), Err(Error::AddressNack));
}
