//! Sessions in virtual time: a host that plays, dies or lies, a bus that stands still, datagrams from anywhere.

use palpate_core::codec::link::{MOST, State};
use palpate_core::guard::Cause;
use palpate_core::random::RandomStream;
use palpate_core::units::Duration;
use palpate_emulators::time::Nanos;
use palpate_qemu::{Lockstep, Machine};

use super::machines::{in_qemu, met};

/// Length of the bursts.
const BURST: Duration = Duration::from_millis(38);
/// A PWM period at the nominal clock and PRE_SCALE 30, ns.
const PERIOD: u64 = 5_080_000;

in_qemu! {
    a_session_plays_on_time
    runs_repeat_to_the_nanosecond
    a_dead_host_leaves_nothing_on_100_ms_after_its_last_reading
    a_skin_that_is_silent_switches_off_100_ms_after_its_last_reading
    a_unit_that_hangs_is_reset_within_the_burst_and_switches_off_first
    a_bus_that_dies_is_cut_and_comes_back
    ten_thousand_spoiled_datagrams_switch_nothing_on
}

/// A genuine I2C driver, a genuine port over USB and a genuine watchdog, at a fourteenth of real time: what they add is
/// tried, no more.
mod pico {
    use crate::machines::PICO;

    #[test]
    fn a_session_plays_on_time() {
        super::a_session_plays_on_time(PICO);
    }

    #[test]
    fn a_bus_that_dies_is_cut_and_comes_back() {
        super::a_bus_that_dies_is_cut_and_comes_back(PICO);
    }

    #[test]
    fn a_dead_host_leaves_nothing_on_100_ms_after_its_last_reading() {
        super::a_dead_host_leaves_nothing_on_100_ms_after_its_last_reading(PICO);
    }

    #[test]
    fn a_unit_that_hangs_is_reset_within_the_burst_and_switches_off_first() {
        super::a_unit_that_hangs_is_reset_within_the_burst_and_switches_off_first(PICO);
    }
}

fn ms(n: u64) -> Duration {
    Duration::from_millis(n)
}

/// A burst of two wires on each board, 70 ms apart, `count` times. Returns how many the host's guard passed.
pub fn play(run: &mut Lockstep, count: u16) -> u32 {
    let mut passed = 0;
    for n in 0..count {
        let wires = [n % 8, (n + 3) % 8];
        passed += run.host.burst(0, &wires, 100, BURST).unwrap();
        passed += run
            .host
            .burst(1, &wires.map(|w| 8 + w), 100, BURST)
            .unwrap();
        run.run(ms(70)).unwrap();
    }
    passed
}

fn a_session_plays_on_time(machine: Machine) {
    let mut run = met(machine, true);
    let from = run.now();
    assert_eq!(run.host.burst(0, &[3], 100, BURST), Ok(1));
    run.run(ms(120)).unwrap();
    let levels = &run.chips.levels;
    assert!(levels.iter().all(|l| l.board == 0 && l.channel.0 == 3));
    // From 20 ms after the onset, as long as was asked for: at most a period late, to begin and to end.
    let (first, last) = (
        levels[0].at.0 - from.0,
        levels[levels.len() - 1].at.0 - from.0,
    );
    assert!(
        (20_000_000..20_000_000 + 2 * PERIOD).contains(&first),
        "{first}"
    );
    assert!(
        (58_000_000 - PERIOD..58_000_000 + PERIOD).contains(&last),
        "{last}"
    );
    let passed = play(&mut run, 20);
    assert!(passed > 70, "{passed}");
    let status = run.host.driver.status().unwrap();
    assert_eq!(
        (status.state, status.stops),
        (State::Ready, 0),
        "{status:?}"
    );
    assert_eq!(
        (status.applied, status.limited, status.dropped),
        (1 + passed, 0, 0),
        "{status:?}"
    );
    assert!(u64::from(status.late_us) * 1000 < PERIOD, "{status:?}");
    println!("latest beginning after its time: {} us", status.late_us);
}

fn runs_repeat_to_the_nanosecond(machine: Machine) {
    let played = |disturbed| {
        let mut run = met(machine, true);
        run.disturbed = disturbed;
        play(&mut run, 10);
        (run.chips.transfers, run.chips.levels)
    };
    let (one, other) = (played(false), played(true));
    assert!(one.0.len() > 50 && one.1.len() > 200);
    assert_eq!(one, other);
}

fn a_dead_host_leaves_nothing_on_100_ms_after_its_last_reading(machine: Machine) {
    let mut s = RandomStream::new(1, "deaths of hosts");
    for death in 0..4u64 {
        let mut run = met(machine, death % 2 == 0);
        play(&mut run, 3);
        assert_eq!(
            run.host.burst(0, &[6 + (death % 2) as u16], 100, ms(48)),
            Ok(1)
        );
        run.run(Duration::from_micros(22_000 + s.next_u64() % 20_000))
            .unwrap();
        let died = run.now();
        run.host.lives = false;
        run.run(ms(400)).unwrap();
        let last = run.chips.last_high(run.now()).unwrap();
        assert!(last > died, "{death}: nothing was on");
        assert!(
            last.since(died) <= Nanos(100_000_000),
            "{death}: {last:?} {died:?}"
        );
        assert!(!run.chips.any_high());
    }
}

fn a_skin_that_is_silent_switches_off_100_ms_after_its_last_reading(machine: Machine) {
    let mut run = met(machine, true);
    play(&mut run, 2);
    let silent = run.now();
    run.host.reads = false;
    // Wire after wire: the burst row alone would let them go on.
    for n in 0..20 {
        let _ = run.host.burst(0, &[n % 8], 100, BURST);
        run.run(ms(15)).unwrap();
    }
    let last = run.chips.last_high(run.now()).unwrap().since(silent).0;
    assert!((60_000_000..=100_000_000).contains(&last), "{last}");
    let state = run.host.driver.status().unwrap().state;
    assert_eq!(state, State::Stopped(Cause::StaleInput));
}

fn a_unit_that_hangs_is_reset_within_the_burst_and_switches_off_first(machine: Machine) {
    for oe in [false, true] {
        let mut run = met(machine, oe);
        play(&mut run, 2);
        assert_eq!(run.host.burst(0, &[5], 100, ms(48)), Ok(1));
        run.run(ms(24)).unwrap();
        assert!(
            run.chips
                .levels
                .last()
                .is_some_and(|l| run.now().since(l.at).0 < PERIOD)
        );
        // The next transfer never ends: no output is switched off by the program.
        run.chips.stuck = true;
        assert_eq!(run.host.burst(1, &[15], 60, BURST), Ok(1));
        run.run(ms(300)).unwrap();
        let [_, again] = run.chips.boots[..] else {
            panic!("{oe}: {:?}", run.chips.boots);
        };
        let hung = *run.chips.transfers.iter().rfind(|t| **t < again).unwrap();
        let bitten = again.since(hung).0;
        assert!(
            (20_000_000..=41_000_000).contains(&bitten),
            "{oe}: {bitten}"
        );
        // What was on goes off at the first transfer of the new start, or with the OE line before.
        let last = run.chips.last_high(run.now()).unwrap();
        assert!(
            last.since(again) <= Nanos(2_000_000),
            "{oe}: {last:?}, {again:?}"
        );
        println!(
            "OE wired: {oe}; reset {} us after the hang, off after {} us",
            bitten / 1000,
            last.since(hung).0 / 1000
        );
        // The host finds it again and plays on.
        run.run(ms(400)).unwrap();
        assert_eq!(run.host.driver.ready(run.host.now()), Ok(()));
        let before = run.chips.levels.len();
        play(&mut run, 2);
        assert!(run.chips.levels.len() > before);
    }
}

fn a_bus_that_dies_is_cut_and_comes_back(machine: Machine) {
    let mut run = met(machine, true);
    play(&mut run, 2);
    assert_eq!(run.host.burst(0, &[5], 100, ms(48)), Ok(1));
    run.run(ms(24)).unwrap();
    run.chips.dead = true;
    run.run(ms(50)).unwrap();
    assert!(!run.chips.any_high());
    let state = run.host.driver.status().unwrap().state;
    assert_eq!(state, State::Stopped(Cause::ActuatorError));
    run.chips.dead = false;
    run.run(ms(100)).unwrap();
    let before = run.chips.levels.len();
    play(&mut run, 2);
    assert!(run.chips.levels.len() > before);
    assert_eq!(run.chips.boots.len(), 1);
}

/// What a datagram may become on its way, or in the hands of a person who means harm.
pub fn spoil(s: &mut RandomStream, datagram: &mut Vec<u8>) {
    let length = datagram.len();
    let mut pick = |n: usize| (s.next_u64() % n as u64) as usize;
    match pick(4) {
        0 => datagram[pick(length)] ^= 1 << pick(8),
        1 => datagram.truncate(pick(length)),
        2 => datagram.extend(vec![0x55; 1 + pick(40)]),
        _ => {
            let from = pick(length);
            datagram[from..]
                .iter_mut()
                .for_each(|b| *b = pick(256) as u8);
        }
    }
    datagram.truncate(MOST);
}

fn ten_thousand_spoiled_datagrams_switch_nothing_on(machine: Machine) {
    let mut run = met(machine, true);
    play(&mut run, 10);
    run.run(ms(100)).unwrap();
    run.host.lives = false;
    run.run(ms(100)).unwrap();
    let recorded = std::mem::take(&mut run.host.sent);
    let (quiet, applied) = (
        run.chips.levels.len(),
        run.host.driver.status().unwrap().applied,
    );
    let mut s = RandomStream::new(1, "spoiled datagrams");
    for n in 0..10_000u64 {
        let mut datagram = recorded[(s.next_u64() as usize) % recorded.len()].clone();
        if n % 3 > 0 {
            spoil(&mut s, &mut datagram);
        }
        run.host.injected.push_back(datagram);
    }
    while !run.host.injected.is_empty() {
        run.run(ms(10)).unwrap();
    }
    assert_eq!(
        run.chips.boots.len(),
        1,
        "a datagram crashed it, or took too long"
    );
    assert_eq!(run.chips.levels.len(), quiet);
    run.host.lives = true;
    run.run(ms(700)).unwrap();
    assert_eq!(run.host.driver.ready(run.host.now()), Ok(()));
    let status = run.host.driver.status().unwrap();
    assert_eq!(status.applied, applied);
    assert!(status.refused > 5_000, "{status:?}");
}
