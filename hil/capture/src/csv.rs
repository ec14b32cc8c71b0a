//! CSV exports of logic analysers: sigrok's, a row a sample with the rate in a comment, and Saleae's, a row a
//! change with the time in seconds.

use std::io::Read;

use super::edges::{Capture, Signal};
use super::{MOST_CHANGES, too_long};
use palpate_files::{FileError, LONGEST_LINE, Lines, Text};

/// Content of the comments and the heading.
#[derive(Debug, Default)]
struct Head {
    /// Length of a sample, nanoseconds.
    sample_ns: Option<f64>,
    /// Names in a comment: the heading of a sigrok file may only say `logic`.
    channels: Vec<String>,
    /// Nanoseconds of one unit of the time column, if there is one.
    time: Option<f64>,
    names: Vec<String>,
}

pub(super) fn read(label: &str, input: impl Read) -> Result<Capture, FileError> {
    let mut lines = Lines::over(Text::new(label, input, LONGEST_LINE));
    let bad = |line: usize, expected: &str, found: &str| FileError {
        path: label.into(),
        line: Some(line),
        key: None,
        expected: expected.into(),
        found: format!("`{}`", found.chars().take(60).collect::<String>()),
    };
    let (mut head, mut capture) = (Head::default(), Capture::default());
    let (mut row, mut now, mut zero, mut steps) = (0_u64, 0, None, Vec::new());
    let mut changes = 0;
    while let Some((number, line)) = lines.advance()? {
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        if let Some(comment) = line.strip_prefix([';', '#']) {
            head.comment(comment);
            continue;
        }
        if head.names.is_empty() {
            let found = || bad(number, "a heading with one name a channel", line);
            let is_heading = head.heading(line).ok_or_else(found)?;
            if head.time.is_none() && head.sample_ns.is_none() {
                let expected = "a time column, or `; Samplerate: ...` before the heading";
                return Err(bad(number, expected, line));
            }
            let signal = |name: &String| Signal {
                name: name.clone(),
                ..Signal::default()
            };
            capture.signals = head.names.iter().map(signal).collect();
            if is_heading {
                continue;
            }
        }
        let Some((time, levels)) = head.row(line) else {
            if capture.end_ns == 0 && row == 0 {
                return Err(bad(number, "a time and levels of 0 or 1", line));
            }
            let edges: usize = capture.signals.iter().map(|s| s.edges.len()).sum();
            capture.notes.push(format!(
                "{label}:{}: expected levels of 0 or 1; {edges} changes until {:.6} s were read",
                number,
                now as f64 * 1e-9
            ));
            break;
        };
        let absolute = time.unwrap_or_else(|| row as f64 * head.sample_ns.unwrap_or(1.0));
        // Times before a trigger are negative.
        let t_ns = (absolute - *zero.get_or_insert(absolute)).max(0.0).round() as u64;
        if t_ns > now {
            steps.push(t_ns - now);
            steps.truncate(4096);
        }
        now = t_ns.max(now);
        for (signal, high) in capture.signals.iter_mut().zip(levels) {
            changes += usize::from(signal.set(now, high));
        }
        if changes > MOST_CHANGES {
            return Err(too_long(label, Some(number)));
        }
        row += 1;
    }
    capture.notes.extend(lines.note());
    capture.end_ns = now;
    capture.resolution_ns = match head.sample_ns {
        Some(ns) => ns.ceil() as u64,
        None => steps.into_iter().reduce(gcd).unwrap_or(1),
    }
    .max(1);
    Ok(capture)
}

/// Greatest common divisor. Rows are whole samples apart, so that of all their distances is a sample, or several.
fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Nanoseconds of one unit of a time column by its heading, with the unit in any bracket, behind an underscore or in words; none
/// for another column. Without a unit it counts seconds.
fn time_unit(heading: &str) -> Option<f64> {
    let lower = heading.to_lowercase();
    let mut words = lower
        .split(|c: char| !c.is_alphanumeric())
        .filter(|w| !w.is_empty());
    let first = words.next()?;
    let last = words.next_back().unwrap_or(first);
    let ns = match last.trim_start_matches("time") {
        "ms" | "msec" | "millis" | "milliseconds" => 1e6,
        "us" | "µs" | "μs" | "usec" | "micros" | "microseconds" => 1e3,
        "ns" | "nsec" | "nanos" | "nanoseconds" => 1.0,
        "ps" | "picoseconds" => 1e-3,
        _ => 1e9,
    };
    (first.starts_with("time") || last.ends_with("seconds")).then_some(ns)
}

impl Head {
    fn comment(&mut self, comment: &str) {
        let Some((key, value)) = comment.split_once(':') else {
            return;
        };
        let key = key.trim().to_ascii_lowercase();
        if key == "samplerate" {
            let mut words = value.split_whitespace();
            let number: Option<f64> = words.next().and_then(|w| w.parse().ok());
            let scale = match words.next() {
                Some("GHz") => 1e9,
                Some("MHz") => 1e6,
                Some("kHz") => 1e3,
                _ => 1.0,
            };
            self.sample_ns = number.filter(|hz| *hz > 0.0).map(|hz| 1e9 / (hz * scale));
        } else if key.starts_with("channels") {
            self.channels = value.split(',').map(|c| c.trim().to_owned()).collect();
        }
    }

    /// Takes the first row that is no comment; false if it is data already. `None` for neither.
    fn heading(&mut self, line: &str) -> Option<bool> {
        let fields: Vec<&str> = line
            .split(',')
            .map(|f| f.trim().trim_matches('"'))
            .collect();
        let is_level = |f: &&str| matches!(*f, "0" | "1");
        if fields.iter().all(is_level) {
            self.names = (0..fields.len()).map(|n| self.channel(n)).collect();
            return Some(false);
        }
        let mut names = fields.as_slice();
        if let Some((first, rest)) = fields.split_first()
            && let Some(unit) = time_unit(first)
        {
            self.time = Some(unit);
            names = rest;
        }
        let all_alike = names.iter().all(|n| *n == "logic");
        let named = |(n, name): (usize, &&str)| match all_alike {
            true => self.channel(n),
            false => (*name).to_owned(),
        };
        self.names = names.iter().enumerate().map(named).collect();
        (!self.names.is_empty() && names.iter().all(|n| !n.is_empty())).then_some(true)
    }

    fn channel(&self, n: usize) -> String {
        self.channels
            .get(n)
            .cloned()
            .unwrap_or_else(|| format!("D{n}"))
    }

    /// Time in nanoseconds, where the file has one, and levels.
    fn row(&self, line: &str) -> Option<(Option<f64>, Vec<bool>)> {
        let mut fields = line.split(',').map(str::trim);
        let time = match self.time {
            Some(unit) => {
                let time: f64 = fields.next()?.parse().ok()?;
                Some(Some(time * unit).filter(|t| t.is_finite())?)
            }
            None => None,
        };
        let level = |f: &str| match f {
            "0" => Some(false),
            "1" => Some(true),
            _ => None,
        };
        let levels: Option<Vec<bool>> = fields.map(level).collect();
        Some((time, levels.filter(|l| l.len() == self.names.len())?))
    }
}
