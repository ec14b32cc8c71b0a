//! `hil doctor`: what this machine can do, what is missing, what to type.

use palpate_buses::survey::{Finding, survey};
use serde::Serialize;

use crate::cli::DoctorArgs;
use crate::output::print;
use crate::real::watch;
use palpate_run::Failure;

use super::devices::bench;

/// The JSON object of `--json`.
#[derive(Serialize)]
struct Report {
    findings: Vec<Row>,
    /// Whether everything a real bench cannot do without is there.
    ready: bool,
}

/// One thing that was looked at.
#[derive(Serialize)]
struct Row {
    about: &'static str,
    ok: bool,
    says: String,
    remedy: Option<String>,
}

/// Prints what was found. What is missing is no failure, unless a bench was named.
///
/// # Errors
/// [`Failure::Input`] for a bad bench, [`Failure::Device`] when the named bench lacks something.
pub fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let named = args
        .bench
        .as_deref()
        .map(|name| bench(Some(name), &[], &[]));
    let named = named.transpose()?;
    let real = named.as_ref().and_then(|b| b.value.real.as_ref());
    let watched = named
        .as_ref()
        .zip(real)
        .map(|(b, real)| watch(&b.value, real));
    let can = real.map(|real| real.can.as_slice());
    let findings = survey(can, watched.as_ref());
    let ready = findings.iter().all(|f| f.ok || !f.needed);
    if args.json {
        let row = |f: Finding| Row {
            about: f.about,
            ok: f.ok,
            says: f.says,
            remedy: f.remedy,
        };
        let report = Report {
            findings: findings.into_iter().map(row).collect(),
            ready,
        };
        print(|out| {
            serde_json::to_writer(&mut *out, &report)?;
            writeln!(out)
        })?;
    } else {
        print(|out| {
            for finding in &findings {
                let mark = match (finding.ok, finding.needed) {
                    (true, _) => "ok",
                    (false, true) => "missing",
                    (false, false) => "-",
                };
                writeln!(out, "{mark:<8}{:<12}{}", finding.about, finding.says)?;
                if let Some(remedy) = &finding.remedy {
                    writeln!(out, "{:<20}{remedy}", "")?;
                }
            }
            Ok(())
        })?;
    }
    if ready || named.is_none() {
        return Ok(());
    }
    Err(Failure::Device(
        "the bench lacks what is marked `missing`".into(),
    ))
}
