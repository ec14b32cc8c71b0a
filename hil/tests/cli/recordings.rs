//! Recordings of other makers: every row of the table in `docs/recordings.md`, on a small file of the same format.

use std::collections::BTreeMap;

use fst_writer::{
    FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalType, FstVarDirection, FstVarType,
};

use super::*;

const ROWS: usize = 60;
const COUNTS: usize = 48;
/// 2026-03-01, in seconds.
const SINCE_1970: f64 = 1_772_366_400.0;

fn count(row: usize, column: usize) -> u16 {
    contacts::pad(row, 0)[column]
}

/// Lines with the counts of each row between `before` and the end.
fn lines(
    separator: &str,
    before: impl Fn(usize) -> String,
    shown: impl Fn(u16) -> String,
) -> String {
    let line = |row: usize| {
        let counts: Vec<String> = (0..COUNTS).map(|c| shown(count(row, c))).collect();
        before(row) + &counts.join(separator) + "\n"
    };
    (0..ROWS).map(line).collect()
}

fn names(name: impl Fn(usize) -> String, separator: &str) -> String {
    (0..COUNTS).map(name).collect::<Vec<_>>().join(separator)
}

fn plain(count: u16) -> String {
    count.to_string()
}

fn seconds(row: usize) -> f64 {
    SINCE_1970 + row as f64 * 0.01
}

fn bytes(values: impl Iterator<Item = (usize, usize)>) -> Vec<u8> {
    values
        .flat_map(|(row, column)| f64::from(count(row, column)).to_le_bytes())
        .collect()
}

fn npy() -> Vec<u8> {
    let header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({ROWS}, {COUNTS}), }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(bytes((0..ROWS * COUNTS).map(|n| (n / COUNTS, n % COUNTS))));
    file
}

/// `numpy.savez(counts=...)`.
fn npz() -> Vec<u8> {
    let (name, data) = (b"counts.npy", npy());
    let length = (data.len() as u32).to_le_bytes();
    let mut file = b"PK\x03\x04".to_vec();
    file.extend([0; 22]);
    file.extend([name.len() as u8, 0, 0, 0]);
    file.extend(name);
    file.extend(&data);
    let directory = file.len() as u32;
    file.extend(b"PK\x01\x02");
    file.extend([0; 16]);
    file.extend([length, length].concat());
    file.extend([name.len() as u8, 0]);
    file.extend([0; 16]);
    file.extend(name);
    let size = file.len() as u32 - directory;
    file.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    file.extend([size.to_le_bytes(), directory.to_le_bytes()].concat());
    file.extend([0; 2]);
    file
}

/// `scipy.io.savemat("counts.mat", {"raw": counts})`.
fn mat() -> Vec<u8> {
    let element = |kind: u32, data: &[u8]| {
        let mut all = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        all.extend(data);
        all.resize(all.len().next_multiple_of(8), 0);
        all
    };
    let sizes = [(ROWS as u32).to_le_bytes(), (COUNTS as u32).to_le_bytes()].concat();
    let data = bytes((0..ROWS * COUNTS).map(|n| (n % ROWS, n / ROWS)));
    let flags = [6, 0, 0, 0, 0, 0, 0, 0];
    let parts = [
        element(6, &flags),
        element(5, &sizes),
        element(1, b"raw"),
        element(9, &data),
    ];
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend(b"\x00\x01IM");
    file.extend(element(14, &parts.concat()));
    file
}

/// A bag of ROS 2 with counts under `/skin`, and among others with more numbers under `/wide`.
fn mcap(is_alone: bool) -> Vec<u8> {
    let text = |value: &str| [&(value.len() as u32).to_le_bytes()[..], value.as_bytes()].concat();
    let record =
        |kind: u8, body: Vec<u8>| [&[kind][..], &(body.len() as u64).to_le_bytes(), &body].concat();
    let mut file = b"\x89MCAP0\r\n".to_vec();
    let names = [
        text("skin_msgs/msg/Counts"),
        text("ros2msg"),
        text("uint16[] data"),
    ]
    .concat();
    file.extend(record(3, [&[1, 0][..], &names].concat()));
    let names = [text("/skin"), text("cdr"), vec![0; 4]].concat();
    file.extend(record(4, [&[0, 0, 1, 0][..], &names].concat()));
    let names = [text("/wide"), text("cdr"), vec![0; 4]].concat();
    file.extend(record(4, [&[1, 0, 1, 0][..], &names].concat()));
    for row in 0..ROWS {
        let ns = 1_772_366_400_000_000_000 + row as u64 * 10_000_000;
        let mut message = [&[0; 6][..], &ns.to_le_bytes(), &ns.to_le_bytes()].concat();
        message.extend([0, 1, 0, 0]);
        message.extend((COUNTS as u32).to_le_bytes());
        message.extend((0..COUNTS).flat_map(|c| count(row, c).to_le_bytes()));
        file.extend(record(5, message));
        if !is_alone {
            let mut other = [
                &[1, 0, 0, 0, 0, 0][..],
                &ns.to_le_bytes(),
                &ns.to_le_bytes(),
            ]
            .concat();
            other.extend([0, 1, 0, 0, 60, 0, 0, 0]);
            other.extend([7; 120]);
            file.extend(record(5, other));
        }
    }
    file.extend(record(15, vec![0; 4]));
    file
}

/// The records of an MCAP file in one chunk, which zstd packed without making it smaller: one block, as it is.
fn packed(file: &[u8]) -> Vec<u8> {
    let (magic, records) = file.split_at(8);
    let (records, end) = records.split_at(records.len() - 13);
    let size = records.len() as u32;
    let head = [&[0x28, 0xB5, 0x2F, 0xFD, 0xA0][..], &size.to_le_bytes()].concat();
    let block = &(size << 3 | 1).to_le_bytes()[..3];
    let frame = [&head, block, records].concat();
    let wide = |number: usize| (number as u64).to_le_bytes();
    let (unpacked, length) = (wide(records.len()), wide(frame.len()));
    let chunk = [
        &[0; 16][..],
        &unpacked,
        &[0; 4],
        &[4, 0, 0, 0],
        b"zstd",
        &length,
        &frame,
    ];
    let chunk = chunk.concat();
    [magic, &[6], &wide(chunk.len()), &chunk, end].concat()
}

/// The pins of a dump of ours as a simulator's FST.
fn as_fst(vcd: &str) -> Vec<u8> {
    let info = FstInfo {
        start_time: 0,
        timescale_exponent: -9,
        version: String::new(),
        date: String::new(),
        file_type: FstFileType::Verilog,
    };
    let (bit, way) = (FstSignalType::bit_vec(1), FstVarDirection::Output);
    let mut fst = FstHeaderWriter::write_to_mem(&info).unwrap();
    let mut pins = BTreeMap::new();
    let (names, changes) = vcd.split_once("$enddefinitions $end\n").unwrap();
    for line in names.lines() {
        match line.split(' ').collect::<Vec<_>>()[..] {
            ["$scope", "module", name, _] => {
                fst.scope(name, "", FstScopeType::Module).unwrap();
            }
            ["$upscope", _] => fst.up_scope().unwrap(),
            ["$var", "wire", "1", code, name, _] => {
                let pin = fst.var(name, bit, FstVarType::Wire, way, None).unwrap();
                pins.insert(code, pin);
            }
            _ => {}
        }
    }
    let mut fst = fst.finish().unwrap();
    for line in changes.lines() {
        match (
            line.split_at(1),
            line.get(1..).and_then(|code| pins.get(code)),
        ) {
            (("#", time), _) => fst.time_change(time.parse().unwrap()).unwrap(),
            ((level, _), Some(pin)) => fst.signal_change(*pin, level.as_bytes()).unwrap(),
            _ => {}
        }
    }
    fst.finish().unwrap().into_inner()
}

/// The pins of a dump of ours as GHDL writes them, with the words of a machine whose highest byte comes first.
fn as_ghw(vcd: &str) -> Vec<u8> {
    let (mut names, mut hierarchy, mut pins) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut name = |name: &str| {
        names.push(format!("{name}\0"));
        names.len() as u8
    };
    let (declared, changes) = vcd.split_once("$enddefinitions $end\n").unwrap();
    for line in declared.lines() {
        match line.split(' ').collect::<Vec<_>>()[..] {
            ["$scope", "module", scope, _] => hierarchy.extend([6, name(scope)]),
            ["$upscope", _] => hierarchy.push(15),
            ["$var", "wire", "1", code, pin, _] => {
                pins.insert(code, pins.len() as u8 + 1);
                hierarchy.extend([18, name(pin), 1, pins.len() as u8]);
            }
            _ => {}
        }
    }
    let mut cycles: Vec<(i64, BTreeMap<u8, u8>)> = Vec::new();
    for line in changes.lines() {
        let (sign, rest) = line.split_at(1);
        match (sign, pins.get(rest)) {
            ("#", _) => cycles.push((rest.parse().unwrap(), BTreeMap::new())),
            (_, Some(pin)) => {
                let literal = "ux01zwlh-".find(sign).unwrap() as u8;
                cycles.last_mut().unwrap().1.insert(*pin, literal);
            }
            _ => {}
        }
    }
    let begin = (cycles[0].0 * 1_000_000).to_be_bytes();
    let (mut values, mut now) = (Vec::new(), cycles[0].0);
    for (time, changes) in cycles {
        let mut step = (time - now) * 1_000_000;
        while !values.is_empty() && step > 0x3f {
            values.push(step as u8 | 0x80);
            step >>= 7;
        }
        if !values.is_empty() {
            values.push(step as u8);
        }
        now = time;
        let mut last = 0;
        for (pin, literal) in changes {
            values.extend([pin - last, literal]);
            last = pin;
        }
        values.push(0);
    }
    let names = names.concat();
    let count = names.matches('\0').count();
    let word = |number: usize| (number as u32).to_be_bytes();
    [
        b"GHDLwave\n\x10\0\x01\x02\x04\x01\0STR\0\0\0\0\0",
        &word(count)[..],
        &word(names.len() - count),
        names.as_bytes(),
        b"EOS\0TYP\0\0\0\0\0\0\0\0\x01\x17\0\x09",
        &[0; 9],
        b"\0WKT\0\0\0\0\0\x03\x01\0HIE\0\0\0\0\0",
        &[0; 12],
        &hierarchy,
        b"\0EOH\0SNP\0\0\0\0\0",
        &begin,
        &vec![2; pins.len()],
        b"ESN\0CYC\0",
        &begin,
        &values,
        b"\x7fECY\0DIR\0\x02\x04\x01\0",
        &word(8),
        &[0; 64],
        b"EOD\0TAI\0",
        &[0; 8],
    ]
    .concat()
}

/// Pins of a run, and their schedule.
fn write_pins(folder: &Folder) {
    let path = |name: &str| folder.path(name).display().to_string();
    let (plan, vcd) = (path("plan.jsonl"), path("pins.vcd"));
    let run = ["run", "sphere-along", "--quiet"];
    good(&[&run[..], &["--record", &plan, "--record", &vcd]].concat());
    let pins = folder.text("pins.vcd");
    fs::write(folder.path("pins.fst"), as_fst(&pins)).unwrap();
    fs::write(folder.path("pins.ghw"), as_ghw(&pins)).unwrap();
}

/// A file of every format in the table.
fn write_all(folder: &Folder) {
    write_pins(folder);
    let axis = |c: usize| ["X", "Y", "Z"][c % 3];
    let taxel = |c: usize| format!("txl{}_{}", c / 3 + 1, axis(c).to_lowercase());
    let own = names(taxel, ",");
    let plain_rows = lines(",", |_| String::new(), plain);
    folder.write("own.csv", &format!("{own}\n{plain_rows}"));
    let both = ["left_", "right_"].map(|side| names(|c| side.to_owned() + &taxel(c), ","));
    let twice: Vec<String> = plain_rows
        .lines()
        .map(|line| format!("{line},{line}"))
        .collect();
    folder.write(
        "two.csv",
        &format!("{}\n{}\n", both.join(","), twice.join("\n")),
    );
    let milli = |count: u16| format!("{:.3}", f64::from(count) / 1000.0);
    let units = lines(",", |row| format!("{},", row as f64 * 0.01), milli);
    folder.write("newtons.csv", &format!("t,{own}\n{units}"));
    let forces = |row: usize| format!("{0},{0},{row},", seconds(row));
    let head = names(|c| format!("{}{}", c / 3 + 1, axis(c)), ",");
    let force = names(|c| format!("Force {}{}", c / 3 + 1, axis(c)), ",");
    let zeros = vec!["0.0"; COUNTS].join(",");
    let rows = lines(",", forces, plain).replace('\n', &format!(",{zeros}\n"));
    let head = format!("Receive time,Send time,Message number,{head},{force}\n");
    folder.write("xela_log.csv", &(head + &rows));
    let message = |row: usize| {
        let data: Vec<String> = (0..COUNTS)
            .map(|c| format!("{:04X}", count(row, c)))
            .collect();
        let (time, data) = (seconds(row), data.join(","));
        format!(
            "{{\"message\":{row},\"time\":{time},\"sensors\":1,\"1\":{{\"data\":\"{data}\",\"model\":\"uSPa44\",\"calibrated\":null}}}}\n"
        )
    };
    let greeting = "{\"message\":\"Welcome\",\"sensors\":1}\n".to_owned();
    folder.write(
        "xela_server.jsonl",
        &(greeting + &(0..ROWS).map(message).collect::<String>()),
    );
    let head = format!("%time,{}\n", names(|c| format!("field.data{c}"), ","));
    let ns = |row: usize| format!("{},", 1_772_366_400_000_000_000 + row as u64 * 10_000_000);
    folder.write("rostopic.csv", &(head + &lines(",", ns, plain)));
    let head = format!("secs,nsecs,{}\n", names(|c| format!("data[{c}]"), ","));
    let stamp = |row: usize| format!("1772366400,{},", row * 10_000_000);
    folder.write("stamps.csv", &(head + &lines(",", stamp, plain)));
    let port = |row: usize| format!("{row} {:.6} ", seconds(row));
    folder.write("data.log", &lines(" ", port, |c| format!("{c}.000000")));
    let head = format!("# t {}\n", names(|c| format!("c{c}"), " "));
    let elapsed = |row: usize| format!("{:.18e} ", row as f64 * 0.01);
    let float = |c: u16| format!("{:.18e}", f64::from(c));
    folder.write("savetxt.txt", &(head + &lines(" ", elapsed, float)));
    let head = format!(
        "\u{FEFF}Zeit;Time (ms);{};\r\n",
        names(|c| format!("Kanal {c}"), ";")
    );
    let clock = |row: usize| format!("x;{},0;", row * 10);
    let rows = lines(";", clock, |c| format!("{c},0")).replace('\n', ";\r\n");
    folder.write("tabelle.csv", &(head + &rows));
    let head = format!("Zeit;{}\n", names(|c| format!("Kanal {c}"), ";"));
    // Midnight comes in the middle.
    let night = |row: usize| match row {
        0..30 => format!("31.03.2026 23:59:59,{};", row + 70),
        _ => format!("01.04.2026 00:00:00,{:02};", row - 30),
    };
    folder.write(
        "excel.csv",
        &format!("sep=;\n{head}{}", lines(";", night, plain)),
    );
    let units = vec!["counts"; COUNTS].join(",");
    let head = names(|c| format!("ai{c}"), ",");
    let words = "Instrument,DAQ 9,serial 12\nSample rate=100\n\n";
    let rows = lines(",", |row| format!("{},", row * 10), plain);
    folder.write("daq.csv", &format!("{words}t,{head}\nms,{units}\n{rows}"));
    let american = |row: usize| format!("3/31/2026,11:59:59.{:02} PM,", row);
    let rows = lines(",", american, plain);
    folder.write("days.csv", &format!("Date,Time,{head}\n{rows}"));
    // Sorted as texts are: ch0, ch1, ch10.
    let mut order: Vec<usize> = (0..COUNTS).collect();
    order.sort_by_key(|c| c.to_string());
    let mut sorted = order
        .iter()
        .map(|c| format!("ch{c}"))
        .collect::<Vec<_>>()
        .join(",");
    for row in 0..ROWS {
        let row: Vec<String> = order.iter().map(|c| plain(count(row, *c))).collect();
        sorted += &format!("\n{}", row.join(","));
    }
    folder.write("sorted.csv", &sorted);
    fs::write(folder.path("counts.npy"), npy()).unwrap();
    fs::write(folder.path("counts.npz"), npz()).unwrap();
    fs::write(folder.path("counts.mat"), mat()).unwrap();
    fs::write(folder.path("bag.mcap"), mcap(true)).unwrap();
    fs::write(folder.path("two.mcap"), mcap(false)).unwrap();
    fs::write(folder.path("packed.mcap"), packed(&mcap(true))).unwrap();
    write_frames(folder);
    for (name, start) in [
        ("table.parquet", &b"PAR1\x15\x04"[..]),
        ("data.h5", b"\x89HDF\r\n\x1a\n"),
        ("bag.db3", b"SQLite format 3\0"),
        (
            "can.asc",
            b"date Sun Mar 1 12:00:00 pm 2026\nbase hex  timestamps absolute\n",
        ),
        ("can.blf", b"LOGG\x90\0\0\0"),
        ("can.trc", b";$FILEVERSION=2.0\n"),
        (
            "gvret.csv",
            b"Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n",
        ),
    ] {
        fs::write(folder.path(name), start).unwrap();
    }
}

/// Frames of sixteen lines of three counts: after one another, as Tekscan writes them, and in a file each.
fn write_frames(folder: &Folder) {
    let frame = |row: usize| -> String {
        let line = |taxel: usize| -> String {
            let counts: Vec<String> = (0..3).map(|c| plain(count(row, 3 * taxel + c))).collect();
            counts.join(",") + "\n"
        };
        (0..COUNTS / 3).map(line).collect()
    };
    let slices: String = (0..ROWS).map(|row| frame(row) + "# New slice\n").collect();
    folder.write(
        "frames.txt",
        &format!("# Array shape: ({ROWS}, 16, 3)\n{slices}"),
    );
    let head = "DATA_TYPE MOVIE\nVERSION I-Scan 7.60\nROWS 16\nCOLS 3\nSECONDS_PER_FRAME 0.01\nUNITS Raw\nASCII_DATA @@\n";
    let movie: String = (0..ROWS)
        .map(|row| format!("\nFrame {}\n{}", row + 1, frame(row)))
        .collect();
    folder.write("movie.asf", &format!("{head}{movie}\n@@\n"));
    fs::create_dir_all(folder.path("frames")).unwrap();
    for row in 0..ROWS {
        folder.write(&format!("frames/frame_{row}.csv"), &frame(row));
    }
}

/// Contacts without their times.
fn untimed(table: &str) -> Vec<String> {
    let without = |line: &str| {
        let mut fields: Vec<&str> = line.split(',').collect();
        fields.remove(1);
        fields.join(",")
    };
    table.lines().map(without).collect()
}

#[test]
fn every_row_of_the_table_does_what_it_says() {
    let folder = Folder::new("recordings");
    write_all(&folder);
    let of = |command: &str| {
        let words = command.split_whitespace().skip(1);
        let args: Vec<String> = words
            .map(|word| match folder.path(word) {
                path if path.exists() => path.display().to_string(),
                _ => word.to_owned(),
            })
            .collect();
        hil(&args.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let own = of("hil contacts own.csv --layout uskin-4x4 --rate 100");
    assert_eq!(own.status, Some(0), "{}", own.err);
    let expected = untimed(&own.out);
    assert!(expected.len() > 30, "a finger wanders over the pad");
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/recordings.md");
    let page = fs::read_to_string(page).unwrap();
    let mut rows = 0;
    for line in page.lines().filter(|line| line.contains("| `hil ")) {
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let [_, _, command, result] = cells[..] else {
            panic!("four cells: {line}");
        };
        let said = of(command.trim_matches('`'));
        let texts: Vec<&str> = result.split('`').skip(1).step_by(2).collect();
        match result.split_once(' ').map_or(result, |(first, _)| first) {
            "contacts;" | "contacts" => {
                assert_eq!(said.status, Some(0), "{command}: {}", said.err);
                assert_eq!(untimed(&said.out), expected, "{command}");
            }
            "run;" | "compared" => assert_eq!(said.status, Some(0), "{command}: {}", said.err),
            _ => assert_eq!(said.status, Some(2), "{command}: {}", said.err),
        }
        // Names stand between backquotes in a message, and between quotes in a cell.
        let err = said.err.replace('`', "\"");
        for text in texts {
            assert!(err.contains(text), "{command}: `{text}` in {}", said.err);
        }
        rows += 1;
    }
    assert_eq!(rows, 35, "the rows of the table");
}
