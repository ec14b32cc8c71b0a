//! Scenes on a bench for the stimuli of a study's trials.

use palpate_core::contact::Levels;
use palpate_core::guard::Guard;
use palpate_files::{Bench, BenchKind, FileError, Loaded, Pass, Protocol, Real, Setup, Source};
use palpate_run::{Failure, build, fits, pass};
use palpate_study::Stimulus;

/// The reference and a moment more before a wire is driven, s.
const BEFORE_S: f64 = 0.7;
/// Time that a stimulus may still need to end, s.
const AFTER_S: f64 = 0.2;

/// Stimuli of a protocol on a bench.
#[derive(Debug, Clone)]
pub struct Stimuli {
    protocol: Loaded<Protocol>,
    bench: Loaded<Bench>,
    wires_mm: Vec<[f64; 2]>,
    /// Cold wires are passed before the first trial: a pass is felt, so none comes between a question and its answer.
    is_passed: bool,
}

impl Stimuli {
    /// A protocol on a bench: every condition is one that the bench can play.
    ///
    /// # Errors
    /// [`Failure`] with the condition or key that the bench cannot play.
    pub fn new(protocol: Loaded<Protocol>, bench: Loaded<Bench>) -> Result<Self, Failure> {
        if !bench.value.displays.is_empty() {
            let expected = "one display: a participant wears one thimble";
            let found = format!("{} displays", bench.value.displays.len());
            return Err(bench.source.bad_found("displays", expected, found).into());
        }
        let mut stimuli = Self {
            protocol,
            bench,
            wires_mm: Vec::new(),
            is_passed: false,
        };
        let silent = stimuli.joined(&Stimulus::Silence)?;
        stimuli.is_passed = pass::is_due(&silent) && pass::lasts(&silent);
        stimuli.wires_mm = silent.display.value.wires_mm.clone();
        stimuli.check_wires()?;
        for (index, condition) in stimuli.protocol.value.conditions.iter().enumerate() {
            if condition.scene.is_none() {
                continue;
            }
            let setup = stimuli.setup(&Stimulus::Condition(condition.name.clone()))?;
            let scene = &setup.scene.value;
            let wired =
                setup.bench.value.kind == BenchKind::Real && setup.bench.value.unit.is_none();
            if wired && scene.strokes.is_empty() {
                let key = format!("conditions[{index}].scene");
                let expected = "a scene of [[strokes]] on a bench of hardware: nothing touches a skin that is no emulation";
                let found = format!("`{}`", scene.name);
                return Err(stimuli
                    .protocol
                    .source
                    .bad_found(&key, expected, found)
                    .into());
            }
            fits(&setup)?;
        }
        Ok(stimuli)
    }

    /// The protocol.
    #[must_use]
    pub const fn protocol(&self) -> &Loaded<Protocol> {
        &self.protocol
    }

    /// Places of the display's wires, mm.
    #[must_use]
    pub fn wires_mm(&self) -> &[[f64; 2]] {
        &self.wires_mm
    }

    /// Object that the experimenter lays under the finger in a trial without a played stimulus.
    #[must_use]
    pub fn present(&self, stimulus: &Stimulus) -> Option<&str> {
        match stimulus {
            Stimulus::Condition(name) => self.protocol.value.condition(name)?.present.as_deref(),
            _ => None,
        }
    }

    fn check_wires(&self) -> Result<(), FileError> {
        let protocol = &self.protocol.value;
        let count = self.wires_mm.len();
        let reference = protocol
            .matching
            .as_ref()
            .map(|t| ("matching.reference".to_owned(), t.reference));
        let named = protocol.tasks().into_iter().flat_map(|(task, ..)| {
            let numbered = protocol.wires(task).iter().enumerate();
            numbered.map(move |(index, wire)| (format!("{}.wires[{index}]", task.name()), *wire))
        });
        for (key, wire) in named.chain(reference) {
            if usize::from(wire) >= count {
                let bench = &self.bench.value.name;
                let expected = format!(
                    "a wire of bench `{bench}`, 0 to {}",
                    count.saturating_sub(1)
                );
                return Err(self
                    .protocol
                    .source
                    .bad_found(&key, expected, wire.to_string()));
            }
        }
        Ok(())
    }

    /// A silent scene that begins with the hot pass of the bench's wires; `None` where they need none.
    ///
    /// # Errors
    /// The errors of [`Self::setup`].
    pub fn unpassed(&self) -> Result<Option<Setup>, Failure> {
        let silent = self.is_passed.then(|| self.joined(&Stimulus::Silence));
        silent.transpose()
    }

    /// Lets the wires be cold in every trial: their hot pass has failed.
    pub const fn leave_cold(&mut self) {
        self.is_passed = false;
    }

    /// The scene of a stimulus on the bench, with wires as they are in a trial; of what the experimenter lays under the finger one that drives nothing.
    ///
    /// # Errors
    /// [`Failure`] with file and key of what does not fit together.
    pub fn setup(&self, stimulus: &Stimulus) -> Result<Setup, Failure> {
        let mut setup = self.joined(stimulus)?;
        if self.is_passed && pass::is_due(&setup) {
            pass::set_passed(&mut setup);
        }
        setup.pass = Pass::LeftOut;
        Ok(setup)
    }

    fn joined(&self, stimulus: &Stimulus) -> Result<Setup, Failure> {
        let protocol = &self.protocol.value;
        if let Stimulus::Condition(name) = stimulus {
            let place = protocol.conditions.iter().position(|c| c.name == *name);
            let place = place.ok_or_else(|| Failure::Input(format!("no condition `{name}`")))?;
            if let Some(scene) = self.protocol.scene(place)? {
                let overrides = protocol.conditions[place].overrides()?;
                let label = self.protocol.source.label();
                let changed = self.bench.clone().with(&overrides);
                let changed = changed.map_err(|error| FileError {
                    path: format!("{label}: conditions[{place}].set"),
                    ..error
                })?;
                // Devices that the command line named are not in the file.
                let named = self.bench.value.real.clone();
                let real = changed.value.real.clone().zip(named);
                let bench = Loaded {
                    value: Bench {
                        kind: self.bench.value.kind,
                        real: real.map(|(changed, Real { can, i2c, .. })| Real {
                            can,
                            i2c,
                            ..changed
                        }),
                        unit: self.bench.value.unit.clone(),
                        name: self.bench.value.name.clone(),
                        ..changed.value
                    },
                    source: changed.source,
                };
                return Ok(Setup::join(scene, bench)?);
            }
        }
        let source = Source::new("a stimulus of the study", self.text(stimulus));
        Ok(Setup::join(Loaded::read(source)?, self.bench.clone())?)
    }

    /// One wire, or none, as a scene: a stroke that stays where the wire is.
    fn text(&self, stimulus: &Stimulus) -> String {
        let seconds = self.protocol.value.stimulus_s;
        let length_s = BEFORE_S + seconds + AFTER_S;
        let mut text = format!(
            "name = \"stimulus\"\ndescription = \"One wire of a study\"\nlength_s = {length_s}\n[illusion]\nmodel = \"nearest\"\n"
        );
        if let Stimulus::Wire { wire, level_db } = stimulus
            && let Some([x, y]) = self.wires_mm.get(usize::from(*wire))
        {
            let weight = part(*level_db);
            text += &format!(
                "[[strokes]]\nstart_s = {BEFORE_S}\nlength_s = {seconds}\nfrom_mm = [{x:?}, {y:?}]\nto_mm = [{x:?}, {y:?}]\nweight = {weight}\n"
            );
        }
        text
    }

    /// Scene and bench of a stimulus, as in [`Self::setup`], with
    /// the bench emulated: for results that are computed beforehand.
    ///
    /// # Errors
    /// The errors of [`Self::setup`].
    pub fn emulated(&self, stimulus: &Stimulus) -> Result<Setup, Failure> {
        let mut setup = self.setup(stimulus)?;
        let bench = &mut setup.bench.value;
        (bench.kind, bench.real, bench.unit) = (BenchKind::Emulated, None, None);
        Ok(setup)
    }

    /// A guard of the bench, on which nothing was played yet.
    ///
    /// # Errors
    /// [`Failure`] of a bench that has no guard.
    pub fn guard(&self) -> Result<Guard, Failure> {
        let projector = build(&self.emulated(&Stimulus::Silence)?, 1, Levels::Off)?;
        Ok(projector.guard().clone())
    }
}

/// A level, dB of full drive, as a part of it.
fn part(level_db: f64) -> f64 {
    10f64.powf(level_db.min(0.0) / 20.0)
}

#[cfg(test)]
#[path = "stimuli_tests.rs"]
mod tests;
