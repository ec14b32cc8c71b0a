//! A session that a page plays: its fingers, its pictures, and the scene that it can be saved as.

use std::collections::BTreeMap;

use palpate_core::contact::Scope;
use palpate_core::guard::Cause;
use palpate_core::skin::Module;
use palpate_core::units::{Instant, Point};
use palpate_files::{Loaded, Scene, Setup, Source, Touch};
use palpate_records::digest::schedule_digest;
use palpate_records::trace::{Event, Header, PlaceUm};
use palpate_run::{EmulatedSession, Failure, Fingers, Input, Turn, header};
use serde::Serialize;

use crate::picture::{Burst, Contact, Felt, Head, LimitsC, ModuleHead, Picture};

/// A picture is of so much virtual time at most, microseconds: a page that slept does not make up for it.
const MOST_STEP_US: u64 = 2_000_000;

/// Peaks and doses are summed up this often, microseconds: no one reads them faster.
const TOTALS_US: u64 = 100_000;

/// A finger: its number, module, x, y (um), force (mN), diameter (um).
type Finger = (usize, usize, i64, i64, i64, i64);

/// A session with its page's state.
pub struct Played {
    setup: Setup,
    seed: u64,
    session: EmulatedSession,
    fingers: Fingers,
    header: Header,
    /// Modules that are shown.
    shown: Vec<usize>,
    /// What the fingers do from here on counts from here.
    mark: Instant,
    /// Fingers that press, by number.
    pressing: BTreeMap<usize, Finger>,
    contacts: Vec<Contact>,
    frames: u32,
    /// When they are summed up next, and what peaks, doses and energy came to.
    totals: (u64, [f64; 4], f64),
}

/// A session as a scene.
#[derive(Debug, Serialize)]
pub struct Saved {
    /// The scene's text (TOML).
    text: String,
    /// Its length, s.
    length_s: f64,
    /// The schedule of a run of it.
    digest: String,
}

fn mm(place: PlaceUm) -> [f64; 2] {
    [f64::from(place.x) * 1e-3, f64::from(place.y) * 1e-3]
}

fn pair(point: Point) -> [f32; 2] {
    [point.x, point.y]
}

impl Played {
    /// Begins a session.
    ///
    /// # Errors
    /// What fits no emulated hardware, and several displays.
    pub fn new(setup: Setup, seed: u64) -> Result<Self, Failure> {
        if !setup.bench.value.displays.is_empty() {
            return Err(Failure::Input(format!(
                "bench `{}`: expected a bench of one display; the page has one finger, `hil run` has all",
                setup.bench.value.name
            )));
        }
        let (mut session, fingers) = EmulatedSession::played(&setup, seed)?;
        let header = header(&setup, seed, session.projector())?;
        session.display().compare(&setup, &header, false)?;
        session.recorder().counts = Some(Vec::new());
        let scene = &setup.scene.value;
        let shown = match scene.compression.scope {
            Scope::Skin => (0..session.projector().layout().modules().len()).collect(),
            Scope::Module => vec![scene.drives],
        };
        session
            .start(Instant::ZERO)
            .map_err(|e| Failure::Device(e.to_string()))?;
        Ok(Self {
            setup,
            seed,
            session,
            fingers,
            header,
            shown,
            mark: Instant::ZERO,
            pressing: BTreeMap::new(),
            contacts: Vec::new(),
            frames: 0,
            totals: (0, [0.0; 4], 0.0),
        })
    }

    /// When the reference has been taken, microseconds.
    fn quiet_us(&self) -> u64 {
        let scene = &self.setup.scene.value;
        let quiet_s = f64::from(scene.reference_frames + 1) / scene.rate_hz;
        (quiet_s * 1e6).ceil() as u64
    }

    /// When what the scene itself does is over; 0 where it does nothing.
    fn scene_us(&self) -> u64 {
        let scene = &self.setup.scene.value;
        let idle = scene.touches.is_empty()
            && scene.strokes.is_empty()
            && scene.faults.is_empty()
            && scene.texture.is_none();
        match idle {
            true => 0,
            false => (scene.length_s * 1e6).ceil() as u64,
        }
    }

    /// What stays as it is.
    pub fn head(&self) -> Head {
        let setup = &self.setup;
        let (scene, projector) = (&setup.scene.value, self.session.projector());
        let layout = projector.layout();
        let module = |&number: &usize| {
            let module: &Module = layout.modules().get(number)?;
            Some(ModuleHead {
                number,
                name: module.name().to_owned(),
                place_mm: match scene.compression.scope {
                    Scope::Skin => pair(module.origin()),
                    Scope::Module => [0.0; 2],
                },
                taxels_mm: module.points().iter().copied().map(pair).collect(),
            })
        };
        let prescale = projector.guard().prescale();
        let limits = projector.guard().limits();
        let celsius = |milli: u64| milli as f64 * 1e-3;
        let spacing = layout.modules().get(scene.drives).map(Module::spacing);
        Head {
            scene: scene.name.clone(),
            description: scene.description.clone(),
            bench: setup.bench.value.name.clone(),
            source: self.header.source.words(),
            seed: self.seed,
            skin: setup.sensor.value.name.clone(),
            display: setup.display.value.name.clone(),
            illusion: scene.illusion.model.name(),
            renderer: crate::shelves::word(scene.illusion.render),
            person: setup.person.value.name.clone(),
            wire: setup.wire.value.name.clone(),
            contacts_most: scene.compression.kc,
            observed: setup.is_observed(),
            rate_hz: scene.rate_hz,
            soa_us: self.header.soa_us,
            tau_d_us: self.header.tau_d_us,
            period_ns: prescale.period_ns(),
            pwm_hz: 1e9 / prescale.period_ns() as f64,
            pitch_mm: f64::from(spacing.unwrap_or(1.0)),
            quiet_us: self.quiet_us(),
            scene_us: self.scene_us(),
            modules: self.shown.iter().filter_map(module).collect(),
            drives: scene.drives,
            wires_mm: projector
                .display()
                .wires()
                .iter()
                .map(|w| pair(w.place))
                .collect(),
            wire_mm: setup.wire.value.length_mm,
            finger_mm: setup
                .display
                .value
                .surface
                .map(|s| [s.diameter_mm, s.tip_mm]),
            widest_ticks: projector.guard().widest().get(),
            limits_c: LimitsC {
                mean: celsius(limits.skin_mean_mc),
                peak: celsius(limits.skin_peak_mc),
                deep: celsius(limits.skin_deep_mc),
            },
        }
    }

    /// What fingers do from the end of the last step on.
    ///
    /// # Errors
    /// Numbers that no finger has, a touch while the reference is taken, and a full log.
    pub fn touch(&mut self, fingers: &[Finger]) -> Result<(), Failure> {
        let now_us = self.mark.as_micros();
        for &finger in fingers {
            let (number, module, x, y, force, diameter) = finger;
            let quiet_us = self.quiet_us();
            if now_us < quiet_us {
                return Err(Failure::Input(format!(
                    "finger {number}: expected a touch from {quiet_us} us on, when the reference is taken, found {now_us} us"
                )));
            }
            let modules = self.setup.sensor.value.modules.len();
            if module >= modules {
                return Err(Failure::Input(format!(
                    "finger {number}: expected a module from 0 to {}, found {module}",
                    modules - 1
                )));
            }
            let t_us = i64::try_from(now_us).unwrap_or(i64::MAX);
            self.fingers
                .add(number, module, [t_us, x, y, force, diameter])?;
            match force {
                0 => self.pressing.remove(&number),
                _ => self.pressing.insert(number, finger),
            };
        }
        Ok(())
    }

    /// Lets the session go on until a time, and looks.
    ///
    /// # Errors
    /// What ends the session.
    pub fn step(&mut self, until_us: u64) -> Result<Picture, Failure> {
        let mark_us = self.mark.as_micros();
        let until_us = until_us.clamp(mark_us, mark_us.saturating_add(MOST_STEP_US));
        let until = Instant::from_micros(until_us);
        if self.session.advance(until)? == Turn::Last {
            let ended = self.session.take_failure();
            return Err(ended.unwrap_or_else(|| Failure::Device("the session ended".into())));
        }
        self.mark = until;
        let (events, dropped) = self.session.drain();
        let mut picture = self.look(dropped);
        for event in &events {
            self.add(event, &mut picture);
        }
        picture.contacts.clone_from(&self.contacts);
        picture.frames = self.frames;
        Ok(picture)
    }

    /// How things are, nothing having happened.
    fn look(&mut self, dropped: u64) -> Picture {
        let wires = self.header.wires.len();
        let hardware = self.session.display().hardware();
        let warm = (0..wires).map(|w| {
            let celsius = [hardware.wire_c(w), hardware.tissue_c(w)];
            celsius.map(|c| c.unwrap_or(f64::NAN))
        });
        let warm = warm.collect();
        let now_us = self.mark.as_micros();
        if now_us >= self.totals.0 {
            let totals = hardware.totals();
            let (omega, cem43) = totals.dose;
            let peaks = [totals.hottest_tissue_c, totals.hottest_deep_c, omega, cem43];
            self.totals = (now_us + TOTALS_US, peaks, totals.electrical_j);
        }
        let (_, hottest, energy_j) = self.totals;
        let projector = self.session.projector();
        let map = projector.map();
        let presses = |&(number, module, x, y, ..): &Finger| {
            let place = Point::new(x as f32 * 1e-3, y as f32 * 1e-3);
            let here = module == self.setup.scene.value.drives && map.shows(place);
            here.then(|| (number, pair(map.apply(place))))
        };
        let guard = projector.guard();
        Picture {
            now_us,
            counts: self.counts(),
            frames: 0,
            contacts: Vec::new(),
            fingers: self.pressing.values().filter_map(presses).collect(),
            spheres: self.spheres(),
            warm,
            used: guard.used(self.mark).rows().to_vec(),
            hottest,
            energy_j,
            bursts: Vec::new(),
            edges: Vec::new(),
            felt: Vec::new(),
            notes: Vec::new(),
            stopped: guard.latched().map(Cause::word),
            dropped,
        }
    }

    /// What the scene presses with now.
    fn spheres(&self) -> Vec<[f64; 4]> {
        let (scene, modules) = (&self.setup.scene.value, &self.setup.sensor.value.modules);
        let t_s = self.mark.as_micros() as f64 * 1e-6;
        let touches = scene.touches.iter();
        let here = touches.filter(|touch| self.shown.contains(&touch.module));
        let sphere = |touch: &Touch| {
            let [x, y] = match scene.compression.scope {
                Scope::Skin => modules.get(touch.module)?.place_mm,
                Scope::Module => [0.0; 2],
            };
            let at = touch.at(t_s)?;
            Some([at.x_mm + x, at.y_mm + y, at.force_n, at.diameter_mm])
        };
        here.filter_map(sphere).collect()
    }

    /// The newest readings of the shown modules.
    fn counts(&self) -> Vec<Option<u32>> {
        let (_, recorder) = self.session.seen();
        let all = recorder.counts.as_deref().unwrap_or_default();
        let modules = self.session.projector().layout().modules();
        let mut first = 0;
        let mut counts = Vec::new();
        for (number, module) in modules.iter().enumerate() {
            let taxels = module.points().len();
            if self.shown.contains(&number) {
                let own = all.iter().skip(first).take(taxels);
                counts.extend(own.map(|c| c.is_finite().then(|| c.round() as u32)));
            }
            first += taxels;
        }
        counts
    }

    fn wire_of(&self, board: u8, channel: u8) -> Option<usize> {
        let mut wires = self.header.wires.iter();
        wires.position(|w| (w.board, w.channel) == (board, channel))
    }

    /// Adds what happened.
    fn add(&mut self, event: &Event, picture: &mut Picture) {
        match event {
            Event::Frame { .. } => {
                self.frames += 1;
                self.contacts.clear();
            }
            Event::Contact {
                module,
                contact,
                place,
                intensity_milli,
                level,
                ..
            } => {
                let map = self.session.projector().map();
                let [x, y] = mm(*place);
                let at = Point::new(x as f32, y as f32);
                self.contacts.push(Contact {
                    id: *contact,
                    module: *module,
                    at_mm: [x, y],
                    on_mm: map.shows(at).then(|| pair(map.apply(at))),
                    counts: f64::from(*intensity_milli) * 1e-3,
                    level: *level,
                });
            }
            Event::Schedule(entry) => {
                let wire = self.wire_of(entry.board.0, entry.channel.0);
                picture.bursts.extend(wire.map(|wire| Burst {
                    at_us: entry.at.as_micros(),
                    until_us: entry.until.as_micros(),
                    wire,
                    ticks: entry.width().get(),
                    asked: entry.requested.get(),
                    reason: entry.reason.map(|reason| reason.word()),
                }));
            }
            Event::Edge {
                t_ns,
                board,
                channel,
                high,
            } => {
                let wire = self.wire_of(*board, *channel);
                let at_us = *t_ns as f64 * 1e-3;
                picture.edges.extend(wire.map(|wire| (at_us, wire, *high)));
            }
            Event::Felt {
                t_us,
                target,
                inside,
                met,
                ..
            } => {
                let band = self.session.display().newest_band_db();
                picture.felt.push(Felt {
                    at_us: *t_us,
                    target_mm: mm(*target),
                    inside: *inside,
                    at_mm: met.map(|met| mm(met.energy)),
                    level_db: met.map_or(f64::NAN, |met| f64::from(met.level_mdb) * 1e-3),
                    band_db: band.filter(|_| met.is_some()),
                    tap: met.is_some_and(|met| met.tap),
                });
            }
            Event::AllOff { t_us, cause, .. } => {
                picture
                    .notes
                    .push((*t_us, "off", format!("all off: {cause}")));
            }
            Event::Note { t_us, text } => picture.notes.push((*t_us, "note", text.clone())),
            _ => {}
        }
    }

    /// The session so far as a scene of its own, and what a run of it comes to.
    ///
    /// # Errors
    /// As reading and running that scene.
    pub fn save(&self) -> Result<Saved, Failure> {
        let now_us = self.mark.as_micros();
        let length_s = now_us.max(self.scene_us()).max(self.quiet_us()) as f64 / 1e6;
        let fingers = i64::try_from(now_us).unwrap_or(i64::MAX);
        let fingers = self.fingers.touches(fingers, length_s);
        let text = self.setup.scene.saved(length_s, &fingers)?;
        let mut setup = self.setup.clone();
        let source = Source::new("the session", text.clone());
        let value = Scene::read(&source)?;
        setup.scene = Loaded { value, source };
        let trace = palpate_run::run(&setup, &Input::Scene, self.seed)?.trace;
        Ok(Saved {
            text,
            length_s,
            digest: schedule_digest(&trace),
        })
    }
}
