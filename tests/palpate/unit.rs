//! A driver unit in the loop: against the wired bench, through an outage, and its link as other languages meet it.

use palpate_core::codec::link::{
    Command, Face, HEADER, HELD, Header, Hello, Key, Kind, MOST, Planned, Request, Said, State,
    Status, TAG, Warmth,
};
use palpate_core::guard::{Cause, CurrentControl, HARD, Plant};
use palpate_core::peltier::PeltierReason;
use palpate_core::units::{Board, Channel, Instant, Milliamps, Ticks};
use palpate_files::Setup;
use palpate_records::trace::{Event, event};
use palpate_run::{Input, Outcome, run};

fn played(scene: &str, bench: &str) -> Outcome {
    run(&Setup::load(scene, bench).unwrap(), &Input::Scene, 1).unwrap()
}

/// Times, us, of every edge that goes high.
fn rising(outcome: &Outcome) -> Vec<u64> {
    let one = |event: &Event| match event {
        Event::Edge(event::Edge { t_ns, high, .. }) if *high => Some(t_ns / 1000),
        _ => None,
    };
    outcome.trace.events.iter().filter_map(one).collect()
}

/// A PWM period at PRE_SCALE 30, us, rounded up.
const PERIOD_US: u32 = 5080;

#[test]
fn behind_wifi_as_much_is_felt_as_on_a_wire_and_no_limiter_acts() {
    let [wired, unit] = ["emulated", "unit"].map(|bench| played("sphere-along", bench));
    let report = unit.summary.unit.unwrap();
    assert!(report.late_us <= PERIOD_US, "{report:?}");
    assert_eq!(
        (report.limited, report.stops, report.sessions),
        (0, 0, 1),
        "{report:?}"
    );
    assert!(report.begun > 100 && report.lost > 5, "{report:?}");
    // Losses and delays leave few out: a way of 58 ms is one of many thousands.
    assert!(report.dropped * 100 < report.begun, "{report:?}");
    assert_eq!(unit.summary.limiter_events, wired.summary.limiter_events);
    let felt = |outcome: &Outcome| outcome.summary.felt.error_energy_mm.unwrap().rmse;
    let (wired, unit) = (felt(&wired), felt(&unit));
    assert!(
        unit < wired + 0.3,
        "felt: {wired} mm on a wire, {unit} mm through the air"
    );
}

#[test]
fn an_outage_switches_off_within_100_ms_and_ends_by_itself() {
    let outcome = played("wifi-outage", "unit");
    let report = outcome.summary.unit.unwrap();
    let edges = rising(&outcome);
    let within = |from: u64, to: u64| edges.iter().filter(|t| (from..to).contains(t)).count();
    assert!(within(2_300_000, 2_500_000) > 5);
    // The newest reading that the unit has is from before 2.5 s.
    assert_eq!(within(2_600_000, 2_900_000), 0);
    assert!(within(3_300_000, 3_800_000) > 5, "{report:?}");
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let [one, other] = [0; 2].map(|_| played("sphere-along-wifi", "unit"));
    assert_eq!(one.trace.events, other.trace.events);
    assert_eq!(one.summary.unit, other.summary.unit);
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// A datagram of each kind as a line of JSON: the key, the body before it is sealed, and what goes over the air.
fn vectors() -> String {
    let key: [u8; 32] = std::array::from_fn(|n| n as u8);
    let (host, unit) = (0x0123_4567_89AB_CDEF, 0xFEDC_BA98_7654_3210);
    let at = Instant::from_micros;
    let planned = |channel: u8, width: u16, current: u32| Planned {
        board: Board(1),
        channel: Channel(channel),
        width: Ticks::new(width),
        current: Milliamps(current),
        at: at(5_020_000),
        until: at(5_055_000),
    };
    let hello = Hello {
        now: at(5_000_000),
        busy: false,
        heat: false,
        warmth: true,
        state: State::Stopped(Cause::End),
        stops: 2,
        plant: Plant::default(),
        limits: HARD,
        wires: std::array::from_fn(|board| if board < 2 { 0x00FF } else { 0 }),
        current: Some(CurrentControl {
            full_scale: Milliamps(990),
            gain_ppm: 10_000,
            offset: Milliamps(5),
        }),
    };
    let status = Status {
        now: at(5_004_000),
        echo: 2,
        taken: at(5_003_500),
        state: State::Ready,
        stops: 2,
        applied: 17,
        limited: 1,
        reasons: 2,
        dropped: 3,
        late_us: 450,
        refused: 4,
        skin_mc: 0,
        phase_us: std::array::from_fn(|board| if board == 0 { 1234 } else { HELD }),
        face: Face {
            face_mc: 28_400,
            warmest_mc: 28_901,
            aim_mc: 28_350,
            sink_mc: 26_700,
            milliamps: -120,
            reason: Some(PeltierReason::Ramp),
        },
    };
    let mut body = [0; MOST];
    let plan = [planned(3, 148, 700), planned(4, 0, 0)];
    let datagrams = [
        ("knock", Kind::Knock, 0, 1, 0),
        ("hello", Kind::Hello, unit, 1, hello.write(&mut body)),
    ];
    let mut lines = Vec::new();
    let mut seal = |name: &str, kind, unit, sequence, plain: &[u8]| {
        let header = Header {
            kind,
            host,
            unit,
            sequence,
        };
        let mut buffer = [0; MOST];
        let write = |out: &mut [u8]| {
            out[..plain.len()].copy_from_slice(plain);
            plain.len()
        };
        let datagram = hex(Key::new(&key).seal(&header, &mut buffer, write));
        let (key, body) = (hex(&key), hex(plain));
        lines.push(format!(
            r#"{{"name":"{name}","key":"{key}","body":"{body}","datagram":"{datagram}"}}"#
        ));
    };
    for (name, kind, unit, sequence, length) in datagrams {
        seal(name, kind, unit, sequence, &body[..length]);
    }
    let said = Said {
        reading: at(4_990_000),
        stops: 2,
        request: Request::Play,
        warmth: Some(Warmth {
            face_mc: 27_600,
            ceiling_mc: 40_500,
        }),
    };
    let length = Command::write(&mut body, &said, &plan);
    seal("command", Kind::Command, unit, 2, &body[..length]);
    let length = status.write(&mut body);
    seal("status", Kind::Status, unit, 2, &body[..length]);
    lines.join("\n") + "\n"
}

#[test]
fn vectors_for_other_languages_are_what_is_sent() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../fixtures/link/vectors.jsonl"
    );
    if std::env::var_os("PALPATE_WRITE_VECTORS").is_some() {
        std::fs::write(path, vectors()).unwrap();
    }
    let kept = std::fs::read_to_string(path).unwrap();
    assert_eq!(
        kept,
        vectors(),
        "PALPATE_WRITE_VECTORS=1 cargo test -p palpate-tests vectors"
    );
    // Longest of all: what the description says of sizes.
    let most = HEADER + TAG + 26 + 10 * palpate_core::codec::link::MOST_PLANNED;
    assert!(most <= MOST, "{most}");
}
