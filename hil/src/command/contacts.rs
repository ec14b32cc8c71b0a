//! `hil contacts`: (4.1) to (4.10) on a recording, and nothing else.

use std::io::{self, Write};
use std::path::PathBuf;

use palpate_core::contact::{Contact, Settings};
use palpate_core::skin::{BaselineSettings, Layout};
use palpate_records::contacts_csv;
use palpate_records::json::write_json;
use palpate_records::trace::{PlaceUm, event};
use serde_json::json;

use crate::cli::{ContactsArgs, StaleArg};
use palpate_files::{Columns, Rows, Timing, is_stream, load_skin};
use palpate_live::output::{Outputs, make_folder, note, print, write_file, write_sidecar};
use palpate_live::progress::Progress;
use palpate_live::recording::{Reading, Recorded, ahead};
use palpate_run::plan;
use palpate_run::{Failure, Finder, Intensities, Search};

use super::rate::rate_of;

/// A contact of a row before levels are known.
#[derive(Clone, Copy)]
pub struct Row {
    /// Time of the row, us.
    pub time_us: u64,
    /// Number of the row.
    pub frame: u32,
    /// The contact.
    pub contact: Contact,
}

impl Row {
    /// The contact as records have it.
    pub fn recorded(&self, level: u16) -> event::Contact {
        event::Contact {
            t_us: self.time_us,
            frame: self.frame,
            module: self.contact.module,
            contact: self.contact.id,
            place: PlaceUm::from(self.contact.place),
            intensity_milli: (f64::from(self.contact.intensity) * 1e3).round() as u32,
            level,
            members: self.contact.members,
        }
    }
}

/// Most contacts that are held, 40 bytes each; where there are more, the recording is read again for the output.
const HELD: usize = 1 << 19;

/// Contacts that become text together.
const ROWS: usize = 1024;

/// Prints the contacts of every frame after the reference.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn contacts(args: &ContactsArgs) -> Result<(), Failure> {
    let table = args.out.as_ref().map(|folder| folder.join("contacts.csv"));
    if let Some(table) = &table {
        let inputs = std::slice::from_ref(&args.file);
        let outputs = Outputs {
            force: args.force,
            inputs,
        };
        outputs.check_table(table)?;
    }
    let recording = Recording::open(args)?;
    let (mut held, mut intensities) = (Vec::new(), Intensities::default());
    let mut count = 0;
    let notes = recording.compress(&mut |row| {
        count += 1;
        if count <= HELD {
            held.push(row);
        }
        intensities.add(&row.contact);
        Ok(())
    })?;
    if !args.quiet {
        notes.iter().for_each(|text| note(text));
    }
    let levels = match args.weber {
        Some(fraction) => intensities.noticeable(fraction as f32),
        None => intensities.levels(usize::from(args.ki), args.vectors),
    };
    let level = |c: &Contact| levels.level(c);
    if count > HELD && is_stream(&recording.file) {
        return Err(Failure::Input(format!(
            "{}: expected a file: levels are found over the whole recording, which is then read again (a pipe may hold up to {HELD} contacts)",
            recording.file.display()
        )));
    }
    let found = Found {
        recording: &recording,
        held: (count <= HELD).then_some(held),
    };
    if args.json {
        return print(|out| write_list(&found, level, out));
    }
    match args.out.as_ref().zip(table) {
        None => print(|out| write_csv(&found, level, out)),
        Some((folder, table)) => {
            make_folder(folder)?;
            write_file(&table, |out| write_csv(&found, level, out))?;
            write_sidecar(&table, None)
        }
    }
}

/// Callback for one contact after another.
type Each<'a> = dyn FnMut(Row) -> io::Result<()> + 'a;

/// The contacts of a recording, to go through once more.
struct Found<'a> {
    recording: &'a Recording<'a>,
    /// Rows of all contacts; `None` where there are too many.
    held: Option<Vec<Row>>,
}

impl Found<'_> {
    fn each(&self, to: &mut Each<'_>) -> io::Result<()> {
        match &self.held {
            Some(rows) => rows.iter().copied().try_for_each(to),
            None => {
                let again = self.recording.compress(to);
                again.map(drop).map_err(io::Error::other)
            }
        }
    }
}

fn write_csv(
    found: &Found<'_>,
    level: impl Fn(&Contact) -> u16,
    out: &mut dyn Write,
) -> io::Result<()> {
    contacts_csv::write_header(&[], out)?;
    let mut rows = Vec::with_capacity(ROWS);
    found.each(&mut |row| {
        rows.push(row.recorded(level(&row.contact)));
        if rows.len() == ROWS {
            contacts_csv::write_rows(&rows, &[], out)?;
            rows.clear();
        }
        Ok(())
    })?;
    contacts_csv::write_rows(&rows, &[], out)
}

fn write_list(
    found: &Found<'_>,
    level: impl Fn(&Contact) -> u16,
    out: &mut dyn Write,
) -> io::Result<()> {
    let thousandths = |v: f32| (f64::from(v) * 1e3).round() / 1e3;
    let mut before: &[u8] = b"[";
    found.each(&mut |row| {
        let c = &row.contact;
        out.write_all(std::mem::replace(&mut before, b","))?;
        let mut object = json!({
            "frame": row.frame,
            "time_us": row.time_us,
            "module": c.module,
            "contact": c.id,
            "x_mm": thousandths(c.place.x) + 0.0,
            "y_mm": thousandths(c.place.y) + 0.0,
            "intensity": thousandths(c.intensity),
            "level": level(c),
            "members": c.members,
        });
        if found.recording.args.vectors {
            object["vector"] = json!(c.vector.map(thousandths));
        }
        write_json(&object, &mut *out)?;
        Ok(())
    })?;
    let begun = before == b",";
    writeln!(out, "{}", if begun { "]" } else { "[]" })
}

/// A recording and how its contacts are to be found.
struct Recording<'a> {
    args: &'a ContactsArgs,
    file: PathBuf,
    layout: Layout,
    columns: Columns,
    reading: Reading,
    search: Search,
}

impl<'a> Recording<'a> {
    fn open(args: &'a ContactsArgs) -> Result<Self, Failure> {
        let recorded = Recorded::find(args.recipe.as_deref(), &args.file)?;
        if let (Some(note_of), false) = (recorded.note(), args.quiet) {
            note(&note_of);
        }
        let named = args.layout.clone().or_else(|| recorded.layout());
        let name = named.ok_or_else(|| {
            let expected = "--layout: expected the skin's layout (`hil list layouts` has their names), or a recipe that \
                            names it (`hil import` proposes one), found neither";
            Failure::Input(expected.into())
        })?;
        let skin = load_skin(&name).map_err(|e| Failure::Input(format!("--layout: {e}")))?;
        let file = &skin.value;
        let time = args.time.clone().or_else(|| recorded.time(args.rate));
        let recordings = match time {
            Some(_) => &[],
            None => std::slice::from_ref(&recorded.file),
        };
        let rate = rate_of(args.rate.or_else(|| recorded.rate_hz()), recordings)?;
        if let (Some(hz), Some(meta), false) = (rate.hz, &rate.found_in, args.quiet) {
            note(&format!("{hz} rows a second, from {}", meta.display()));
        }
        let timing = Timing {
            column: time,
            rate_hz: rate.hz,
            split_jumps: args.split_jumps,
            rest_rows: args.reference_frames as usize + 1,
            gain: args.gain,
            topic: args.topic.clone().or_else(|| recorded.topic()),
        };
        Ok(Self {
            args,
            file: recorded.file.clone(),
            layout: plan::layout(file)?,
            columns: Columns::of_skin(file),
            reading: Reading {
                timing,
                prefix: args.columns.clone(),
                recipe: recorded.plan(file)?,
            },
            search: Search {
                baseline: BaselineSettings {
                    reference_frames: args.reference_frames,
                    fault_sigmas: args.faulty_deviations.map(|k| k as f32),
                    threshold: args.threshold.rule(),
                    axes: args.axes,
                    drift: args.threshold.drift(args.drift_s),
                },
                compression: Settings {
                    clusters: args.kc,
                    exponent: args.weight_exponent as f32,
                    norm: args.norm,
                    scope: args.scope,
                    seed: args.seed,
                    tolerance: args.stop_mm as f32,
                    vectors: args.vectors,
                    ..Settings::default()
                },
                skips_repeats: args.replay_stale == StaleArg::Skip,
            },
        })
    }

    /// Hands every contact to `each`, row by row; returns notes on the file.
    fn compress(&self, each: &mut Each<'_>) -> Result<Vec<String>, Failure> {
        let args = self.args;
        let file = self.file.display();
        let of_file = |failure: Failure| match failure {
            Failure::Input(text) => Failure::Input(format!("{file}: {text}")),
            other => other,
        };
        let mut finder = Finder::new(&self.layout, &self.columns, self.search.clone())?;
        let _shown = Progress::reading(&self.file);
        let take = self.reading.take(&self.columns);
        let rows = Rows::open(&self.file, take, Some(&self.reading.timing))?;
        let mut rows = ahead(rows, &mut |time_us, counts| {
            let frame = u32::try_from(finder.rows()).unwrap_or(u32::MAX);
            for &contact in finder.row(time_us, counts).map_err(of_file)? {
                let row = Row {
                    time_us,
                    frame,
                    contact,
                };
                each(row).map_err(Failure::written("contacts"))?;
            }
            Ok(())
        })?;
        let needed = args.reference_frames as usize + 1;
        if rows.count() < needed {
            return Err(Failure::Input(format!(
                "{file}: expected at least {needed} rows ({} for the reference, one for the threshold), found {}",
                args.reference_frames,
                rows.count()
            )));
        }
        let mut notes = rows.notes();
        notes.extend(finder.notes());
        Ok(notes)
    }
}
