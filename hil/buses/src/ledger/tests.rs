//! Accounts from run to run: what a death leaves booked, what a clean end does, and what is not known.

use std::fs;

use palpate_core::guard::{HARD, Plant, Used, WireMemory, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Point, Ticks};

use super::*;
use crate::pacer::RunClock;

/// Accounts of a test, gone with it.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let name = format!("palpate-ledger-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&folder);
        Self(folder)
    }

    /// A run of a fingertip with wires on these channels of a piece of hardware.
    fn ledger(&self, hardware: &str, channels: &[u8], wearer: &str) -> Result<Ledger, LedgerError> {
        let (hardware, wearer) = ([hardware.to_owned()], [wearer.to_owned()]);
        let names = (&hardware[..], &wearer[..]);
        Ledger::open(&self.0, names, vec![fingertip(channels)])
    }

    fn used(&self, hardware: &str, channels: &[u8], wearer: &str) -> Used {
        used(&self.ledger(hardware, channels, wearer).unwrap().memory(0))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn fingertip(channels: &[u8]) -> Fingertip {
    let wire = |channel: &u8| {
        let output = Output {
            bus: 0,
            board: 0x40,
            channel: *channel,
        };
        (0, output)
    };
    Fingertip {
        wires: channels.iter().map(wire).collect(),
        wearer: Some(0),
    }
}

fn guard(wires: usize) -> Guard {
    let wire = |channel: u8| DisplayWire {
        place: Point::new(f32::from(channel), 0.0),
        board: Board(0),
        channel: Channel(channel),
    };
    let wires: Vec<_> = (0..wires as u8).map(wire).collect();
    Guard::new(HARD, Plant::default(), &wires, WornWire::default()).unwrap()
}

fn used(memory: &Memory) -> Used {
    let mut guard = guard(memory.wires.len());
    guard.remember(memory, Instant::ZERO).unwrap();
    guard.used(Instant::ZERO)
}

const fn ms(ms: u64) -> Instant {
    Instant::from_micros(1000 * ms)
}

/// Drives the first wire so often.
fn drive(guard: &mut Guard, bursts: u64) -> Instant {
    for n in 0..bursts {
        let at = ms(117 * n);
        let stimulus = Stimulus {
            wire: 0,
            width: Ticks::new(60),
            peak: guard.plant().peak,
            at,
            until: at + Duration::from_millis(35),
        };
        let _ = guard.change(at, Board(0), &[stimulus], |_| {});
        let _ = guard.expire(stimulus.until, Board(0));
    }
    ms(117 * bursts)
}

#[test]
fn a_clean_end_books_what_came_true() {
    let place = Place::new("clean");
    let ledger = place.ledger("bench", &[0, 1], "wearer").unwrap();
    let cold = used(&ledger.memory(0));
    assert!(cold.skin_peak < 1e-9 && cold.cem43 < 1e-9, "{cold:?}");
    let mut first = guard(2);
    let keeper = ledger.keep(&[(Instant::ZERO, &first)]).unwrap();
    let end = drive(&mut first, 40);
    keeper.end(&[(end, &first)], true).unwrap();
    let (kept, true_one) = (place.used("bench", &[0, 1], "wearer"), first.used(end));
    assert!(kept.skin_mean > 0.1, "{kept:?}");
    assert!(
        (true_one.omega..2.0 * true_one.omega).contains(&kept.omega),
        "{kept:?} {true_one:?}"
    );
    // Nor do more of them begin anew.
    for _ in 0..5 {
        let ledger = place.ledger("bench", &[0, 1], "wearer").unwrap();
        let mut next = guard(2);
        next.remember(&ledger.memory(0), Instant::ZERO).unwrap();
        let before = next.used(Instant::ZERO);
        let keeper = ledger.keep(&[(Instant::ZERO, &next)]).unwrap();
        let end = drive(&mut next, 10);
        keeper.end(&[(end, &next)], true).unwrap();
        let after = place.used("bench", &[0, 1], "wearer");
        assert!(after.omega > before.omega, "{after:?} {before:?}");
    }
}

#[test]
fn a_death_leaves_the_reserve_booked() {
    let place = Place::new("death");
    let first = guard(1);
    let keeper = place.ledger("bench", &[3], "wearer").unwrap();
    let keeper = keeper.keep(&[(Instant::ZERO, &first)]).unwrap();
    // Nobody says how it ended.
    drop(keeper);
    // Its thread lets go of the files.
    let next = place.ledger("bench", &[3], "wearer").unwrap();
    drop(next.keep(&[(Instant::ZERO, &first)]).unwrap());
    let kept = place.used("bench", &[3], "wearer");
    let reserve = first.reserve(Instant::ZERO, Duration::from_millis(4000));
    assert!((kept.cem43 - reserve.doses().cem43_min / 2.0).abs() < 1e-12);
    assert!(
        kept.wire_power > 0.999 && kept.fingertip_power > 0.999,
        "{kept:?}"
    );
    // Outputs that are not known to be off book more than what came true.
    let place = Place::new("unknown");
    let ledger = place.ledger("bench", &[3], "wearer").unwrap();
    let keeper = ledger.keep(&[(Instant::ZERO, &first)]).unwrap();
    keeper.end(&[(ms(10), &first)], false).unwrap();
    assert!(place.used("bench", &[3], "wearer").wire_power > 0.999);
}

#[test]
fn dose_is_a_wearer_s_and_heat_the_hardware_s() {
    let place = Place::new("whose");
    let ledger = place.ledger("one", &[0, 1], "anna").unwrap();
    let mut first = guard(2);
    let keeper = ledger.keep(&[(Instant::ZERO, &first)]).unwrap();
    let end = drive(&mut first, 40);
    keeper.end(&[(end, &first)], true).unwrap();
    // Other hardware is cold, and its wearer is not new.
    let other = place.used("two", &[5], "anna");
    let dose = first.memory(end).doses().omega / 0.01;
    assert!(
        other.skin_mean < 1e-9 && (other.omega - dose).abs() < 1e-9,
        "{other:?}"
    );
    // The same hardware is warm for another wearer.
    let warm = place.used("one", &[0, 1], "bert");
    assert!(warm.skin_mean > 0.1 && warm.omega < 0.5 * dose, "{warm:?}");
    // Its wires are known one by one, in any bench.
    let turned = place.ledger("one", &[1, 7, 0], "bert").unwrap().memory(0);
    assert!(turned.wires[2].energy_j[0] > 0.0 && turned.wires[0].energy_j[0] <= 0.0);
    // What another bench of it drives leaves the others as they were.
    let ledger = place.ledger("one", &[7], "bert").unwrap();
    let keeper = ledger.keep(&[(Instant::ZERO, &guard(1))]).unwrap();
    keeper.end(&[(ms(1), &guard(1))], true).unwrap();
    let again = place.ledger("one", &[1, 7, 0], "bert").unwrap().memory(0);
    assert!(again.wires[2].energy_j[0] > 0.0);
}

#[test]
fn fingertips_that_became_one_have_spent_what_both_had() {
    let place = Place::new("tips");
    let mut ledger = place.ledger("bench", &[0, 1, 2, 3], "wearer").unwrap();
    let uptime = Uptime { boot: 5, us: 1000 };
    let tip = |pj, us| Spent {
        pj,
        ago: Duration::from_micros(us),
    };
    let kept = |channel, tip, face_k| Kept {
        output: fingertip(&[channel]).wires[0].1,
        uptime,
        wire: WireMemory::default(),
        tip,
        face_k,
    };
    ledger.hardware[0].1 = vec![
        kept(0, tip(70, 30), 0.0),
        kept(1, tip(70, 30), 1.5),
        kept(3, tip(8, 20), 0.5),
    ];
    let memory = ledger.memory_at(0, uptime.after(Duration::from_micros(5)));
    assert_eq!(memory.tip, tip(78, 25));
    assert!((memory.face_k - 1.5).abs() < 1e-12);
    let all = tip(u64::MAX, 0);
    ledger.hardware[0].1.push(kept(2, all, 0.0));
    assert_eq!(ledger.memory_at(0, uptime).tip, all);
}

#[test]
fn nothing_cools_in_a_time_that_is_not_known() {
    let place = Place::new("time");
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    let mut first = guard(1);
    let keeper = ledger.keep(&[(Instant::ZERO, &first)]).unwrap();
    let end = drive(&mut first, 40);
    keeper.end(&[(end, &first)], true).unwrap();
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    let kept = ledger.hardware[0].1[0].uptime;
    let at = |uptime| used(&ledger.memory_at(0, uptime));
    let now = at(kept);
    assert!(at(kept.after(Duration::from_millis(60_000))).skin_peak < 0.1 * now.skin_peak);
    let another = Uptime {
        boot: kept.boot ^ 1,
        us: kept.us + 60_000_000,
    };
    assert_eq!(at(another), now);
    let back = Uptime {
        us: kept.us - 1,
        ..kept
    };
    assert_eq!(at(back), now);
}

#[test]
fn what_cannot_be_read_is_refused_until_it_is_forgotten() {
    let place = Place::new("unreadable");
    let first = guard(1);
    let end = |keeper: Keeper| keeper.end(&[(ms(1), &first)], true).unwrap();
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    end(ledger.keep(&[(Instant::ZERO, &first)]).unwrap());
    for name in ["bench.heat", "wearer.dose"] {
        let file = place.0.join(name);
        let whole = fs::read(&file).unwrap();
        for length in 0..whole.len() {
            fs::write(&file, &whole[..length]).unwrap();
            let refused = place.ledger("bench", &[0], "wearer").unwrap_err();
            assert!(
                matches!(refused, LedgerError::Unreadable { .. }),
                "{length}: {refused}"
            );
        }
        fs::write(&file, &whole).unwrap();
        place.ledger("bench", &[0], "wearer").unwrap();
        fs::write(&file, "").unwrap();
        assert!(Account::forget(&place.0, name).unwrap());
        place.ledger("bench", &[0], "wearer").unwrap();
    }
}

#[test]
fn a_person_forgets_what_there_is_of_hardware_and_wearers() {
    let place = Place::new("forgotten");
    let first = guard(1);
    let states = [(Instant::ZERO, &first)];
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    ledger.keep(&states).unwrap().end(&states, true).unwrap();
    let [hardware, wearer, other] = ["bench", "wearer", "other"].map(str::to_owned);
    let forget = |hardware: &[String], wearers: &[String]| {
        let left = forget(&place.0, hardware, wearers).unwrap();
        let is_there = ["bench.heat", "wearer.dose"].map(|name| place.0.join(name).exists());
        (left, is_there)
    };
    let other = [other];
    assert_eq!(forget(&other, &other), (false, [true; 2]));
    // What there is of one counts, whatever there is of the next.
    assert_eq!(
        forget(&[hardware, other[0].clone()], &other),
        (true, [false, true])
    );
    assert_eq!(forget(&other, &[wearer]), (true, [false; 2]));
    assert!(folder().is_absolute() && folder().ends_with("heat"));
}

#[test]
fn a_first_reserve_that_cannot_be_written_is_told_and_one_that_can_takes_no_time() {
    let place = Place::new("first");
    let first = guard(1);
    let states = [(Instant::ZERO, &first)];
    // Where the neighbour is to be.
    fs::create_dir_all(place.0.join("bench.heat.new")).unwrap();
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    let refused = ledger.keep(&states).unwrap_err();
    assert!(matches!(refused, LedgerError::Reserve(_)), "{refused}");
    fs::remove_dir(place.0.join("bench.heat.new")).unwrap();
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    let clock = RunClock::start();
    let _keeper = ledger.keep(&states).unwrap();
    assert!(clock.now() < ms(4000), "it waited for more than the write");
}

#[test]
fn a_run_that_ended_between_two_looks_is_not_overlooked() {
    let place = Place::new("between");
    let (early, late) = (
        place.ledger("bench", &[0], "wearer").unwrap(),
        place.ledger("bench", &[0], "wearer").unwrap(),
    );
    let first = guard(1);
    let states = [(Instant::ZERO, &first)];
    early.keep(&states).unwrap().end(&states, true).unwrap();
    let refused = late.keep(&states).unwrap_err();
    assert!(matches!(refused, LedgerError::Changed(_)), "{refused}");
}

/// Calls the keeper as a loop does, for a real second and more, until something is so.
fn beats(keeper: &Keeper, guard: &Guard, begun: Instant, so: impl Fn(bool) -> bool) -> bool {
    let clock = RunClock::start();
    while clock.now() < ms(4000) {
        let beat = keeper.beat(0, begun + clock.now().since(Instant::ZERO), guard);
        if so(beat.is_ok()) {
            return true;
        }
        clock.sleep_until(clock.now() + Duration::from_millis(5));
    }
    false
}

#[test]
fn a_reserve_goes_on_while_the_loop_does_and_ends_with_the_disk() {
    let place = Place::new("reserve");
    let first = guard(1);
    let ledger = place.ledger("bench", &[0], "wearer").unwrap();
    let keeper = ledger.keep(&[(Instant::ZERO, &first)]).unwrap();
    keeper.beat(0, ms(3800), &first).unwrap();
    let late = |at| keeper.beat(0, at, &first).unwrap_err().to_string();
    assert_eq!(
        late(ms(3901)),
        "heat cannot be kept: the disk does not answer"
    );
    // The thread asks once a second, and the loop's guard is reserved from.
    assert!(beats(&keeper, &first, ms(5000), |is_kept| is_kept));
    fs::remove_dir_all(&place.0).unwrap();
    assert!(beats(&keeper, &first, ms(8500), |is_kept| !is_kept));
    assert!(late(ms(20_000)).contains("No such file"));
    let refused = keeper.end(&[(ms(9000), &first)], true).unwrap_err();
    assert!(refused.to_string().contains("No such file"), "{refused}");
}

#[test]
fn a_fingertip_that_ended_waits_for_nobody() {
    let place = Place::new("ended");
    let (hardware, wearer) = (["bench".to_owned()], ["wearer".to_owned()]);
    let names = (&hardware[..], &wearer[..]);
    let fingertips = vec![fingertip(&[0]), fingertip(&[1])];
    let ledger = Ledger::open(&place.0, names, fingertips).unwrap();
    let (first, second) = (guard(1), guard(1));
    let states = [(Instant::ZERO, &first), (Instant::ZERO, &second)];
    let keeper = ledger.keep(&states).unwrap();
    keeper.leave(1, ms(500), &second);
    assert!(beats(&keeper, &first, ms(5000), |is_kept| is_kept));
    keeper.end(&states, true).unwrap();
    assert!(place.used("bench", &[0, 1], "wearer").cem43 < 1e-6);
}
