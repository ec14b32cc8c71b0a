//! Formats by the first bytes of a file: what a reader took it for, and what an output may replace.

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
    /// Columns between commas, no contacts.
    Csv,
    /// TOML: a scene, bench, layout.
    Toml,
    /// A model in safetensors.
    Safetensors,
    /// A model in ONNX.
    Onnx,
    /// An array of NumPy.
    Numpy,
    /// A picture, an archive, a program: what begins with bytes that are no text. The name says which.
    Binary(&'static str),
}

/// Binary formats by what they begin with.
const MAGIC: [(&[u8], Format); 12] = [
    (b"\x89MCAP0\r\n", Format::Mcap),
    (b"\x1f\x8b", Format::Binary("gzip (unpack it first)")),
    (
        b"\x28\xb5\x2f\xfd",
        Format::Binary("zstd (unpack it first)"),
    ),
    (
        b"PK\x03\x04",
        Format::Binary("a zip archive or spreadsheet"),
    ),
    (b"\xD0\xCF\x11\xE0", Format::Binary("an old spreadsheet")),
    (b"\x89HDF", Format::Binary("HDF5")),
    (b"\x93NUMPY", Format::Numpy),
    (b"\x89PNG", Format::Binary("a PNG picture")),
    (b"%PDF", Format::Binary("a PDF")),
    (b"\x7fELF", Format::Binary("a program")),
    (b"SQLite format 3", Format::Binary("an SQLite data base")),
    (b"#ROSBAG", Format::Binary("a ROS 1 bag")),
];

impl Format {
    /// The format of a file that begins so; none of an empty one, and of text without a mark.
    #[must_use]
    pub fn of(start: &[u8]) -> Option<Self> {
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
        // With insta's head, or without it as `hil run --record` writes one.
        let (_, body) = headed(text);
        if body.starts_with("palpate ") && body.lines().next()?.contains(" of ") {
            return Some(Self::Golden);
        }
        if begins("(") && first.contains(") ") {
            return Some(Self::Candump);
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
        heading.contains(',').then_some(Self::Csv)
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

    /// Whether a record of it is written while a run goes on; others take all of a run.
    #[must_use]
    pub const fn grows(self) -> bool {
        matches!(
            self,
            Self::Contacts | Self::Schedule | Self::Candump | Self::Mcap | Self::Vcd
        )
    }

    /// Whether each of several displays has a record of its own.
    #[must_use]
    pub const fn is_per_display(self) -> bool {
        matches!(self, Self::Golden | Self::Mcap | Self::Vcd | Self::Html)
    }

    /// Whether people can read it.
    #[must_use]
    pub const fn is_text(self) -> bool {
        !matches!(
            self,
            Self::Mcap | Self::Safetensors | Self::Onnx | Self::Numpy | Self::Binary(_)
        )
    }

    /// As errors name it.
    #[must_use]
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Mcap => "an MCAP file",
            Self::Candump => "a candump log",
            Self::Schedule => "a schedule (JSON Lines)",
            Self::Contacts => "contacts (CSV)",
            Self::Golden => "a golden",
            Self::Vcd => "a value change dump (VCD)",
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
            Self::Binary(what) => what,
        }
    }
}

/// Splits a snapshot of insta's into the heading above it, if there is one, and the snapshot itself. Editors may have put a
/// byte order mark before it, and lines may end as on Windows.
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
