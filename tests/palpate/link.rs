//! The link for ends that are not written in Rust: its tables against the codec, the C header, a C program.

mod layout;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

use layout::{COMMAND_FIELDS, Field, HEADER_FIELDS, HELLO_FIELDS, PLANNED_FIELDS, STATUS_FIELDS};
use palpate_core::codec::link::{
    BUSY, Command, FROM_UNIT, HEADER, HEAT, HELD, Header, Hello, INTERNAL, Kind, MAGIC, MOST,
    MOST_CURRENT, MOST_PLANNED, Planned, Request, State, Status, TAG, VERSION, WARMTH,
};
use palpate_core::guard::Cause;
use palpate_core::peltier::PeltierReason;
use palpate_core::schedule::Reason;
use palpate_core::units::Ticks;
use proptest::prelude::*;

fn fixture(name: &str) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/link");
    Path::new(folder).join(name)
}

const KINDS: [(&str, Kind); 4] = [
    ("KNOCK", Kind::Knock),
    ("HELLO", Kind::Hello),
    ("COMMAND", Kind::Command),
    ("STATUS", Kind::Status),
];
const REQUESTS: [(&str, Request); 3] = [
    ("PLAY", Request::Play),
    ("OFF", Request::Off),
    ("STOP", Request::Stop),
];
const CAUSES: [Cause; 6] = [
    Cause::StaleInput,
    Cause::ActuatorError,
    Cause::SensorError,
    Cause::LateTick,
    Cause::End,
    Cause::Overrun,
];
const PARTS: [(&str, &[Field]); 5] = [
    ("HEADER", &HEADER_FIELDS),
    ("COMMAND", &COMMAND_FIELDS),
    ("PLANNED", &PLANNED_FIELDS),
    ("STATUS", &STATUS_FIELDS),
    ("HELLO", &HELLO_FIELDS),
];

/// Bytes of a whole part.
fn size(fields: &[Field]) -> usize {
    fields.last().unwrap().end()
}

/// Every element of every field, by its offset.
fn by_table(fields: &[Field], bytes: &[u8]) -> Vec<u64> {
    let one = |field: &Field| {
        let elements = bytes[field.at..field.end()].chunks(field.bytes);
        let number = |e: &[u8]| e.iter().rev().fold(0, |x, byte| x << 8 | u64::from(*byte));
        elements.map(number).collect::<Vec<_>>()
    };
    fields.iter().flat_map(one).collect()
}

/// The same of a header, as the codec reads it.
fn header_values(datagram: &[u8]) -> Vec<u64> {
    let header = Header::read(datagram).unwrap();
    let from_unit = matches!(header.kind, Kind::Hello | Kind::Status);
    vec![
        u16::from_le_bytes(MAGIC).into(),
        VERSION.into(),
        header.kind.number().into(),
        header.host,
        header.unit,
        header.sequence | if from_unit { FROM_UNIT } else { 0 },
    ]
}

/// A command's, and those of each of its stimuli.
fn command_values(body: &[u8]) -> (Vec<u64>, Vec<[u64; 4]>) {
    let command = Command::read(body).unwrap();
    let planned: Vec<_> = command.planned().collect();
    let base = planned.iter().map(|p| p.at).min().unwrap_or_default();
    let one = |p: &Planned| {
        [
            u64::from(p.board.0) * 16 + u64::from(p.channel.0),
            u64::from(p.width.get()) | u64::from(p.current.0) << 12,
            p.at.since(base).as_micros(),
            p.until.since(p.at).as_micros(),
        ]
    };
    let fixed = vec![
        command.said.reading.as_micros(),
        base.as_micros(),
        command.said.stops.into(),
        command.said.request.number().into(),
        planned.len() as u64,
        command.said.warmth.map_or(0, |w| w.face_mc.into()),
        command.said.warmth.map_or(0, |w| w.ceiling_mc.into()),
    ];
    (fixed, planned.iter().map(one).collect())
}

fn status_values(body: &[u8]) -> Vec<u64> {
    let status = Status::read(body).unwrap();
    let mut values = vec![
        status.now.as_micros(),
        status.echo,
        status.taken.as_micros(),
        status.state.number().into(),
        status.stops.into(),
        status.applied.into(),
        status.limited.into(),
        status.reasons.into(),
        status.dropped.into(),
        status.late_us.into(),
        status.refused.into(),
        status.skin_mc.into(),
    ];
    values.extend(status.phase_us.map(u64::from));
    let face = &status.face;
    let degrees = [face.face_mc, face.warmest_mc, face.aim_mc, face.sink_mc];
    values.extend(degrees.map(u64::from));
    values.push(face.milliamps.cast_unsigned().into());
    values.push(
        face.reason
            .map_or(0, |reason| 1 + u64::from(reason.number())),
    );
    values
}

fn hello_values(body: &[u8]) -> Vec<u64> {
    let hello = Hello::read(body).unwrap();
    let (plant, limits) = (&hello.plant, &hello.limits);
    let clock = plant.prescale.clock();
    let flags = [
        (hello.busy, BUSY),
        (hello.heat, HEAT),
        (hello.warmth, WARMTH),
    ];
    let flags: u8 = flags.iter().filter(|f| f.0).map(|f| f.1).sum();
    let mut values = vec![
        hello.now.as_micros(),
        flags.into(),
        hello.state.number().into(),
        hello.stops.into(),
        plant.prescale.get().into(),
        clock.hz().into(),
        clock.tolerance_ppm().unwrap_or(INTERNAL).into(),
        plant.wire_milliohm.into(),
        plant.peak.0.into(),
        plant.bus.as_micros(),
        limits.pulse_width_ns,
        limits.burst.as_micros(),
        limits.burst_energy_nj,
        limits.wire_1s_uw,
        limits.wire_10s_uw,
        limits.fingertip_1s_uw,
        limits.fingertip_60s_uw,
        limits.hand_60s_uw,
        limits.skin_mean_mc,
        limits.skin_peak_mc,
        limits.skin_deep_mc,
        limits.dose_omega_ppm,
        limits.dose_cem43_ms,
        limits.stale.as_micros(),
        limits.supply.0.into(),
    ];
    values.extend(hello.wires.map(u64::from));
    let current = hello.current.unwrap_or_default();
    let set = [current.full_scale.0, current.gain_ppm, current.offset.0];
    values.extend(set.map(u64::from));
    values
}

fn put(body: &mut [u8], fields: &[Field], name: &str, value: u64) {
    let field = fields.iter().find(|f| f.name == name).unwrap();
    body[field.at..][..field.bytes].copy_from_slice(&value.to_le_bytes()[..field.bytes]);
}

/// As many bytes as a part has, of any value.
fn any_bytes(fields: &[Field]) -> impl Strategy<Value = Vec<u8>> + use<> {
    proptest::collection::vec(any::<u8>(), size(fields))
}

proptest! {
    #[test]
    fn the_codec_reads_every_field_where_its_table_says(
        mut hello in any_bytes(&HELLO_FIELDS),
        mut status in any_bytes(&STATUS_FIELDS),
        mut command in any_bytes(&COMMAND_FIELDS),
        plan in proptest::collection::vec(any_bytes(&PLANNED_FIELDS), 1..16),
        (state, request, flags, reason) in (0..6u64, 0..3u64, 0..8u64, 0..9u64),
        (hz, ppm, supply) in (1_000_000..50_000_000u64, 0..50_000u64, any::<u32>()),
        (face, full_scale) in (1..=u64::from(u16::MAX), 1..=u64::from(u32::MAX)),
        base in 0..u64::from(u32::MAX),
    ) {
        let fields = &HELLO_FIELDS;
        for (name, value) in [
            ("flags", flags),
            ("state", state),
            ("clock", hz),
            ("tolerance", ppm),
            ("prescale", 3 + base % 253),
            ("supply_limit", supply.into()),
            ("full_scale", full_scale),
        ] {
            put(&mut hello, fields, name, value);
        }
        prop_assert_eq!(by_table(fields, &hello), hello_values(&hello));
        put(&mut status, &STATUS_FIELDS, "state", state);
        put(&mut status, &STATUS_FIELDS, "module_reason", reason);
        prop_assert_eq!(by_table(&STATUS_FIELDS, &status), status_values(&status));
        let fields = &COMMAND_FIELDS;
        for (name, value) in [
            ("request", request),
            ("base", base),
            ("stimuli", plan.len() as u64),
            ("face", face),
        ] {
            put(&mut command, fields, name, value);
        }
        let mut each = Vec::new();
        for (n, mut planned) in plan.into_iter().enumerate() {
            if n == 0 {
                // The base is the earliest onset.
                put(&mut planned, &PLANNED_FIELDS, "onset", 0);
            }
            command.extend(&planned);
            each.push(by_table(&PLANNED_FIELDS, &planned));
        }
        let (fixed, planned) = command_values(&command);
        prop_assert_eq!(by_table(fields, &command), fixed);
        prop_assert_eq!(planned.iter().map(|p| p.to_vec()).collect::<Vec<_>>(), each);
    }
}

#[test]
fn the_tables_leave_no_gap_and_the_description_says_the_same() {
    for (part, fields) in PARTS {
        let mut end = 0;
        for field in fields {
            assert_eq!(field.at, end, "{part}: {}", field.name);
            end = field.end();
        }
    }
    assert_eq!(size(&HEADER_FIELDS), HEADER);
    let described = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/unit.md");
    let text = fs::read_to_string(described).unwrap();
    for (part, fields) in PARTS.iter().filter(|p| p.0 != "PLANNED") {
        let heading = format!("| at | bytes | {} |", part.to_lowercase());
        let (_, table) = text.split_once(&heading).unwrap();
        let rows = table.lines().skip(2).take_while(|l| l.starts_with('|'));
        let mut count = 0;
        for row in rows {
            let cell = |n: usize| row.split('|').nth(n).unwrap().trim();
            let at: usize = cell(1).parse().unwrap();
            let bytes: usize = cell(2).split(' ').next().unwrap().parse().unwrap();
            let field = fields.iter().any(|f| (f.at, f.bytes) == (at, bytes));
            let stimuli =
                *part == "COMMAND" && (at, bytes) == (size(&COMMAND_FIELDS), size(&PLANNED_FIELDS));
            assert!(field || stimuli, "{part}: {row}");
            count += 1;
        }
        // The fifteen limits of a hello share a row; the stimuli of a command have one.
        let rows = match *part {
            "HELLO" => fields.len() - 14,
            "COMMAND" => fields.len() + 1,
            _ => fields.len(),
        };
        assert_eq!(count, rows, "{part}");
    }
}

/// A line of the header.
fn define(out: &mut String, name: &str, value: &str, what: &str) {
    let comment = match what {
        "" => String::new(),
        what => format!(" /* {what} */"),
    };
    writeln!(out, "#define PALPATE_{name} {value}{comment}").unwrap();
}

/// `palpate_link.h`, from the codec's tables and constants.
fn header() -> String {
    let mut out = String::from(
        "/* Datagrams between a host and a driver unit: where their fields lie, and what their bytes mean (docs/unit.md).\n \
         *\n \
         * Made from the codec by PALPATE_WRITE_HEADER=1 cargo test -p palpate-tests link; no need to edit it.\n \
         * Integers are little-endian. Offsets in a body count from its own start, behind the header. Times are of the\n \
         * unit's clock.\n \
         */\n\
         #ifndef PALPATE_LINK_H\n#define PALPATE_LINK_H\n\n",
    );
    define(&mut out, "LINK_VERSION", &VERSION.to_string(), "");
    define(&mut out, "DATAGRAM_MOST", &MOST.to_string(), "bytes");
    define(&mut out, "TAG_BYTES", &TAG.to_string(), "behind the body");
    let host = HEADER_FIELDS.iter().find(|f| f.name == "host").unwrap();
    define(&mut out, "NONCE_AT", &host.at.to_string(), "of the header");
    define(&mut out, "NONCE_BYTES", &(HEADER - host.at).to_string(), "");
    let magic = u16::from_le_bytes(MAGIC);
    define(&mut out, "MAGIC", &format!("0x{magic:04X}"), "as a number");
    let (from_unit, bit) = (format!("0x{FROM_UNIT:X}ULL"), "of a sequence");
    define(&mut out, "FROM_UNIT", &from_unit, bit);
    out.push('\n');
    for (name, kind) in KINDS {
        define(
            &mut out,
            &format!("KIND_{name}"),
            &kind.number().to_string(),
            "",
        );
    }
    for (part, fields) in PARTS {
        out.push('\n');
        let what = match part {
            "COMMAND" => "before its stimuli",
            _ => "",
        };
        define(
            &mut out,
            &format!("{part}_BYTES"),
            &size(fields).to_string(),
            what,
        );
        for field in fields {
            let name = format!("{part}_{}", field.name.to_uppercase());
            define(
                &mut out,
                &format!("{name}_AT"),
                &field.at.to_string(),
                field.what,
            );
            define(
                &mut out,
                &format!("{name}_BYTES"),
                &field.bytes.to_string(),
                "",
            );
            if field.count > 1 {
                define(
                    &mut out,
                    &format!("{name}_COUNT"),
                    &field.count.to_string(),
                    "",
                );
            }
        }
    }
    out.push('\n');
    define(
        &mut out,
        "STIMULI_MOST",
        &MOST_PLANNED.to_string(),
        "of a command",
    );
    let most = (Ticks::PER_PERIOD - 1).to_string();
    define(&mut out, "WIDTH_MOST", &most, "ticks");
    define(&mut out, "CURRENT_MOST", &MOST_CURRENT.to_string(), "mA");
    define(
        &mut out,
        "CURRENT_BIT",
        "12",
        "of a pulse: its width lies below",
    );
    out.push('\n');
    for (name, request) in REQUESTS {
        define(
            &mut out,
            &format!("REQUEST_{name}"),
            &request.number().to_string(),
            "",
        );
    }
    out.push('\n');
    let ready = State::Ready.number().to_string();
    define(&mut out, "STATE_READY", &ready, "");
    let upper = |word: &str| word.to_uppercase().replace('-', "_");
    for cause in CAUSES {
        let name = format!("STATE_{}", upper(cause.word()));
        define(
            &mut out,
            &name,
            &State::Stopped(cause).number().to_string(),
            "",
        );
    }
    out.push('\n');
    for (bit, reason) in Reason::ALL.into_iter().enumerate() {
        let name = format!("REASON_{}", upper(reason.word()));
        define(&mut out, &name, &format!("0x{:04X}", 1 << bit), "");
    }
    out.push('\n');
    let held = format!("0x{HELD:X}");
    define(&mut out, "PHASE_HELD", &held, "drives nothing");
    for (name, flag, what) in [
        ("FLAG_BUSY", BUSY, "another host has it"),
        ("FLAG_HEAT", HEAT, "it has thermal rows"),
        ("FLAG_WARMTH", WARMTH, "it has a Peltier module"),
    ] {
        define(&mut out, name, &flag.to_string(), what);
    }
    for reason in PeltierReason::ALL {
        let name = format!("MODULE_{}", upper(reason.word()));
        define(&mut out, &name, &(1 + reason.number()).to_string(), "");
    }
    let internal = format!("0x{INTERNAL:X}UL");
    define(
        &mut out,
        "TOLERANCE_INTERNAL",
        &internal,
        "the chips' own oscillator",
    );
    out + "\n#endif\n"
}

#[test]
fn the_c_header_is_the_codecs() {
    let path = fixture("palpate_link.h");
    if std::env::var_os("PALPATE_WRITE_HEADER").is_some() {
        fs::write(&path, header()).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap();
    assert_eq!(
        kept,
        header(),
        "PALPATE_WRITE_HEADER=1 cargo test -p palpate-tests link"
    );
}

/// What `vectors.c` prints, by the codec.
fn printed() -> String {
    let mut out = String::new();
    let mut show = |part: &str, values: &[u64]| {
        let (_, fields) = PARTS.iter().find(|p| p.0 == part).unwrap();
        let each = |f: &Field| vec![f.name.to_uppercase(); f.count];
        let names: Vec<_> = fields.iter().flat_map(each).collect();
        assert_eq!(names.len(), values.len(), "{part}");
        for (name, value) in names.iter().zip(values) {
            writeln!(out, "{part}_{name} {value}").unwrap();
        }
    };
    for line in fs::read_to_string(fixture("vectors.jsonl"))
        .unwrap()
        .lines()
    {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        let bytes = |key: &str| -> Vec<u8> {
            let text = line[key].as_str().unwrap();
            let pairs = text.as_bytes().chunks(2);
            let byte = |p: &[u8]| u8::from_str_radix(std::str::from_utf8(p).unwrap(), 16);
            pairs.map(|p| byte(p).unwrap()).collect()
        };
        let (datagram, body) = (bytes("datagram"), bytes("body"));
        show("HEADER", &header_values(&datagram));
        match Kind::stated_in(&datagram).unwrap() {
            Kind::Knock => {}
            Kind::Hello => show("HELLO", &hello_values(&body)),
            Kind::Status => show("STATUS", &status_values(&body)),
            Kind::Command => {
                let (fixed, planned) = command_values(&body);
                show("COMMAND", &fixed);
                planned.iter().for_each(|p| show("PLANNED", p));
            }
        }
    }
    out
}

#[test]
fn a_c_program_reads_the_vectors_by_the_header() {
    if Process::new("cc").arg("--version").output().is_err() {
        println!("skipped: no C compiler (cc) here");
        return;
    }
    let folder = std::env::temp_dir().join(format!("palpate-link-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let program = folder.join("vectors");
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"];
    let mut cc = Process::new("cc");
    cc.args(strict).arg(fixture("vectors.c")).arg("-o");
    let built = cc.arg(&program).output().unwrap();
    let complaint = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{complaint}");
    let ran = Process::new(&program)
        .arg(fixture("vectors.jsonl"))
        .output()
        .unwrap();
    fs::remove_dir_all(&folder).unwrap();
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    assert_eq!(String::from_utf8(ran.stdout).unwrap(), printed());
}
