//! `hil contacts`: (4.1) to (4.10) on a recording, and nothing else.

use palpate_core::contact::{Compressor, Contact, LevelTable, Norm, Settings};
use palpate_core::skin::{
    Axes, Initialiser, InitialiserSettings, Phase, RelativeFrame, Scan, ThresholdRule,
};
use palpate_core::units::Instant;

use crate::cli::{AxesArg, ContactsArgs, NormArg, StaleArg};
use crate::failure::Failure;
use crate::files::{Columns, LayoutFile, load_layout, read_taxel_csv};
use crate::output::print;
use crate::plan;

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
    let levels = LevelTable::from_intensities(&intensities, usize::from(args.ki)).ok();
    print(|out| {
        writeln!(out, "{}", palpate_records::contacts_csv::HEADER)?;
        for Row {
            frame,
            time_us,
            contact: c,
        } in &rows
        {
            let level = levels.as_ref().map_or(1, |table| table.level(c.intensity));
            let Contact {
                id,
                module,
                place,
                intensity,
                members,
                ..
            } = c;
            writeln!(
                out,
                "{frame},{time_us},{module},{id},{:.4},{:.4},{intensity:.3},{level},{members}",
                place.x, place.y
            )?;
        }
        Ok(())
    })
}

fn compress(args: &ContactsArgs) -> Result<Vec<Row>, Failure> {
    let option = |name: &str, e: &dyn std::fmt::Display| Failure::Input(format!("--{name}: {e}"));
    if args.ki == 0 {
        return Err(option("ki", &"expected at least 1 level, found 0"));
    }
    let loaded = load_layout(&args.layout)?;
    let LayoutFile::Sensor(file) = &loaded.value else {
        let message = format!(
            "expected a layout of kind \"sensor\", found the display `{}`",
            args.layout
        );
        return Err(option("layout", &message));
    };
    let layout = plan::layout(file)?;
    let table = read_taxel_csv(&args.file, &Columns::of_skin(file), args.rate)?;
    let needed = args.reference_frames as usize + 1;
    if table.frames() < needed {
        return Err(Failure::Input(format!(
            "{}: expected at least {needed} rows ({} for the reference, one for the threshold), found {}",
            args.file.display(),
            args.reference_frames,
            table.frames()
        )));
    }
    let settings = InitialiserSettings {
        reference_frames: args.reference_frames,
        fault_sigmas: None,
        threshold: threshold(&args.threshold)?,
        axes: match args.axes {
            AxesArg::Xyz => Axes::XYZ,
            AxesArg::Z => Axes::Z,
        },
    };
    let mut initialiser =
        Initialiser::new(&layout, settings).map_err(|e| option("reference-frames", &e))?;
    let compression = Settings {
        clusters: args.kc,
        exponent: args.weight_exponent as f32,
        norm: match args.norm {
            NormArg::L1 => Norm::L1,
            NormArg::L2 => Norm::L2,
            NormArg::Linf => Norm::LInf,
        },
        seed: args.seed,
        ..Settings::default()
    };
    let mut compressor = Compressor::new(&layout, compression)
        .map_err(|e| Failure::Input(format!("--kc or --weight-exponent: {e}")))?;

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
        if initialiser.phase() != Phase::Ready {
            initialiser.feed(&scan);
        }
        // The reference rows count and emit nothing; the row that sets the threshold is a frame.
        if is_reference || initialiser.phase() != Phase::Ready {
            continue;
        }
        let relative = relative.get_or_insert_with(|| initialiser.frame(&layout));
        let contacts = initialiser
            .relative(&scan, relative)
            .and_then(|()| compressor.compress(relative))
            .map_err(|e| Failure::Input(format!("{}: row {frame}: {e}", args.file.display())))?;
        rows.extend(contacts.iter().map(|&contact| Row {
            frame,
            time_us,
            contact,
        }));
    }
    Ok(rows)
}

fn threshold(text: &str) -> Result<ThresholdRule, Failure> {
    if text == "auto" {
        return Ok(ThresholdRule::Auto { margin: 0.0 });
    }
    match text.parse::<f32>() {
        Ok(counts) if counts.is_finite() && counts >= 0.0 => Ok(ThresholdRule::Fixed { counts }),
        _ => Err(Failure::Input(format!(
            "--threshold {text}: expected auto or raw counts of at least 0"
        ))),
    }
}
