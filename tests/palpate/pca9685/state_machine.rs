//! Random traffic against the reference model: every acknowledge, every byte read, every edge, every
//! register. A transition is one thing that happens to the chip: a bus condition, a byte, time, OE, power.

use std::cell::Cell;

use proptest::prelude::*;
use proptest::test_runner::{Config as Runner, TestRunner};

use super::reference::Reference;
use super::*;

/// Cases and what each holds: a million transitions and more, counted below.
const CASES: u32 = 1500;

#[derive(Clone, Debug)]
enum Op {
    /// One write transaction, or the beginning of one that a repeated START follows.
    Write {
        address: u8,
        bytes: Vec<u8>,
        stop: bool,
    },
    Read {
        address: u8,
        count: u8,
    },
    Wait(u64),
    OutputEnable(bool),
    PowerCycle,
}

fn address() -> impl Strategy<Value = u8> {
    prop_oneof![
        20 => Just(0x40),
        2 => Just(0x70),
        1 => prop_oneof![Just(0x71), Just(0x72), Just(0x74), Just(0x33)],
        1 => 1..0x80_u8,
    ]
}

fn count_bytes() -> impl Strategy<Value = [u8; 2]> {
    // Small, large, edges of the counter, and the full bit.
    let count = prop_oneof![
        Just(0_u16),
        Just(1),
        Just(4095),
        Just(0x1000),
        0..4096_u16,
        any::<u16>()
    ];
    count.prop_map(u16::to_le_bytes)
}

fn led_write() -> impl Strategy<Value = Vec<u8>> {
    (0..16_u8, count_bytes(), count_bytes(), 0..5_usize).prop_map(|(n, on, off, lost)| {
        let mut bytes = vec![map::led(n), on[0], on[1], off[0], off[1]];
        bytes.truncate(if lost == 0 { 3 } else { 5 });
        bytes
    })
}

fn message() -> impl Strategy<Value = Vec<u8>> {
    let mode1 = prop_oneof![
        6 => Just(0x21_u8),
        3 => Just(0x31),
        4 => Just(0xA1),
        1 => Just(0x2F),
        2 => any::<u8>().prop_map(|b| b & !0x40),
    ];
    prop_oneof![
        12 => led_write(),
        3 => mode1.prop_map(|v| vec![map::MODE1, v]),
        2 => any::<u8>().prop_map(|v| vec![map::MODE2, v]),
        1 => Just(vec![map::MODE2, 0x04]),
        1 => (3..6_u8).prop_map(|v| vec![map::PRE_SCALE, v]),
        1 => (2..6_u8, any::<u8>()).prop_map(|(r, v)| vec![r, v]),
        2 => (count_bytes(), count_bytes())
            .prop_map(|(on, off)| vec![map::ALL_LED_ON_L, on[0], on[1], off[0], off[1]]),
        1 => Just(vec![map::ALL_LED_OFF_H, 0x10]),
        1 => (any::<u8>(), prop::collection::vec(0..0x40_u8, 0..12)).prop_map(|(r, mut v)| {
            v.insert(0, r);
            // Not into a huge PRE_SCALE: the reference walks every tick.
            if r >= map::ALL_LED_ON_L { v.truncate(4); }
            if r == map::PRE_SCALE { v.truncate(1); }
            v
        }),
    ]
}

fn op() -> impl Strategy<Value = Op> {
    prop_oneof![
        12 => (address(), message(), prop::bool::weighted(0.9))
            .prop_map(|(address, bytes, stop)| Op::Write { address, bytes, stop }),
        1 => prop_oneof![4 => Just(vec![6]), 1 => prop::collection::vec(5..8_u8, 0..3)]
            .prop_map(|bytes| Op::Write { address: 0, bytes, stop: true }),
        3 => (address(), 0..6_u8).prop_map(|(address, count)| Op::Read { address, count }),
        6 => (0..60_000_u64).prop_map(Op::Wait),
        2 => (0..1_500_000_u64).prop_map(Op::Wait),
        1 => any::<bool>().prop_map(Op::OutputEnable),
        1 => prop::bool::weighted(0.1).prop_map(|off| if off { Op::PowerCycle } else { Op::Wait(1) }),
    ]
}

/// Both models under the same traffic.
struct Pair {
    chip: Pca9685,
    reference: Reference,
    t: u64,
    bit: u64,
    transitions: u64,
}

impl Pair {
    fn new(oscillator: u32, updates: UpdateModel, bit: u64) -> Self {
        let mut config = Config::new(0x40);
        config.oscillator = Oscillator::from_hz(oscillator);
        config.updates = updates;
        let mut pair = Self {
            chip: Pca9685::new(config),
            reference: Reference::new(0x40, u64::from(oscillator), updates),
            t: 0,
            bit,
            transitions: 0,
        };
        // A fast counter and awake, or little would happen in a case.
        for bytes in [[map::PRE_SCALE, 3], [map::MODE1, 0x21]] {
            pair.write(0x40, &bytes);
            pair.stop();
        }
        pair
    }

    fn after(&mut self, bits: u64) -> Nanos {
        self.t += bits * self.bit;
        self.transitions += 1;
        Nanos(self.t)
    }

    fn start(&mut self, address: u8, read: bool) -> bool {
        let at = self.after(10);
        let acknowledged = self.chip.start(at, address, read);
        assert_eq!(
            acknowledged,
            self.reference.start(at.0, address, read),
            "address {address:02x}"
        );
        acknowledged
    }

    fn write(&mut self, address: u8, bytes: &[u8]) {
        if self.start(address, false) {
            for &byte in bytes {
                let at = self.after(9);
                let acknowledged = self.chip.write(at, byte);
                assert_eq!(
                    acknowledged,
                    self.reference.write(at.0, byte),
                    "byte {byte:02x}"
                );
                if !acknowledged {
                    break;
                }
            }
        }
    }

    fn stop(&mut self) {
        let at = self.after(1);
        self.chip.stop(at);
        self.reference.stop(at.0);
    }

    fn apply(&mut self, op: &Op) {
        match op {
            Op::Write {
                address,
                bytes,
                stop,
            } => {
                self.write(*address, bytes);
                if *stop {
                    self.stop();
                }
            }
            Op::Read { address, count } => {
                if self.start(*address, true) {
                    for _ in 0..*count {
                        let at = self.after(9);
                        assert_eq!(self.chip.read(at), self.reference.read(at.0));
                    }
                }
                self.stop();
            }
            Op::Wait(ns) => {
                self.t += ns;
                self.transitions += 1;
            }
            Op::OutputEnable(high) => {
                let at = self.after(0);
                self.chip.set_output_enable_pin(at, *high);
                self.reference.set_oe(at.0, *high);
            }
            Op::PowerCycle => {
                let at = self.after(0);
                self.chip.power_cycle(at);
                self.reference.power_cycle(at.0);
            }
        }
        self.compare();
    }

    fn compare(&mut self) {
        let mut edges = Vec::new();
        let mut sink = |e: Edge| edges.push((e.at.0, e.channel.0, e.pin));
        self.chip.advance(Nanos(self.t), &mut sink);
        self.reference.pass(self.t);
        assert_eq!(edges, std::mem::take(&mut self.reference.edges));
        for register in 0..=255 {
            let is = self.chip.register(register);
            assert_eq!(
                is,
                self.reference.reg[usize::from(register)],
                "register {register:02x}"
            );
        }
    }
}

#[test]
fn a_million_random_transitions_agree_with_the_reference_model() {
    let total = Cell::new(0);
    let oscillator = prop_oneof![
        Just(25_000_000_u32),
        Just(23_000_000),
        Just(27_400_000),
        23_000_000..27_400_000_u32
    ];
    let updates = prop_oneof![Just(UpdateModel::EndOfLow), Just(UpdateModel::Immediate)];
    let bit = prop_oneof![Just(2_500_u64), Just(1_000)];
    let ops = prop::collection::vec(op(), 180..220);
    let mut runner = TestRunner::new_with_rng(
        Runner {
            cases: CASES,
            failure_persistence: None,
            ..Runner::default()
        },
        proptest::test_runner::TestRng::deterministic_rng(
            proptest::test_runner::RngAlgorithm::ChaCha,
        ),
    );
    runner
        .run(
            &(oscillator, updates, bit, ops),
            |(oscillator, updates, bit, ops)| {
                let mut pair = Pair::new(oscillator, updates, bit);
                for op in &ops {
                    pair.apply(op);
                }
                total.set(total.get() + pair.transitions);
                Ok(())
            },
        )
        .unwrap();
    assert!(total.get() >= 1_000_000, "only {} transitions", total.get());
}

proptest! {
    #![proptest_config(Runner { cases: 200, failure_persistence: None, ..Runner::default() })]

    /// Looking more often changes nothing: skipping quiet ticks is a shortcut, this is the long way.
    #[test]
    fn edges_do_not_depend_on_how_often_one_looks(
        ops in prop::collection::vec(op(), 1..60),
        looks in prop::collection::vec(1..3_000_000_u64, 0..40),
    ) {
        let mut lazy = Pair::new(26_543_210, UpdateModel::EndOfLow, 1_000);
        for op in &ops {
            lazy.apply(op);
        }
        let mut eager = lazy.chip.clone();
        let (mut a, mut b, mut t) = (Vec::new(), Vec::new(), lazy.t);
        for look in looks {
            t += look;
            eager.advance(Nanos(t), &mut |e| a.push(e));
        }
        lazy.chip.advance(Nanos(t), &mut |e| b.push(e));
        prop_assert_eq!(a, b);
        prop_assert_eq!(eager.next_event(), lazy.chip.next_event());
    }
}
