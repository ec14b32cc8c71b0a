//! A hot pass while a scene goes on: after a display was put on anew, and after its wires were too cold.

use palpate_core::projector::{HotPass, Projector};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::worn::Modelled;
use palpate_files::{Pass, Setup, WireState};

use super::heated::PASSED;
use super::plan;

/// Time between two looks at the modelled wires.
const LOOK: Duration = Duration::from_millis(250);
/// How much warmer than at a pass that did not last a wire must be for another one, K.
const WARMER_K: f64 = 1.0;

/// Passes of a run that goes on.
#[derive(Debug, Default)]
pub(crate) struct Again {
    /// Pulses by the boards' present clock, or the reason why there is no pass.
    pass: Option<Result<HotPass, &'static str>>,
    /// The modelled wires are passed, as far as anything tells.
    is_passed: bool,
    /// A pass is on its way, and its end is to be noted.
    is_awaited: bool,
    next: Instant,
    /// Coldest wire when martensite came back last, degrees C.
    cold_c: Option<f64>,
}

impl Again {
    /// Passes for a loop on a setup's bench.
    pub fn new(setup: &Setup, projector: &Projector) -> Self {
        let pass = match (setup.pass, setup.bench.value.drive.hot_pass) {
            (Pass::Before, true) => plan::of_loop(setup, projector),
            (Pass::Before, false) => Err("the bench says `drive.hot_pass = false`"),
            (Pass::Itself(_) | Pass::Apart(_) | Pass::LeftOut, _) => {
                Err("no pass comes in this run")
            }
        };
        Self {
            pass: Some(pass),
            is_passed: setup.wire.value.state == WireState::Passed,
            ..Self::default()
        }
    }

    /// Begins a pass at the next onset without a contact. Returns what became of that, for a note.
    pub fn begin(&mut self, projector: &mut Projector, now: Instant) -> Result<String, String> {
        match self.pass {
            Some(Ok(pass)) => {
                projector.pass(pass, now);
                self.is_awaited = true;
                let wires = projector.display().wires().len();
                Ok(format!(
                    "each of {wires} wires is heated in turn, at onsets without a contact; each is felt as a tap"
                ))
            }
            Some(Err(why)) => Err(format!("none: {why}")),
            None => Err("none: no pass was planned for this run".to_owned()),
        }
    }

    /// Looks at the loop's pass and at the modelled wires, if that is due. Returns a note where something came of it.
    pub fn look(
        &mut self,
        projector: &mut Projector,
        modelled: impl FnOnce() -> Option<Modelled>,
        now: Instant,
    ) -> Option<String> {
        if now < self.next || self.pass.is_none() {
            return None;
        }
        self.next = now + LOOK;
        if self.is_awaited {
            return self.ended(projector);
        }
        let Modelled {
            martensite,
            coldest_c,
        } = modelled()?;
        if martensite < PASSED {
            self.is_passed = true;
            self.cold_c = None;
            return None;
        }
        if self.is_passed {
            self.is_passed = false;
            self.cold_c = Some(coldest_c);
            return Some(format!(
                "hot pass: at {coldest_c:.1} C {:.0} % martensite came back in the modelled wires; they are passed at a pause once they are {WARMER_K:.0} K warmer",
                martensite * 100.0
            ));
        }
        let is_warmer = self.cold_c.is_some_and(|cold| coldest_c >= cold + WARMER_K);
        self.cold_c = self.cold_c.map(|cold| cold.min(coldest_c));
        if !is_warmer {
            return None;
        }
        self.cold_c = None;
        let begun = self.begin(projector, now).unwrap_or_else(|why| why);
        Some(format!("hot pass: {begun}"))
    }

    /// Notes the end of a pass that was on its way.
    fn ended(&mut self, projector: &Projector) -> Option<String> {
        let passing = projector.passing().filter(|passing| passing.is_over())?;
        self.is_awaited = false;
        self.is_passed = passing.has_passed();
        let (passed, wires) = (passing.passed(), projector.display().wires().len());
        Some(match passing.refused() {
            None => format!("hot pass: {wires} wires had their pulses; they are assumed passed"),
            Some((wire, entry)) => {
                let why = entry.reason.map_or("shortened", |reason| reason.word());
                format!(
                    "hot pass: NOT PASSED: {passed} of {wires} wires had their pulses; the guard refused wire {wire}: {why}"
                )
            }
        })
    }
}
