//! `hil new`: a commented file with the values that differ from the defaults.

mod motors;

use std::fmt::Write as _;
use std::io::{self, BufRead, IsTerminal};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use palpate_core::physics::AIR_POWER;
use palpate_files::{FileKind, LayoutFile, load_layout, load_skin, load_wire, resolve};
use palpate_run::Failure;

use crate::cli::{
    LayoutKind, Motion, NewBench, NewFile, NewKind, NewLayout, NewProtocol, NewScene, NewWire,
    positive, whole,
};
use palpate_live::output::{make_folder, print, write_text};

const SCENE: &str = include_str!("new/scene.toml");
const TOUCH: &str = include_str!("new/touch.toml");
const BENCH: &str = include_str!("new/bench.toml");
const REAL: &str = include_str!("new/real.toml");
const SENSOR: &str = include_str!("new/sensor.toml");
const DISPLAY: &str = include_str!("new/display.toml");

/// The folder beside a new file that holds the schema for editors.
const SCHEMAS: &str = ".schemas";

/// Writes a new file.
///
/// # Errors
/// [`Failure::Input`] for a name that is none, a file that is there, or a layout that cannot be touched.
pub fn new(kind: &NewKind) -> Result<(), Failure> {
    let (file, kind, body) = match kind {
        NewKind::Scene(args) => (&args.file, FileKind::Scene, scene(args)?),
        NewKind::Bench(args) => (&args.file, FileKind::Bench, bench(args)?),
        NewKind::Layout(args) => (&args.file, FileKind::Layout, layout(args)?),
        NewKind::Wire(args) => (&args.file, FileKind::Wire, wire(args)?),
        NewKind::Protocol(args) => (&args.file, FileKind::Protocol, protocol(args)?),
    };
    let path = path(file);
    write_schema(&path, kind)?;
    let text = format!("#:schema {SCHEMAS}/{}.json\n{body}", kind.name());
    write_text(&path, &text)?;
    let next = match kind {
        FileKind::Scene => format!("hil run {}", path.display()),
        FileKind::Bench => format!("hil run --bench {}", path.display()),
        FileKind::Protocol => format!("hil study simulate {}", path.display()),
        _ => format!("hil check {}", path.display()),
    };
    print(|out| writeln!(out, "wrote {}; next: {next}", path.display()))
}

/// Writes the schema of a kind of file into a folder beside one that has its first line from there.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_schema(beside: &Path, kind: FileKind) -> Result<(), Failure> {
    let folder = beside.with_file_name(SCHEMAS);
    make_folder(&folder)?;
    let text = palpate_fixtures::schema(kind.name()).unwrap_or_default();
    write_text(&folder.join(format!("{}.json", kind.name())), text)
}

fn path(file: &NewFile) -> PathBuf {
    let name = format!("{}.toml", file.name);
    match &file.out {
        Some(folder) if folder.is_dir() => folder.join(name),
        Some(path) => path.clone(),
        None => name.into(),
    }
}

/// Refuses, before anything is asked, a bad name or a file that is there.
fn refuse(file: &NewFile) -> Result<(), Failure> {
    let letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if file.name.is_empty() || !file.name.chars().all(letter) {
        return Err(Failure::Input(format!(
            "{}: expected a name of lower-case letters, digits and hyphens; --out names the file",
            file.name
        )));
    }
    expect_new(&path(file), file.force)
}

/// Refuses a file that is there.
///
/// # Errors
/// [`Failure::Input`] for it, unless with `force`.
pub fn expect_new(path: &Path, force: bool) -> Result<(), Failure> {
    match path.exists() && !force {
        false => Ok(()),
        true => Err(Failure::Input(format!(
            "{}: expected a file that is not there yet; --force overwrites it",
            path.display()
        ))),
    }
}

/// A value from the command line, else from a person at a terminal, else the default.
fn value<T: Clone>(
    given: &Option<T>,
    question: &str,
    default: &str,
    read: impl Fn(&str) -> Result<T, String>,
) -> Result<T, Failure> {
    if let Some(value) = given {
        return Ok(value.clone());
    }
    let ours = |text: &str| read(text).map_err(Failure::Input);
    if !(io::stdin().is_terminal() && io::stdout().is_terminal()) {
        return ours(default);
    }
    loop {
        print(|out| write!(out, "{question} [{default}]: "))?;
        let mut line = String::new();
        let read_line = io::stdin().lock().read_line(&mut line);
        match (read_line, line.trim()) {
            // Ctrl-D takes the default, as Enter does.
            (Ok(_), "") | (Err(_), _) => return ours(default),
            (Ok(_), text) => match read(text) {
                Ok(value) => return Ok(value),
                Err(error) => print(|out| writeln!(out, "{error}"))?,
            },
        }
    }
}

fn word<T: ValueEnum + Clone>(text: &str) -> Result<T, String> {
    T::from_str(text, true)
}

fn text(text: &str) -> Result<String, String> {
    Ok(text.to_owned())
}

/// A layout that can be read, by name or path.
fn known_layout(name: &str) -> Result<String, String> {
    let read = load_layout(name);
    read.map_err(|error| error.to_string()).map(|_| name.into())
}

/// A text as TOML writes it, which is how JSON does.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// The first lines of every file.
fn heading(file: &NewFile, page: &str, default: &str) -> Result<String, Failure> {
    let description = value(
        &file.description,
        "what is it, in a sentence",
        default,
        text,
    )?;
    Ok(format!(
        "# What is not stated has its default: {page} lists every key.\nname = {}\ndescription = {}\n",
        quoted(&file.name),
        quoted(&description)
    ))
}

/// A template whose lines `key = {key}` have their values, and are comments where a value is the default.
fn filled(template: &str, values: &[(&str, String, &str)]) -> String {
    let mut text = template.to_owned();
    for (key, value, default) in values {
        let mark = if value == default { "# " } else { "" };
        let line = format!("{mark}{key} = {value}");
        text = text.replace(&format!("{key} = {{{key}}}"), &line);
    }
    text
}

fn listed<T: AsRef<str>>(texts: impl IntoIterator<Item = T>) -> String {
    let texts = texts.into_iter().map(|text| quoted(text.as_ref()));
    format!("[{}]", texts.collect::<Vec<_>>().join(", "))
}

/// A number as TOML writes it.
fn float(number: f64) -> String {
    format!("{number:?}")
}

fn scene(args: &NewScene) -> Result<String, Failure> {
    refuse(&args.file)?;
    let layout = value(&args.layout, "sensor layout", "uskin-4x4", known_layout)?;
    let place = middle(&layout)?;
    let motion = value(&args.path, "path: line, circle, hold or none", "line", word)?;
    let length = value(&args.length_s, "length, seconds", "10", positive)?;
    if motion != Motion::None && length < 2.0 {
        return Err(Failure::Input(format!(
            "--length-s: expected at least 2 s for a touch, found {length}"
        )));
    }
    let what = match motion {
        Motion::Line => "A sphere rolls along the pad and back",
        Motion::Circle => "A sphere rolls around the pad's middle",
        Motion::Hold => "A sphere rests on the pad's middle",
        Motion::None => "Nothing touches the skin",
    };
    let touch = place
        .path(motion)
        .map(|path| TOUCH.replace("{path}", &path));
    let values = [
        ("length_s", float(length), "10.0"),
        ("layout", quoted(&layout), "\"uskin-4x4\""),
    ];
    let text = filled(SCENE, &values).replace("{touch}", &touch.unwrap_or_default());
    Ok(heading(&args.file, "docs/files/scene.md", what)? + &text)
}

/// Field of a module's taxels: its middle, and half its size, mm.
struct Pad {
    x: f64,
    y: f64,
    half: [f64; 2],
}

/// The pad of a layout's first module.
fn middle(layout: &str) -> Result<Pad, Failure> {
    let sensor = load_skin(layout)?.value;
    let taxels = sensor.modules.first().map(|m| m.taxels());
    let taxels = taxels.unwrap_or_default();
    let span = |of: fn(&palpate_files::Taxel) -> f64| {
        let low = taxels.iter().map(of).fold(f64::INFINITY, f64::min);
        let high = taxels.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        ((low + high) / 2.0, (high - low) / 2.0)
    };
    let ((x, half_x), (y, half_y)) = (span(|t| t.x_mm), span(|t| t.y_mm));
    Ok(Pad {
        x,
        y,
        half: [half_x, half_y],
    })
}

impl Pad {
    /// The path of a touch, in the scene's words; none where nothing touches.
    fn path(&self, motion: Motion) -> Option<String> {
        let round = |v: f64| float((v * 100.0).round() / 100.0 + 0.0);
        let point = |x: f64, y: f64| format!("[{}, {}]", round(x), round(y));
        let &Self { x, y, half } = self;
        let [along, across] = half;
        let radius = 0.6 * along.min(across);
        Some(match motion {
            Motion::None => return None,
            Motion::Circle if radius > 0.1 => format!(
                "{{ kind = \"circle\", centre_mm = {}, radius_mm = {}, period_s = 4.0 }}",
                point(x, y),
                round(radius)
            ),
            Motion::Line if along.max(across) > 0.1 => {
                // Along the longer side.
                let [u, v] = if along >= across {
                    [along, 0.0]
                } else {
                    [0.0, across]
                };
                format!(
                    "{{ kind = \"line\", points_mm = [{}, {}], period_s = 4.0 }}",
                    point(x - u, y - v),
                    point(x + u, y + v)
                )
            }
            Motion::Circle | Motion::Line | Motion::Hold => {
                format!("{{ kind = \"hold\", points_mm = [{}] }}", point(x, y))
            }
        })
    }
}

fn bench(args: &NewBench) -> Result<String, Failure> {
    refuse(&args.file)?;
    let real = !args.can.is_empty();
    let display = value(&args.display, "display layout", "thimble-8", known_layout)?;
    let LayoutFile::Display(wires) = load_layout(&display)?.value else {
        return Err(Failure::Input(format!(
            "--display {display}: expected a layout of kind \"display\", found a sensor"
        )));
    };
    if let Some(kind) = args.motors {
        return motors::bench(args, kind, (&display, wires.wires_mm.len()));
    }
    let known = |name: &str| {
        let read = load_wire(name).map_err(|error| error.to_string());
        read.map(|_| name.to_owned())
    };
    let wire = value(&args.wire, "wire", "final-75um", known)?;
    load_wire(&wire)?;
    let current = value(
        &args.current_ma,
        "current of a wire that is on, mA",
        "990",
        positive,
    )?;
    let question = "most current of the supply, mA";
    let supply = value(&args.supply_limit_ma, question, "4000", positive)?;
    let what = if real {
        "Buses and wires of our own"
    } else {
        "An emulated bench of our own"
    };
    let mut out = heading(&args.file, "docs/files/bench.md", what)?;
    // A real bench states its hardware, default or not.
    let usual = |text: &'static str| if real { "" } else { text };
    let values = [
        ("display", quoted(&display), usual("\"thimble-8\"")),
        ("wire.kind", quoted(&wire), usual("\"final-75um\"")),
        ("wire.alloy", quoted("low"), usual("\"low\"")),
        ("drive.current_ma", float(current), usual("990.0")),
        ("drive.supply_limit_ma", float(supply), usual("4000.0")),
        ("drive.hot_pass", (!real).to_string(), usual("true")),
    ];
    out.push_str(&filled(BENCH, &values));
    if real {
        let i2c = args.i2c.iter().map(|path| path.display().to_string());
        let values = [("can", listed(&args.can), ""), ("i2c", listed(i2c), "")];
        out.push_str(&filled(REAL, &values));
        for wire in 0..wires.wires_mm.len() {
            let (board, channel) = (0x40 + wire / 16, wire % 16);
            // Writing to a text does not fail.
            let _ = write!(
                out,
                "[[outputs]]\nboard = {board:#04x}\nchannel = {channel}\n"
            );
        }
    }
    Ok(out)
}

fn layout(args: &NewLayout) -> Result<String, Failure> {
    refuse(&args.file)?;
    let kind = value(&args.kind, "kind: sensor or display", "sensor", word)?;
    let count = whole::<u16, 1, 256>;
    let (usual, gap) = match kind {
        LayoutKind::Sensor => ("4", "4.7"),
        LayoutKind::Display => ("2", "10.0"),
    };
    let rows = value(&args.rows, "rows", usual, count)?;
    let columns = value(&args.columns, "columns", usual, count)?;
    let pitch = value(&args.pitch_mm, "distance of neighbours, mm", gap, positive)?;
    let what = match kind {
        LayoutKind::Sensor => format!("{rows}x{columns} taxels, {pitch} mm apart"),
        LayoutKind::Display => format!("{rows}x{columns} wires, {pitch} mm apart"),
    };
    let mut out = heading(&args.file, "docs/files/layout.md", &what)?;
    let template = match kind {
        LayoutKind::Sensor => SENSOR,
        LayoutKind::Display => DISPLAY,
    };
    let size = template.replace("{rows}", &rows.to_string());
    let size = size.replace("{columns}", &columns.to_string());
    out.push_str(&size.replace("{pitch_mm}", &float(pitch)));
    match kind {
        // What a board on the bus can carry; a larger skin has recordings alone.
        LayoutKind::Sensor if rows <= 8 && columns <= 8 => {
            let boards = 1..=(rows * columns).div_ceil(16);
            let boards: Vec<String> = boards.map(|board| board.to_string()).collect();
            let boards = boards.join(", ");
            let _ = writeln!(
                out,
                "bus = 0\nboards = [{boards}] # addresses, 16 taxels each"
            );
        }
        LayoutKind::Sensor => {}
        LayoutKind::Display => {
            out.push_str("wires_mm = [\n");
            for row in 0..rows {
                for column in 0..columns {
                    let at = |n: u16, of: u16| (f64::from(n) - f64::from(of - 1) / 2.0) * pitch;
                    let (x, y) = (at(column, columns), -at(row, rows) + 0.0);
                    let _ = writeln!(out, "    [{x:?}, {y:?}],");
                }
            }
            out.push_str("]\n");
        }
    }
    Ok(out)
}

fn wire(args: &NewWire) -> Result<String, Failure> {
    refuse(&args.file)?;
    let base = load_wire("final-75um")?.value;
    let diameter = value(&args.diameter_um, "diameter, micrometres", "75", positive)?;
    let length = value(
        &args.length_mm,
        "length between the crimps, mm",
        "5",
        positive,
    )?;
    // The wire's own part follows its size; crimps and leads stay.
    let own = base.electrical.resistance_ohm * base.electrical.wire_share;
    let scaled = own * length / base.length_mm * (base.diameter_um / diameter).powi(2);
    let whole = scaled + base.electrical.resistance_ohm - own;
    let usual = float((whole * 1000.0).round() / 1000.0);
    let question = "resistance between the terminals, Ohm";
    let resistance = value(&args.resistance_ohm, question, &usual, positive)?;
    let share = (scaled / resistance * 1000.0).round() / 1000.0;
    if share > 1.0 {
        return Err(Failure::Input(format!(
            "--resistance-ohm: expected at least {scaled:.3} Ohm, which such a wire has without crimps, found {resistance}"
        )));
    }
    // Still air takes more heat per area from a thinner wire.
    let air = base.thermal.air_w_m2k * (diameter / base.diameter_um).powf(AIR_POWER);
    let what = format!("NiTi, {diameter} um thick, {length} mm between its crimps");
    let heading = heading(&args.file, "docs/files/bench.md", &what)?;
    // Every value of a wire is stated: the built-in one's, but for its size and resistance.
    let text = palpate_fixtures::wire("final-75um").unwrap_or_default();
    let stated = |line: &str| match line.split(['=', ' ']).next().unwrap_or_default() {
        "name" | "description" => None,
        "diameter_um" => Some(format!("diameter_um = {}", float(diameter))),
        "length_mm" => Some(format!("length_mm = {}", float(length))),
        "resistance_ohm" => Some(format!(
            "resistance_ohm = {} # between the terminals; measure it",
            float(resistance)
        )),
        "wire_share" => Some(format!(
            "wire_share = {} # what of it is wire, computed",
            float(share)
        )),
        "air_w_m2k" => Some(format!("air_w_m2k = {} # still air", float(air.ceil()))),
        _ if line.starts_with('#') => None,
        _ => Some(line.to_owned()),
    };
    let rows: Vec<String> = text.lines().filter_map(stated).collect();
    Ok(format!("{heading}{}\n", rows.join("\n")))
}

/// A built-in protocol under a new name, whose tasks, conditions and people are to be changed.
fn protocol(args: &NewProtocol) -> Result<String, Failure> {
    refuse(&args.file)?;
    let like = resolve(FileKind::Protocol, &args.like)?;
    let what = format!("A study like {}", args.like);
    let heading = heading(&args.file, "docs/study.md", &what)?;
    let own = |line: &&str| {
        !["name = ", "description = "]
            .iter()
            .any(|k| line.starts_with(k))
    };
    // Names further down are those of conditions and questions.
    let tables = like.text().find("\n[").unwrap_or(like.text().len());
    let (top, rest) = like.text().split_at(tables);
    let top: Vec<&str> = top.lines().filter(own).collect();
    Ok(format!("{heading}{}{rest}", top.join("\n")))
}
