//! `hil contacts`: (4.1) to (4.10) on a recording, and nothing else.

use std::fmt;
use std::io::{self, Write};

use palpate_core::contact::{Compressor, Contact, LevelTable, Settings};
use palpate_core::skin::{
    Baseline, BaselinePhase, BaselineSettings, FrameError, RelativeFrame, Scan, ThresholdRule,
};
use palpate_core::units::{Duration, Instant};
use palpate_records::contacts_csv;
use palpate_records::trace::{Event, PlaceUm};
use serde_json::json;

use crate::cli::{ContactsArgs, StaleArg, Threshold};
use crate::output::{make_folder, note, print, write_file, write_sidecar};
use crate::recording::{Columns, read_taxel_csv};
use palpate_files::{LayoutFile, THRESHOLD_FLOOR, THRESHOLD_SIGMAS, load_layout};
use palpate_run::Failure;
use palpate_run::plan;

use super::rate::rate_of;

/// `--threshold per-taxel`, as scenes have it by default.
const PER_TAXEL: ThresholdRule = ThresholdRule::PerTaxel {
    sigmas: THRESHOLD_SIGMAS as f32,
    floor: THRESHOLD_FLOOR as f32,
};

/// One line of the output before levels are known.
struct Row {
    frame: usize,
    time_us: u64,
    contact: Contact,
}

/// Prints the contacts of every frame after the reference.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn contacts(args: &ContactsArgs) -> Result<(), Failure> {
    let rows = compress(args)?;
    let intensities: Vec<f32> = rows.iter().map(|r| r.contact.intensity).collect();
    // No table without a contact, and then no row asks for a level.
    let levels = LevelTable::from_intensities(&intensities, usize::from(args.ki)).ok();
    let level = |c: &Contact| levels.as_ref().map_or(1, |table| table.level(c.intensity));
    if args.json {
        return print(|out| write_json(&rows, level, out));
    }
    match &args.out {
        None => print(|out| write_csv(&rows, level, out)),
        Some(folder) => {
            make_folder(folder)?;
            let table = folder.join("contacts.csv");
            write_sidecar(&table, None)?;
            write_file(&table, |out| write_csv(&rows, level, out))
        }
    }
}

fn write_csv(rows: &[Row], level: impl Fn(&Contact) -> u16, out: &mut dyn Write) -> io::Result<()> {
    let contact = |row: &Row| Event::Contact {
        t_us: row.time_us,
        frame: u32::try_from(row.frame).unwrap_or(u32::MAX),
        module: row.contact.module,
        contact: row.contact.id,
        place: PlaceUm::from(row.contact.place),
        intensity_milli: (f64::from(row.contact.intensity) * 1e3).round() as u32,
        level: level(&row.contact),
        members: row.contact.members,
    };
    let events: Vec<Event> = rows.iter().map(contact).collect();
    contacts_csv::write_table(&events, out)
}

fn write_json(
    rows: &[Row],
    level: impl Fn(&Contact) -> u16,
    out: &mut dyn Write,
) -> io::Result<()> {
    let thousandths = |v: f32| (f64::from(v) * 1e3).round() / 1e3;
    let objects = rows.iter().map(|row| {
        let c = &row.contact;
        json!({
            "frame": row.frame,
            "time_us": row.time_us,
            "module": c.module,
            "contact": c.id,
            "x_mm": thousandths(c.place.x) + 0.0,
            "y_mm": thousandths(c.place.y) + 0.0,
            "intensity": thousandths(c.intensity),
            "level": level(c),
            "members": c.members,
        })
    });
    serde_json::to_writer(&mut *out, &objects.collect::<Vec<_>>())?;
    writeln!(out)
}

fn compress(args: &ContactsArgs) -> Result<Vec<Row>, Failure> {
    let option = |name: &str, e: &dyn fmt::Display| Failure::Input(format!("--{name}: {e}"));
    let loaded = load_layout(&args.layout)?;
    let LayoutFile::Sensor(file) = &loaded.value else {
        let found = format!(
            "{}: expected a layout of kind \"sensor\", found a display",
            args.layout
        );
        return Err(option("layout", &found));
    };
    let layout = plan::layout(file)?;
    let rate = rate_of(args.rate, std::slice::from_ref(&args.file))?;
    let table = read_taxel_csv(&args.file, &Columns::of_skin(file), rate.hz)?;
    if let (Some(hz), Some(meta), false) = (rate.hz, &rate.found_in, args.quiet) {
        note(&format!("{hz} rows a second, from {}", meta.display()));
    }
    let needed = args.reference_frames as usize + 1;
    if table.frames() < needed {
        return Err(Failure::Input(format!(
            "{}: expected at least {needed} rows ({} for the reference, one for the threshold), found {}",
            args.file.display(),
            args.reference_frames,
            table.frames()
        )));
    }
    let settings = BaselineSettings {
        reference_frames: args.reference_frames,
        fault_sigmas: args.faulty_deviations.map(|k| k as f32),
        threshold: match args.threshold {
            Threshold::Auto => ThresholdRule::Auto { margin: 0.0 },
            Threshold::PerTaxel => PER_TAXEL,
            Threshold::Counts(counts) => ThresholdRule::Fixed { counts },
        },
        axes: args.axes,
        drift: args
            .drift_s
            .map(|s| Duration::from_micros((s * 1e6).round() as u64)),
    };
    let mut baseline =
        Baseline::new(&layout, settings).map_err(|e| option("reference-frames", &e))?;
    let compression = Settings {
        clusters: args.kc,
        exponent: args.weight_exponent as f32,
        norm: args.norm,
        scope: args.scope,
        seed: args.seed,
        ..Settings::default()
    };
    let mut compressor =
        Compressor::new(&layout, compression).map_err(|e| option("kc, --weight-exponent", &e))?;

    // Columns run over the active taxels of all modules, module after module.
    let active: Vec<usize> = layout
        .modules()
        .iter()
        .enumerate()
        .flat_map(|(m, module)| {
            let start = layout.range(m).start;
            (0..module.points().len())
                .filter(|&i| module.active()[i])
                .map(move |i| start + i)
        })
        .collect();
    let axes = usize::from(file.axes);
    let mut counts = vec![[0u16; 3]; layout.taxels()];
    let (mut scan, mut relative): (Scan, Option<RelativeFrame>) = (Scan::new(&layout), None);
    let mut rows = Vec::new();
    for frame in 0..table.frames() {
        let Some(row) = table.frame(frame) else { break };
        let repeats = frame > 0 && table.frame(frame - 1) == Some(row);
        let is_reference = frame < args.reference_frames as usize;
        if repeats && args.replay_stale == StaleArg::Skip && relative.is_some() {
            continue;
        }
        for (column, &taxel) in active.iter().enumerate() {
            counts[taxel] = match row[column * axes..][..axes] {
                [x, y, z] => [x, y, z],
                [z, ..] => [0, 0, z],
                [] => [0; 3],
            };
        }
        let time_us = table.time_us[frame];
        let loaded = scan.load(Instant::from_micros(time_us), &counts);
        loaded.map_err(|e| Failure::Input(format!("{}: {e}", args.file.display())))?;
        if baseline.phase() != BaselinePhase::Ready {
            baseline.feed(&scan);
        }
        // The reference rows count and emit nothing; the row that sets the threshold is a frame.
        if is_reference || baseline.phase() != BaselinePhase::Ready {
            continue;
        }
        let relative = relative.get_or_insert_with(|| baseline.frame(&layout));
        let mut compress = || {
            if baseline.advance(&scan, relative)? || !compressor.repeat() {
                compressor.compress(relative)?;
            }
            Ok(())
        };
        compress().map_err(|e: FrameError| {
            Failure::Input(format!("{}: row {frame}: {e}", args.file.display()))
        })?;
        rows.extend(compressor.contacts().iter().map(|&contact| Row {
            frame,
            time_us,
            contact,
        }));
    }
    Ok(rows)
}
