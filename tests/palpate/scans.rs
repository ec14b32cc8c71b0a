//! A scan is never merged from two: what boards truly send, with frames lost in any pattern, against
//! what the assembler makes of it.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use palpate_core::bus::SensorBus;
use palpate_core::skin::{Layout, Module as Pad, Reading, ScanAssembler};
use palpate_core::units::Duration;
use palpate_core::wire::uskin::{IdProfile, Message, Wiring, decode};
use palpate_emulators::board::BoardConfig;
use palpate_emulators::rig::{Handle, SkinBus};
use palpate_emulators::skin::{Module, ModuleConfig};
use palpate_emulators::time::Nanos;
use proptest::prelude::*;

/// The readings of `boards` on one bus, in order of arrival; x says which scan of its board each is from.
/// Boards tick together, or 0.6 ms apart.
fn sent(boards: u8, apart_us: u64) -> Vec<Reading> {
    let mut bus = SkinBus::new(1_000_000);
    for n in 0..boards {
        let module = Module::new(ModuleConfig {
            number: usize::from(n),
            ..ModuleConfig::default()
        });
        let config = BoardConfig {
            address: n,
            autostart: true,
            phase: Nanos::from_micros(apart_us * u64::from(n)),
            ..BoardConfig::default()
        };
        bus.add_board(config, vec![module]).unwrap();
    }
    let mut bus = Handle::new(vec![bus]);
    bus.advance(Nanos::from_micros(450_000));
    let mut scans: BTreeMap<u16, u16> = BTreeMap::new();
    let mut readings = Vec::new();
    while let Some(received) = bus.receive().unwrap() {
        let Ok(Message::Data(data)) = decode(IdProfile::Current, &received.frame) else {
            continue;
        };
        let scan = scans.entry(received.frame.id()).or_default();
        *scan += 1;
        readings.push(Reading {
            module: u16::from(data.board.unwrap()),
            taxel: Wiring::FLAT.taxel(data.place).unwrap().1 as u32,
            order: Wiring::FLAT.order(data.place).unwrap() as u32,
            counts: [*scan, data.reading.y, data.reading.z],
            at: received.at,
        });
    }
    readings
}

fn skin(boards: u8) -> Layout {
    let pad = |n| Pad::grid(&format!("pad-{n}"), 4, 4, 4.7).unwrap();
    Layout::new((0..boards).map(pad).collect()).unwrap()
}

/// Assembles what is left after losing and doubling frames; returns the scans that hold readings of two.
fn merged(
    readings: &[Reading],
    boards: u8,
    gap_us: u64,
    pattern: &[(usize, usize, bool)],
) -> usize {
    let layout = skin(boards);
    let mut assembler = ScanAssembler::new(&layout, Duration::from_micros(gap_us));
    let mut wrong = 0;
    let mut at = 0;
    for &(kept, lost, twice) in pattern.iter().cycle() {
        let run = readings.iter().skip(at).take(kept);
        for reading in run {
            for _ in 0..=usize::from(twice) {
                let done = |scan: &palpate_core::skin::Scan, module: u16| {
                    let fresh = layout
                        .range(usize::from(module))
                        .filter(|&i| scan.fresh()[i]);
                    let mut numbers: Vec<u16> = fresh.map(|i| scan.counts()[i][0]).collect();
                    numbers.dedup();
                    wrong += usize::from(numbers.len() > 1);
                };
                assembler.push(reading, done).unwrap();
            }
        }
        at += kept + lost;
        if at >= readings.len() {
            break;
        }
    }
    wrong
}

/// Boards, the gap that a run gives them, what they send.
static SENT: LazyLock<Vec<(u8, u64, Vec<Reading>)>> = LazyLock::new(|| {
    vec![
        (1, 4_000, sent(1, 0)),
        (4, 4_000, sent(4, 0)),
        (4, 4_000, sent(4, 600)),
        (15, 21_060, sent(15, 0)),
    ]
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]
    #[test]
    fn no_scan_is_merged_from_two_whatever_is_lost(
        bus in 0usize..4,
        pattern in prop::collection::vec((1usize..40, 0usize..80, prop::bool::weighted(0.1)), 1..60),
    ) {
        let (boards, gap_us, readings) = &SENT[bus];
        prop_assert_eq!(merged(readings, *boards, *gap_us, &pattern), 0);
    }

    #[test]
    fn no_scan_is_merged_from_two_under_random_loss(
        bus in 0usize..4,
        pattern in prop::collection::vec((0usize..3, 0usize..3, Just(false)), 60..200),
    ) {
        prop_assume!(pattern.iter().any(|p| p.0 + p.1 > 0));
        let (boards, gap_us, readings) = &SENT[bus];
        prop_assert_eq!(merged(readings, *boards, *gap_us, &pattern), 0);
    }
}

#[test]
fn without_loss_every_scan_is_whole() {
    for (boards, gap_us, readings) in SENT.iter() {
        let layout = skin(*boards);
        let mut assembler = ScanAssembler::new(&layout, Duration::from_micros(*gap_us));
        for reading in readings {
            assembler.push(reading, |_, _| {}).unwrap();
        }
        assert_eq!(assembler.lost(), 0, "{boards} boards");
        assert!(assembler.scans() >= u64::from(*boards) * 14);
    }
}
