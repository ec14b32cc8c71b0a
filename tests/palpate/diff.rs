//! `hil diff`'s words: nothing between a run and itself, exact times for edges that moved, and a line for
//! everything that is damaged.

use palpate_core::schedule::Entry;
use palpate_core::units::{Board, Channel, Instant, Ticks};
use palpate_records::bursts::{Burst, DrivenOutput};
use palpate_records::diff::{Grade, Tolerance, align, compare, tell};
use palpate_records::schedule::write_schedule;
use palpate_records::story::{LINES, Story};
use palpate_records::trace::{Driven, Event, Trace};
use proptest::prelude::*;

use crate::goldens::shipped;

/// Onsets of the made-up trains, microseconds.
const SOA_US: u64 = 58_500;

fn words(a: &Story, b: &Story) -> Vec<String> {
    let found = compare(a, b, Tolerance::between(a, b));
    found.into_iter().map(|d| d.text).collect()
}

fn schedule_file(trace: &Trace) -> String {
    let mut bytes = Vec::new();
    write_schedule(trace, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn read_schedule(trace: &Trace) -> Story {
    let wires = trace.header.wires.clone();
    Story::of_schedule_file(&schedule_file(trace), |_| wires).unwrap()
}

/// The bursts of one wire after another, as a trace of entries.
fn trace_of(trains: &[Vec<(u64, u64, u16)>], like: &Trace) -> Trace {
    let mut events = Vec::new();
    let mut driven = Driven::default();
    for (wire, train) in trains.iter().enumerate() {
        let info = &like.header.wires[wire];
        for &(from, to, width) in train {
            let entry = Entry {
                at: Instant::from_micros(from),
                board: Board(info.board),
                channel: Channel(info.channel),
                on: 0,
                off: width,
                until: Instant::from_micros(to),
                requested: Ticks::new(width),
                requested_until: Instant::from_micros(to),
                current: None,
                reason: None,
            };
            driven.add(&entry);
            events.push(Event::Schedule(entry));
        }
    }
    events.sort_by_key(Event::t_ns);
    let mut trace = like.clone();
    trace.header.tau_d_us = 35_000;
    trace.header.soa_us = SOA_US;
    trace.events = events;
    trace.ledger.driven = driven;
    trace
}

fn like() -> Trace {
    let mut trace = shipped("idle").trace;
    trace.events.clear();
    trace
}

/// Up to 40 onsets, of which some are left out on each of three wires.
fn trains() -> impl Strategy<Value = Vec<Vec<(u64, u64, u16)>>> {
    let burst = (any::<bool>(), 1u16..400, 1_000u64..50_000);
    let wire = prop::collection::vec(burst, 4..40).prop_map(|all| {
        let onsets = all.into_iter().enumerate().filter(|(_, (on, ..))| *on);
        let burst = |(i, (_, width, length)): (usize, (bool, u16, u64))| {
            let from = i as u64 * SOA_US;
            (from, from + length, width)
        };
        onsets.map(burst).collect()
    });
    prop::collection::vec(wire, 3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_run_does_not_differ_from_itself(trains in trains()) {
        let trace = trace_of(&trains, &like());
        let story = Story::schedule(&trace);
        prop_assert_eq!(words(&story, &story), Vec::<String>::new());
        // Neither does what was written and read again.
        let golden = Story::read(&story.text()).unwrap();
        prop_assert_eq!(words(&story, &golden), Vec::<String>::new());
        prop_assert_eq!(&golden, &story);
        let file = read_schedule(&trace);
        prop_assert_eq!(words(&file, &story), Vec::<String>::new());
    }

    #[test]
    fn a_shifted_edge_is_told_with_its_time(
        trains in trains(),
        pick in any::<prop::sample::Index>(),
        by in -7_900i64..8_000,
        edge in 0usize..3,
    ) {
        let like = like();
        let places: Vec<(usize, usize)> = trains
            .iter()
            .enumerate()
            .flat_map(|(w, t)| (0..t.len()).map(move |i| (w, i)))
            .collect();
        // A single burst that comes later is a whole run that does.
        prop_assume!(places.len() >= 3 && by != 0);
        let (wire, index) = places[pick.index(places.len())];
        let mut moved = trains.clone();
        let burst = &mut moved[wire][index];
        let (from, to, _) = *burst;
        if edge != 1 {
            prop_assume!(from as i64 + by >= 0 && (edge == 2 || from as i64 + by < to as i64));
            burst.0 = from.saturating_add_signed(by);
        }
        if edge != 0 {
            prop_assume!(to as i64 + by > from as i64);
            burst.1 = to.saturating_add_signed(by);
        }
        let (a, b) = (trace_of(&trains, &like), trace_of(&moved, &like));
        let (a, b) = (Story::schedule(&a), Story::schedule(&b));
        let found = compare(&a, &b, Tolerance::default());
        let edges: Vec<&str> = found
            .iter()
            .filter(|d| d.grade == Grade::Edge)
            .map(|d| d.text.as_str())
            .collect();
        let verb = ["rises", "falls", "comes"][edge];
        let ms = format!("{:.3}", by.unsigned_abs() as f64 / 1e3);
        let ms = ms.trim_end_matches('0').trim_end_matches('.');
        let later = if by > 0 { "later" } else { "earlier" };
        let at = format!("{}.{:03}", from / 1_000_000, from / 1000 % 1000);
        let expected = format!("wire {wire} {verb} {ms} ms {later}, at {at} s");
        prop_assert_eq!(edges, [expected.as_str()]);
        prop_assert!(!found.iter().any(|d| d.grade == Grade::Burst));
    }

    #[test]
    fn what_is_left_out_is_gone_and_what_is_put_in_is_new(
        trains in trains(),
        pick in any::<prop::sample::Index>(),
    ) {
        let like = like();
        let places: Vec<(usize, usize)> = trains
            .iter()
            .enumerate()
            .flat_map(|(w, t)| (0..t.len()).map(move |i| (w, i)))
            .collect();
        prop_assume!(places.len() >= 3);
        let (wire, index) = places[pick.index(places.len())];
        let mut fewer = trains.clone();
        let (from, ..) = fewer[wire].remove(index);
        let (a, b) = (trace_of(&trains, &like), trace_of(&fewer, &like));
        let (a, b) = (Story::schedule(&a), Story::schedule(&b));
        let at = format!("{}.{:03}", from / 1_000_000, from / 1000 % 1000);
        let gone = format!("1 burst gone: wire {wire}, at {at} s");
        prop_assert!(words(&a, &b).contains(&gone));
        let new = format!("1 new burst: wire {wire}, at {at} s");
        prop_assert!(words(&b, &a).contains(&new));
    }

    #[test]
    fn an_alignment_uses_every_burst_once_and_in_order(
        a in prop::collection::vec((0u64..3_000_000, 0u64..60_000, 0u16..4097), 0..60),
        b in prop::collection::vec((0u64..3_000_000, 0u64..60_000, 0u16..4097), 0..60),
        gap in 0u64..100_000,
    ) {
        let stays = |list: &[(u64, u64, u16)]| {
            let stay = |&(from_us, length, width): &(u64, u64, u16)| Burst {
                output: DrivenOutput::Wire(0),
                from_us,
                to_us: from_us + length,
                width,
                requested: width,
                reason: None,
            };
            let mut all: Vec<Burst> = list.iter().map(stay).collect();
            all.sort_by_key(|s| (s.from_us, s.to_us));
            all
        };
        let (a, b) = (stays(&a), stays(&b));
        let found = align(&a, &b, gap);
        prop_assert!(found.pairs.is_sorted() && found.gone.is_sorted() && found.new.is_sorted());
        let mut left: Vec<usize> = found.pairs.iter().map(|p| p.0).chain(found.gone).collect();
        let mut right: Vec<usize> = found.pairs.iter().map(|p| p.1).chain(found.new).collect();
        left.sort_unstable();
        right.sort_unstable();
        prop_assert_eq!(left, (0..a.len()).collect::<Vec<_>>());
        prop_assert_eq!(right, (0..b.len()).collect::<Vec<_>>());
    }

    #[test]
    fn damaged_goldens_are_refused_or_read_and_never_panic(
        line in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        with in "[ -~\n\t]{0,3}",
    ) {
        let text = include_str!("../../fixtures/goldens/sphere-along.schedule.snap");
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let index = line.index(lines.len());
        let place = at.index(lines[index].len() + 1);
        lines[index].replace_range(place.., &with);
        if let Err(damage) = Story::read(&lines.join("\n")) {
            prop_assert!(damage.line >= 1 && damage.line <= lines.len() + 4);
        }
    }
}

/// What is told of sphere-along when tau_d changes by a number of PWM periods and onsets stay where they are.
fn told_of_tau_d(periods: f64) -> Vec<String> {
    let scene = "sphere-along";
    let mut setup = palpate_files::Setup::load(scene, "emulated").unwrap();
    setup.scene.value.illusion.model = palpate_core::illusion::IllusionModel::Balanced;
    // So gently that no limit is met.
    setup.bench.value.drive.current_ma = 550.0;
    let input = palpate_run::Input::Scene;
    let before = palpate_run::run(&setup, &input, 1).unwrap().trace;
    let period_ms = before.header.pre_scale.period_ns() as f64 * 1e-6;
    setup.scene.value.illusion.tau_d_ms = Some(35.0 + periods * period_ms);
    setup.scene.value.illusion.soa_ms = Some(58.5);
    let after = palpate_run::run(&setup, &input, 1).unwrap().trace;
    let (a, b) = (Story::schedule(&before), Story::schedule(&after));
    let lines = tell(&compare(&a, &b, Tolerance::default()));
    assert!(lines.len() <= 11);
    lines
}

#[test]
fn a_change_of_tau_d_by_a_period_is_told() {
    let shorter = told_of_tau_d(-1.0);
    assert_eq!(shorter[0], "tau_d 35.000 -> 29.921 ms");
    assert_eq!(
        shorter[1],
        "every burst falls 5.079 ms earlier: 496 on 8 wires"
    );
    assert!(
        shorter.iter().any(|t| t.starts_with("energy -")),
        "{shorter:#?}"
    );
    // Longer by one, and less than 20 ms are left between two bursts: to the guard they are one, too long.
    let longer = told_of_tau_d(1.0);
    assert_eq!(longer[0], "tau_d 35.000 -> 40.079 ms");
    assert_eq!(
        longer[1],
        "206 new limiter events (burst): 8 wires, from 0.936 s"
    );
    let every = "every burst falls 5.079 ms later: 496 on 8 wires";
    assert!(longer.contains(&every.to_owned()), "{longer:#?}");
}

#[test]
fn limiter_events_are_told_by_wire_and_reason() {
    let a = trace_of(
        &[vec![
            (0, 35_000, 80),
            (58_500, 93_500, 80),
            (117_000, 152_000, 80),
        ]],
        &like(),
    );
    let mut b = a.clone();
    for event in &mut b.events {
        if let Event::Schedule(entry) = event
            && entry.at.as_micros() == 58_500
        {
            entry.off = 40;
            entry.reason = Some(palpate_core::schedule::Reason::WirePower);
        }
    }
    let (a, b) = (Story::schedule(&a), Story::schedule(&b));
    let told = words(&a, &b);
    let expected = "1 new limiter event (wire-power): wire 0, at 0.058 s";
    assert!(told.contains(&expected.to_owned()), "{told:#?}");
}

#[test]
fn shipped_goldens_read_back_and_are_no_longer_than_they_may() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/goldens");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "snap") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let story = Story::read(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert_eq!(compare(&story, &story, Tolerance::default()), []);
        // What is read again has every line of insta's heading in front.
        assert!(text.lines().count() <= LINES + 3, "{}", path.display());
        seen += 1;
    }
    // Two per scene, a surface, and the four displays of a hand that grasps and of one that rubs.
    assert_eq!(
        seen,
        palpate_fixtures::scene_names().count() * 2 + 1 + 2 * 4
    );
}
