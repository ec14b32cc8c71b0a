//! Formats by the first bytes of a file: refusals name them, and they decide on the files that an output may replace.

use std::path::Path;

/// A format that this project reads or writes, or that is often taken for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MCAP.
    Mcap,
    /// The log of `candump -l`.
    Candump,
    /// A schedule of ours, JSON Lines.
    Schedule,
    /// Contacts of ours, CSV.
    Contacts,
    /// A golden of ours (insta's format).
    Golden,
    /// Value change dump.
    Vcd,
    /// Value change dump, packed by GTKWave's library.
    Fst,
    /// Waveform of GHDL.
    Ghw,
    /// A page.
    Html,
    /// JUnit XML.
    Junit,
    /// A drawing.
    Svg,
    /// Another XML.
    Xml,
    /// A JSON object or array, no schedule.
    Json,
    /// Columns between commas, semicolons, tabs or blanks, no contacts.
    Csv,
    /// TOML: a scene, bench, layout.
    Toml,
    /// A model in safetensors.
    Safetensors,
    /// A model in ONNX.
    Onnx,
    /// An array of NumPy.
    Numpy,
    /// Arrays of NumPy in an archive.
    Npz,
    /// Samples of a sound card.
    Wav,
    /// Arrays of MATLAB, version 5.
    Matlab,
    /// A format that is refused: a picture, an archive, a log of another program. The name tells it, and how to
    /// convert it.
    Binary(&'static str),
}

/// Binary formats by their first bytes.
const MAGIC: [(&[u8], Format); 23] = [
    (b"\x89MCAP0\r\n", Format::Mcap),
    (b"\x1f\x8b", Format::Binary("gzip (gunzip --keep FILE.gz)")),
    (
        b"\x28\xb5\x2f\xfd",
        Format::Binary("zstd (unzstd FILE.zst)"),
    ),
    (b"PK\x03\x04", Format::Binary(SHEET)),
    (b"\xD0\xCF\x11\xE0", Format::Binary("an old spreadsheet")),
    (b"\x89HDF", Format::Binary(HDF5)),
    (b"PAR1", Format::Binary(PARQUET)),
    (b"ARROW1", Format::Binary(ARROW)),
    (b"\x80\x05\x95", Format::Binary(PICKLE)),
    (b"\x93NUMPY", Format::Numpy),
    (b"MATLAB 5.0", Format::Matlab),
    (
        b"MATLAB 7.3",
        Format::Binary("a MATLAB 7.3 file (save it again with `save -v7`)"),
    ),
    (b"\x89PNG", Format::Binary("a PNG picture")),
    (b"%PDF", Format::Binary("a PDF")),
    (b"\x7fELF", Format::Binary("a program")),
    (
        b"SQLite format 3",
        Format::Binary("an SQLite data base (of a bag: mcap convert FILE.db3 FILE.mcap)"),
    ),
    (
        b"#ROSBAG",
        Format::Binary("a ROS 1 bag (mcap convert FILE.bag FILE.mcap)"),
    ),
    (b"\0\0\0\0\0\0\0\x01\x49", Format::Fst),
    (b"\xFE\0\0\0", Format::Fst),
    (b"GHDLwave\n", Format::Ghw),
    (
        b"LOGG",
        Format::Binary("a Vector log (python -m can.logconvert FILE.blf FILE.log)"),
    ),
    (
        b"MDF     ",
        Format::Binary("an MDF log (python -m can.logconvert FILE.mf4 FILE.log)"),
    ),
    (
        b";$FILEVERSION",
        Format::Binary("a PCAN trace (python -m can.logconvert FILE.trc FILE.log)"),
    ),
];

const HDF5: &str = "HDF5 (python -c \"import h5py, numpy; numpy.savetxt('FILE.csv', h5py.File('FILE.h5')['DATASET'], \
                    delimiter=',')\")";
const PARQUET: &str = "Parquet (python -c \"import pandas; pandas.read_parquet('FILE.parquet').to_csv('FILE.csv', index=False)\")";
const SHEET: &str = "a zip archive or spreadsheet (python -c \"import pandas; pandas.read_excel('FILE.xlsx').to_csv('FILE.csv', index=False)\")";
const ARROW: &str = "Arrow (python -c \"import pandas; pandas.read_feather('FILE').to_csv('FILE.csv', index=False)\")";
const PICKLE: &str = "a Python pickle (python -c \"import pandas; pandas.read_pickle('FILE.pkl').to_csv('FILE.csv', index=False)\")";
/// CAN logs of other programs by the beginning of their text.
const CAN_TEXTS: [(&str, &str); 3] = [
    ("// version", ASC),
    (
        "timestamp,arbitration_id,",
        "CSV of python-can (python -m can.logconvert FILE.csv FILE.log)",
    ),
    ("Time Stamp,ID,Extended,", GVRET),
];
const ASC: &str = "a Vector log (asc2log -I FILE.asc -O FILE.log)";
const GVRET: &str = "a GVRET log of SavvyCAN (awk -F, '$3==\"false\"{d=\"\";for(i=7;i<7+$6;i++)d=d $i; \
                     printf \"(%.6f) can%d %s#%s\\n\",$1/1e6,$5,substr($2,length($2)-2),d}' FILE.csv > FILE.log)";

impl Format {
    /// The format of a file with this beginning; none for an empty file, and for text without a mark.
    #[must_use]
    pub fn recognise(start: &[u8]) -> Option<Self> {
        if start.starts_with(b"PK\x03\x04") && start.windows(4).take(256).any(|w| w == b".npy") {
            return Some(Self::Npz);
        }
        if start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WAVE") {
            return Some(Self::Wav);
        }
        let magic = MAGIC.iter().find(|(magic, _)| start.starts_with(magic));
        if let Some((_, format)) = magic {
            return Some(*format);
        }
        if matches!(start, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]) {
            return Some(Self::Binary("UTF-16 text (save it as UTF-8)"));
        }
        if start.first() == Some(&8) && start.windows(7).take(64).any(|w| w == b"palpate") {
            return Some(Self::Onnx);
        }
        if matches!(start, [_, _, _, _, _, 0, 0, 0, b'{', ..]) {
            return Some(Self::Safetensors);
        }
        if start.first() == Some(&0) {
            return Some(Self::Binary("NUL bytes"));
        }
        // A text may end amid a character where the start ends.
        let text = match std::str::from_utf8(start) {
            Ok(text) => text,
            Err(e) => std::str::from_utf8(&start[..e.valid_up_to()]).ok()?,
        };
        Self::of_text(text.trim_start_matches('\u{FEFF}').trim_start())
    }

    fn of_text(text: &str) -> Option<Self> {
        let first = text.lines().next()?;
        let lower = text.get(..text.len().min(9)).unwrap_or(first);
        let begins = |word: &str| text.starts_with(word);
        if begins("{\"version\":") && first.contains("\"scene_digest\"") {
            return Some(Self::Schedule);
        }
        if begins("frame,time_us,module") {
            return Some(Self::Contacts);
        }
        // A golden has insta's head, or none when `hil run --record` wrote it.
        let (_, body) = headed(text);
        if body.starts_with("palpate ") && body.lines().next()?.contains(" of ") {
            return Some(Self::Golden);
        }
        if is_candump(text) {
            return Some(Self::Candump);
        }
        if begins("date ") && text.lines().nth(1)?.starts_with("base ") {
            return Some(Self::Binary(ASC));
        }
        if let Some((_, log)) = CAN_TEXTS.iter().find(|(start, _)| begins(start)) {
            return Some(Self::Binary(log));
        }
        let vcd = ["$date", "$version", "$timescale", "$comment", "$scope"];
        if vcd.iter().any(|word| begins(word)) {
            return Some(Self::Vcd);
        }
        if lower.eq_ignore_ascii_case("<!doctype") || begins("<html") {
            return Some(Self::Html);
        }
        if begins("<svg") {
            return Some(Self::Svg);
        }
        if begins("<") {
            let junit = text.contains("<testsuites");
            return Some(if junit { Self::Junit } else { Self::Xml });
        }
        let json = |rest: &str| {
            let rest = rest.trim_start();
            rest.starts_with(['"', '{', '}', ']']) || rest.starts_with(|c: char| c.is_ascii_digit())
        };
        if begins("{") || text.strip_prefix('[').is_some_and(json) {
            return Some(Self::Json);
        }
        let lines = || {
            text.lines()
                .map(str::trim)
                .filter(|l| !l.is_empty() && !l.starts_with('#'))
        };
        let key = |line: &str| {
            let word = line.split_once('=').map_or("", |(key, _)| key.trim());
            let part = |c: char| c.is_ascii_alphanumeric() || "_-.\"".contains(c);
            !word.is_empty() && word.chars().all(part)
        };
        let heading = lines().next()?;
        if key(heading) || (heading.starts_with('[') && heading.ends_with(']')) {
            return Some(Self::Toml);
        }
        let are_numbers = |line: &str| {
            let words: Vec<_> = line.split_whitespace().collect();
            words.len() > 1
                && words
                    .iter()
                    .all(|w| w.replace(',', ".").parse::<f64>().is_ok())
        };
        // A heading of names between blanks has numbers below it.
        let is_table = heading.contains([',', ';', '\t']) || lines().take(2).any(are_numbers);
        is_table.then_some(Self::Csv)
    }

    /// The format of a record by the ending of its name; none for other endings.
    #[must_use]
    pub fn of_name(path: &Path) -> Option<Self> {
        Some(match path.extension()?.to_str()? {
            "csv" => Self::Contacts,
            "jsonl" => Self::Schedule,
            "log" => Self::Candump,
            "mcap" => Self::Mcap,
            "vcd" => Self::Vcd,
            "snap" => Self::Golden,
            "html" => Self::Html,
            "json" => Self::Json,
            _ => return None,
        })
    }

    /// Returns true if a record of it is written while a run goes on; others take all of a run.
    #[must_use]
    pub const fn grows(self) -> bool {
        matches!(
            self,
            Self::Contacts | Self::Schedule | Self::Candump | Self::Mcap | Self::Vcd
        )
    }

    /// Returns true if each of several displays has a record of its own.
    #[must_use]
    pub const fn is_per_display(self) -> bool {
        matches!(self, Self::Golden | Self::Mcap | Self::Vcd | Self::Html)
    }

    /// Returns true if people can read it.
    #[must_use]
    pub const fn is_text(self) -> bool {
        !matches!(
            self,
            Self::Mcap
                | Self::Fst
                | Self::Ghw
                | Self::Safetensors
                | Self::Onnx
                | Self::Numpy
                | Self::Npz
                | Self::Matlab
                | Self::Wav
                | Self::Binary(_)
        )
    }

    /// Name of the format in errors.
    #[must_use]
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Mcap => "an MCAP file",
            Self::Candump => "a candump log",
            Self::Schedule => "a schedule (JSON Lines)",
            Self::Contacts => "contacts (CSV)",
            Self::Golden => "a golden",
            Self::Vcd => "a value change dump (VCD)",
            Self::Fst => "a value change dump (FST)",
            Self::Ghw => "a waveform of GHDL (GHW)",
            Self::Html => "an HTML page",
            Self::Junit => "JUnit XML",
            Self::Svg => "an SVG drawing",
            Self::Xml => "XML",
            Self::Json => "JSON",
            Self::Csv => "CSV",
            Self::Toml => "TOML settings",
            Self::Safetensors => "a model (safetensors)",
            Self::Onnx => "a model (ONNX)",
            Self::Numpy => "a NumPy array",
            Self::Npz => "NumPy arrays (.npz)",
            Self::Matlab => "MATLAB arrays",
            Self::Wav => "a WAV file",
            Self::Binary(what) => what,
        }
    }
}

/// Returns true if the first line that is no remark is one of candump's: a log's, or a terminal's.
fn is_candump(text: &str) -> bool {
    let is_remark = |line: &&str| line.is_empty() || line.starts_with('#');
    let mut lines = text.lines().map(str::trim);
    let line = lines.find(|line| !is_remark(line)).unwrap_or_default();
    let is_length = |word: &str| {
        let inner = word.strip_prefix('[').and_then(|w| w.strip_suffix(']'));
        inner.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let is_timed = line.starts_with('(') && line.contains(") ");
    let in_columns = || line.split_whitespace().skip(2).take(4).any(is_length);
    is_timed || line.starts_with("DROPCOUNT: ") || (!line.contains(['=', ',', '$']) && in_columns())
}

/// Splits a snapshot of insta's into the heading above it, if there is one, and the snapshot itself. A byte order
/// mark of an editor may stand before it, and lines may end as on Windows.
#[must_use]
pub fn headed(text: &str) -> (Option<&str>, &str) {
    let text = text.trim_start_matches('\u{FEFF}');
    let within = |line: &str, end: &str| {
        let rest = text.strip_prefix(line)?;
        rest.split_once(end)
    };
    let parts = within("---\n", "\n---\n").or_else(|| within("---\r\n", "\r\n---\r\n"));
    parts.map_or((None, text), |(head, body)| (Some(head), body))
}

#[cfg(test)]
#[path = "format_tests.rs"]
mod tests;
