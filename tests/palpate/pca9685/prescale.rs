//! What a change of PRE_SCALE costs in the midst of pulses: how long none comes, and how close two come.

use super::*;

/// Pulses of 100 ticks at PRE = 30 until a change to `pre` begins `phase_ns` into a period; the time from the last
/// rising edge before it to the first one after it, ns.
fn across(pre: u8, phase_ns: u64) -> u64 {
    let mut bench = Bench::awake();
    bench.channel(0, 0, 100);
    bench.wait_ns(3 * PERIOD);
    let rises = |bench: &mut Bench| -> Vec<u64> {
        let edges = bench.take(0);
        edges.iter().filter(|e| e.1).map(|e| e.0).collect()
    };
    let start = *rises(&mut bench).last().unwrap() + 2 * PERIOD;
    bench.wait_ns(start + phase_ns - bench.now());
    let begun = bench.now();
    bench.write(&[map::MODE1, 0x31]); // SLEEP
    bench.write(&[map::PRE_SCALE, pre]);
    bench.write(&[map::MODE1, 0x21]);
    bench.wait_us(500);
    bench.write(&[map::MODE1, 0xA1]); // RESTART
    assert_eq!(bench.read(map::PRE_SCALE), pre);
    bench.wait_ns(1_000_000);
    let rises = rises(&mut bench);
    let after = *rises.iter().find(|at| **at > begun).unwrap();
    after - rises.iter().rev().find(|at| **at <= begun).unwrap()
}

/// Four writes of two bytes to a chip at 400 kbit/s, START to STOP, and 500 us: what docs/texture.md states.
const COST: u64 = 4 * 72_500 + 500_000;

#[test]
fn a_change_costs_less_than_800_us_beyond_a_period_and_its_phase() {
    let phase = |n: u64| 200_000 + n * (PERIOD - 200_000) / 64;
    for pre in [3, 15, 30, 121, 255] {
        let gaps: Vec<u64> = (0..64).map(|n| across(pre, phase(n))).collect();
        let (least, most) = (gaps.iter().min().unwrap(), gaps.iter().max().unwrap());
        println!("PRE {pre}: {least} to {most} ns between two pulses, a period is {PERIOD}");
        assert!(*most <= PERIOD + COST, "{pre}: {most}");
        // The other side of it: a pulse may come long before its period is over, which no guard has reckoned with.
        assert!(*least < PERIOD / 4, "{pre}: {least}");
    }
}
