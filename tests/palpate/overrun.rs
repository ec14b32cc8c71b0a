//! The real policy before an actuator bus that fails or answers late, and no line that cuts outputs: what is on is
//! counted as on, and a run whose wires were on for too long ends at once, latched, with the verdict of a passed limit.

use palpate_core::driver::{Actuators, Banks, Driver, DriverError, Traffic};
use palpate_core::guard::{Cause, Guarded};
use palpate_core::units::{Board, Duration, Instant};
use palpate_emulators::display::i2c::I2cHandle;
use palpate_files::Setup;
use palpate_records::margin::Limited;
use palpate_records::trace::{Event, event};
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::display_end::{DisplayEnd, OutputEnable};
use palpate_run::wires::EmulatedDisplay;
use palpate_run::{
    EmulatedSkin, Failure, Policy, Recorder, Session, Truth, Turn, build, dynamic_levels, exceeded,
    plan, skin,
};

/// What a bus does from its first update after a time on.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// Every transfer fails for so many milliseconds.
    Fails(u64),
    /// The next transfer that switches something off arrives, but is known to so many milliseconds later.
    Hangs(u64),
}

/// Boards on a bus with one fault.
struct Boards {
    banks: Banks<I2cHandle>,
    fault: Fault,
    /// The fault strikes then; `None` until the burst that it strikes has begun.
    strikes: Option<Instant>,
    /// No burst is struck before.
    not_before: Instant,
    now: Instant,
    /// The transfer that hangs is over then.
    busy: Instant,
}

impl Boards {
    fn transfer(&mut self, board: Board, off: bool) -> Result<(), DriverError> {
        let Some(since) = self.strikes.filter(|since| self.now >= *since) else {
            return Ok(());
        };
        match self.fault {
            Fault::Fails(ms) if self.now < since + Duration::from_millis(ms) => {
                let kind = embedded_hal::i2c::ErrorKind::Other;
                Err(DriverError::Bus(board, kind))
            }
            Fault::Hangs(ms) if off => {
                self.busy = self.now + Duration::from_millis(ms);
                self.strikes = Some(Instant::FAR_FUTURE);
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

impl Actuators for Boards {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        let begins = (0..16).any(|n| update.ends()[n] > update.at());
        self.transfer(update.board(), !begins)?;
        if begins && self.now >= self.not_before && self.strikes.is_none() {
            self.strikes = Some(self.now + Duration::from_millis(10));
        }
        self.banks.apply(update)
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        self.transfer(Board(0), true)?;
        self.banks.all_off()
    }

    fn confirmed(&self, asked: Instant) -> Instant {
        asked.max(self.busy)
    }
}

impl Driver for Boards {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.now = now;
        self.transfer(Board(0), false)?;
        self.banks.start(now)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.banks.verify()
    }

    fn retries(&self) -> u64 {
        self.banks.retries()
    }

    fn traffic(&self) -> Traffic {
        self.banks.traffic()
    }

    fn boards(&self) -> Vec<Board> {
        self.banks.boards()
    }
}

/// A line that cuts outputs, or none.
struct Line(bool);

impl OutputEnable for Line {
    fn set_enabled(&self, _now: Instant, _enabled: bool) {}

    fn cuts(&self) -> bool {
        self.0
    }

    fn words(&self) -> &'static str {
        "the test's line"
    }
}

/// Emulated wires behind those boards, and the stops that were kept.
struct Bench {
    display: EmulatedDisplay,
    boards: Boards,
    line: Line,
    kept: Vec<String>,
}

impl DisplayEnd for Bench {
    type Update = Guarded;

    fn parts(&mut self) -> (&mut dyn Driver, &dyn OutputEnable) {
        (&mut self.boards, &self.line)
    }

    fn advance_to(&mut self, now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        self.boards.now = now;
        self.display.advance_to(now, events)
    }

    fn keep_stopped(&mut self, cause: &str) -> Failure {
        self.kept.push(cause.to_owned());
        Failure::Guard(cause.to_owned())
    }
}

type Run = Session<EmulatedSkin, Bench>;

fn session(fault: Fault, cuts: bool, policy: Policy) -> Run {
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let levels = dynamic_levels(&setup.scene.value.compression);
    let projector = build(&setup, 1, levels).unwrap();
    let mut display = EmulatedDisplay::new(&setup, &projector, 1).unwrap();
    display.hardware().set_enabled(Instant::ZERO, true);
    let prescale = projector.guard().prescale();
    let banks = plan::banks(&setup.bench.value, display.hardware().bus(), prescale);
    let bench = Bench {
        display,
        boards: Boards {
            banks,
            fault,
            strikes: None,
            not_before: at(2000),
            now: Instant::ZERO,
            busy: Instant::ZERO,
        },
        line: Line(cuts),
        kept: Vec::new(),
    };
    let skin = skin::scene(&setup, 1, None).unwrap();
    let recorder = Recorder::new(Truth::Unknown, projector.layout());
    let mut session = Session::new(projector, (skin, bench), policy, recorder, None);
    session.start(Instant::ZERO).unwrap();
    session
}

const fn at(ms: u64) -> Instant {
    Instant::from_micros(ms * 1000)
}

/// How a run came out that was switched off at its end.
struct Came {
    turn: Turn,
    /// The beginning of the burst that was struck, and how long it was to be, us.
    begun: u64,
    length: u64,
    /// Boards that went off since, when and why.
    offs: Vec<(u64, &'static str)>,
    /// From that beginning to the last falling edge of a burst that goes on without a pause, ms.
    flowed_ms: f64,
    verdict: Verdict,
    failure: Option<String>,
    kept: Vec<String>,
    session: Run,
}

fn run(fault: Fault, cuts: bool, policy: Policy) -> Came {
    let mut session = session(fault, cuts, policy);
    let turn = session.advance(at(6500)).unwrap();
    let end = session.now().max(session.next());
    session.display().advance_to(end, &mut Vec::new()).unwrap();
    let _ = session.switch_off(end);
    let events = session.recorder().events.clone();
    let driven = events.iter().filter_map(|e| match e {
        Event::Schedule(entry) if entry.at >= at(2000) && entry.on < entry.off => Some(entry),
        _ => None,
    });
    let struck = driven.min_by_key(|entry| entry.at).unwrap();
    let begun = struck.at.as_micros();
    let length = struck.until.as_micros() - begun;
    let offs = events.iter().filter_map(|e| match e {
        Event::AllOff(event::AllOff { t_us, cause, .. }) if *t_us > begun => Some((*t_us, *cause)),
        _ => None,
    });
    let mut last = begun * 1000;
    for edge in &events {
        if let Event::Edge(event::Edge { t_ns, .. }) = edge
            && *t_ns > last
            && *t_ns - last < 20_000_000
        {
            last = *t_ns;
        }
    }
    let mut conclusion = Conclusion::default();
    conclusion.add_margins(&exceeded(session.projector().guard()));
    Came {
        turn,
        begun,
        length,
        offs: offs.collect(),
        flowed_ms: (last - begun * 1000) as f64 * 1e-6,
        verdict: conclusion.verdict,
        failure: session.failure().map(ToString::to_string),
        kept: session.display().kept.clone(),
        session,
    }
}

/// The longest that a wire may be on, us.
fn longest(came: &Came) -> u64 {
    came.session.projector().guard().longest().as_micros()
}

#[test]
fn a_bus_that_fails_is_an_overrun_where_a_wire_was_on_for_too_long() {
    let (mut over, mut within) = (0, 0);
    for ms in [10, 26, 30, 36, 46, 48, 60, 100, 450, 1000, 2500, 2950] {
        let came = run(Fault::Fails(ms), false, Policy::REAL);
        let Some((off, cause)) = came.offs.first().copied() else {
            panic!("{ms} ms: nothing went off");
        };
        if cause == "end" {
            // The bus was back before the burst ended.
            assert!(10_000 + ms * 1000 <= came.length, "{ms} ms");
            assert_eq!(
                (came.verdict, came.turn == Turn::Last),
                (Verdict::Ok, false)
            );
            continue;
        }
        let on = off - came.begun;
        // It went off with the first try that the bus took, and is told so.
        let back = 10_000 + ms * 1000;
        assert!((back..back + 21_000).contains(&on), "{ms} ms: {on} us");
        assert!(
            came.flowed_ms <= on as f64 * 1e-3 + 6.0 && came.flowed_ms * 1e3 > on as f64 - 12_000.0
        );
        if on > longest(&came) {
            over += 1;
            assert_eq!(
                (came.turn, came.verdict),
                (Turn::Last, Verdict::LimitExceeded),
                "{ms} ms"
            );
            assert_eq!(cause, "overrun");
            let words = format!("was on for {} ms, allowed are 50 ms", on.div_ceil(1000));
            assert!(
                came.kept.len() == 1 && came.kept[0].contains(&words),
                "{:?}",
                came.kept
            );
            assert_eq!(came.failure.as_deref(), Some(&*came.kept[0]));
            assert_eq!(
                came.session.projector().guard().latched(),
                Some(Cause::Overrun)
            );
            // Nothing is driven after it.
            let driven = came.session.seen().1.first.last().unwrap();
            assert!(driven.at.as_micros() <= came.begun + 60_000);
        } else {
            within += 1;
            assert_eq!(
                (came.verdict, came.turn == Turn::Last),
                (Verdict::Ok, false),
                "{ms} ms"
            );
            assert_eq!(cause, "actuator-error");
            assert!(came.kept.is_empty() && came.failure.is_none());
        }
    }
    assert!(over >= 6 && within >= 2, "{over} over, {within} within");
}

#[test]
fn a_bus_that_stays_dead_leaves_wires_on_until_the_end_and_after_it() {
    let came = run(Fault::Fails(10_000), false, Policy::REAL);
    assert_eq!(
        (came.turn, came.verdict),
        (Turn::Last, Verdict::LimitExceeded)
    );
    // Not known to be off: told by nobody, and no stop with outputs off is kept.
    assert_eq!(came.offs, vec![]);
    assert!(came.kept.is_empty());
    assert!(came.failure.unwrap().contains("dead for 30"));
    let on = came.session.projector().guard().overrun().unwrap().on;
    assert!((3000..3100).contains(&(on.as_micros() / 1000)), "{on:?}");
    let words = came.session.overrun().unwrap();
    assert!(words.starts_with("overrun: wire "), "{words}");
}

#[test]
fn a_line_that_cuts_ends_what_a_failing_bus_leaves_on() {
    for ms in [30, 450, 2500] {
        let came = run(Fault::Fails(ms), true, Policy::REAL);
        assert_eq!(
            (came.verdict, came.turn == Turn::Last),
            (Verdict::Ok, false),
            "{ms} ms"
        );
        let (off, cause) = came.offs[0];
        assert_eq!(cause, "actuator-error");
        assert!((came.length..came.length + 1100).contains(&(off - came.begun)));
        assert!(came.failure.is_none() && came.kept.is_empty());
    }
}

#[test]
fn an_off_that_arrives_late_is_an_overrun_where_that_is_too_late() {
    let punctual = run(Fault::Hangs(0), false, Policy::REAL);
    let most = (longest(&punctual) - punctual.length) / 1000;
    for ms in [0, 10, most, most + 1, 450, 3000] {
        let came = run(Fault::Hangs(ms), false, Policy::REAL);
        let over = came.length + ms * 1000 > longest(&came);
        assert_eq!(over, ms > most);
        let expected = if over {
            Verdict::LimitExceeded
        } else {
            Verdict::Ok
        };
        assert_eq!(
            (came.verdict, came.turn == Turn::Last),
            (expected, over),
            "{ms} ms"
        );
        assert_eq!(came.kept.len(), usize::from(over));
        let (off, cause) = came.offs[0];
        if over {
            assert_eq!(cause, "overrun");
            let on = came.session.projector().guard().overrun().unwrap().on;
            assert_eq!(on.as_micros(), came.length + ms * 1000);
            // The all-off that the overrun brought comes after the hang.
            assert_eq!(off - came.begun, came.length + ms * 1000);
        } else {
            assert_eq!(cause, "end");
        }
    }
    let rows = exceeded(
        run(Fault::Hangs(450), false, Policy::REAL)
            .session
            .projector()
            .guard(),
    );
    assert_eq!(rows[0].of, Limited::Burst);
    assert!((rows[0].worst() - 488.1).abs() < 0.1 && (rows[0].limit() - 50.0).abs() < 1e-9);
    assert!(rows.iter().all(palpate_records::margin::Margin::over));
}

#[test]
fn an_emulated_bench_goes_on_by_itself() {
    let came = run(Fault::Hangs(450), false, Policy::EMULATED);
    assert_ne!(came.turn, Turn::Last);
    assert!(came.kept.is_empty() && came.failure.is_none());
    assert_eq!(came.offs[0].1, "overrun");
    let events = came.session.seen().1.events.iter();
    let notes = events.filter_map(|e| match e {
        Event::Note(event::Note { text, .. }) => Some(text.as_str()),
        _ => None,
    });
    let notes: Vec<&str> = notes.collect();
    assert!(notes.contains(&"stopped: overrun"));
    assert!(notes.iter().any(|n| n.contains("stop ended")));
}

#[test]
fn time_that_nobody_saw_ends_a_run_on_hardware_and_stops_an_emulated_one_for_a_while() {
    for (policy, goes_on) in [(Policy::REAL, false), (Policy::EMULATED, true)] {
        let mut session = session(Fault::Hangs(0), false, policy);
        session.advance(at(1500)).unwrap();
        let unseen = session.unseen(at(1700), Duration::ZERO, "nobody looked");
        assert_eq!(unseen, goes_on);
        assert!(session.projector().guard().latched().is_some());
        assert_eq!(session.display().kept.len(), usize::from(!goes_on));
        assert_eq!(session.failure().is_some(), !goes_on);
        if goes_on {
            assert_ne!(session.turn(at(1700)).unwrap(), Turn::Last);
            assert_ne!(session.advance(at(1900)).unwrap(), Turn::Last);
            assert_eq!(session.projector().guard().latched(), None);
        }
    }
}
