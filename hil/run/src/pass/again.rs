//! A hot pass while a scene goes on: after a display was put on anew, and after a cold face has brought martensite back.

use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::projector::{HotPass, Projector};
use palpate_core::units::{Duration, Instant};
use palpate_files::{Pass, SKIN_C, Setup, WireState};

use super::heated::lasting;
use super::plan as planning;
use crate::plan;

/// Time between two looks at a pass and at the face.
const LOOK: Duration = Duration::from_millis(250);
/// Margin by which a face must be warmer than the one that brings martensite back, K.
const WARMER_K: f64 = 1.0;
/// Halvings of the range in which that face is sought: to a hundredth of a kelvin.
const HALVINGS: u32 = 12;

/// Passes of a run that goes on.
#[derive(Debug, Default)]
pub(crate) struct Again {
    /// Pulses by the boards' present clock, or the reason why there is no pass; `None` until it is planned.
    pass: Option<Result<HotPass, &'static str>>,
    /// Face under which a passed wire turns back, degrees C; `None` without a module under the finger.
    turns_c: Option<f64>,
    /// The wires are assumed passed.
    is_passed: bool,
    /// A pass is on its way, and its end is to be noted.
    is_awaited: bool,
    next: Instant,
}

impl Again {
    /// Passes for a loop on a setup's bench.
    pub fn new(setup: &Setup, projector: &Projector) -> Self {
        let bench = &setup.bench.value;
        let pass = match (setup.pass, bench.drive.hot_pass) {
            _ if bench.haptics.is_some() => Err("motors have no wires to heat"),
            (Pass::Before, true) => planning::of_loop(setup, projector),
            (Pass::Before, false) => Err("the bench says `drive.hot_pass = false`"),
            (Pass::Itself(_) | Pass::Apart(_) | Pass::LeftOut, _) => {
                Err("no pass comes in this run")
            }
        };
        let turns_c = bench.heat.filter(|_| pass.is_ok());
        Self {
            pass: Some(pass),
            turns_c: turns_c.map(|_| turns_c_of(&plan::wire(setup), &bench.tissue.parameters())),
            is_passed: setup.wire.value.state == WireState::Passed,
            ..Self::default()
        }
    }

    /// Begins a pass at the next onset without a contact. Returns a note on it.
    pub fn begin(&mut self, projector: &mut Projector, now: Instant) -> String {
        let why = match self.pass {
            Some(Ok(pass)) => {
                projector.pass(pass, now);
                self.is_awaited = true;
                let wires = projector.display().wires().len();
                return format!(
                    "hot pass: each of {wires} wires is heated in turn, at onsets without a contact; each is felt as a tap"
                );
            }
            Some(Err(why)) => why,
            None => "none was planned for this run",
        };
        format!("hot pass: none: {why}")
    }

    /// Looks at the loop's pass and at the face under the finger, if that is due. Returns a note where something came of it.
    pub fn look(
        &mut self,
        projector: &mut Projector,
        face_c: impl FnOnce() -> Option<f64>,
        now: Instant,
    ) -> Option<String> {
        if now < self.next || !(self.is_awaited || self.turns_c.is_some()) {
            return None;
        }
        self.next = now + LOOK;
        if self.is_awaited {
            return self.ended(projector);
        }
        let (turns_c, face_c) = (self.turns_c?, face_c()?);
        if self.is_passed && face_c < turns_c {
            self.is_passed = false;
            return Some(format!(
                "hot pass: under a face of {face_c:.1} C martensite comes back in the wires; they are passed at a pause once it has {:.1} C",
                turns_c + WARMER_K
            ));
        }
        let is_due = !self.is_passed && face_c >= turns_c + WARMER_K;
        is_due.then(|| self.begin(projector, now))
    }

    /// Notes the end of a pass that was on its way.
    fn ended(&mut self, projector: &Projector) -> Option<String> {
        let passing = projector.passing().filter(|passing| passing.is_over())?;
        self.is_awaited = false;
        let (passed, wires) = (passing.passed(), projector.display().wires().len());
        let Some((wire, entry)) = passing.refused() else {
            self.is_passed = true;
            return Some(format!(
                "hot pass: {wires} wires had their pulses; they are assumed passed"
            ));
        };
        // The guard would refuse it again: only a person asks for another one.
        self.turns_c = None;
        let why = entry.reason.map_or("shortened", |reason| reason.word());
        Some(format!(
            "hot pass: NOT PASSED: {passed} of {wires} wires had their pulses; the guard refused wire {wire}: {why}"
        ))
    }
}

/// The coldest face under which a passed wire keeps its austenite and R, degrees C. Skin and wire are taken to follow the face
/// at once and whole, which is from above: less of a cold face comes through.
fn turns_c_of(wire: &WireParameters, tissue: &TissueParameters) -> f64 {
    let lasts = |colder_k: f64| {
        let (mut wire, mut tissue) = (*wire, *tissue);
        wire.ends_c -= colder_k;
        tissue.body_c -= colder_k;
        lasting(&wire, &tissue).is_ok()
    };
    let (mut lasting_k, mut turning_k) = (0.0, SKIN_C);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(lasting_k, turning_k);
        match lasts(middle) {
            true => lasting_k = middle,
            false => turning_k = middle,
        }
    }
    SKIN_C - lasting_k
}

#[cfg(test)]
#[path = "again_tests.rs"]
mod tests;
