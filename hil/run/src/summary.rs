//! Summary of a run, the JSON object of `--json`.

use palpate_core::projector::Projector;
use palpate_core::skin::{Condition, HealthSummary};
use palpate_core::statistics::{mean, quantile};
use palpate_core::units::Instant;
use palpate_records::felt::{FeltPath, decibels};
use palpate_records::frame_time::FrameTime;
use palpate_records::margin::{Limited, Margin};
use palpate_records::measure::{Errors, path_error};
use palpate_records::trace::{Header, Ledger, Source, Trace, sort_by_time};
use palpate_records::verdict::Conclusion;
use serde::Serialize;

use super::boards::{self, BoardReport, BusReport, CanReport, Pacing};
use super::display_end::DisplayEnd;
use super::effort::FrameCost;
use super::recorder::Recorder;
use super::script::FaultReport;
use super::session::Session;
use super::skin_end::SkinEnd;
use crate::heat::HeatReport;
use crate::known::{known_tissue, known_wire};
use crate::motors::MotorReport;
use crate::onsets::Onsets;
use crate::pass::PassReport;
use crate::path_error::PathError;
use crate::summary_felt::{CountedError, FeltError, FeltSummary};
use crate::texture_summary::TextureSummary;
use crate::unit::UnitReport;
use palpate_files::Bench;

/// Summary of one of several displays.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct DisplaySummary {
    pub name: String,
    pub modules: Vec<usize>,
    pub boards: Vec<u8>,
    pub path_error_mm: Option<PathError>,
    pub onsets: Onsets,
    pub felt: FeltSummary,
    pub stimuli: u64,
    pub limiter_events: u32,
    /// Hottest skin, degrees C; null beyond the model.
    #[serde(serialize_with = "known_tissue")]
    pub hottest_skin_c: Option<f64>,
    /// Felt textures of the display, where the scene has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<TextureSummary>,
    /// The display's part of the supply's current.
    pub supply_share_a: f64,
    /// Times that the display was switched off for a cause of its own.
    pub stops: u64,
    /// Failure that ended the display before the run.
    pub failure: Option<String>,
}

/// Energy of all wires together over one wire's, dB, over the onsets inside the display.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EnergyDb {
    /// Lowest energy.
    pub min: f64,
    /// Highest energy.
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
    /// Rates of change; `None` where no reading came.
    pub refresh_hz: Option<Refresh>,
    /// Taxels that stopped changing although readings came in.
    pub frozen: u32,
    /// Taxels never seen, or not any more.
    pub dead: u32,
    /// Taxels with an axis at the end of its range.
    pub saturated: u32,
    /// Taxels that jump.
    pub jumping: u32,
    /// Dead taxels that never sent a reading.
    pub never_seen: u32,
    /// Frames that were no readings of the layout.
    pub foreign: u64,
    /// Share of frames in which no taxel changed.
    pub repeated: f64,
    /// Rows in which a module had no reference because the skin was moved; the verdict says it.
    #[serde(skip)]
    pub rows_not_at_rest: u32,
    /// References that readings fell below, so that they were taken touched; the verdict says it.
    #[serde(skip)]
    pub taken_touched: u32,
    /// Every taxel that was ill when the run ended, and left out.
    pub ill: Vec<IllTaxel>,
    /// Rate of change of every taxel that is read, Hz, by module.
    pub refresh_each_hz: Vec<Vec<f32>>,
}

/// A taxel that is left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IllTaxel {
    /// Module of the taxel, zero-based.
    pub module: usize,
    /// Number of the taxel in its module, zero-based.
    pub taxel: usize,
    /// frozen, dead, saturated or jumping; never-seen for a dead one that never sent a reading.
    pub condition: &'static str,
}

impl Taxels {
    /// Sums several fingers, each with the skin's numbers of its modules.
    pub(crate) fn joined<'a>(parts: impl Iterator<Item = (&'a [usize], &'a Self)> + Clone) -> Self {
        let mut sum = Self::default();
        let mut rates: Vec<(usize, Vec<f32>)> = Vec::new();
        for (modules, part) in parts.clone() {
            sum.frozen += part.frozen;
            sum.dead += part.dead;
            sum.saturated += part.saturated;
            sum.jumping += part.jumping;
            sum.rows_not_at_rest += part.rows_not_at_rest;
            sum.taken_touched += part.taken_touched;
            (sum.foreign, sum.never_seen) = (part.foreign, sum.never_seen + part.never_seen);
            sum.ill.extend(part.ill.iter().cloned());
            let each = part.refresh_each_hz.iter().cloned();
            rates.extend(modules.iter().copied().zip(each));
        }
        sum.ill.sort_unstable_by_key(|t| (t.module, t.taxel));
        rates.sort_unstable_by_key(|(module, _)| *module);
        let mut sorted: Vec<f32> = rates.iter().flat_map(|(_, hz)| hz.clone()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let read = parts.clone().any(|(_, part)| part.refresh_hz.is_some());
        let middle = quantile(&sorted, 0.5).filter(|_| read);
        sum.refresh_hz = middle.map(|middle| Refresh {
            median: f64::from(middle.above),
            min: f64::from(sorted[0]),
        });
        sum.repeated = mean(parts.map(|(_, part)| part.repeated)).unwrap_or(0.0);
        sum.refresh_each_hz = rates.into_iter().map(|(_, hz)| hz).collect();
        sum
    }

    /// Fills in what is known of every single taxel at `now`.
    fn list(&mut self, projector: &Projector, now: Instant, foreign: u64) {
        self.foreign = foreign;
        self.rows_not_at_rest = projector.baseline().unrest();
        self.taken_touched = projector.baseline().taken_touched();
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
                    other => other.word(),
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

/// The object that `hil run --json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the keys say what they are, with their units
pub struct Summary {
    /// End of the run, and its reason.
    #[serde(flatten)]
    pub conclusion: Conclusion,
    pub source: Source,
    /// Version of the program.
    pub version: &'static str,
    /// Time at which the summary was made, UTC; null where no clock says so.
    pub date: Option<String>,
    pub scene: String,
    pub bench: String,
    pub seed: u64,
    pub frames: u32,
    pub contacts: u64,
    pub stimuli: u64,
    pub path_error_mm: Option<PathError>,
    /// Distance between neighbouring taxels on the skin that drives; null for a single taxel.
    pub pitch_mm: Option<f64>,
    pub onsets: Onsets,
    /// Hot pass before the run; left out where there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pass: Option<PassReport>,
    /// Reason why there was none before a run on cold wires; left out for one that had one, or needed none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_pass: Option<String>,
    pub felt: FeltSummary,
    pub felt_error_mm: FeltError,
    pub felt_error_amplitude_mm: FeltError,
    pub requested_energy_db: Option<EnergyDb>,
    pub applied_energy_db: Option<EnergyDb>,
    /// Energy of the currents after the filter of a person's skin.
    pub felt_energy_db: Option<EnergyDb>,
    /// Energy, mJ; null on a real bench, which does not measure it.
    pub energy_mj: Option<f64>,
    /// Largest supply current, A; null on a real bench.
    pub peak_supply_a: Option<f64>,
    /// Hottest wire, degrees C; null where nothing measures it, and beyond the model.
    #[serde(serialize_with = "known_wire")]
    pub hottest_wire_c: Option<f64>,
    /// Hottest skin, degrees C; null as the wire's.
    #[serde(serialize_with = "known_tissue")]
    pub hottest_skin_c: Option<f64>,
    /// Longest time for which the run may be repeated until a wire's dose is used up, as the guard counts; null where
    /// that takes a day or more, or nothing was driven.
    pub longest_session_s: Option<f64>,
    pub pwm_hz: f64,
    pub limiter_events: u32,
    /// Felt textures; null where none was felt.
    pub texture: Option<TextureSummary>,
    pub frame_us: Option<FrameTime>,
    pub taxels: Taxels,
    pub boards: Vec<BoardReport>,
    pub buses: Vec<BusReport>,
    pub faults: Vec<FaultReport>,
    pub margins: Vec<Margin>,
    /// Summaries of several displays; left out for one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub displays: Vec<DisplaySummary>,
    /// Report of a driver unit and its link; left out where the host has the boards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<UnitReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heat: Option<HeatReport>,
    /// Motors of the bench; left out where it has wires.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motors: Option<MotorReport>,
    /// Lateness of a real run's turns; null for an emulated one.
    pub pacing: Option<Pacing>,
    /// Reports of the CAN interfaces of a real run.
    pub can: Vec<CanReport>,
    /// Frames that a record lacks because the disk did not follow.
    pub frames_not_recorded: u64,
    pub sim_s: f64,
    pub wall_s: f64,
}

/// Trace and summary of a session, from its records until `end`. Fields that only one kind of bench knows are left for
/// its run to fill in: the hardware's totals where it is emulated, its pacing where it is real.
pub fn finished<S: SkinEnd, D: DisplayEnd>(
    session: &mut Session<S, D>,
    header: Header,
    totals: Ledger,
    costs: &[FrameCost],
    bench: &Bench,
) -> (Trace, Summary) {
    let end = Instant::from_micros(totals.length_us);
    let recorder = session.recorder();
    let mut events = std::mem::take(&mut recorder.events);
    sort_by_time(&mut events);
    let trace = Trace {
        header,
        events,
        ledger: Ledger {
            driven: recorder.driven,
            ..totals
        },
    };
    let felt = recorder.felt.take();
    let mut felt = felt.unwrap_or_else(|| FeltPath::new(&trace.header));
    trace.events.iter().for_each(|event| felt.add(event));
    let health = session.projector_mut().health(end);
    let (skin, recorder) = session.seen();
    let projector = session.projector();
    let mut summary = Summary::new(&trace, (recorder, &felt), costs, &health, bench);
    summary.texture = TextureSummary::summarise(recorder, projector);
    summary.longest_session_s = recorder.longest_session_s(projector.guard(), end);
    summary.boards = boards::boards(projector, |module| skin.lost_of(module));
    summary.taxels.list(projector, end, skin.foreign());
    (trace, summary)
}

impl Summary {
    fn new(
        trace: &Trace,
        (recorder, felt): (&Recorder, &FeltPath),
        costs: &[FrameCost],
        health: &HealthSummary,
        bench: &Bench,
    ) -> Self {
        let path = path_error(trace).map(PathError::from);
        // Without a truth there is nothing to hold the felt path against; breaks need none.
        let is_scored = felt.level().is_some();
        let [by_energy, by_amplitude] = felt.scores().map(|score| {
            let known = |errors: Option<Errors>| errors.filter(|_| path.is_some());
            let inside = known(score.errors);
            let errors = inside.map(PathError::from);
            FeltError {
                rmse: errors.map(|e| e.rmse),
                max: errors.map(|e| e.max),
                onsets: inside.map_or(0, |e| e.count),
                everywhere: known(score.everywhere).map(CountedError::from),
                breaks: is_scored.then_some(score.breaks),
                jumps: is_scored.then_some(score.jumps),
                perceiver: score.perceiver,
            }
        });
        let energy = |(_, (min, max))| EnergyDb {
            min: decibels(min),
            max: decibels(max),
        };
        let [requested, applied, felt_energy] = felt
            .energies()
            .map_or([None; 3], |all| all.map(|e| Some(energy(e))));
        let ledger = &trace.ledger;
        let emulated = trace.header.source.is_emulated();
        let worst = |of| ledger.margin(of).map(Margin::worst);
        Self {
            conclusion: Conclusion::default(),
            source: trace.header.source,
            version: env!("CARGO_PKG_VERSION"),
            date: None,
            scene: trace.header.scene.clone(),
            bench: trace.header.bench.clone(),
            seed: trace.header.seed,
            frames: recorder.frames,
            contacts: recorder.contacts,
            stimuli: ledger.driven.stimuli,
            path_error_mm: path,
            pitch_mm: None,
            onsets: Onsets {
                // Where a person is emulated, an onset that was not met was not felt.
                felt: emulated.then(|| recorder.met.felt.unwrap_or(0)),
                ..recorder.met
            },
            pass: None,
            no_pass: None,
            felt: FeltSummary::new((&trace.header, felt), [&by_energy, &by_amplitude]),
            felt_error_mm: by_energy,
            felt_error_amplitude_mm: by_amplitude,
            requested_energy_db: requested,
            applied_energy_db: applied,
            felt_energy_db: felt_energy,
            energy_mj: emulated.then_some(ledger.energy_uj as f64 * 1e-3),
            peak_supply_a: worst(Limited::SupplyCurrent),
            hottest_wire_c: ledger.hottest_wire.map(|(t, _)| f64::from(t) * 1e-3),
            hottest_skin_c: worst(Limited::SkinPeak),
            longest_session_s: None,
            pwm_hz: trace.header.pre_scale.hz() * bench.drive.oscillator,
            limiter_events: ledger.driven.limiter_events,
            texture: None,
            frame_us: FrameTime::summarise(costs.iter().map(|c| c.us)),
            taxels: Taxels {
                refresh_hz: (recorder.frames > 0).then_some(Refresh {
                    median: f64::from(health.refresh_median_hz),
                    min: f64::from(health.refresh_min_hz),
                }),
                frozen: health.frozen,
                dead: health.dead,
                saturated: health.saturated,
                jumping: health.jumping,
                repeated: health.repeated as f64 / (health.frames.max(1)) as f64,
                ..Taxels::default()
            },
            boards: Vec::new(),
            buses: Vec::new(),
            faults: Vec::new(),
            margins: ledger.margins.clone(),
            displays: Vec::new(),
            unit: None,
            heat: None,
            motors: None,
            pacing: None,
            can: Vec::new(),
            frames_not_recorded: 0,
            sim_s: ledger.length_us as f64 * 1e-6,
            wall_s: 0.0,
        }
    }
}
