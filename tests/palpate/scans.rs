//! A scan is never merged from two: what boards truly send, with frames lost in any pattern, against
//! what the skin makes of it.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::sync::LazyLock;

use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::codec::uskin::{Message, Reading, data_frame, decode};
use palpate_core::skin::{Address, CanSkin, Layout, Module as Pad, ModuleScan, SkinSource};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::sensor::board::BoardConfig;
use palpate_emulators::sensor::rig::{Handle, SkinBus};
use palpate_emulators::sensor::{EmulatedModule, ModuleConfig};
use palpate_emulators::time::Nanos;
use proptest::prelude::*;

/// The frames of `boards` on one bus, in order of arrival; x says which scan of its board each is from.
/// Boards tick together, or 0.6 ms apart.
fn sent(boards: u8, apart_us: u64) -> Vec<Received> {
    let mut bus = SkinBus::new(1_000_000);
    for n in 0..boards {
        let module = EmulatedModule::new(ModuleConfig {
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
    let mut frames = Vec::new();
    while let Some(received) = bus.receive().unwrap() {
        let Ok(Message::Data(data)) = decode(&received.frame) else {
            continue;
        };
        let id = received.frame.id();
        let scan = scans.entry(id).or_default();
        *scan += 1;
        let numbered = Reading {
            x: *scan,
            ..data.reading
        };
        let frame = data_frame(id, numbered).unwrap();
        frames.push(Received { frame, ..received });
    }
    frames
}

/// What is left of the frames.
struct Left(VecDeque<Received>);

impl CanBus for Left {
    type Error = Infallible;

    fn receive(&mut self) -> Result<Option<Received>, Infallible> {
        Ok(self.0.pop_front())
    }

    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), Infallible> {
        Ok(())
    }
}

fn skin(boards: u8, gap_us: u64, left: VecDeque<Received>) -> CanSkin<Left> {
    let pad = |board| {
        let pad = Pad::grid(&format!("pad-{board}"), 4, 4, 4.7).unwrap();
        pad.with_address(Address { bus: 0, board }).unwrap()
    };
    let layout = Layout::new((0..boards).map(pad).collect()).unwrap();
    CanSkin::new(&layout, Left(left)).with_gap(Duration::from_micros(gap_us))
}

/// Makes scans of what is left after losing and doubling frames; returns those that hold readings of two.
fn merged(frames: &[Received], boards: u8, gap_us: u64, pattern: &[(usize, usize, bool)]) -> usize {
    let (mut left, mut at) = (VecDeque::new(), 0);
    for &(kept, lost, twice) in pattern.iter().cycle() {
        for frame in frames.iter().skip(at).take(kept) {
            left.extend(std::iter::repeat_n(*frame, 1 + usize::from(twice)));
        }
        at += kept + lost;
        if at >= frames.len() {
            break;
        }
    }
    let mut wrong = 0;
    let mut take = |scan: &ModuleScan<'_>| {
        let taxels = scan.counts.iter().zip(scan.fresh.unwrap());
        let mut numbers: Vec<u16> = taxels.filter(|t| *t.1).map(|t| t.0[0]).collect();
        numbers.dedup();
        wrong += usize::from(numbers.len() > 1);
    };
    let mut skin = skin(boards, gap_us, left);
    skin.scans(Instant::FAR_FUTURE, &mut take).unwrap();
    wrong
}

/// Boards, the gap that a run gives them, what they send.
static SENT: LazyLock<Vec<(u8, u64, Vec<Received>)>> = LazyLock::new(|| {
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
        let (boards, gap_us, frames) = &SENT[bus];
        prop_assert_eq!(merged(frames, *boards, *gap_us, &pattern), 0);
    }

    #[test]
    fn no_scan_is_merged_from_two_under_random_loss(
        bus in 0usize..4,
        pattern in prop::collection::vec((0usize..3, 0usize..3, Just(false)), 60..200),
    ) {
        prop_assume!(pattern.iter().any(|p| p.0 + p.1 > 0));
        let (boards, gap_us, frames) = &SENT[bus];
        prop_assert_eq!(merged(frames, *boards, *gap_us, &pattern), 0);
    }
}

#[test]
fn without_loss_every_scan_is_whole() {
    for (boards, gap_us, frames) in SENT.iter() {
        let mut skin = skin(*boards, *gap_us, frames.iter().copied().collect());
        let mut scans = 0;
        // No time passes after the last frame: what it leaves unfinished stays so.
        skin.scans(Instant::ZERO, &mut |_| scans += 1).unwrap();
        assert_eq!((skin.lost(), skin.foreign()), (0, 0), "{boards} boards");
        assert!(scans >= u64::from(*boards) * 14);
    }
}
