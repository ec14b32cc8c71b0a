//! The sensor's half of the loop: frames off the bus become scans, scans become contacts.

use alloc::boxed::Box;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

use crate::bus::Received;
use crate::contact::{CompressError, Compressor, Settings};
use crate::skin::{Health, Initialiser, InitialiserSettings, Layout, Module, Phase, Scan};
use crate::units::Instant;
use crate::wire::uskin::{IdProfile, Message, Wiring, decode};

use super::{FrameReport, Observer};

/// One module on its way from readings to contacts.
#[derive(Debug)]
pub(super) struct ModuleState {
    address: (u8, u8),
    wiring: Wiring,
    active: Box<[bool]>,
    scan: Scan,
    initialiser: Initialiser,
    compressor: Compressor,
    health: Health,
    norms: Box<[f32]>,
    frames: u32,
}

/// The state of the sensor half.
#[derive(Debug)]
pub(super) struct Sensing {
    profile: IdProfile,
    modules: Vec<ModuleState>,
    /// When the newest frame of any kind of data was received.
    last_received: Option<Instant>,
    /// Frames that were no sensor data of this layout.
    foreign: u64,
}

impl ModuleState {
    fn new(
        index: usize,
        module: &Module,
        initialiser: InitialiserSettings,
        compression: &Settings,
    ) -> Result<Self, CompressError> {
        let n = module.taxels().len();
        let wiring = module.wiring();
        let position = |taxel| wiring.place(0, taxel).and_then(|p| wiring.order(p));
        let active = (0..n).filter(|&i| module.active()[i]);
        let end = active.filter_map(position).max().unwrap_or(0);
        let identity = format!("compressor {index}");
        Ok(Self {
            address: module.address(),
            wiring,
            active: module.active().into(),
            scan: Scan::new(n, end),
            initialiser: Initialiser::new(initialiser, module),
            compressor: Compressor::new(module, compression.clone(), &identity)?,
            health: Health::new(n),
            norms: vec![0.0; n].into(),
            frames: 0,
        })
    }

    pub(super) const fn compressor(&self) -> &Compressor {
        &self.compressor
    }

    pub(super) const fn health(&self) -> &Health {
        &self.health
    }

    pub(super) const fn active(&self) -> &[bool] {
        &self.active
    }

    pub(super) const fn initialiser(&self) -> &Initialiser {
        &self.initialiser
    }

    /// Closes the open scan: initialiser, then compression.
    fn close(&mut self, module: usize, observer: &mut impl Observer) {
        let Some(at) = self.scan.time() else { return };
        let number = self.frames;
        self.frames = self.frames.saturating_add(1);
        let counts = self.scan.counts();
        let threshold = match (self.initialiser.phase(), self.initialiser.threshold()) {
            (Phase::Ready, Some(threshold)) => threshold,
            _ => {
                self.initialiser.feed(counts);
                self.scan.close();
                return;
            }
        };
        self.initialiser.norms(counts, &mut self.norms);
        let axes = |taxel: usize| self.initialiser.axes_of(taxel, counts[taxel]);
        let in_contact =
            self.compressor
                .compress(&self.norms, threshold, self.initialiser.faulty(), axes);
        observer.frame(&FrameReport {
            at,
            module: module as u16, // a skin has at most 16 modules a bus
            number,
            in_contact: u16::try_from(in_contact).unwrap_or(u16::MAX),
            norms: &self.norms,
            contacts: self.compressor.contacts(),
            stage: self.compressor.stage(),
        });
        self.scan.close();
    }
}

impl Sensing {
    pub(super) fn new(
        layout: &Layout,
        profile: IdProfile,
        initialiser: InitialiserSettings,
        compression: &Settings,
    ) -> Result<Self, CompressError> {
        let module = |(i, m)| ModuleState::new(i, m, initialiser, compression);
        let modules = layout
            .modules()
            .iter()
            .enumerate()
            .map(module)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            profile,
            modules,
            last_received: None,
            foreign: 0,
        })
    }

    pub(super) fn modules(&self) -> &[ModuleState] {
        &self.modules
    }

    pub(super) const fn last_received(&self) -> Option<Instant> {
        self.last_received
    }

    pub(super) const fn foreign(&self) -> u64 {
        self.foreign
    }

    /// Takes one frame off a bus.
    pub(super) fn take(&mut self, received: &Received, observer: &mut impl Observer) {
        let Ok(Message::Data(data)) = decode(self.profile, &received.frame) else {
            self.foreign = self.foreign.saturating_add(1);
            return;
        };
        let is_ours = |m: &ModuleState| {
            m.address.0 == received.bus && data.board.is_none_or(|b| b == m.address.1)
        };
        let Some(index) = self.modules.iter().position(is_ours) else {
            self.foreign = self.foreign.saturating_add(1);
            return;
        };
        let m = &mut self.modules[index];
        let (Some((0, taxel)), Some(position)) =
            (m.wiring.taxel(data.place), m.wiring.order(data.place))
        else {
            self.foreign = self.foreign.saturating_add(1);
            return;
        };
        self.last_received = Some(received.at);
        let counts = [data.reading.x, data.reading.y, data.reading.z];
        m.health.record(taxel, counts, received.at);
        if m.scan.ends_before(position, received.at) {
            m.close(index, observer);
        }
        m.scan.put(taxel, position, counts, received.at);
        if m.scan.is_complete() {
            m.close(index, observer);
        }
    }

    /// Closes scans whose remaining readings did not come in time.
    pub(super) fn flush(&mut self, now: Instant, observer: &mut impl Observer) {
        for (index, m) in self.modules.iter_mut().enumerate() {
            if m.scan.deadline().is_some_and(|end| end <= now) {
                m.close(index, observer);
            }
        }
    }

    /// When the next scan ends by itself.
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.modules.iter().filter_map(|m| m.scan.deadline()).min()
    }
}
