//! The summary of a run in lines for people.

use std::io::{self, Write};

use palpate_records::felt::FeltBand;
use palpate_records::margin::{Limited, Margin};
use palpate_records::model;
use palpate_records::trace::Source;

use crate::boards::{BoardReport, BusReport};
use crate::pass::PassReport;
use crate::path_error::PathError;
use crate::states::FeltState;
use crate::summary::{DisplaySummary, EnergyDb, Summary, Taxels};
use crate::summary_felt::{AskedLevel, FeltError, FeltSummary};

/// Three digits or so, whatever the size.
fn short(v: f64) -> String {
    match v.abs() {
        a if a > 1e6 || !a.is_finite() => "> 1e6".to_owned(),
        a if a >= 100.0 => format!("{v:.0}"),
        a if a >= 1.0 => format!("{v:.1}"),
        a if a >= 0.001 || a == 0.0 => format!("{v:.3}"),
        _ => format!("{v:.0e}"),
    }
}

/// Words of a count of things.
fn counted(count: u64, one: &str) -> String {
    match count {
        0 => format!("no {one}"),
        1 => format!("1 {one}"),
        n => format!("{n} {one}s"),
    }
}

/// Words of a count behind a comma; empty where nothing was measured.
fn and_counted(count: Option<u64>, one: &str) -> String {
    count.map_or_else(String::new, |n| format!(", {}", counted(n, one)))
}

impl FeltError {
    fn words(&self) -> String {
        let jumps = and_counted(self.jumps, "jump");
        let onsets = |count: u64| counted(count, "onset");
        let inside = match (self.rmse, self.max) {
            (Some(rmse), Some(max)) => format!(
                "{rmse:.2} mm, {max:.2} at most inside the wires ({})",
                onsets(self.onsets)
            ),
            _ => "no onset inside the wires".to_owned(),
        };
        match &self.everywhere {
            Some(all) => format!(
                "{}: {:.2} mm RMSE, {:.2} at most over all {}; {inside}{jumps}",
                self.perceiver,
                all.rmse,
                all.max,
                onsets(all.onsets)
            ),
            None => format!(
                "{}: - (nothing felt on a known path){jumps}",
                self.perceiver
            ),
        }
    }
}

impl FeltSummary {
    /// Words of the level on these actuators.
    fn words(&self, actuators: &str) -> String {
        let level = self.level_db.as_ref().map_or("-".into(), |level| {
            format!(
                "{:+.1} dB over threshold (median), {:+.1} dB (5 %)",
                level.median, level.p5
            )
        });
        let skin = self.skin_um.as_ref().map_or_else(String::new, |um| {
            format!(
                ", skin {:.1} um (median), {:.1} at most",
                um.median, um.most
            )
        });
        let breaks = and_counted(self.breaks, "break");
        format!(
            "{level}{skin}{breaks}; person {}, {actuators} {}{}",
            self.person,
            self.preset,
            self.state
                .map_or_else(String::new, |state| format!(" ({state})"))
        )
    }
}

impl FeltSummary {
    /// Line of the run in each state of its wires, by the errors of the energy and the amplitude centroid.
    fn states_line(&self) -> Option<Line> {
        let of = |state: &FeltState| {
            let mm = |error: Option<PathError>| {
                error.map_or_else(|| "-".to_owned(), |error| format!("{:.2}", error.rmse))
            };
            format!(
                "{} {:+.1} dB, error {} / {} mm",
                state.state,
                state.level_db,
                mm(state.error_energy_mm),
                mm(state.error_amplitude_mm)
            )
        };
        let states: Vec<String> = self.states.iter().map(of).collect();
        (!states.is_empty()).then(|| line("by state", states.join("; ")))
    }
}

impl AskedLevel {
    fn line(&self) -> Line {
        let weaker = match self.weaker {
            0 => "had by every onset".to_owned(),
            n => format!(
                "heat left less to {n} of {} onsets, {:+.1} dB at least",
                self.onsets, self.least_db
            ),
        };
        line(
            "asked",
            format!("{:+.1} dB over threshold, {weaker}", self.level_db),
        )
    }
}

/// Line of a band.
fn band_line(band: &FeltBand) -> Line {
    let [low, half, high] = band.level_db;
    let [least, middle, most] = band.error_mm;
    let words = format!(
        "{low:+.1} to {high:+.1} dB, {half:+.1} median; {:.0} % feel it; error {least:.1} to {most:.1} mm, {middle:.1} median (5 to 95 % of {} draws on {})",
        100.0 * band.felt,
        band.draws,
        band.scene
    );
    line("felt band", words)
}

impl DisplaySummary {
    /// Line of this display; the lines before it tell the worst of all displays.
    fn line(&self) -> Line {
        let end = match (&self.failure, self.stops) {
            (Some(failure), _) => format!("; ENDED: {failure}"),
            (None, 0) => String::new(),
            (None, stops) => format!("; stopped {}", counted(stops, "time")),
        };
        let all = self.felt.error_energy_all_mm.as_ref();
        let error = all.map_or_else(
            || "-".into(),
            |all| {
                let inside = self.felt.error_energy_mm.as_ref();
                let inside = inside.map_or_else(String::new, |e| {
                    format!(" ({:.2} in {} inside)", e.rmse, self.felt.onsets_inside)
                });
                format!("{:.2} mm RMSE over {}{inside}", all.rmse, all.onsets)
            },
        );
        let level = self.felt.level_db.as_ref();
        let level = level.map_or_else(|| "-".into(), |l| format!("{:+.1} dB", l.median));
        let texture = self.texture.as_ref().map(|t| t.words());
        let texture = texture.map_or_else(String::new, |words| format!("; texture {words}"));
        let words = format!(
            "felt {level}, {error}{}; {} stimuli, {} limited; skin {}; person {}{texture}{end}",
            and_counted(self.felt.breaks, "break"),
            self.stimuli,
            self.limiter_events,
            model::words(self.hottest_skin_c, model::TISSUE_C),
            self.felt.person
        );
        line(&self.name, words)
    }
}

impl EnergyDb {
    fn words(&self) -> String {
        format!("{:.1} to {:.1}", self.min, self.max)
    }
}

/// Name and value of a line.
type Line = (String, String);

fn line(name: &str, value: String) -> Line {
    (name.to_owned(), value)
}

impl Summary {
    /// Writes every figure for a person: some dozen lines, without the verdict.
    ///
    /// # Errors
    /// Errors of the stream.
    pub fn write_long(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "{} on {} ({}), seed {}",
            self.scene,
            self.bench,
            self.source.words(),
            self.seed
        )?;
        let felt = self.felt_lines().into_iter();
        let displays = self.displays.iter().map(DisplaySummary::line);
        let lines = felt.chain(displays).chain(self.heat_lines());
        for (name, value) in lines
            .chain(self.hardware_lines())
            .chain(self.margin_lines())
        {
            writeln!(out, "  {name:<16}{value}")?;
        }
        Ok(())
    }

    /// Lines of the contacts, and of the places where they are felt.
    fn felt_lines(&self) -> Vec<Line> {
        let mut lines = vec![
            match self.source.is_emulated() {
                true => line(
                    "simulated",
                    format!("{:.3} s in {:.3} s", self.sim_s, self.wall_s),
                ),
                false => line("length", format!("{:.3} s", self.sim_s)),
            },
            line(
                "contacts",
                format!("{} in {} frames", self.contacts, self.frames),
            ),
            line(
                "path error",
                match &self.path_error_mm {
                    Some(e) => format!("{:.2} mm RMSE, {:.2} mm at most (sensor)", e.rmse, e.max),
                    None => "- (no true path known)".into(),
                },
            ),
        ];
        let passed = self.pass.as_ref().map(PassReport::line);
        let passed = passed.or_else(|| self.no_pass.clone());
        lines.extend(passed.map(|text| line("hot pass", text)));
        let actuators = match self.motors {
            Some(_) => "motors",
            None => "wires",
        };
        lines.push(line("felt level", self.felt.words(actuators)));
        lines.extend(self.felt.asked.as_ref().map(AskedLevel::line));
        lines.extend(self.felt.band.as_ref().map(band_line));
        let none = self.felt.no_band.as_ref();
        lines.extend(none.map(|why| line("felt band", why.clone())));
        lines.extend(self.felt.states_line());
        lines.push(line("felt error", self.felt_error_mm.words()));
        // Error by the other centroid of the literature.
        lines.push(line("", self.felt_error_amplitude_mm.words()));
        let all = [
            (&self.requested_energy_db, "requested"),
            (&self.applied_energy_db, "applied"),
            (&self.felt_energy_db, "felt"),
        ];
        let energies: Vec<String> = all
            .into_iter()
            .filter_map(|(db, name)| Some(format!("{} {name}", db.as_ref()?.words())))
            .collect();
        if !energies.is_empty() {
            let words = format!("{} (dB over one wire's)", energies.join(", "));
            lines.push(line("felt energy", words));
        }
        lines
    }

    /// Lines of the stimuli, and of the heat in wires and tissue.
    fn heat_lines(&self) -> Vec<Line> {
        if let Some(motors) = &self.motors {
            return vec![
                line("stimuli", self.stimuli.to_string()),
                line("exposure", motors.words()),
                line("limiter events", self.limiter_events.to_string()),
            ];
        }
        let stimuli = format!("{} at {:.2} Hz", self.stimuli, self.pwm_hz);
        let mut lines = vec![line("stimuli", stimuli)];
        if let (Some(mj), Some(ampere)) = (self.energy_mj, self.peak_supply_a) {
            lines.push(line("energy", format!("{mj:.1} mJ electrical")));
            lines.push(line("supply", format!("{ampere:.2} A at most")));
        }
        let wire = model::words(self.hottest_wire_c, model::WIRE_C);
        let wire = format!("{wire} (no limit of its own)");
        lines.push(line("hottest wire", wire));
        lines.push(line("hottest skin", self.skin_words()));
        if self.stimuli > 0 {
            lines.push(line("longest session", self.session_words()));
        }
        lines.extend(self.texture.as_ref().map(|t| line("texture", t.words())));
        let events = match self.source {
            Source::Observed => format!("0 stimuli changed, {} noted", self.limiter_events),
            Source::Emulated | Source::Real => self.limiter_events.to_string(),
        };
        lines.push(line("limiter events", events));
        lines
    }

    /// The hottest skin against its limit.
    pub(crate) fn skin_words(&self) -> String {
        let limit = self.margins.iter().find(|m| m.of == Limited::SkinPeak);
        let limit = limit.map_or(String::new(), |m| {
            let passed = if m.over() { ", EXCEEDED" } else { "" };
            format!(", limit {:.1} C{passed}", m.limit())
        });
        let tissue = model::words(self.hottest_skin_c, model::TISSUE_C);
        let known = |celsius: f64| model::known(celsius, model::TISSUE_C);
        let depth = match self.hottest_skin_c.and_then(known) {
            Some(_) => " (modelled, 0.1 mm deep)",
            None => "",
        };
        format!("{tissue}{limit}{depth}")
    }

    /// The longest session of a run that drove something.
    pub(crate) fn session_words(&self) -> String {
        let Some(seconds) = self.longest_session_s else {
            return "a day and more of this".into();
        };
        let long = match (seconds / 3600.0, seconds / 60.0) {
            (hours, _) if hours >= 2.0 => format!("{hours:.1} h"),
            (_, minutes) if minutes >= 2.0 => format!("{minutes:.0} min"),
            _ => format!("{seconds:.0} s"),
        };
        format!("{long} of this, then a wire's dose runs out")
    }

    /// Lines of computing time, taxels, buses, records and faults.
    fn hardware_lines(&self) -> Vec<Line> {
        let frame = self.frame_us.as_ref().map_or("-".into(), |t| {
            format!("{:.1} us median, {:.1} us p99", t.median, t.p99)
        });
        let mut lines = vec![line("time per frame", frame), self.taxels.line()];
        lines.extend(self.buses.iter().map(|bus| self.bus_line(bus)));
        let can = self.can.iter();
        lines.extend(can.map(|can| line(&can.interface, can.words())));
        if self.frames_not_recorded > 0 {
            let lost = format!(
                "{} frames not recorded, the disk was too slow",
                self.frames_not_recorded
            );
            lines.push(line("records", lost));
        }
        lines.extend(self.heat.as_ref().map(|h| line("warmth", h.words())));
        lines.extend(self.unit.as_ref().map(|u| line("unit", u.words())));
        lines.extend(self.pacing.as_ref().map(|p| line("pacing", p.words())));
        let fault = self.faults.iter();
        lines.extend(fault.map(|f| line("fault", format!("{}: count {}", f.what, f.count))));
        lines
    }

    fn bus_line(&self, bus: &BusReport) -> Line {
        let of_bus = |b: &&BoardReport| b.bus.map(usize::from) == Some(bus.bus);
        let boards: Vec<_> = self.boards.iter().filter(of_bus).collect();
        let rates = boards.iter().map(|b| b.rate_hz);
        let slowest = rates.clone().map(|r| r.min).reduce(f64::min);
        let fastest = rates.map(|r| r.max).reduce(f64::max);
        let taxels = match slowest.zip(fastest) {
            Some((slow, fast)) => format!(
                "{}, taxels at {slow:.1} to {fast:.1} Hz",
                counted(boards.len() as u64, "board")
            ),
            None => "no boards".to_owned(),
        };
        let words = format!(
            "{:.1} % load, {taxels}, {} errors",
            bus.load * 100.0,
            bus.errors.iter().sum::<u64>()
        );
        line(&format!("bus {}", bus.bus), words)
    }

    fn margin_lines(&self) -> Vec<Line> {
        let row = |(index, m): (usize, &Margin)| {
            let (worst, used) = match m.is_beyond() {
                true => (format!("> {:.0}", model::TISSUE_C), "-".to_owned()),
                false => (short(m.worst()), m.used_words()),
            };
            let words = format!(
                "{:<27}{worst:>8} of {:>7} {:<5} {used:>7} used{}",
                m.of.name(),
                short(m.limit()),
                m.of.unit(),
                if m.over() { ", EXCEEDED" } else { "" }
            );
            line(if index == 0 { "margins" } else { "" }, words)
        };
        self.margins.iter().enumerate().map(row).collect()
    }
}

impl Taxels {
    fn line(&self) -> Line {
        let refresh = match &self.refresh_hz {
            Some(hz) => format!("refresh {:.1} Hz median, {:.1} Hz min", hz.median, hz.min),
            None => "no reading".to_owned(),
        };
        let words = format!(
            "{refresh}; {:.0} % of frames repeated; {} frozen, {} dead, {} saturated, {} jumping",
            self.repeated * 100.0,
            self.frozen,
            self.dead,
            self.saturated,
            self.jumping
        );
        line("taxels", words)
    }
}
