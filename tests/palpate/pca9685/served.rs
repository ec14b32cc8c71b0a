//! The served bridge under a client that fuzzes it: whatever reports come, the chip behind it ends in a
//! state that the reference model reaches by the traffic that crossed the bus.

use palpate_buses::served::mcp2221::{Mcp2221, REPORT};
use palpate_buses::served::uhid::Request;
use palpate_core::random::RandomStream;

use super::reference::Reference;
use super::*;

/// Reports of the fuzzing client.
const REPORTS: u32 = 120_000;

const STATUS: u8 = 0x10;
const GET_DATA: u8 = 0x40;
const TRANSFERS: [u8; 5] = [0x90, 0x91, 0x92, 0x93, 0x94];

struct Dice(RandomStream);

impl Dice {
    fn below(&mut self, n: u32) -> u32 {
        (self.0.uniform() * f64::from(n)) as u32
    }

    fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }

    /// What the kernel's driver would send, with unchecked values.
    fn plausible(&mut self) -> Vec<u8> {
        let command = match self.below(10) {
            0 => STATUS,
            1 | 2 => GET_DATA,
            n => TRANSFERS[n as usize % 5],
        };
        let address =
            [0x40, 0x40, 0x40, 0x70, 0x00, 0x71, self.byte() >> 1][self.below(7) as usize];
        let length = [1, 2, 3, 5, 9, 65, self.below(80)][self.below(7) as usize];
        let mut report = vec![command, length as u8, (length >> 8) as u8, address << 1];
        let register = [
            0x00,
            0x01,
            0xFA,
            0xFE,
            6 + 4 * (self.byte() % 16),
            self.byte(),
        ];
        report.push(register[self.below(6) as usize]);
        report.resize_with(4 + length.max(1) as usize, || 0);
        for byte in &mut report[5..] {
            *byte = [0x00, 0x10, 0x21, 0xA1, 0x06, self.byte()][self.below(6) as usize];
        }
        report.truncate(REPORT);
        report
    }

    /// One of the plausible ones with a few bytes changed and an end of its own, or bytes and nothing else.
    fn malformed(&mut self) -> Vec<u8> {
        let mut report = self.plausible();
        if self.below(3) == 0 {
            report = (0..self.below(80)).map(|_| self.byte()).collect();
        }
        for _ in 0..self.below(3) {
            let at = self.below(report.len().max(1) as u32) as usize;
            let byte = self.byte();
            if let Some(slot) = report.get_mut(at) {
                *slot = byte;
            }
        }
        report.truncate(self.below(80) as usize);
        // Lengths up to 65535 are for the test below: the reference walks every tick of their time.
        if let Some(high) = report.get_mut(2) {
            *high = 0;
        }
        report
    }
}

/// Lets the reference see what crossed the bus, at the very times.
fn replay(reference: &mut Reference, log: Vec<palpate_emulators::display::i2c::Transaction>) {
    let bit = BusClock::Fast.bit().0;
    for record in log {
        let mut t = record.start.0;
        for (n, message) in record.messages.iter().enumerate() {
            t += 10 * bit;
            let acknowledged = reference.start(t, message.address, message.read);
            let last = n + 1 == record.messages.len();
            let refused = last && record.result == Err(Error::AddressNack);
            assert_eq!(acknowledged, !refused, "address {:02x}", message.address);
            for (m, &byte) in message.bytes.iter().enumerate() {
                t += 9 * bit;
                if message.read {
                    assert_eq!(reference.read(t), byte, "a byte read");
                } else {
                    let last = last && m + 1 == message.bytes.len();
                    let refused = last && record.result == Err(Error::DataNack);
                    assert_eq!(reference.write(t, byte), !refused, "byte {byte:02x}");
                }
            }
        }
        assert_eq!(record.end.0, t + bit, "STOP");
        reference.stop(record.end.0);
    }
}

#[test]
fn whatever_a_client_sends_the_registers_are_those_of_the_reference_model() {
    let oscillator = 25_000_000;
    let bench = Bench::one();
    let mut reference = Reference::new(ADDRESS, oscillator, UpdateModel::EndOfLow);
    let mut bridge = Mcp2221::default();
    let mut dice = Dice(RandomStream::new(1, "fuzzing client"));
    let (mut transfers, mut written, mut clocks) = (0, 0, 0);
    for n in 0..REPORTS {
        let report = if dice.below(4) == 0 {
            dice.malformed()
        } else {
            dice.plausible()
        };
        let answer = bridge.answer(&report, &mut bench.bus.clone());
        assert!(
            answer
                .is_none_or(|a| a[0] == report[usize::from(report.len() == 65 && report[0] == 0)])
        );
        let log = bench.bus.with(I2cSegment::take_log).unwrap();
        transfers += log.len();
        written += log
            .iter()
            .filter(|r| r.result.is_ok() && r.messages.iter().any(|m| m.bytes.len() > 1))
            .count();
        let pause = Nanos(u64::from(dice.below(50_000)));
        bench
            .bus
            .with(|segment| {
                replay(&mut reference, log);
                let now = segment.now() + pause;
                segment.set_now(now);
                let chip = &mut segment.chips_mut()[0];
                chip.advance(now, &mut |_| {});
                reference.pass(now.0);
                reference.edges.clear();
                for register in 0..=255 {
                    let wanted = reference.reg[usize::from(register)];
                    assert_eq!(
                        chip.register(register),
                        wanted,
                        "report {n} {report:02x?}: register {register:02x}"
                    );
                }
                // Only power takes a chip off the external clock, of which the reference knows nothing.
                if reference.reg[0] & 0x40 != 0 {
                    clocks += 1;
                    chip.power_cycle(now);
                    chip.advance(now, &mut |_| {});
                    reference.power_cycle(now.0);
                    reference.edges.clear();
                }
            })
            .unwrap();
    }
    assert!(transfers > 50_000, "only {transfers} transfers");
    assert!(written > 10_000, "only {written} transfers moved data");
    println!(
        "{REPORTS} reports, {transfers} transfers, {written} with data, {clocks} to the external clock"
    );
}

#[test]
fn no_length_and_no_event_of_any_kind_does_harm() {
    let bench = Bench::one();
    let mut bridge = Mcp2221::default();
    let mut dice = Dice(RandomStream::new(2, "fuzzing client"));
    for _ in 0..20_000 {
        let length = dice.below(4400);
        let event: Vec<u8> = (0..length.min(80)).map(|_| dice.byte()).collect();
        let mut event = [event, vec![0xFF; length.saturating_sub(80) as usize]].concat();
        if dice.below(2) == 0 && event.len() > 4 {
            event[..4].copy_from_slice(&6_u32.to_le_bytes()); // an output report
        }
        if let Request::Report(report) = Request::decode(&event) {
            let _ = bridge.answer(&report, &mut bench.bus.clone());
        }
    }
    // The longest transfers there are: chunk after chunk, then fetched.
    for command in TRANSFERS {
        let mut report = [0x21; REPORT];
        report[..5].copy_from_slice(&[command, 0xFF, 0xFF, ADDRESS << 1, map::LED0_ON_L]);
        for _ in 0..=65_535 / 60 {
            bridge.answer(&report, &mut bench.bus.clone()).unwrap();
            if command & 1 == 1 {
                break; // a read asks once
            }
        }
        let mut fetched = 0;
        while command & 1 == 1 && fetched < 65_535 {
            let answer = bridge.answer(&[GET_DATA], &mut bench.bus.clone()).unwrap();
            assert_eq!((answer[1], answer[2]), (0, 0x55));
            fetched += usize::from(answer[3]);
        }
    }
}

/// A bridge with a chip behind it, asked as Linux's driver asks.
struct Asked {
    bench: Bench,
    bridge: Mcp2221,
}

impl Asked {
    fn new() -> Self {
        Self {
            bench: Bench::one(),
            bridge: Mcp2221::default(),
        }
    }

    fn ask(&mut self, report: &[u8]) -> [u8; REPORT] {
        let bus = &mut self.bench.bus.clone();
        self.bridge.answer(report, bus).unwrap()
    }

    /// What the driver concludes from a status report: bit 6 of byte 20, then byte 8.
    fn status(&mut self) -> (bool, u8) {
        let answer = self.ask(&[STATUS]);
        assert_eq!(answer[..2], [STATUS, 0]);
        (answer[20] & 0x40 != 0, answer[8])
    }
}

#[test]
fn a_register_is_written_and_read_through_a_repeated_start() {
    let mut asked = Asked::new();
    let speed = asked.ask(&[STATUS, 0, 0, 0x20, 27]);
    assert_eq!((speed[3], speed[4]), (0x20, 27));
    assert_eq!(
        asked.ask(&[0x90, 2, 0, ADDRESS << 1, map::MODE1, 0x21])[..3],
        [0x90, 0, 0]
    );
    assert_eq!(asked.status(), (false, 0));
    assert_eq!(asked.ask(&[0x94, 1, 0, ADDRESS << 1, map::MODE1])[1], 0);
    assert_eq!(asked.ask(&[0x93, 2, 0, ADDRESS << 1])[1], 0);
    assert_eq!(
        asked.ask(&[GET_DATA])[..6],
        [GET_DATA, 0, 0x55, 2, 0x21, 0x04]
    );
    // Nothing is left.
    assert_eq!(asked.ask(&[GET_DATA])[1], 0x41);
    let log = asked.bench.bus.with(I2cSegment::take_log).unwrap();
    assert_eq!(log.len(), 2, "{log:?}");
    assert_eq!(
        log[1].messages.len(),
        2,
        "one transaction with a repeated START"
    );
}

#[test]
fn a_block_is_fetched_without_being_asked_for() {
    let mut asked = Asked::new();
    asked.ask(&[0x90, 2, 0, ADDRESS << 1, map::MODE1, 0x21]);
    asked.ask(&[0x94, 1, 0, ADDRESS << 1, map::MODE1]);
    assert_eq!(asked.status(), (false, 0));
    let answer = asked.ask(&[GET_DATA]);
    assert_eq!(answer[..6], [GET_DATA, 0, 0x55, 33, 32, 0x21]);
}

#[test]
fn a_long_message_goes_out_when_its_last_chunk_is_there() {
    let mut asked = Asked::new();
    asked.ask(&[0x90, 2, 0, ADDRESS << 1, map::MODE1, 0x21]);
    let mut bytes = vec![map::LED0_ON_L];
    bytes.extend((0..64).map(|n| n & 0x0F));
    for chunk in bytes.chunks(60) {
        assert_eq!(
            asked.bench.bus.with(I2cSegment::take_log).unwrap().len(),
            usize::from(chunk.len() == 60)
        );
        asked.ask(&[&[0x90, 65, 0, ADDRESS << 1], chunk].concat());
    }
    let log = asked.bench.bus.with(I2cSegment::take_log).unwrap();
    assert_eq!(log[0].messages[0].bytes, bytes);
    // Back in two reports, marked alike.
    asked.ask(&[0x94, 1, 0, ADDRESS << 1, map::LED0_ON_L]);
    asked.ask(&[0x93, 64, 0, ADDRESS << 1]);
    let (first, second) = (asked.ask(&[GET_DATA]), asked.ask(&[GET_DATA]));
    assert_eq!(
        (first[2], first[3], second[2], second[3]),
        (0x55, 60, 0x55, 4)
    );
    assert_eq!([&first[4..64], &second[4..8]].concat(), bytes[1..]);
}

#[test]
fn a_missing_chip_is_told_and_then_forgotten() {
    let mut asked = Asked::new();
    asked.ask(&[0x90, 1, 0, 0x41 << 1, 0]);
    assert_eq!(asked.status(), (true, 0x25));
    // The driver sets the speed before the next transfer; an old failure must not spoil that.
    let speed = asked.ask(&[STATUS, 0, 0, 0x20, 27]);
    assert_eq!((speed[8], speed[20]), (0, 0));
    assert_eq!(asked.ask(&[0x91, 1, 0, 0x41 << 1])[1..3], [1, 0x25]);
    let answer = asked.ask(&[GET_DATA]);
    assert_eq!((answer[2], answer[3]), (0x25, 127));
    // hidraw puts a report number in front.
    let mut numbered = [0; REPORT + 1];
    numbered[1..6].copy_from_slice(&[0x90, 1, 0, ADDRESS << 1, 0]);
    assert_eq!(asked.ask(&numbered)[..2], [0x90, 0]);
    assert_eq!(asked.status(), (false, 0));
}
