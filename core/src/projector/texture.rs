//! The texture in the loop: a module's scans become windows, windows latent vectors, those control parameters.
//!
//! A window counts once all its samples were touched. Nothing is felt before the first one, and nothing once the
//! module is no longer touched, or silent.

use alloc::boxed::Box;
use alloc::sync::Arc;

use crate::skin::{Baseline, Layout, Scan};
use crate::texture::{Control, ControlMap, Encoder, Ends, Pulses, Stream};
use crate::units::{Duration, Instant};

use super::Observer;
use super::gather::Gathering;
use super::tap::Taps;

/// A texture whose last sample is older than this is no longer felt.
const SILENCE: Duration = Duration::from_millis(100);

/// Carrier of a texture to the finger.
#[derive(Clone, Debug)]
pub enum Carrier {
    /// The whole display: pulses of (3.1) move over its wires, contacts do not show. Surfaces whose hardness is known are felt
    /// where they are met and left, if at all.
    Display(Pulses, Option<Taps>),
    /// The contacts: f_PWM thins out their bursts.
    Contacts,
}

/// Settings of a texture.
#[derive(Debug)]
pub struct TexturePlan {
    /// The network.
    pub encoder: Arc<Encoder>,
    /// The module that is stroked.
    pub module: u16,
    /// The network's features: taxel of that module, and axis (0 to 2).
    pub features: Box<[(u32, u8)]>,
    /// One contact rubs over the module: the network hears it as a stroke over the whole face, which is what networks are trained
    /// on. Where the contact is and which way it goes says the contact itself.
    pub gather: bool,
    /// Time from sample to sample.
    pub sample: Duration,
    /// Map from the latent vector to control parameters, (3.2).
    pub map: ControlMap,
    /// Carrier of the texture.
    pub carrier: Carrier,
}

/// Reasons for which a texture does not fit its skin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// A stroked module that does not exist, with the number of modules.
    #[error("expected a stroked module below {0}")]
    NoSuchModule(usize),
    /// Another number of features in the plan than in the network, with the network's.
    #[error("expected a taxel and axis for each of {0} features")]
    Features(usize),
    /// A feature whose taxel or axis does not exist.
    #[error("feature {0}: expected a taxel and axis of the skin")]
    NoSuchTaxel(usize),
}

/// The newest texture, as observers see it.
#[derive(Clone, Copy, Debug)]
pub struct TextureReport<'a> {
    /// The end of its window.
    pub at: Instant,
    /// The latent vector z.
    pub latent: &'a [f32],
    /// Roughness of the latent vector, 0 to 1.
    pub roughness: f64,
    /// Control parameters that (3.2) makes of it.
    pub control: Control,
}

/// Sampler of a texture: scans in, control parameters out.
#[derive(Debug)]
pub(super) struct Sampler {
    module: u16,
    /// Index among the layout's taxels, and axis.
    features: Box<[(usize, usize)]>,
    sample: Box<[f32]>,
    /// The module's first taxel.
    start: usize,
    /// Gathering of features, where one contact rubs over the module.
    gathering: Option<Gathering>,
    stream: Stream,
    window: usize,
    ends: Ends,
    map: ControlMap,
    /// Samples that were touched since the last one that was not.
    touched: usize,
    newest: Option<Control>,
    last: Instant,
    /// Hardness of the surface, by the newest window of this touch or the one before.
    hardness: Option<f64>,
    /// Time of the module's newest touch.
    left: Instant,
    /// Hardness of a surface that was met or left, until it is taken.
    tap: Option<f64>,
}

impl Sampler {
    /// A sampler whose windows end with the onsets of the grid, `every` apart.
    pub(super) fn new(
        plan: TexturePlan,
        layout: &Layout,
        every: Duration,
    ) -> Result<(Self, Carrier), TextureError> {
        let modules = layout.modules().len();
        if usize::from(plan.module) >= modules {
            return Err(TextureError::NoSuchModule(modules));
        }
        if plan.features.len() != plan.encoder.features() {
            return Err(TextureError::Features(plan.encoder.features()));
        }
        let range = layout.range(usize::from(plan.module));
        let active = layout.modules()[usize::from(plan.module)].active();
        let read = range.clone().zip(active);
        let read = read.filter_map(|(taxel, active)| active.then_some(taxel));
        let place = |(i, &(taxel, axis)): (usize, &(u32, u8))| {
            let (taxel, axis) = (taxel as usize, usize::from(axis));
            let exists = taxel < range.len() && axis < 3;
            exists
                .then_some((range.start + taxel, axis))
                .ok_or(TextureError::NoSuchTaxel(i))
        };
        let features = plan.features.iter().enumerate().map(place);
        let sampler = Self {
            module: plan.module,
            features: features.collect::<Result<_, _>>()?,
            sample: alloc::vec![0.0; plan.features.len()].into(),
            start: range.start,
            gathering: (plan.gather).then(|| Gathering::new(read.collect(), range.len())),
            window: plan.encoder.window(),
            stream: Stream::new(plan.encoder, 1),
            ends: Ends::Onsets {
                sample: plan.sample,
                every,
            },
            map: plan.map,
            touched: 0,
            newest: None,
            last: Instant::ZERO,
            hardness: None,
            left: Instant::ZERO,
            tap: None,
        };
        Ok((sampler, plan.carrier))
    }

    /// Takes a scan of `module`, which is touched or not, with the reference of its taxels at rest.
    pub(super) fn scan(
        &mut self,
        scan: &Scan,
        (module, touched): (u16, bool),
        baseline: &Baseline,
        observer: &mut impl Observer,
    ) {
        if module != self.module {
            return;
        }
        self.last = scan.at();
        // The network needs a window to know a surface. So the surface that is met counts as the one left last, and a
        // touch that comes back within a moment as one touch.
        let is_met = touched && self.touched == 0 && scan.at().since(self.left) > SILENCE;
        let is_left = !touched && self.newest.is_some();
        if is_met || is_left {
            self.tap = self.hardness;
        }
        if touched {
            self.left = scan.at();
        }
        self.touched = if touched { self.touched + 1 } else { 0 };
        if !touched {
            self.newest = None;
        }
        let counts = scan.counts();
        if let Some(gathering) = &mut self.gathering {
            let reference = |taxel| baseline.reference(taxel).unwrap_or_default();
            gathering.push(counts, touched, reference);
        }
        for (value, &(taxel, axis)) in self.sample.iter_mut().zip(&self.features) {
            *value = match &self.gathering {
                Some(gathering) => gathering.reading(taxel - self.start, axis),
                None => f32::from(counts[taxel][axis]),
            };
        }
        // A window that begins before the touch would not count: it is not computed.
        let begin = touched && self.ends.begins(self.stream.seen(), self.window);
        // Counts are finite and as many as features, so no sample is refused.
        if let Ok(Some(latent)) = self.stream.push(&self.sample, begin)
            && self.touched >= self.window
        {
            let control = self.map.control(latent);
            self.newest = Some(control);
            self.hardness = self.map.hardness(latent);
            observer.texture(&TextureReport {
                at: scan.at(),
                latent,
                roughness: self.map.roughness(latent),
                control,
            });
        }
    }

    /// Takes the hardness, 0 to 1, of a surface that was met or left since the last call.
    pub(super) fn take_tap(&mut self) -> Option<f64> {
        self.tap.take()
    }

    /// Control parameters of the texture that is felt at `now`.
    pub(super) fn control(&self, now: Instant) -> Option<Control> {
        self.newest.filter(|_| now.since(self.last) <= SILENCE)
    }
}
