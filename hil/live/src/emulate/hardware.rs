//! The emulated hardware of a bench on a time line that others set: boards under a scene's touches, chips
//! with wires on a finger, the scene's faults in front of both buses.

use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::codec::uskin::{Message, decode};
use palpate_core::skin::Layout;
use palpate_core::units::Instant;
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::sensor::can::NodeConfig;
use palpate_emulators::sensor::can::faults::Faulty;
use palpate_emulators::sensor::rig::Handle;
use palpate_emulators::time::Nanos;
use palpate_records::trace::Event;

use palpate_files::Setup;
use palpate_run::Failure;
use palpate_run::effects::{Faultable, FaultyDisplay};
use palpate_run::place::Place;
use palpate_run::plan;
use palpate_run::script::Script;
use palpate_run::skin;

use super::Options;
use super::record::PinEdge;
use super::served::Served;

/// Frames of other programs that may wait for the emulated wire, a bus.
const WAITING: usize = 4096;

/// Both ends of a bench: skin and display.
pub(super) struct Hardware<'a> {
    setup: &'a Setup,
    layout: Layout,
    seed: u64,
    skin: Faulty<Handle>,
    /// Time at which the scene began; the skin's own time starts there.
    scene_zero: Nanos,
    script: Script,
    place: Place,
    pub(super) display: Served,
    i2c: Shared<I2cHandle>,
}

impl<'a> Hardware<'a> {
    /// Boards that wait for their commands and chips at rest.
    ///
    /// # Errors
    /// [`Failure::Input`] for a layout that no board carries or a display that cannot be.
    pub fn new(setup: &'a Setup, options: &Options) -> Result<Self, Failure> {
        let layout = plan::layout(&setup.sensor.value)?;
        let (display, seed) = (Served::new(setup, options.oe)?, options.seed);
        let (bus, faults) = (display.bus(), I2cFaults::default());
        let i2c = Shared::new(I2cFault::new(bus, faults, seed, "actuator bus"));
        Ok(Self {
            skin: boards(setup, &layout, seed)?,
            scene_zero: Nanos::ZERO,
            script: Script::new(&setup.scene.value.faults, &layout),
            place: Place::whole(&setup.bench.value),
            setup,
            layout,
            seed,
            display,
            i2c,
        })
    }

    /// Number of sensor buses.
    pub fn buses(&self) -> usize {
        self.skin.inner().with(|buses| buses.len())
    }

    /// Begins the scene at `now` with new boards, all of them sending.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn begin_scene(&mut self, now: Nanos) -> Result<(), Failure> {
        self.skin = boards(self.setup, &self.layout, self.seed)?;
        self.scene_zero = now;
        self.script = Script::new(&self.setup.scene.value.faults, &self.layout);
        skin::start(self.skin.inner_mut())
    }

    /// Tells whether any board sends.
    pub fn sends(&self) -> bool {
        let any =
            |b: &palpate_emulators::sensor::rig::SkinBus| b.boards().iter().any(|b| b.sending());
        self.skin.inner().with(|buses| buses.iter().any(any))
    }

    /// Lets time pass until `now` on both sides; edges go to `tell`, faults that come and go are returned
    /// in words.
    ///
    /// # Errors
    /// The errors of [`Served::advance`].
    pub fn advance(
        &mut self,
        now: Nanos,
        epoch_ns: u64,
        tell: impl FnMut(PinEdge) -> Result<(), Failure>,
    ) -> Result<Vec<String>, Failure> {
        let scene_now = now.since(self.scene_zero);
        self.skin.inner_mut().advance(scene_now);
        self.display.advance(now, epoch_ns, tell)?;
        let mut events = Vec::new();
        let chips = self.display.bus();
        let (worn, motors) = self.display.faulty();
        self.script.step(
            Instant::from_micros(scene_now.as_micros()),
            false,
            &mut Faultable {
                skin: Some(&mut self.skin),
                display: Some(FaultyDisplay {
                    i2c: &self.i2c,
                    chips,
                    worn,
                    drive: self.setup.bench.value.drive,
                    place: &self.place,
                    unit: None,
                    heat: None,
                    motors,
                }),
            },
            &mut events,
        );
        let words = |event| match event {
            Event::Note(note) => Some(note.text),
            _ => None,
        };
        Ok(events.into_iter().filter_map(words).collect())
    }

    /// Time of the next event on a sensor bus.
    pub fn next_event(&self) -> Nanos {
        self.skin.inner().next_event() + self.scene_zero
    }

    /// The next frame that a board has sent, with the time at which it ended on the emulated wire.
    pub fn frame(&mut self) -> Option<(Nanos, Received)> {
        // The emulated bus reports nothing here that the boards do not mend themselves.
        let received = self.skin.receive().ok().flatten()?;
        Some((self.scene_zero + Nanos::from(received.at), received))
    }

    /// Puts a frame of another program onto an emulated wire; `false` if there was no room for it.
    pub fn hear(&mut self, bus: usize, frame: &CanFrame) -> bool {
        self.skin.transmit(bus as u8, frame).is_ok() // at most 256 buses, as the layout has it
    }

    /// The bus of the chips, through the scene's faults.
    pub fn i2c(&self) -> Shared<I2cHandle> {
        self.i2c.clone()
    }
}

/// Tells whether a frame is a start command.
pub(super) fn starts(frame: &CanFrame) -> bool {
    matches!(decode(frame), Ok(Message::Command(c)) if c.start)
}

fn boards(setup: &Setup, layout: &Layout, seed: u64) -> Result<Faulty<Handle>, Failure> {
    let scene = &setup.scene.value;
    let span = Nanos((scene.length_s * 1e9) as u64);
    let host = NodeConfig {
        transmit_limit: WAITING,
        ..NodeConfig::default()
    };
    let handle = skin::boards(setup, layout, seed, Some(span), host)?;
    Ok(Faulty::new(handle, seed, "sensor bus"))
}
