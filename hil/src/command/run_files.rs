//! The files that `hil run` writes: which, checked before it begins, and how.

use std::path::{Path, PathBuf};

use palpate_files::{Format as FileFormat, Setup};
use palpate_records::contacts_csv::write_table;
use palpate_records::mcap::{BusTraffic, write_mcap};
use palpate_records::schedule::write_schedule;
use palpate_records::story::schedule_golden;
use palpate_records::vcd::write_vcd;
use palpate_run::{Failure, Outcome, attachments};

use super::report::{hand, report};
use crate::cli::RunArgs;
use crate::output::{Outputs, write_file, write_sidecar};
use crate::record::{Kind as LiveKind, path_of};
use crate::recording::write_can_log;

/// What to write, by the ending of a file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Contacts,
    Schedule,
    Can,
    Golden,
    Mcap,
    Vcd,
    Report,
    Summary,
}

impl Format {
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => Ok(Self::Contacts),
            Some("jsonl") => Ok(Self::Schedule),
            Some("log") => Ok(Self::Can),
            Some("mcap") => Ok(Self::Mcap),
            Some("vcd") => Ok(Self::Vcd),
            Some("snap") => Ok(Self::Golden),
            _ => Err(Failure::Input(format!(
                "--record {}: expected a name that ends in .csv (contacts), .jsonl (schedule), .log (candump), .mcap (everything), .vcd (pins, ticks, temperatures) or .snap (golden)",
                path.display()
            ))),
        }
    }

    /// As a file of it is known again.
    pub(super) const fn on_disk(self) -> FileFormat {
        match self {
            Self::Contacts => FileFormat::Contacts,
            Self::Schedule => FileFormat::Schedule,
            Self::Can => FileFormat::Candump,
            Self::Golden => FileFormat::Golden,
            Self::Mcap => FileFormat::Mcap,
            Self::Vcd => FileFormat::Vcd,
            Self::Report => FileFormat::Html,
            Self::Summary => FileFormat::Json,
        }
    }

    /// As a file that is written while a run goes on; none of what takes all of it.
    pub(super) const fn grows(self) -> Option<LiveKind> {
        match self {
            Self::Contacts => Some(LiveKind::Contacts),
            Self::Schedule => Some(LiveKind::Schedule),
            Self::Can => Some(LiveKind::Can),
            Self::Mcap => Some(LiveKind::Mcap),
            Self::Vcd => Some(LiveKind::Vcd),
            Self::Golden | Self::Report | Self::Summary => None,
        }
    }

    /// Whether several displays have a file each.
    const fn is_per_display(self) -> bool {
        matches!(self, Self::Golden | Self::Mcap | Self::Vcd | Self::Report)
    }

    /// The files that it makes of the one that was asked for.
    pub(super) fn paths(self, path: &Path, setup: &Setup) -> Vec<PathBuf> {
        let whole = || path.to_owned();
        let each = setup.fingers.iter().map(|f| path_of(path, &f.name));
        match self {
            _ if setup.fingers.is_empty() || !self.is_per_display() => vec![whole()],
            // The hand's page stands before those of its fingers.
            Self::Report => std::iter::once(whole()).chain(each).collect(),
            _ => each.collect(),
        }
    }

    /// Writes it of a run that is over.
    pub(super) fn write(
        self,
        path: &Path,
        setup: &Setup,
        outcome: &Outcome,
    ) -> Result<(), Failure> {
        if !self.is_per_display() || outcome.displays.is_empty() {
            return self.write_one(path, setup, outcome);
        }
        let mut paths = self.paths(path, setup);
        if self == Self::Report {
            let whole = paths.remove(0);
            let page = hand(setup, outcome, &paths);
            write_file(&whole, |out| out.write_all(page.as_bytes()))?;
        }
        let mut each = paths.iter().zip(&outcome.displays);
        each.try_for_each(|(path, display)| self.write_one(path, setup, &display.outcome))
    }

    fn write_one(self, path: &Path, setup: &Setup, outcome: &Outcome) -> Result<(), Failure> {
        write_file(path, |out| match self {
            Self::Contacts => write_table(&outcome.trace, out),
            Self::Mcap => {
                let traffic = BusTraffic {
                    can: &outcome.can,
                    i2c: &outcome.i2c,
                    ..BusTraffic::default()
                };
                let run = (&outcome.trace, outcome.readings.as_ref());
                write_mcap(run, traffic, &attachments(setup), out)
            }
            Self::Vcd => write_vcd(&outcome.trace, out),
            Self::Schedule => write_schedule(&outcome.trace, out),
            Self::Can => write_can_log(&outcome.can, &[], out),
            Self::Golden => out.write_all(schedule_golden(&outcome.trace).as_bytes()),
            Self::Report => out.write_all(report(outcome).as_bytes()),
            Self::Summary => {
                serde_json::to_writer_pretty(&mut *out, &outcome.summary)?;
                writeln!(out)
            }
        })?;
        match self {
            Self::Contacts => write_sidecar(path, Some(&outcome.trace.header)),
            _ => Ok(()),
        }
    }
}

/// The files that a real run or a replay writes while it runs, and those that come after it.
#[allow(clippy::type_complexity)] // two lists of what `wanted` returns
pub(super) fn split(
    files: Vec<(Format, PathBuf)>,
) -> (Vec<(LiveKind, PathBuf)>, Vec<(Format, PathBuf)>) {
    let (mut live, mut later) = (Vec::new(), Vec::new());
    for (format, path) in files {
        match format.grows() {
            Some(kind) => live.push((kind, path)),
            None => later.push((format, path)),
        }
    }
    (live, later)
}

/// The files to write, checked before anything runs.
pub(super) fn wanted(args: &RunArgs, setup: &Setup) -> Result<Vec<(Format, PathBuf)>, Failure> {
    let mut files = Vec::new();
    if let Some(folder) = &args.out {
        for (format, name) in [
            (Format::Summary, "summary.json"),
            (Format::Schedule, "schedule.jsonl"),
            (Format::Contacts, "contacts.csv"),
            (Format::Report, "report.html"),
        ] {
            files.push((format, folder.join(name)));
        }
    }
    files.extend(args.schedule.iter().map(|p| (Format::Schedule, p.clone())));
    files.extend(args.report.iter().map(|p| (Format::Report, p.clone())));
    for path in &args.record {
        files.push((Format::of(path)?, path.clone()));
    }
    let outputs = Outputs {
        force: args.force,
        inputs: &args.replay,
    };
    for (n, (format, path)) in files.iter().enumerate() {
        match format {
            Format::Contacts => outputs.check_table(path)?,
            format => {
                let paths = format.paths(path, setup);
                let mut each = paths.iter();
                each.try_for_each(|path| outputs.check(path, format.on_disk()))?;
            }
        }
        if files[..n].iter().any(|(_, before)| before == path) {
            return Err(Failure::Input(format!(
                "{}: expected one output per file, found two",
                path.display()
            )));
        }
    }
    if let Some(path) = &args.junit {
        outputs.check(path, FileFormat::Junit)?;
    }
    Ok(files)
}
