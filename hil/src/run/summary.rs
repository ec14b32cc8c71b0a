//! What a run came to: for people, and as the JSON object of `--json`.

use std::io::{self, Write};
use std::time::Duration;

use palpate_core::projector::Projector;
use palpate_core::skin::{Condition, HealthSummary};
use palpate_core::units::Instant;
use palpate_records::felt::{decibels, energy_permille, felt_scores};
use palpate_records::measure::{Errors, path_error};
use palpate_records::report::Margin;
use palpate_records::trace::{Source, Trace};
use serde::Serialize;

use super::boards::{BoardReport, BusReport};
use super::real::{CanReport, Pacing};
use super::recorder::{Recorder, word};
use super::script::FaultReport;
use palpate_files::Bench;

/// Root mean square and maximum of a distance, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PathError {
    /// Root mean square.
    pub rmse: f64,
    /// Largest.
    pub max: f64,
}

/// The same of what is felt, and where nothing is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeltError {
    /// Root mean square, display mm, over the onsets inside the display; `None` where nothing was felt or no truth is known.
    pub rmse: Option<f64>,
    /// Largest.
    pub max: Option<f64>,
    /// Onsets with a contact inside the hull and no wire above threshold.
    pub breaks: u64,
    /// Onsets at which the felt place went further than the contact by a step that can be felt.
    pub jumps: u64,
    /// Which perceiver says so.
    pub perceiver: &'static str,
}

/// Energy asked of all wires together over one wire's, dB, over the onsets inside the display.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyDb {
    /// The deepest dip.
    pub min: f64,
    /// The highest.
    pub max: f64,
}

/// Rates at which taxels truly change, Hz.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Refresh {
    /// Median over the taxels.
    pub median: f64,
    /// Slowest taxel.
    pub min: f64,
}

/// The skin's health.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Taxels {
    /// Rates of change.
    pub refresh_hz: Refresh,
    /// Taxels that stopped changing although readings came in.
    pub frozen: u32,
    /// Taxels never seen, or not any more.
    pub dead: u32,
    /// Taxels with an axis at the end of its range.
    pub saturated: u32,
    /// Taxels that jump.
    pub jumping: u32,
    /// Of the dead ones, those of which nothing ever came.
    pub never_seen: u32,
    /// Share of frames in which no taxel changed.
    pub repeated: f64,
    /// Every taxel that was ill when the run ended, and left out.
    pub ill: Vec<IllTaxel>,
    /// Rate of change of every taxel that is read, Hz, by module.
    pub refresh_each_hz: Vec<Vec<f32>>,
}

/// A taxel that is left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IllTaxel {
    /// Its module, zero-based.
    pub module: usize,
    /// Its number there, zero-based.
    pub taxel: usize,
    /// frozen, dead, saturated or jumping; never-seen for a dead one of which nothing ever came.
    pub condition: &'static str,
}

impl Taxels {
    /// Fills in what is known of every single taxel at `now`.
    pub(super) fn list(&mut self, projector: &Projector, now: Instant) {
        let (layout, monitor) = (projector.layout(), projector.monitor());
        for (module, m) in layout.modules().iter().enumerate() {
            let mut rates = Vec::new();
            for (taxel, index) in layout.range(module).enumerate() {
                if !m.active()[taxel] {
                    continue;
                }
                rates.push(monitor.rates_hz(index).0);
                let condition = match monitor.condition(index, now) {
                    Condition::Good | Condition::Inactive => continue,
                    Condition::Dead if monitor.received(index).is_none() => "never-seen",
                    other => word(other),
                };
                self.never_seen += u32::from(condition == "never-seen");
                self.ill.push(IllTaxel {
                    module,
                    taxel,
                    condition,
                });
            }
            self.refresh_each_hz.push(rates);
        }
    }
}

/// Computing time of a frame, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameTime {
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub p99: f64,
}

/// What was felt of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TextureSummary {
    /// Windows that went through the network and were felt.
    pub windows: u32,
    /// Mean roughness, 0 to 1.
    pub roughness: f64,
    /// Pulses that were left out for a wire to rest.
    pub rested_pulses: u64,
}

/// The object that `hil run --json` prints; `interface.md` names its keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct Summary {
    pub source: Source,
    pub scene: String,
    pub bench: String,
    pub seed: u64,
    pub frames: u32,
    pub contacts: u64,
    pub stimuli: u64,
    pub path_error_mm: Option<PathError>,
    pub felt_error_mm: FeltError,
    pub felt_error_amplitude_mm: FeltError,
    pub felt_energy_db: Option<EnergyDb>,
    /// Null on a real bench, which does not measure it.
    pub energy_mj: Option<f64>,
    /// Null on a real bench.
    pub peak_supply_a: Option<f64>,
    pub hottest_wire_c: Option<f64>,
    pub hottest_skin_c: Option<f64>,
    pub pwm_hz: f64,
    pub limiter_events: u32,
    /// Null where no texture was felt.
    pub texture: Option<TextureSummary>,
    pub frame_us: Option<FrameTime>,
    pub taxels: Taxels,
    pub boards: Vec<BoardReport>,
    pub buses: Vec<BusReport>,
    pub faults: Vec<FaultReport>,
    pub margins: Vec<Margin>,
    /// How a real run kept its time; null for an emulated one.
    pub pacing: Option<Pacing>,
    /// The CAN interfaces of a real run.
    pub can: Vec<CanReport>,
    /// Frames that a record lacks because the disk did not follow.
    pub frames_not_recorded: u64,
    pub sim_s: f64,
    pub wall_s: f64,
}

/// Three digits or so, whatever the size.
fn short(v: f64) -> String {
    match v.abs() {
        a if a >= 100.0 || !a.is_finite() => format!("{v:.0}"),
        a if a >= 1.0 => format!("{v:.1}"),
        a if a >= 0.001 || a == 0.0 => format!("{v:.3}"),
        _ => format!("{v:.0e}"),
    }
}

fn mm(um: u64) -> f64 {
    um as f64 * 1e-3
}

impl TextureSummary {
    /// Of the windows that a recorder saw.
    pub(super) fn of(recorder: &Recorder, projector: &Projector) -> Option<Self> {
        let (windows, rough_permille) = recorder.windows;
        (windows > 0).then(|| Self {
            windows,
            roughness: rough_permille as f64 * 1e-3 / f64::from(windows),
            rested_pulses: projector.rested_pulses(),
        })
    }
}

impl FeltError {
    fn line(&self) -> String {
        let many = |count: u64, one: &str| match count {
            0 => format!("no {one}"),
            1 => format!("1 {one}"),
            n => format!("{n} {one}s"),
        };
        let events = format!(
            "{}, {}",
            many(self.breaks, "break"),
            many(self.jumps, "jump")
        );
        match (self.rmse, self.max) {
            (Some(rmse), Some(max)) => format!(
                "{rmse:.2} mm RMSE, {max:.2} mm at most (display, {}), {events}",
                self.perceiver
            ),
            _ => format!("- (no true path known), {events}"),
        }
    }
}

impl FrameTime {
    /// Of measured times; `None` for none.
    fn of(frame_us: &[f32]) -> Option<Self> {
        let mut sorted = frame_us.to_vec();
        sorted.sort_by(f32::total_cmp);
        let at = |part: f64| {
            sorted
                .get((part * (sorted.len().checked_sub(1)?) as f64) as usize)
                .copied()
        };
        Some(Self {
            median: f64::from(at(0.5)?),
            p99: f64::from(at(0.99)?),
        })
    }
}

impl Summary {
    pub(super) fn new(
        trace: &Trace,
        recorder: &Recorder,
        frame_us: &[f32],
        health: &HealthSummary,
        bench: &Bench,
        wall: Duration,
    ) -> Self {
        let error = |e: Errors| PathError {
            rmse: mm(e.rmse_um),
            max: mm(e.max_um),
        };
        let path = path_error(trace).map(error);
        // Without a truth there is nothing to hold the felt path against; breaks need none.
        let [felt, felt_amplitude] = felt_scores(trace).map(|score| {
            let errors = score.errors.map(error).filter(|_| path.is_some());
            FeltError {
                rmse: errors.map(|e| e.rmse),
                max: errors.map(|e| e.max),
                breaks: score.breaks,
                jumps: score.jumps,
                perceiver: score.perceiver,
            }
        });
        let ledger = &trace.ledger;
        let emulated = trace.header.source == Source::Emulated;
        Self {
            source: trace.header.source,
            scene: trace.header.scene.clone(),
            bench: trace.header.bench.clone(),
            seed: trace.header.seed,
            frames: recorder.frames,
            contacts: recorder.contacts,
            stimuli: recorder.stimuli,
            path_error_mm: path,
            felt_error_mm: felt,
            felt_error_amplitude_mm: felt_amplitude,
            felt_energy_db: energy_permille(trace).map(|(min, max)| EnergyDb {
                min: decibels(min),
                max: decibels(max),
            }),
            energy_mj: emulated.then_some(ledger.energy_uj as f64 * 1e-3),
            peak_supply_a: emulated.then_some(f64::from(ledger.peak_supply_ma) * 1e-3),
            hottest_wire_c: ledger.hottest_wire.map(|(t, _)| f64::from(t) * 1e-3),
            hottest_skin_c: ledger.hottest_skin_milli_c.map(|t| f64::from(t) * 1e-3),
            pwm_hz: trace.header.pre_scale.hz() * bench.drive.oscillator,
            limiter_events: ledger.limiter_events,
            texture: None,
            frame_us: FrameTime::of(frame_us),
            taxels: Taxels {
                refresh_hz: Refresh {
                    median: f64::from(health.refresh_median_hz),
                    min: f64::from(health.refresh_min_hz),
                },
                frozen: health.frozen,
                dead: health.dead,
                saturated: health.saturated,
                jumping: health.jumping,
                never_seen: 0,
                ill: Vec::new(),
                refresh_each_hz: Vec::new(),
                repeated: health.repeated as f64 / (health.frames.max(1)) as f64,
            },
            boards: Vec::new(),
            buses: Vec::new(),
            faults: Vec::new(),
            margins: Vec::new(),
            pacing: None,
            can: Vec::new(),
            frames_not_recorded: 0,
            sim_s: ledger.length_us as f64 * 1e-6,
            wall_s: wall.as_secs_f64(),
        }
    }

    /// A dozen lines for a person.
    ///
    /// # Errors
    /// What the stream says.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let source = match self.source {
            Source::Emulated => "emulated",
            Source::Real => "real",
        };
        writeln!(
            out,
            "{} on {} ({source}), seed {}",
            self.scene, self.bench, self.seed
        )?;
        let mut row = |name: &str, value: String| writeln!(out, "  {name:<16}{value}");
        match self.source {
            Source::Emulated => row(
                "simulated",
                format!("{:.3} s in {:.3} s", self.sim_s, self.wall_s),
            ),
            Source::Real => row("length", format!("{:.3} s", self.sim_s)),
        }?;
        row(
            "contacts",
            format!("{} in {} frames", self.contacts, self.frames),
        )?;
        row(
            "path error",
            match &self.path_error_mm {
                Some(e) => format!("{:.2} mm RMSE, {:.2} mm at most (sensor)", e.rmse, e.max),
                None => "- (no true path known)".into(),
            },
        )?;
        for felt in [&self.felt_error_mm, &self.felt_error_amplitude_mm] {
            row("felt error", felt.line())?;
        }
        if let Some(db) = &self.felt_energy_db {
            row(
                "felt energy",
                format!("{:.1} to {:.1} dB of one wire's", db.min, db.max),
            )?;
        }
        row(
            "stimuli",
            format!("{} at {:.2} Hz", self.stimuli, self.pwm_hz),
        )?;
        if let (Some(mj), Some(ampere)) = (self.energy_mj, self.peak_supply_a) {
            row("energy", format!("{mj:.1} mJ electrical"))?;
            row("supply", format!("{ampere:.2} A at most"))?;
        }
        let celsius = |t: Option<f64>| t.map_or("-".into(), |t| format!("{t:.1} C"));
        row(
            "hottest wire",
            format!("{} (no limit of its own)", celsius(self.hottest_wire_c)),
        )?;
        let limit = self.margins.iter().find(|m| m.name == "skin at 0.1 mm");
        let limit = limit.map_or(String::new(), |m| {
            let passed = if m.over() { ", PASSED" } else { "" };
            format!(", limit {:.1} C{passed}", m.limit)
        });
        row(
            "hottest skin",
            format!(
                "{}{limit} (modelled, 0.1 mm deep)",
                celsius(self.hottest_skin_c)
            ),
        )?;
        if let Some(t) = &self.texture {
            let rested = match t.rested_pulses {
                0 => String::new(),
                n => format!("; {n} pulses left out, wires rest after 48 ms"),
            };
            row(
                "texture",
                format!(
                    "{} windows, roughness {:.2} (mean){rested}",
                    t.windows, t.roughness
                ),
            )?;
        }
        row("limiter events", self.limiter_events.to_string())?;
        row(
            "time per frame",
            match &self.frame_us {
                Some(t) => format!("{:.1} us median, {:.1} us p99", t.median, t.p99),
                None => "-".into(),
            },
        )?;
        let t = &self.taxels;
        row(
            "taxels",
            format!(
                "refresh {:.1} Hz median, {:.1} Hz min; {:.0} % of frames repeated; {} frozen, {} dead, {} saturated, {} jumping",
                t.refresh_hz.median,
                t.refresh_hz.min,
                t.repeated * 100.0,
                t.frozen,
                t.dead,
                t.saturated,
                t.jumping
            ),
        )?;
        for bus in &self.buses {
            let of_bus = |b: &&BoardReport| b.bus.map(usize::from) == Some(bus.bus);
            let boards: Vec<_> = self.boards.iter().filter(of_bus).collect();
            let slowest = boards
                .iter()
                .map(|b| b.rate_hz.min)
                .fold(f64::MAX, f64::min);
            let fastest = boards.iter().map(|b| b.rate_hz.max).fold(0.0, f64::max);
            row(
                &format!("bus {}", bus.bus),
                format!(
                    "{:.1} % load, {} boards, taxels at {slowest:.1} to {fastest:.1} Hz, {} errors",
                    bus.load * 100.0,
                    boards.len(),
                    bus.errors.iter().sum::<u64>()
                ),
            )?;
        }
        for can in &self.can {
            row(&can.interface, can.words())?;
        }
        if self.frames_not_recorded > 0 {
            let lost = format!(
                "{} frames not recorded, the disk was too slow",
                self.frames_not_recorded
            );
            row("records", lost)?;
        }
        if let Some(pacing) = &self.pacing {
            row("pacing", pacing.words())?;
        }
        for fault in &self.faults {
            row("fault", format!("{}: count {}", fault.what, fault.count))?;
        }
        for (index, m) in self.margins.iter().enumerate() {
            let line = format!(
                "{:<27}{:>8} of {:>7} {:<3} {:>4.0} % used{}",
                m.name,
                short(m.worst),
                short(m.limit),
                m.unit,
                m.used.max(0.0) * 100.0,
                if m.over() { ", PASSED" } else { "" }
            );
            row(if index == 0 { "margins" } else { "" }, line)?;
        }
        Ok(())
    }
}
