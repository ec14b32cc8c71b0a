//! A scene on a bench of motors: laws and settings that are of wires alone.

use palpate_core::illusion::IllusionModel;

use super::bench::Bench;
use super::error::FileError;
use super::loaded::Loaded;
use super::scene::Scene;

/// Law of a scene on motors that states none: the energy centroid is what the published studies of motors found.
const LAW: IllusionModel = IllusionModel::Energy;
/// Activation of 1 is the rated voltage.
const FULL: f64 = 1.0;

impl Loaded<Scene> {
    /// Gives a scene on motors the law and drive of motors where it states none, and refuses those of wires.
    pub(super) fn on_motors(&mut self, bench: &Bench) -> Result<(), FileError> {
        if bench.haptics.is_none() {
            return Ok(());
        }
        if self.value.texture.is_some() {
            let expected = "nothing on a bench of motors: a texture is made of a wire's pulses";
            return Err(self.source.bad("texture", expected));
        }
        if !self.value.seats.is_empty() {
            let expected = "nothing on a bench of motors: a seat is a wire's";
            return Err(self.source.bad("seats", expected));
        }
        let stated = |key: &str| self.source.states(key);
        let (model, beta) = (stated("illusion.model"), stated("illusion.beta"));
        let illusion = &mut self.value.illusion;
        if !beta {
            illusion.beta = FULL;
        }
        if !model {
            illusion.model = LAW;
        } else if illusion.model == IllusionModel::Inverse {
            let fits = IllusionModel::ALL.into_iter();
            let fits = fits.filter(|law| *law != IllusionModel::Inverse);
            let names: Vec<&str> = fits.map(IllusionModel::name).collect();
            let expected = format!(
                "a law for motors on bench `{}`: {}; `inverse` plans a wire's pulses",
                bench.name,
                names.join(", ")
            );
            return Err(self
                .source
                .bad_found("illusion.model", expected, "\"inverse\""));
        }
        Ok(())
    }
}
