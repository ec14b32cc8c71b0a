//! What of a skin one of several fingers reads: scans of its own modules, by its own numbers.

use palpate_core::skin::ModuleScan;
use palpate_core::units::Instant;

use crate::failure::Failure;
use crate::skin_end::SkinEnd;

/// A scan that waits for its finger's next turn.
#[derive(Debug)]
struct Held {
    module: u16,
    at: Instant,
    counts: Vec<[u16; 3]>,
    fresh: Option<Vec<bool>>,
}

/// The modules of one finger.
#[derive(Debug)]
pub struct Pads {
    /// Their numbers in the skin.
    modules: Vec<usize>,
    held: Vec<Held>,
    /// Boards that are to be told to send, by the skin's numbers.
    silent: Vec<usize>,
    /// Readings missing so far, by its own numbers.
    lost: Vec<u64>,
}

impl Pads {
    /// Of modules by the skin's numbers; its own are their places here.
    pub fn new(modules: &[usize]) -> Self {
        Self {
            modules: modules.to_vec(),
            held: Vec::new(),
            silent: Vec::new(),
            lost: vec![0; modules.len()],
        }
    }

    /// Takes a scan of the skin, if it is of one of its modules.
    pub fn offer(&mut self, scan: &ModuleScan<'_>) {
        let own = |m: &usize| *m == usize::from(scan.module);
        if let Some(module) = self.modules.iter().position(own) {
            self.held.push(Held {
                module: module as u16, // a skin has fewer modules than that
                at: scan.at,
                counts: scan.counts.to_vec(),
                fresh: scan.fresh.map(<[bool]>::to_vec),
            });
        }
    }

    /// Tells the skin's boards what the finger's loop has for them, and asks what was lost.
    pub fn exchange(&mut self, skin: &mut dyn SkinEnd) {
        self.silent.drain(..).for_each(|module| skin.start(module));
        for (lost, module) in self.lost.iter_mut().zip(&self.modules) {
            *lost = skin.lost_of(*module);
        }
    }
}

impl SkinEnd for Pads {
    fn scans(
        &mut self,
        _now: Instant,
        take: &mut dyn FnMut(&ModuleScan<'_>),
    ) -> Result<(), Failure> {
        for held in self.held.drain(..) {
            take(&ModuleScan {
                module: held.module,
                at: held.at,
                counts: &held.counts,
                fresh: held.fresh.as_deref(),
            });
        }
        Ok(())
    }

    /// The skin that they are part of has its own time.
    fn advance_to(&mut self, _now: Instant) {}

    fn start(&mut self, module: usize) {
        self.silent.extend(self.modules.get(module));
    }

    fn lost_of(&self, module: usize) -> u64 {
        self.lost.get(module).copied().unwrap_or(0)
    }
}
