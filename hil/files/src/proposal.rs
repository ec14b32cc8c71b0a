//! A recipe proposed from a recording's first rows: what they say, and what had to be assumed.

use std::fmt::Write;
use std::path::Path;

use super::clock::{Beginning, Timing};
use super::columns::{Columns, MOST_BEFORE};
use super::error::FileError;
use super::gain::Gain;
use super::layout::{LayoutFile, SensorLayout};
use super::loaded::load_layout;
use super::opening::Opening;
use super::order::{Group, groups, is_computed, listed};
use super::resolve::FileKind;
use super::rows::opened;
use super::taken::Wrong;

/// Rows per second that are assumed where nothing says.
const RATE_HZ: f64 = 100.0;

/// Something that was assumed, and what changes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumed {
    /// The assumption, in words.
    pub what: String,
    /// The option of `hil import`, or key of the recipe, that changes it.
    pub option: String,
}

/// A recipe for a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Proposal {
    /// The recipe as a file has it.
    pub text: String,
    /// Things understood: a word, and what the recording says.
    pub understood: Vec<(&'static str, String)>,
    /// Things assumed.
    pub assumed: Vec<Assumed>,
}

impl Proposal {
    fn assume(&mut self, what: impl Into<String>, option: &str) {
        self.assumed.push(Assumed {
            what: what.into(),
            option: option.to_owned(),
        });
    }

    fn line(&mut self, line: impl AsRef<str>) {
        self.text += line.as_ref();
        self.text.push('\n');
    }
}

/// The columns of a module.
enum Own<'a> {
    Group(&'a Group),
    /// The first of so many, from 0.
    From(usize),
}

/// Proposes a recipe for a recording by its first rows; `name` is its path from the recipe on. What `timing` and `layout` state is
/// taken as it is.
///
/// # Errors
/// A file that holds no table, and columns that no known layout has.
pub fn propose(
    path: &Path,
    name: &str,
    layout: Option<&str>,
    timing: &Timing,
) -> Result<Proposal, FileError> {
    let (opening, note) = opened(path, timing)?;
    let at = |(key, expected, found): Wrong| FileError {
        path: path.display().to_string(),
        line: Some(opening.line),
        key,
        expected,
        found,
    };
    let mut proposal = Proposal {
        text: String::new(),
        understood: Vec::new(),
        assumed: Vec::new(),
    };
    proposal.understood.extend(note.map(|note| ("file", note)));
    let names = opening.headings();
    let time = timing.column.as_ref().map(|column| column.name.as_str());
    let named = names.iter().flatten().copied().enumerate();
    let all = groups(named.filter(|(_, name)| time != Some(name)));
    let (skin, owns) = chosen(&opening, &all, layout, &mut proposal).map_err(at)?;
    let (skin, sensor) = skin;
    head(path, (name, &skin), &mut proposal);
    if let Some(topic) = &timing.topic {
        proposal.line(format!("topic = {}", quoted(topic)));
    }
    writing(&opening, &mut proposal);
    times(&opening, names.as_deref(), &sensor, timing, &mut proposal).map_err(at)?;
    let widths = (0..owns.len()).filter_map(|m| Some(Columns::of_module(&sensor, m)?.count()));
    let places: Vec<usize> = owns
        .iter()
        .zip(widths)
        .flat_map(|(own, n)| places(own, n))
        .collect();
    values(
        &opening,
        names.as_deref(),
        &places,
        timing.gain,
        &mut proposal,
    );
    for (module, own) in sensor.modules.iter().zip(&owns) {
        of_module(&module.name, own, names.as_deref(), &mut proposal);
    }
    proposal.assume(
        "taxels are counted from the top left, row by row, and no module is turned",
        "turned_deg, mirrored of the recipe",
    );
    Ok(proposal)
}

fn places(own: &Own<'_>, width: usize) -> Vec<usize> {
    match own {
        Own::Group(group) => group.places.clone(),
        Own::From(begin) => (*begin..begin + width).collect(),
    }
}

fn head(path: &Path, (file, layout): (&str, &str), proposal: &mut Proposal) {
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    let lower = |c: char| {
        if c.is_ascii_lowercase() || c.is_ascii_digit() {
            c
        } else {
            '-'
        }
    };
    let name: String = stem.chars().map(lower).collect();
    proposal.line("#:schema .schemas/recording.json");
    proposal.line("kind = \"recording\"");
    proposal.line(format!(
        "name = \"{}\"",
        if name.is_empty() { "recording" } else { &name }
    ));
    proposal.line("description = \"As `hil import` proposed it\"");
    proposal.line(format!("recording = {}", quoted(file)));
    proposal.line(format!("layout = {}", quoted(layout)));
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn writing(opening: &Opening, proposal: &mut Proposal) {
    let (word, noun) = match opening.dialect.separator {
        Some(b';') => ("semicolon", "semicolons"),
        Some(b'\t') => ("tab", "tabs"),
        Some(_) => ("comma", "commas"),
        None => ("blanks", "blanks"),
    };
    let point = if opening.dialect.decimal_comma {
        "decimal commas"
    } else {
        "decimal points"
    };
    let heading = match opening.headings() {
        Some(_) => "with a heading",
        None => "without a heading",
    };
    proposal.understood.push((
        "table",
        format!(
            "{} columns between {noun}, {point}, {heading}",
            opening.width
        ),
    ));
    proposal.line(format!("delimiter = \"{word}\""));
    if opening.dialect.decimal_comma {
        proposal.line("decimal_comma = true");
    }
}

/// The layout with its name, and the columns of each of its modules.
type Skin<'a> = ((String, SensorLayout), Vec<Own<'a>>);

fn chosen<'a>(
    opening: &Opening,
    all: &'a [Group],
    layout: Option<&str>,
    proposal: &mut Proposal,
) -> Result<Skin<'a>, Wrong> {
    let known: Vec<String> = match layout {
        Some(name) => vec![name.to_owned()],
        None => FileKind::Layout
            .names()
            .into_iter()
            .map(str::to_owned)
            .collect(),
    };
    let mut fits: Vec<Skin<'a>> = Vec::new();
    for name in known {
        let loaded = load_layout(&name).map_err(|e| (None, e.expected, e.found))?;
        let LayoutFile::Sensor(sensor) = loaded.value else {
            continue;
        };
        if let Some(owns) = fitting(opening, all, &sensor) {
            fits.push(((name, sensor), owns));
        }
    }
    // The fewest modules first; of as many, the first name.
    fits.sort_by_key(|((_, sensor), _)| sensor.modules.len());
    let others: Vec<String> = fits
        .iter()
        .skip(1)
        .map(|((name, _), _)| name.clone())
        .collect();
    let Some(first) = fits.into_iter().next() else {
        let found = match all {
            [] => format!("{} columns", opening.width),
            all => listed(&all.iter().collect::<Vec<_>>()),
        };
        let expected = match layout {
            Some(name) => format!("the columns of layout `{name}`"),
            None => "the columns of a layout that ships (--layout names another; `hil new layout` makes one)".to_owned(),
        };
        return Err((None, expected, found));
    };
    let (name, sensor) = &first.0;
    let skin = format!(
        "`{name}`: {} taxels of {} axes in {} modules",
        sensor.readings(),
        sensor.axes,
        sensor.modules.len()
    );
    proposal.understood.push(("skin", skin));
    if layout.is_none() {
        let also = match others.as_slice() {
            [] => String::new(),
            others => format!("; {} would fit as well", others.join(", ")),
        };
        proposal.assume(
            format!("the skin is `{name}`, which has as many columns{also}"),
            "--layout",
        );
    }
    Ok(first)
}

/// The columns of each module of a layout; none where it has others.
fn fitting<'a>(opening: &Opening, all: &'a [Group], sensor: &SensorLayout) -> Option<Vec<Own<'a>>> {
    let axes = usize::from(sensor.axes);
    let widths: Vec<usize> = sensor.modules.iter().map(|m| m.readings() * axes).collect();
    let total: usize = widths.iter().sum();
    if all.is_empty() {
        let before = opening
            .width
            .checked_sub(total)
            .filter(|before| *before <= MOST_BEFORE)?;
        let begin = |n: usize| before + widths[..n].iter().sum::<usize>();
        return Some((0..widths.len()).map(|n| Own::From(begin(n))).collect());
    }
    let mut fit: Vec<&Group> = all.iter().filter(|g| axes == 3 || !g.has_axes).collect();
    if fit
        .iter()
        .filter(|g| widths.contains(&g.places.len()))
        .count()
        > widths.len()
    {
        fit.retain(|group| !is_computed(&group.pattern));
    }
    fit.retain(|group| widths.contains(&group.places.len()));
    let same =
        fit.len() == widths.len() && fit.iter().zip(&widths).all(|(g, w)| g.places.len() == *w);
    same.then(|| fit.into_iter().map(Own::Group).collect())
}

fn times(
    opening: &Opening,
    names: Option<&[&str]>,
    sensor: &SensorLayout,
    timing: &Timing,
    proposal: &mut Proposal,
) -> Result<(), Wrong> {
    let before = opening.width.checked_sub(Columns::of_skin(sensor).count());
    let table = Beginning {
        names,
        rows: &opening.rows,
        before: before.filter(|n| *n <= MOST_BEFORE).unwrap_or(0),
    };
    let (clock, note) = timing.clock(&table)?;
    let Some((column, unit)) = clock.named(names) else {
        let hz = timing.rate_hz.unwrap_or(RATE_HZ);
        proposal.line(format!("rate_hz = {hz:?}"));
        proposal
            .understood
            .push(("times", format!("none: {hz} rows per second")));
        if timing.rate_hz.is_none() {
            proposal.assume(format!("{hz} rows per second, as nothing says"), "--rate");
        }
        return Ok(());
    };
    let noun = unit.noun();
    proposal
        .understood
        .push(("times", format!("column {}, {noun}", quoted(&column))));
    let unit = unit.word();
    if note.is_some_and(|note| note.contains("by its numbers")) {
        proposal.assume(
            format!("times count {noun}, by their numbers"),
            "--time COLUMN:UNIT",
        );
    }
    proposal.line(format!(
        "time = {{ column = {}, unit = \"{unit}\" }}",
        quoted(&column)
    ));
    Ok(())
}

fn values(
    opening: &Opening,
    names: Option<&[&str]>,
    places: &[usize],
    stated: Option<Gain>,
    proposal: &mut Proposal,
) {
    let gain = stated.or_else(|| Gain::needed(&opening.rows, places).map(|(gain, _)| gain));
    let Some(gain) = gain else {
        proposal.understood.push(("values", "counts".to_owned()));
        return;
    };
    let unit = names.and_then(|names| {
        let name = names.get(*places.first()?)?;
        let inside = name.split_once(['[', '('])?.1.trim_end_matches([']', ')']);
        Some(inside.to_owned())
    });
    let shown = unit
        .clone()
        .unwrap_or_else(|| "a unit that the file does not say".to_owned());
    proposal
        .understood
        .push(("values", format!("{shown}; {gain} makes counts of them")));
    if let Some(unit) = unit {
        proposal.line(format!("unit = {}", quoted(&unit)));
    }
    let (per_unit, at_zero) = gain.parts();
    proposal.line(format!("gain = {per_unit:?}"));
    proposal.line(format!("offset = {at_zero:?}"));
    if stated.is_none() {
        proposal.assume(
            format!("gain and offset {gain}, by the noise of the first rows"),
            "--gain",
        );
    }
}

fn of_module(name: &str, own: &Own<'_>, names: Option<&[&str]>, proposal: &mut Proposal) {
    proposal.line("");
    proposal.line("[[modules]]");
    proposal.line(format!("name = {}", quoted(name)));
    let (group, names) = match (own, names) {
        (Own::Group(group), Some(names)) => (group, names),
        (Own::Group(_), None) => return,
        (Own::From(begin), _) => {
            proposal.line(format!("first_column = {}", begin + 1));
            proposal.line("order = \"file\"");
            proposal.understood.push((
                "columns",
                format!("`{name}` from column {} on, as they stand", begin + 1),
            ));
            proposal.assume(
                format!("columns of `{name}` stand in the layout's order"),
                "order of the recipe",
            );
            return;
        }
    };
    let prefix = group.pattern.split(['#', '?']).next().unwrap_or_default();
    let begin: Vec<usize> = (0..names.len())
        .filter(|c| names[*c].starts_with(prefix))
        .collect();
    let alone = groups(begin.iter().map(|c| (*c, names[*c])));
    if matches!(alone.as_slice(), [one] if one == *group) && !prefix.is_empty() {
        proposal.line(format!("prefix = {}", quoted(prefix)));
    } else {
        let mut list = String::new();
        for place in &group.places {
            // A string takes whatever is written.
            let _ = write!(
                list,
                "{}{}",
                if list.is_empty() { "" } else { ", " },
                quoted(names[*place])
            );
        }
        proposal.line(format!("columns = [{list}]"));
    }
    let mended = if group.is_mended() {
        ", by their numbers and not as they stand"
    } else {
        ""
    };
    let shown = format!(
        "{} of `{}` are `{name}`{mended}",
        group.places.len(),
        group.pattern
    );
    proposal.understood.push(("columns", shown));
    let alike = group.is_mended() || group.has_axes;
    if !alike && group.places.len().is_multiple_of(3) {
        proposal.assume(
            format!(
                "x, y, z of a taxel stand side by side in `{}`",
                group.pattern
            ),
            "order of the recipe",
        );
    }
}

#[cfg(test)]
#[path = "proposal_tests.rs"]
mod tests;
