//! Compression by itself: scans in, contacts out, on either machine. No display, no guard.

use std::sync::Arc;

use palpate_core::contact::{Contact, Levels};
use palpate_core::projector::{FrameReport, Observer, Projector};
use palpate_core::skin::{Condition, ModuleScan, ScanError};
use palpate_core::units::Instant;
use palpate_files::Setup;
use palpate_records::mcap::decode;
use palpate_run::{Failure, Recorder, Truth, build, dynamic_levels, scene_levels};

use crate::message::{About, Body, Frame, VERSION};

/// The newest frame's contacts, and the recorder of the frames.
struct Found {
    recorder: Recorder,
    newest: Option<Instant>,
    contacts: Vec<Contact>,
}

impl Observer for Found {
    fn frame(&mut self, report: &FrameReport<'_>) {
        self.recorder.frame(report);
        self.newest = Some(report.at);
        self.contacts.clear();
        self.contacts.extend_from_slice(report.contacts);
    }

    fn taxel(&mut self, at: Instant, index: usize, condition: Condition) {
        self.recorder.taxel(at, index, condition);
    }
}

/// Intensity levels on both ends. An input that is still to come has no static ones, so they are those of the scene's own
/// touches, as on hardware; a scene without touches has them anew in every frame.
///
/// # Errors
/// [`Failure`] for a scene that fits no emulated skin.
pub fn levels(setup: &Setup, seed: u64) -> Result<Levels, Failure> {
    Ok(match scene_levels(setup, seed)? {
        Levels::Off => dynamic_levels(&setup.scene.value.compression),
        levels => levels,
    })
}

/// Compression of a setup's skin.
pub struct Shrunk {
    projector: Projector,
    found: Found,
}

impl Shrunk {
    /// Compression of a setup's skin; with its scene's touches as the truth, where the skin is emulated here.
    ///
    /// # Errors
    /// [`Failure`] for what fits no loop.
    pub fn new(setup: &Setup, seed: u64, levels: Levels, truth: Truth) -> Result<Self, Failure> {
        let projector = build(setup, seed, levels)?;
        let recorder = Recorder::new(truth, projector.layout());
        Ok(Self {
            projector,
            found: Found {
                recorder,
                newest: None,
                contacts: Vec::new(),
            },
        })
    }

    /// Takes a scan; the contacts of the frame that it makes, if it makes one.
    ///
    /// # Errors
    /// A scan of another layout.
    pub fn push(
        &mut self,
        scan: &ModuleScan<'_>,
    ) -> Result<Option<(Instant, &[Contact])>, ScanError> {
        self.found.newest = None;
        self.projector.push(scan, &mut self.found)?;
        let at = self.found.newest;
        Ok(at.map(|at| (at, &*self.found.contacts)))
    }

    /// The loop that it is a part of.
    pub const fn projector(&self) -> &Projector {
        &self.projector
    }

    /// Recorder of the frames.
    pub const fn recorder(&mut self) -> &mut Recorder {
        &mut self.found.recorder
    }
}

/// Setup of a publisher of scans, whose rest is rebuilt here: the same scans make the same reference.
#[derive(Clone)]
pub(super) struct Rest {
    pub(super) setup: Arc<Setup>,
    pub(super) seed: u64,
    pub(super) levels: Levels,
}

impl Rest {
    /// Compression with the reference of these bytes, and its publisher's session; `None` where the bytes hold none.
    pub(super) fn compress(&self, bytes: &[u8]) -> Option<(u64, Shrunk)> {
        let about: About = decode(bytes)?;
        let wanted = self.setup.scene.value.reference_frames + 1;
        let modules = self.setup.sensor.value.modules.len();
        if about.version != VERSION || about.rest.len() < wanted as usize * modules {
            return None;
        }
        let mut shrunk =
            Shrunk::new(&self.setup, self.seed, self.levels.clone(), Truth::Unknown).ok()?;
        for scan in &about.rest {
            let Some(Frame {
                head,
                body: Body::Scanned { module, counts },
                ..
            }) = Frame::scanned(scan)
            else {
                return None;
            };
            let scan = ModuleScan {
                module,
                at: Instant::from_micros(head.taken_us),
                counts: &counts,
                fresh: None,
            };
            shrunk.push(&scan).ok()?;
        }
        shrunk.recorder().events.clear();
        Some((about.session, shrunk))
    }
}
