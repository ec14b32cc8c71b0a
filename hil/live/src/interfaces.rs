//! Reports of CAN interfaces, for summaries and recordings.

use palpate_buses::can::Tally;
use palpate_run::CanReport;

/// Report of every interface, by name.
pub fn reports(names: &[String], tallies: &[Tally]) -> Vec<CanReport> {
    let report = |(interface, tally): (&String, &Tally)| CanReport {
        interface: interface.clone(),
        frames: tally.frames,
        lost: tally.dropped + tally.discarded,
        overruns: tally.overruns,
        errors: tally.bus_errors,
        bus_off: tally.bus_off,
        hardware_stamps: tally.hardware_stamps,
    };
    names.iter().zip(tallies).map(report).collect()
}

/// Report of every interface, a line each.
pub fn lines(names: &[String], tallies: &[Tally]) -> Vec<String> {
    reports(names, tallies)
        .iter()
        .map(CanReport::words)
        .collect()
}
