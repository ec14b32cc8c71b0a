//! Ends of whole runs on emulated displays: the ledger of a trace, and what the hardware alone knows of a summary.

use palpate_core::guard::Limits;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_files::Setup;
use palpate_records::margin::sort;
use palpate_records::report::Warmth;
use palpate_records::trace::Ledger;

use crate::display_end::DisplayEnd;
use crate::failure::Failure;
use crate::motors::EmulatedMotors;
use crate::pass::{self, PassEnd};
use crate::policy::refuse_hardware;
use crate::recorder::{Recorder, milli_c};
use crate::summary::Summary;
use crate::summary_felt::AskedLevel;
use crate::wires::EmulatedDisplay;
use crate::{band, margins, plan};

/// A display end whose hardware is emulated, at the end of a run.
pub trait EmulatedEnd: DisplayEnd {
    /// A setup's display with nothing started yet.
    ///
    /// # Errors
    /// [`Failure::Input`] for a bench that cannot be, one of hardware, or one with other actuators.
    fn at_rest(setup: &Setup, projector: &Projector, seed: u64) -> Result<Self, Failure>
    where
        Self: Sized;

    /// Scores the newest onset by its sensation until now; otherwise its successor scores it.
    fn score(&mut self, projector: &Projector, recorder: &mut Recorder);

    /// Each wire and the skin 0.1 mm under it, degrees C; `None` for motors, which heat no skin.
    fn warmth_c(&mut self) -> Option<Vec<[f64; 2]>> {
        None
    }

    /// Ledger of a run of this length, and temperatures over time.
    fn ledger(&mut self, limits: &Limits, length: Instant) -> (Ledger, Vec<Warmth>);

    /// Completes the summary of a run of this length. Returns the end of a hot pass.
    ///
    /// # Errors
    /// [`Failure::Input`] for a setup that the renderer refuses.
    fn complete(
        &mut self,
        setup: &Setup,
        projector: &Projector,
        summary: &mut Summary,
        length: Instant,
    ) -> Result<Option<PassEnd>, Failure>;
}

impl EmulatedEnd for EmulatedDisplay {
    fn at_rest(setup: &Setup, projector: &Projector, seed: u64) -> Result<Self, Failure> {
        Self::new(setup, projector, seed)
    }

    fn score(&mut self, projector: &Projector, recorder: &mut Recorder) {
        self.score(projector, recorder);
    }

    fn warmth_c(&mut self) -> Option<Vec<[f64; 2]>> {
        let worn = self.hardware();
        let look = |wire| Some([worn.wire_c(wire)?, worn.tissue_c(wire)?]);
        Some((0..).map_while(look).collect())
    }

    fn ledger(&mut self, limits: &Limits, length: Instant) -> (Ledger, Vec<Warmth>) {
        let (samples, currents) = self.take_samples();
        let totals = self.hardware().totals();
        let course = margins::Course {
            currents: &currents,
            samples: &samples,
            totals: &totals,
        };
        let mut margins = margins::margins(&course, limits);
        margins.extend(self.heat_margins());
        sort(&mut margins);
        let ledger = Ledger {
            energy_uj: (totals.electrical_j * 1e6).round() as u64,
            hottest_wire: milli_c(totals.hottest_wire.0).map(|t| (t, totals.hottest_wire.1 as u16)),
            tight: totals.tight,
            margins,
            length_us: length.as_micros(),
            ..Ledger::default()
        };
        (ledger, samples.iter().map(margins::warmth).collect())
    }

    fn complete(
        &mut self,
        setup: &Setup,
        projector: &Projector,
        summary: &mut Summary,
        length: Instant,
    ) -> Result<Option<PassEnd>, Failure> {
        summary.unit = self.unit();
        summary.heat = self.heat();
        let felt = &mut summary.felt;
        felt.asked = AskedLevel::find(&setup.scene.value, projector);
        if felt.level_db.is_some_and(|l| l.median < 0.0) {
            let missing = -plan::strongest(setup, projector)?;
            felt.missing_db = Some(missing).filter(|db| *db > 0.0);
        }
        if self.has_band() {
            match band::band(setup) {
                Ok(band) => felt.band = Some(band),
                Err(why) => felt.no_band = Some(why),
            }
        }
        felt.states = self.states(summary.path_error_mm.is_some());
        felt.state = Some(pass::state_of(setup));
        let martensite = self.hardware().martensite();
        Ok(PassEnd::find(projector, length, martensite))
    }
}

impl EmulatedEnd for EmulatedMotors {
    fn at_rest(setup: &Setup, projector: &Projector, seed: u64) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        refuse_hardware(bench)?;
        let none = || Failure::File(setup.bench.source.bad("haptics", "a bench of motors"));
        let haptics = bench.haptics.as_ref().ok_or_else(none)?;
        Self::new(setup, haptics, projector, seed)
    }

    fn score(&mut self, projector: &Projector, recorder: &mut Recorder) {
        self.score(projector, recorder);
    }

    fn ledger(&mut self, _limits: &Limits, length: Instant) -> (Ledger, Vec<Warmth>) {
        let mut margins = self.margins();
        sort(&mut margins);
        let ledger = Ledger {
            margins,
            length_us: length.as_micros(),
            ..Ledger::default()
        };
        (ledger, Vec::new())
    }

    fn complete(
        &mut self,
        _setup: &Setup,
        _projector: &Projector,
        summary: &mut Summary,
        length: Instant,
    ) -> Result<Option<PassEnd>, Failure> {
        summary.motors = Some(self.report(length));
        Ok(None)
    }
}
