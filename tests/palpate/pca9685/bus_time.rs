//! Bus time and the segment itself (document: "Bus time").

use super::*;
use embedded_hal::i2c::{Error as _, ErrorKind, NoAcknowledgeSource};
use palpate_emulators::display::i2c::immediate;

const CLOCKS: [BusClock; 3] = [BusClock::Standard, BusClock::Fast, BusClock::FastPlus];

fn time_of(clock: BusClock, bytes: usize, boards: u8) -> f64 {
    let chips = (0..boards).map(|n| Pca9685::new(Config::new(n))).collect();
    let mut bench = Bench::over(I2cSegment::new(clock, chips));
    for n in 0..boards {
        bench.try_write(0x40 | n, &vec![0; bytes]).unwrap();
    }
    bench.now() as f64 * 1e-6
}

#[test]
fn a_channel_write_of_5_bytes_takes_560_140_56_us() {
    for (clock, us) in CLOCKS.into_iter().zip([560, 140, 56]) {
        assert_eq!((time_of(clock, 5, 1) * 1000.0).round() as u64, us);
        assert_eq!(clock.write_time(5), Nanos::from_micros(us));
    }
}

#[test]
fn sixteen_channels_take_5_96_1_49_0_60_ms() {
    for (clock, ms) in CLOCKS.into_iter().zip([5.96, 1.49, 0.596]) {
        assert!((time_of(clock, 65, 1) - ms).abs() < 1e-3);
    }
}

#[test]
fn sixteen_boards_take_95_23_8_9_5_ms() {
    for (clock, ms) in CLOCKS.into_iter().zip([95.36, 23.84, 9.536]) {
        assert!((time_of(clock, 65, 16) - ms).abs() < 1e-3);
    }
}

#[test]
fn the_fast_stop_is_all_call_and_three_bytes_75_us_at_400k() {
    let mut bench = Bench::new(&[Config::new(0x41), Config::new(0x42)]);
    bench.try_write(0x70, &[map::MODE1, 0x21]).unwrap();
    bench
        .try_write(0x70, &[map::ALL_LED_ON_L + 1, 0x10, 0, 0])
        .unwrap();
    bench.wait_us(1000);
    let before = bench.now();
    bench.try_write(0x70, &[map::ALL_LED_OFF_H, 0x10]).unwrap();
    assert_eq!(bench.now() - before, 72_500); // 29 bits; the document rounds up
    bench.wait_ns(PERIOD);
    assert!(
        bench
            .bus
            .with(|s| s.chips().iter().all(|c| c.pins() == [Pin::Low; 16]))
            .unwrap()
    );
}

#[test]
fn time_is_bit_exact_with_repeated_start() {
    let mut bench = Bench::one();
    bench.read(map::MODE1);
    // START, address, control, START, address, data, STOP.
    assert_eq!(bench.now(), (3 + 4 * 9) * 2_500);
    let log = bench.bus.with(I2cSegment::take_log).unwrap();
    assert_eq!((log[0].start, log[0].end), (Nanos(0), Nanos(39 * 2_500)));
    assert_eq!(log[0].messages.len(), 2);
    assert_eq!(log[0].messages[1].bytes, [0x11]);
}

#[test]
fn a_refused_byte_ends_the_transaction_with_a_stop_and_what_came_before_counts() {
    let mut bench = Bench::awake();
    let before = bench.now();
    let refused = bench.try_write(ADDRESS, &[0x80, 1, 2, 3]);
    assert_eq!(refused, Err(Error::DataNack));
    assert_eq!(bench.now() - before, (2 + 18) * 2_500);
    let log = bench.bus.with(I2cSegment::take_log).unwrap();
    assert_eq!(log[log.len() - 1].result, Err(Error::DataNack));
    assert_eq!(log[log.len() - 1].messages[0].bytes, [0x80]);
}

#[test]
fn an_empty_write_probes_an_address() {
    let mut bench = Bench::one();
    let found: Vec<u8> = (0x03..0x78)
        .filter(|&a| bench.try_write(a, &[]).is_ok())
        .collect();
    assert_eq!(found, [0x40, 0x70]); // what i2cdetect prints
    assert!(bench.bus.read(0x40, &mut []).is_ok());
}

#[test]
fn the_clock_may_be_stretched_up_to_the_limit() {
    let mut bench = Bench::one();
    bench
        .bus
        .with(|s| s.hold_clock(Nanos::from_micros(25_000)))
        .unwrap();
    bench.write(&[map::MODE2, 0x04]);
    assert_eq!(bench.now(), 25_000_000 + 29 * 2_500);
    bench
        .bus
        .with(|s| s.hold_clock(Nanos::from_micros(25_001)))
        .unwrap();
    assert_eq!(
        bench.try_write(ADDRESS, &[map::MODE2, 5]),
        Err(Error::Timeout)
    );
    assert_eq!(bench.read(map::MODE2), 0x04);
}

#[test]
fn errors_have_the_kinds_and_numbers_of_linux() {
    use NoAcknowledgeSource::{Address, Data};
    for (error, errno, kind) in [
        (Error::AddressNack, 6, ErrorKind::NoAcknowledge(Address)),
        (Error::DataNack, 121, ErrorKind::NoAcknowledge(Data)),
        (Error::ArbitrationLost, 11, ErrorKind::ArbitrationLoss),
        (Error::Timeout, 110, ErrorKind::Other),
        (Error::BusBusy, 16, ErrorKind::Bus),
        (Error::Io, 5, ErrorKind::Bus),
        (Error::Unsupported, 95, ErrorKind::Other),
    ] {
        assert_eq!((error.errno(), error.kind()), (errno, kind));
    }
}

#[test]
fn time_never_goes_back() {
    let mut bench = Bench::one();
    bench.wait_us(100);
    bench.bus.with(|s| s.set_now(Nanos(5))).unwrap();
    assert_eq!(bench.now(), 100_000);
}

#[test]
fn the_async_face_is_the_blocking_one() {
    use embedded_hal_async::i2c::I2c as Async;
    let mut bench = Bench::one();
    let mut byte = [0];
    let done = immediate(async {
        let bus = &mut bench.bus;
        Async::write(bus, ADDRESS, &[map::MODE2, 0x0C]).await?;
        Async::write_read(bus, ADDRESS, &[map::MODE2], &mut byte).await
    });
    assert_eq!((done, byte), (Some(Ok(())), [0x0C]));
    assert_eq!(bench.now(), (29 + 39) * 2_500);
}

#[test]
fn a_look_inside_a_look_is_an_error_not_a_panic() {
    let bench = Bench::one();
    let inner = bench.bus.with(|_| bench.bus.with(|s| s.now()));
    assert_eq!(inner, Ok(Err(Error::BusBusy)));
}

#[test]
fn two_threads_take_turns_and_neither_is_refused() {
    let bench = Bench::one();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            let mut bus = bench.bus.clone();
            scope.spawn(move || {
                for _ in 0..1000 {
                    bus.write(ADDRESS, &[map::MODE2, 0x04]).unwrap();
                }
            });
        }
    });
    assert_eq!(bench.now(), 2000 * 29 * 2_500);
}
