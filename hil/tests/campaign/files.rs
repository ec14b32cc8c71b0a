//! Every reader with every kind of bad file.

use super::{Expect, Try};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A scene of a second, short enough to run often.
const SCENE: &str = "name = \"short\"\ndescription = \"a second\"\nlength_s = 1.5\n\
    illusion = { model = \"balanced\", beta = 0.0049 }\n\
    [[touches]]\nstart_s = 0.6\npath = { kind = \"line\", points_mm = [[-5.0, 0.0], [5.0, 0.0]], period_s = 1.0 }\n\
    force_n = { mean = 0.7, amplitude = 0.1, period_s = 1.0 }\n";

/// A file that a command takes as it is.
struct Reader {
    /// The good file.
    good: &'static str,
    /// The command, `{}` for the file.
    args: Vec<&'static str>,
    /// The name of the bad ones.
    named: String,
}

impl Reader {
    fn all() -> impl Iterator<Item = Self> {
        READERS.into_iter().map(|(good, args)| Self {
            good,
            args: args.split(' ').collect(),
            named: good
                .rsplit_once('.')
                .map_or_else(String::new, |(_, e)| format!("bad.{e}")),
        })
    }

    fn call(&self, path: &str, expect: Expect) -> Try {
        // A sweep wants a table of its own.
        static TABLES: AtomicUsize = AtomicUsize::new(0);
        let table = format!("made-{}.csv", TABLES.fetch_add(1, Ordering::Relaxed));
        let args = self.args.iter();
        let args = args.map(|a| a.replace("{}", path).replace("{table}", &table));
        Try {
            args: args.collect(),
            around: "",
            expect,
        }
    }
}

/// Good files, and the commands that read them: `{}` stands for the file.
const READERS: [(&str, &str); 39] = [
    ("taxels.csv", "run --replay {} --layout uskin-4x4"),
    ("taxels.csv", "contacts {} --layout uskin-4x4"),
    ("taxels.csv", "texture encode default {}"),
    ("a.log", "run --replay {} --layout uskin-4x4"),
    ("a.log", "replay {} --can nocan0"),
    ("a.mcap", "run --replay {} --layout uskin-4x4"),
    ("a.jsonl", "diff a.jsonl {}"),
    ("a.snap", "diff {} a.snap"),
    ("a.csv", "diff a.csv {}"),
    ("a.vcd", "diff a.jsonl {}"),
    ("edges.csv", "diff a.jsonl {}"),
    ("scene.toml", "run {}"),
    ("scene.toml", "test {}"),
    ("scene.toml", "export taxels {} --out made.csv"),
    ("bench.toml", "run scene.toml --bench {}"),
    ("layout.toml", "run scene.toml --set layout={}"),
    ("layout.toml", "new scene mine --force --layout {}"),
    ("wire.toml", "new bench weak --force --wire {}"),
    ("limits.toml", "run scene.toml --set bench.limits={}"),
    ("model.safetensors", "texture export {} --out made.onnx"),
    ("quarantine.toml", "test scene.toml --quarantine {}"),
    ("trace.csv", "identify {}"),
    ("bench.toml", "identify trace.csv --bench {}"),
    ("summary.json", "compare summary.json {}"),
    ("sweep.csv", "compare sweep.csv {}"),
    ("sweep.jsonl", "compare {} sweep.jsonl"),
    ("scene.toml", "sweep {} --out {table} --force"),
    (
        "bench.toml",
        "sweep scene.toml --out {table} --force --bench {}",
    ),
    ("wire.toml", "design --seconds=3 --pulses=2 --wire {}"),
    ("alloy.toml", "design --seconds=3 --pulses=2 --alloy {}"),
    ("person.toml", "design --seconds=3 --pulses=2 --person {}"),
    ("person.toml", "run scene.toml --person {}"),
    ("scene.toml", "check {}"),
    ("layout.toml", "contacts taxels.csv --layout {}"),
    ("layout.toml", "run --replay taxels.csv --layout {}"),
    ("model.safetensors", "texture encode {} taxels.csv"),
    ("model.safetensors", "texture map {} --strokes 1"),
    ("textures.toml", "texture map --strokes 1 --textures {}"),
    (
        "textures.toml",
        "texture strokes --out strokes --strokes 1 --textures {}",
    ),
];

/// What is done to a good file.
type Change = fn(&[u8]) -> Vec<u8>;

/// Changes that make any file bad, whatever its format.
const RUINS: [(&str, Change); 13] = [
    ("empty", |_| Vec::new()),
    ("space", |_| b" \n\t\n \n".to_vec()),
    ("nuls", |_| vec![0; 5000]),
    ("random", |_| noise(5000)),
    ("png", |_| b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec()),
    ("gzip", |_| b"\x1f\x8b\x08\0\0\0\0\0\0\x03".to_vec()),
    ("utf16", |good| {
        let text = String::from_utf8_lossy(good);
        let units = text.encode_utf16().flat_map(u16::to_le_bytes);
        [0xff, 0xfe].into_iter().chain(units).collect()
    }),
    ("latin1", |good| [b"\xe9\xe8\n", good].concat()),
    ("prose", |_| {
        b"Dear reader, this is a letter, not a file of numbers.\n".to_vec()
    }),
    ("html", |_| {
        b"<!DOCTYPE html><html><body>404</body></html>\n".to_vec()
    }),
    ("deep", |_| {
        [vec![b'['; 200_000], vec![b'{'; 200_000]].concat()
    }),
    ("long-line", |_| vec![b'7'; 3 << 20]),
    ("scopes", |_| {
        let scopes = b"$scope module a $end\n".repeat(40_000);
        [b"$timescale 1 ns $end\n", scopes.as_slice()].concat()
    }),
];

/// Changes to a text of lines: in their middle, and at their ends.
const TEXT_CHANGES: [(&str, Change); 9] = [
    ("junk", |good| in_middle(good, |_| "%& no such line".into())),
    ("nan", |good| in_middle(good, |line| number(line, "nan"))),
    ("inf", |good| in_middle(good, |line| number(line, "inf"))),
    ("huge", |good| in_middle(good, |line| number(line, "1e999"))),
    ("negative", |good| {
        in_middle(good, |line| number(line, "-7"))
    }),
    ("nothing", |good| in_middle(good, |line| number(line, ""))),
    ("nul-middle", |good| {
        in_middle(good, |line| format!("{line}\0\0\0"))
    }),
    ("comma", |good| {
        in_middle(good, |line| format!("{line},1,2"))
    }),
    ("back", |good| {
        let mut lines = lines(good);
        let middle = lines.len() / 2;
        lines[1..].rotate_left(middle.max(1) - 1);
        (lines.join("\n") + "\n").into_bytes()
    }),
];

/// Numbers without meaning, the same each time.
fn draws(seed: u32) -> impl FnMut() -> u32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    }
}

/// Bytes without meaning, none of which begins like a text.
fn noise(count: usize) -> Vec<u8> {
    let mut draw = draws(1);
    (0..count).map(|_| (draw() >> 16) as u8 | 0x80).collect()
}

/// Files with damage at random places: a cut, a byte that is another, a piece that stands elsewhere.
pub fn damaged(folder: &Path, count: u32) -> Vec<Try> {
    let mut tries = Vec::new();
    for (number, reader) in Reader::all().enumerate() {
        let good = fs::read(folder.join(reader.good)).unwrap();
        for seed in 0..count {
            let mut draw = draws(1 + seed * 7919);
            let mut at = || draw() as usize % good.len().max(1);
            let mut bad = good.clone();
            match seed % 3 {
                0 => bad.truncate(at()),
                1 => bad[at()] = at() as u8,
                _ => bad.rotate_left(at()),
            }
            let path = format!("{number}-damaged-{seed}-{}", reader.named);
            fs::write(folder.join(&path), bad).unwrap();
            tries.push(reader.call(&path, Expect::Survived));
        }
    }
    tries
}

fn lines(text: &[u8]) -> Vec<String> {
    String::from_utf8_lossy(text)
        .lines()
        .map(str::to_owned)
        .collect()
}

fn in_middle(good: &[u8], change: impl Fn(&str) -> String) -> Vec<u8> {
    let mut lines = lines(good);
    let middle = lines.len() / 2;
    if let Some(line) = lines.get_mut(middle) {
        // Nothing is wrong in a remark at a line's end.
        let plain = line.split(" # ").next().unwrap_or_default();
        *line = change(plain);
    }
    (lines.join("\n") + "\n").into_bytes()
}

/// A line with its last number replaced.
fn number(line: &str, by: &str) -> String {
    let end = line
        .rfind(|c: char| c.is_ascii_digit())
        .map_or(line.len(), |i| i + 1);
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let start = line[..end].rfind(|c| !is_part(c)).map_or(0, |i| i + 1);
    format!("{}{by}{}", &line[..start], &line[end..])
}

/// What is no ordinary file, or cannot be opened.
const PLACES: [&str; 9] = [
    "nothing-there",
    "folder",
    "/dev/zero",
    "/dev/urandom",
    "/dev/tty",
    "fifo",
    "loop",
    "dangling",
    "sparse",
];

/// Where a change leaves something that can be read, and how that is told.
fn exception(reader: &Reader, change: &str) -> Option<Expect> {
    let toml = reader.named == "bad.toml";
    Some(match (reader.args[0], reader.good, change) {
        // A frame of fewer bytes is one.
        ("run", "a.log", "nothing") => Expect::Good,
        ("replay", _, "nothing") => Expect::Ends(3, "nocan0"),
        // A line of a log without a frame is counted, as can-utils passes it over.
        ("run", "a.log", "junk") => Expect::Ends(0, "1 remark was passed over"),
        ("replay", "a.log", "junk") => Expect::Ends(3, "1 remark was passed over"),
        // Features are any numbers.
        ("texture", "taxels.csv", "negative") => Expect::Good,
        // The middle of this golden is its count of events.
        ("diff", "a.snap", "nan" | "inf" | "huge" | "negative" | "nothing" | "comma") => {
            Expect::Ends(2, "events")
        }
        // A damaged capture is read as far as it goes.
        ("diff", "a.vcd", "huge" | "comma" | "negative") => Expect::Ends(1, "FAILED"),
        ("diff", "a.vcd", "junk" | "nan" | "inf" | "nothing") => Expect::Ends(1, "INCOMPLETE"),
        ("diff", "edges.csv", "nul-middle") => return None,
        ("diff", "edges.csv", change) if TEXT_CHANGES.iter().any(|c| c.0 == change) => {
            Expect::Ends(1, "INCOMPLETE")
        }
        // A figure is any number, and rows stand in any order.
        ("compare", _, "negative") => Expect::Ends(1, "FAILED"),
        ("compare", "sweep.csv", "nothing") => Expect::Ends(1, "FAILED"),
        ("compare", "sweep.csv" | "sweep.jsonl", "back") => Expect::Good,
        // What loses a digit or stands elsewhere is still a setting.
        ("test", "scene.toml" | "quarantine.toml", "nothing") => {
            Expect::Ends(1, "nothing was tested")
        }
        ("test", "quarantine.toml", "back") => Expect::Ends(1, "nothing was tested"),
        (_, "bench.toml" | "limits.toml" | "alloy.toml", "back") => Expect::Good,
        ("new" | "design", "wire.toml" | "alloy.toml", "nothing") => return None,
        (_, "textures.toml" | "person.toml", "nothing") => return None,
        (_, _, "nothing") if toml => Expect::Good,
        _ => return None,
    })
}

/// Changes that leave a good text good.
const HARMLESS: [(&str, Change); 3] = [
    ("bom", |good| [b"\xEF\xBB\xBF", good].concat()),
    ("crlf", |good| lines(good).join("\r\n").into_bytes()),
    ("unended", |good| good.trim_ascii_end().to_vec()),
];

/// How a command ends with a good file.
fn harmless(reader: &Reader, change: &str) -> Expect {
    match (reader.args[0], reader.good) {
        ("replay", _) => Expect::Ends(3, "nocan0"),
        ("diff", "edges.csv") => Expect::Ends(1, "INCOMPLETE"),
        // A last line that does not end was cut, maybe in a number; `crlf` ends none either.
        ("compare", "sweep.csv" | "sweep.jsonl") if change != "bom" => {
            Expect::Ends(1, "INCOMPLETE")
        }
        ("test", _) => Expect::Ends(1, "nothing was tested"),
        _ => Expect::Good,
    }
}

/// Makes good files, with the program itself where it writes them, and what is no file.
pub fn prepare(folder: &Path) {
    let write = |name: &str, text: &[u8]| fs::write(folder.join(name), text).unwrap();
    write("scene.toml", SCENE.as_bytes());
    let heading = "name = \"mine\"\ndescription = \"d\"\n";
    write(
        "bench.toml",
        format!("{heading}drive.current_ma = 900.0\n").as_bytes(),
    );
    write(
        "limits.toml",
        format!("{heading}pulse.width_us = 100.0\n").as_bytes(),
    );
    let fixture = |kind: &str, name: &str| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
        fs::read(root.join(kind).join(name)).unwrap()
    };
    write("layout.toml", &fixture("layouts", "uskin-4x4.toml"));
    write("wire.toml", &fixture("wires", "final-75um.toml"));
    write("alloy.toml", &fixture("alloys", "low.toml"));
    let person = String::from_utf8(fixture("persons", "typical.toml")).unwrap();
    let plain = |line: &str| line.split(" #").next().unwrap_or_default().to_owned();
    let person: Vec<String> = person.lines().map(plain).collect();
    write("person.toml", person.join("\n").as_bytes());
    write("textures.toml", &fixture("textures", "thesis.toml"));
    write("trace.csv", trace().as_bytes());
    write(
        "model.safetensors",
        &fixture("models", "default.safetensors"),
    );
    write(
        "quarantine.toml",
        b"[[quarantine]]\ntrial = \"short\"\nbench = \"emulated\"\nreason = \"r\"\n",
    );
    write(
        "edges.csv",
        b"Time [s],b0_ch0\n0.0,0\n0.5,1\n0.5001,0\n0.6,1\n",
    );
    let hil = |args: &[&str]| {
        let mut hil = Command::new(env!("CARGO_BIN_EXE_hil"));
        let said = hil.args(args).current_dir(folder).output().unwrap();
        assert!(
            said.status.success(),
            "{args:?}: {}",
            String::from_utf8_lossy(&said.stderr)
        );
    };
    let mut args = vec!["run", "scene.toml", "--quiet"];
    for record in ["a.csv", "a.jsonl", "a.log", "a.mcap", "a.vcd", "a.snap"] {
        args.extend(["--record", record]);
    }
    hil(&args);
    hil(&["export", "taxels", "scene.toml", "--out", "taxels.csv"]);
    write(
        "summary.json",
        b"{\n\"source\": \"emulated\",\n\"contacts\": 917,\n\"path_error_mm\": {\"rmse\": 0.17, \"max\": 2.1},\n\"verdict\": \"ok\"\n}\n",
    );
    for table in ["sweep.csv", "sweep.jsonl"] {
        hil(&[
            "sweep",
            "scene.toml",
            "--seeds",
            "1..3",
            "--quiet",
            "--out",
            table,
        ]);
    }
    fs::create_dir(folder.join("folder")).unwrap();
    symlink("loop", folder.join("loop")).unwrap();
    symlink("nowhere", folder.join("dangling")).unwrap();
    let fifo = Command::new("mkfifo")
        .arg(folder.join("fifo"))
        .status()
        .unwrap();
    assert!(fifo.success());
    let sparse = fs::File::create(folder.join("sparse")).unwrap();
    sparse.set_len(6 << 30).unwrap();
    write("locked", b"locked");
    fs::set_permissions(folder.join("locked"), fs::Permissions::from_mode(0o000)).unwrap();
}

/// A displacement that follows pulses of current.
fn trace() -> String {
    let mut text = "time_us,displacement_um,current_a\n".to_owned();
    let mut um = 0.0;
    for n in 0..100 {
        let amps = [1.4, 1.4, 0.0, 0.0, 0.0][n % 5];
        um = 0.9 * um + 2.0 * amps;
        text.push_str(&format!("{},{um:.4},{amps}\n", 100 * n));
    }
    text
}

/// The tries; the bad files are written on the way.
pub fn tries(folder: &Path) -> Vec<Try> {
    let mut tries = Vec::new();
    for (number, reader) in Reader::all().enumerate() {
        let good = fs::read(folder.join(reader.good)).unwrap();
        let call = |path: &str, expect: Expect| match (reader.args[0], expect) {
            // What is there has the error that it looked for.
            ("check", Expect::Refused(_)) if !path.is_empty() && folder.join(path).exists() => {
                reader.call(path, Expect::Ends(1, "error"))
            }
            (_, expect) => reader.call(path, expect),
        };
        for place in PLACES {
            let expect = match (reader.args[0], reader.good, place) {
                ("test", "scene.toml", "folder") => Expect::Ends(1, "nothing was tested"),
                _ => Expect::Refused(place.to_owned()),
            };
            tries.push(call(place, expect));
        }
        tries.push(call("", Expect::Refused(String::new())));
        if fs::read(folder.join("locked")).is_err() {
            tries.push(call("locked", Expect::Refused("locked".to_owned())));
        }
        let is_text = std::str::from_utf8(&good).is_ok();
        for (name, change) in HARMLESS.iter().filter(|_| is_text) {
            let path = format!("{number}-{name}-{}", reader.named);
            fs::write(folder.join(&path), change(&good)).unwrap();
            tries.push(call(&path, harmless(&reader, name)));
        }
        let texts = TEXT_CHANGES.iter().filter(|_| is_text);
        for (name, change) in RUINS.iter().chain(texts) {
            let path = format!("{number}-{name}-{}", reader.named);
            fs::write(folder.join(&path), change(&good)).unwrap();
            let refused = || Expect::Refused(path.clone());
            tries.push(call(
                &path,
                exception(&reader, name).unwrap_or_else(refused),
            ));
        }
    }
    tries
}
