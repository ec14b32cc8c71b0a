//! The fault layer in front of the segment.

use super::*;
use embedded_hal::i2c::Error as _;
use palpate_emulators::display::i2c::fault::{FaultError, I2cFault, I2cFaultKind, I2cFaults};

fn layer(bench: &Bench, faults: I2cFaults) -> I2cFault<I2cHandle> {
    I2cFault::new(bench.bus.clone(), faults, 7, "i2c-1")
}

#[test]
fn without_faults_the_layer_changes_nothing() {
    let mut bench = Bench::one();
    let mut bus = layer(&bench, I2cFaults::default());
    let mut byte = [0];
    for _ in 0..1000 {
        bus.write_read(ADDRESS, &[map::PRE_SCALE], &mut byte)
            .unwrap();
    }
    assert_eq!(
        (byte, bus.counts(), bus.transactions()),
        ([0x1E], [0; 6], 1000)
    );
    assert_eq!(bench.now(), 1000 * 39 * 2_500);
    bench.collect();
}

#[test]
fn faults_come_as_often_as_asked_and_the_same_for_the_same_seed() {
    let run = || {
        let bench = Bench::one();
        let faults = I2cFaults {
            probability: [0.05, 0.05, 0.05, 0.01, 0.05, 0.05],
            stuck_for: 3,
            stretch_ns: 30_000_000,
        };
        let mut bus = layer(&bench, faults);
        let failed = (0..10_000)
            .filter(|_| bus.write(ADDRESS, &[1, 4]).is_err())
            .count() as u64;
        (failed, bus.counts())
    };
    let (failed, counts) = run();
    assert_eq!((failed, counts), run());
    assert_eq!(failed, counts.iter().sum::<u64>());
    for (count, expected) in counts.into_iter().zip([485, 485, 485, 294, 485, 485]) {
        assert!(count.abs_diff(expected) < 100, "{counts:?}");
    }
}

#[test]
fn a_lost_data_byte_tears_the_update() {
    let mut torn = 0;
    for seed in 0..50 {
        let mut bench = Bench::awake();
        bench.channel(0, 0, 100);
        let mut bus = I2cFault::new(bench.bus.clone(), I2cFaults::default(), seed, "i2c-1");
        bus.strike(I2cFaultKind::DataNack);
        let result = bus.write(ADDRESS, &[map::led(0), 0, 2, 100, 2]);
        assert_eq!(result, Err(FaultError::Injected(I2cFaultKind::DataNack)));
        let is: Vec<u8> = (0..4).map(|k| bench.read(map::led(0) + k)).collect();
        assert_ne!(is, [0, 2, 100, 2]);
        torn += usize::from(is == [0, 2, 100, 0]); // 512/100: 90 % duty
    }
    assert!(torn > 0);
}

#[test]
fn a_failed_adapter_may_have_done_its_work() {
    let mut bench = Bench::one();
    let mut bus = layer(&bench, I2cFaults::default());
    bus.strike(I2cFaultKind::Eio);
    let error = bus.write(ADDRESS, &[map::MODE2, 0x0C]).unwrap_err();
    assert_eq!(error.kind(), embedded_hal::i2c::ErrorKind::Bus);
    assert_eq!(bench.read(map::MODE2), 0x0C);
}

#[test]
fn a_stuck_bus_stays_stuck_and_comes_free() {
    let bench = Bench::one();
    let mut bus = layer(
        &bench,
        I2cFaults {
            stuck_for: 4,
            ..I2cFaults::default()
        },
    );
    bus.strike(I2cFaultKind::StuckBus);
    let results: Vec<bool> = (0..6)
        .map(|_| bus.write(ADDRESS, &[1, 4]).is_ok())
        .collect();
    assert_eq!(results, [false, false, false, false, true, true]);
    bus.strike(I2cFaultKind::StuckBus);
    assert!(bus.write(ADDRESS, &[1, 4]).is_err());
    bus.free();
    assert!(bus.write(ADDRESS, &[1, 4]).is_ok());
}

#[test]
fn a_long_stretch_takes_time_and_a_longer_one_times_out() {
    for (stretch_ns, result) in [
        (1_000_000, Ok(())),
        (30_000_000, Err(FaultError::Bus(Error::Timeout))),
    ] {
        let bench = Bench::one();
        let faults = I2cFaults {
            stretch_ns,
            ..I2cFaults::default()
        };
        let mut bus = layer(&bench, faults);
        bus.strike(I2cFaultKind::LongStretch);
        assert_eq!(bus.write(ADDRESS, &[1, 4]), result);
        assert!(bench.now() >= 1_000_000);
    }
}

#[test]
fn arbitration_loss_and_address_nack_reach_no_chip() {
    for kind in [I2cFaultKind::ArbitrationLoss, I2cFaultKind::AddressNack] {
        let mut bench = Bench::one();
        let mut bus = layer(&bench, I2cFaults::default());
        bus.strike(kind);
        assert!(bus.write(ADDRESS, &[map::MODE2, 0x0C]).is_err());
        assert_eq!(bench.read(map::MODE2), 0x04);
    }
}
