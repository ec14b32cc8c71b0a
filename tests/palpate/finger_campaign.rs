//! Whatever is killed under one finger, no other finger's schedule changes by a tick: buses, boards, adapters, sensors and
//! wires of a hand break at random.
//!
//! `PALPATE_FINGERS=N` (`ci/hostile`) plays N runs, with what they came to on standard output.

use std::thread;

use palpate_core::random::RandomStream;
use palpate_core::schedule::Entry;
use palpate_files::{Bench, Loaded, Scene, Setup, Source, load_bench};
use palpate_records::margin::Limited;
use palpate_records::trace::{Event, Trace};
use palpate_run::{Input, Outcome, run};

/// Runs of an ordinary test.
const FEW: u64 = 120;
/// The first grasp begins after two seconds.
const LENGTH_S: f64 = 3.4;
/// The outputs of each finger: two share a board, three a bus.
const FINGERS: [(&str, usize, usize, u8); 4] = [
    ("index", 0, 0, 0),
    ("middle", 0, 0, 8),
    ("ring", 0, 1, 0),
    ("thumb", 1, 2, 0),
];

/// The bench of those fingers, and a grasp with faults.
fn setup(faults: &str) -> Setup {
    let bench = load_bench("allegro-hand").unwrap();
    let text = bench.source.text();
    let mut text = text[..text.find("[[displays]]").unwrap()].to_owned();
    text = text.replace(
        "[amplifier]",
        "drive.supply_limit_ma = 6000.0\n\n[amplifier]",
    );
    for (name, bus, board, first) in FINGERS {
        let address = 0x40 + board % 2;
        let output = |c| format!("{{ bus = {bus}, board = {address}, channel = {c} }}");
        let outputs: Vec<String> = (first..first + 8).map(output).collect();
        let outputs = outputs.join(", ");
        text += &format!("[[displays]]\nname = \"{name}\"\noutputs = [{outputs}]\n");
    }
    let source = Source::new("bench.toml", text);
    let value = Bench::read(&source).unwrap();
    let bench = Loaded { value, source };
    let scene = palpate_fixtures::scene("allegro-grasp").unwrap();
    let source = Source::new("scene.toml", format!("{scene}\n{faults}"));
    let value = Scene::read(&source).unwrap();
    let mut setup = Setup::join(Loaded { value, source }, bench).unwrap();
    setup.scene.value.length_s = LENGTH_S;
    setup
}

/// What is killed.
const KILLED: [&str; 5] = ["bus", "adapter", "board", "sensor", "wire"];

/// Something that is killed: which of [`KILLED`], the fault, and the fingers that it is under.
struct Kill {
    what: usize,
    fault: String,
    met: [bool; 4],
    /// A transistor that conducts for ever passes limits of its own finger.
    heats: bool,
}

impl Kill {
    fn draw(s: &mut RandomStream) -> Self {
        let mut below = |n: u64| (s.next_u64() % n) as usize;
        let what = below(5);
        let at_ms = 1900 + below(1300);
        let mut until = match below(3) {
            0 => String::new(),
            _ => format!("until_s = {}\n", (at_ms + 20 + below(400)) as f64 * 1e-3),
        };
        let (bus, board, module, wire) = (below(2), below(3), below(15), below(32));
        let on_bus = FINGERS.map(|f| f.1 == bus);
        let (kind, met) = match (what, below(4)) {
            (0, 0) => (
                format!("\"i2c-address-nack\"\nrate = 0.3\nbus = {bus}"),
                on_bus,
            ),
            (0, 1) => (
                format!("\"i2c-data-nack\"\nrate = 0.3\nbus = {bus}"),
                on_bus,
            ),
            (0, _) => (format!("\"i2c-stuck\"\nbus = {bus}"), on_bus),
            (1, 0) => (
                format!("\"i2c-stretch\"\nrate = 0.5\nstretch_ms = 4.0\nbus = {bus}"),
                on_bus,
            ),
            (1, _) => (format!("\"i2c-eio\"\nrate = 1.0\nbus = {bus}"), on_bus),
            (2, _) => {
                until.clear();
                (
                    format!("\"brown-out\"\nboard = {board}"),
                    FINGERS.map(|f| f.2 == board),
                )
            }
            // Each finger's modules have a CAN bus of their own.
            (3, 0) => (
                format!("\"bus-off\"\nbus = {}", module / 4),
                of_finger(module / 4),
            ),
            (3, 1) => (
                format!("\"wrong-model\"\nmodule = {module}"),
                of_finger(module / 4),
            ),
            (3, _) => (
                format!("\"board-reboot\"\nmodule = {module}"),
                of_finger(module / 4),
            ),
            (_, 0) => (
                format!("\"amplifier-stuck-on\"\nwire = {wire}"),
                of_finger(wire / 8),
            ),
            (_, _) => (format!("\"open-wire\"\nwire = {wire}"), of_finger(wire / 8)),
        };
        Self {
            what,
            heats: kind.starts_with("\"amplifier"),
            fault: format!(
                "[[faults]]\nat_s = {}\n{until}kind = {kind}\n",
                at_ms as f64 * 1e-3
            ),
            met,
        }
    }
}

fn of_finger(finger: usize) -> [bool; 4] {
    std::array::from_fn(|f| f == finger)
}

fn entries(trace: &Trace) -> Vec<Entry> {
    let entry = |e: &Event| match e {
        Event::Schedule(entry) => Some(*entry),
        _ => None,
    };
    trace.events.iter().filter_map(entry).collect()
}

fn edges(trace: &Trace) -> Vec<&Event> {
    let edges = trace.events.iter();
    edges.filter(|e| matches!(e, Event::Edge(_))).collect()
}

/// What many runs came to.
#[derive(Debug, Default)]
struct Tally {
    runs: u64,
    /// By [`KILLED`].
    killed: [u64; 5],
    /// Fingers that were under nothing that was killed, and those of them on a bus that another finger's trouble was on.
    spared: u64,
    beside: u64,
    /// Of those beside: whose pins moved, too.
    moved: u64,
    /// Fingers whose schedule changed because of what they were on.
    hit: u64,
    /// Runs that went wrong, in words.
    wrong: Vec<String>,
}

fn one(case: u64, well: &Outcome, tally: &mut Tally) {
    let mut s = RandomStream::new(case, "killed finger");
    let count = 1 + s.next_u64() % 2;
    let kills: Vec<Kill> = (0..count).map(|_| Kill::draw(&mut s)).collect();
    let text: String = kills.iter().map(|k| &*k.fault).collect();
    let ill = run(&setup(&text), &Input::Scene, 1).unwrap();
    tally.runs += 1;
    kills.iter().for_each(|k| tally.killed[k.what] += 1);
    let mut wrong = |what: String| tally.wrong.push(format!("case {case}: {what}\n{text}"));
    let is_met = |finger: usize| kills.iter().any(|k| k.met[finger]);
    for (finger, (well, ill)) in well.displays.iter().zip(&ill.displays).enumerate() {
        let (before, after) = (&well.outcome.trace, &ill.outcome.trace);
        let same = entries(before) == entries(after);
        if is_met(finger) {
            tally.hit += u64::from(!same);
            continue;
        }
        tally.spared += 1;
        if !same {
            wrong(format!("the schedule of {} changed", ill.name));
        }
        let pins = edges(before) == edges(after);
        let beside = (0..4).any(|f| is_met(f) && FINGERS[f].1 == FINGERS[finger].1);
        tally.beside += u64::from(beside);
        tally.moved += u64::from(beside && !pins);
        if !beside && !pins {
            wrong(format!("pins of {} moved", ill.name));
        }
    }
    // Without OE a stuck bus would leave a wire on.
    if !super::faults::outputs_are_off(&ill) {
        wrong("an output stays on".into());
    }
    let over = |m: &palpate_records::margin::Margin| m.over() && m.of != Limited::SupplyCurrent;
    let over: Vec<_> = ill.summary.margins.iter().filter(|m| over(m)).collect();
    if !over.is_empty() && kills.iter().all(|k| !k.heats) {
        wrong(format!("{over:?}"));
    }
}

#[test]
fn what_is_killed_under_one_finger_changes_no_other() {
    let asked = std::env::var("PALPATE_FINGERS").ok();
    let runs: u64 = asked.as_ref().map_or(FEW, |n| n.parse().unwrap());
    let well = run(&setup(""), &Input::Scene, 1).unwrap();
    assert!(well.failure.is_none() && entries(&well.trace).len() > 100);
    let threads = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let tallies: Vec<Tally> = thread::scope(|scope| {
        let part = |first| {
            let well = &well;
            scope.spawn(move || {
                let mut tally = Tally::default();
                let cases = (first..runs).step_by(threads as usize);
                cases.for_each(|case| one(case, well, &mut tally));
                tally
            })
        };
        let parts: Vec<_> = (0..threads).map(part).collect();
        parts.into_iter().map(|p| p.join().unwrap()).collect()
    });
    let sum = |of: fn(&Tally) -> u64| tallies.iter().map(of).sum::<u64>();
    let wrong: Vec<&String> = tallies.iter().flat_map(|t| &t.wrong).collect();
    if asked.is_some() {
        let killed: Vec<String> = (KILLED.iter().enumerate())
            .map(|(n, what)| {
                let times: u64 = tallies.iter().map(|t| t.killed[n]).sum();
                format!("{what} {times}")
            })
            .collect();
        println!(
            "{} runs, killed: {}; {} fingers spared, {} of them beside trouble on their bus ({} with other pins); {} schedules hit; {} wrong",
            sum(|t| t.runs),
            killed.join(", "),
            sum(|t| t.spared),
            sum(|t| t.beside),
            sum(|t| t.moved),
            sum(|t| t.hit),
            wrong.len()
        );
    }
    // A bus in trouble may hold up another finger's transfer, now and then. Drivers that switch off what is not theirs
    // would move the pins of one in fifteen.
    let (beside, moved) = (sum(|t| t.beside), sum(|t| t.moved));
    assert!(100 * moved <= beside, "{moved} of {beside}");
    // Faults do something: more than every second run changes the schedule of a finger that is under one.
    assert!(2 * sum(|t| t.hit) > runs, "{} of {runs}", sum(|t| t.hit));
    let first: Vec<&&String> = wrong.iter().take(5).collect();
    assert!(wrong.is_empty(), "{} of {runs}: {first:#?}", wrong.len());
}
