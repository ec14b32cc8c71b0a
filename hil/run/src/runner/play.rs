//! The pass that counts: a session per finger, turn by turn. The only display of a bench is a finger, too. No session
//! knows of another; skin, boards, buses and supply that several share are shared out before the run begins.

use std::cell::RefCell;
use std::slice;

use palpate_core::contact::Levels;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_files::Gate;
use palpate_records::felt::FeltPath;
use palpate_records::i2c::Transfer;
use palpate_records::readings::Readings;
use palpate_records::trace::{Event, Header};

use super::shared::{Pads, Shared};
use super::{HALF, Run, part};
use crate::effort::Effort;
use crate::emulated_end::EmulatedEnd;
use crate::failure::Failure;
use crate::header::header;
use crate::join::{Part, join};
use crate::levels::known_levels;
use crate::loops::build_with;
use crate::motors::EmulatedMotors;
use crate::piece::Pieces;
use crate::place::{Place, fingers};
use crate::policy::Policy;
use crate::recorder::{Recorder, Truth};
use crate::session::{Session, Turn};
use crate::skin_end::SkinEnd;
use crate::stagger::stagger;
use crate::summary::finished;
use crate::verdict::STOPPED_BY;
use crate::wires::EmulatedDisplay;
use crate::{Beginning, BusReport, Host, KeptReadings, Outcome, TurnView, plan};

/// A finger's session, and whether it has ended before the run.
struct Finger<'a, D> {
    /// The run that the finger would be alone.
    run: Run<'a>,
    place: Place,
    session: Session<Box<dyn SkinEnd + 'a>, D>,
    header: Header,
    pieces: Pieces,
    ended: bool,
    /// The joint that shows or hides the finger's skin, and whether it was shown in the last turn.
    gate: Option<(Gate, bool)>,
}

impl<'a, D: EmulatedEnd> Finger<'a, D> {
    /// A loop between a skin and an emulated display.
    fn new(
        run: Run<'a>,
        skin: Box<dyn SkinEnd + 'a>,
        (projector, mut display): (Projector, D),
        (truth, place): (Truth, Place),
        host: &dyn Host,
    ) -> Result<Self, Failure> {
        let Run { setup, keep, .. } = run;
        display.keep(keep)?;
        let mut recorder = Recorder::new(truth, projector.layout());
        recorder.joints.clone_from(&setup.scene.value.joints);
        recorder.counts = host.looks_on().then(Vec::new);
        let drives = setup.scene.value.drives;
        // A piece names no finger.
        let streams = keep.summary && host.records() && place.name.is_none();
        recorder.handed = streams.then(Vec::new);
        recorder.taxels = (streams && keep.readings == KeptReadings::All)
            .then(|| Readings::whole(projector.layout(), drives));
        recorder.readings = match keep.readings {
            KeptReadings::None => None,
            _ if streams => None,
            KeptReadings::Sampled => Some(Readings::sampled(projector.layout(), drives)),
            KeptReadings::All => Some(Readings::whole(projector.layout(), drives)),
        };
        let header = header(setup, run.seed, &projector)?;
        recorder.felt = keep.summary.then(|| FeltPath::new(&header));
        if keep.spread {
            display.compare(setup, &header, host.aside());
        }
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        // The frames of a stream would be timed with the wait for their readings.
        let watch = host.stopwatch().filter(|_| !run.waits);
        let mut session = Session::new(projector, (skin, display), policy, recorder, watch);
        session.thin_costs(keep.summary);
        Ok(Self {
            run,
            place,
            session,
            pieces: Pieces::new(header.soa_us),
            header,
            ended: false,
            gate: None,
        })
    }

    /// Begins at t = 0 before a host: everything off, boards set up.
    fn begin(&mut self, end: Instant, host: &mut dyn Host) -> Result<(), Failure> {
        host.begin(&Beginning {
            setup: self.run.setup,
            header: &self.header,
            projector: self.session.projector(),
            end,
            display: self.place.name.as_deref(),
        })?;
        let setup = self.run.setup;
        if setup.bench.value.heat.is_some() || host.looks_on() {
            self.session.plan_passes(setup);
        }
        self.session.recorder().begin(setup);
        // The policy waits for boards that do not answer, so this cannot fail.
        let _ = self.session.start(Instant::ZERO);
        Ok(())
    }

    /// Time of the next turn. A host waits while its adapter is busy with other fingers' transfers, else it would take
    /// a late write for one in time. The adapter is looked at only once a turn is due.
    fn due(&mut self, now: Instant) -> Instant {
        let next = self.session.next();
        if self.place.alone || next > now {
            return next;
        }
        let busy = self.session.display().bus_now();
        // The guard counts with this wait.
        let wait_us = self.run.setup.bus_wait.as_micros();
        let waits_us = busy.0.div_ceil(1000).saturating_sub(wait_us);
        next.max(Instant::from_micros(waits_us))
    }

    /// Takes a turn, if one is due. A cause that ends the finger ends no other one.
    fn turn(&mut self, now: Instant, host: &mut dyn Host) -> Result<(), Failure> {
        if self.ended {
            return self.rest(now);
        }
        if self.due(now) > now {
            return Ok(());
        }
        self.look_at_joint(now);
        let turn = self.session.turn(now)?;
        self.hand_on(false, host)?;
        if turn == Turn::Last {
            self.end(now);
        }
        Ok(())
    }

    /// Hands events to a host that records.
    fn hand_on(&mut self, end: bool, host: &mut dyn Host) -> Result<(), Failure> {
        let piece = self.pieces.take(&mut self.session, end);
        piece.map_or(Ok(()), |piece| host.record(piece))
    }

    /// Shows the finger's skin, or hides it, as its joint stands.
    fn look_at_joint(&mut self, now: Instant) {
        let Some((gate, was_open)) = &mut self.gate else {
            return;
        };
        let t_s = now.as_micros() as f64 * 1e-6;
        let (_, projector, recorder) = self.session.all();
        let is_open = gate.is_open(&recorder.joints, t_s);
        if std::mem::replace(was_open, is_open) != is_open {
            projector.show(is_open);
            let joint = recorder.joints.get(gate.joint).map_or("?", |j| &*j.name);
            let word = if is_open { "felt" } else { "not felt" };
            let text = format!("{word}: joint {joint}");
            recorder.note(now, text);
        }
    }

    /// Watches a finger that no loop drives any more: its wires cool, and a shorted amplifier heats on.
    fn rest(&mut self, now: Instant) -> Result<(), Failure> {
        let (display, projector, recorder) = self.session.all();
        display.fail(now, false, None, &mut recorder.events);
        display.advance_to(now, &mut recorder.events)?;
        display.look(now, false, projector, recorder);
        Ok(())
    }

    /// Switches everything of the finger off at `now`, once.
    fn end(&mut self, now: Instant) {
        if !std::mem::replace(&mut self.ended, true) {
            self.session.conclude(now);
        }
    }

    /// Shows a turn, which has this number's display, to a host that looks on. Returns whether the host wants no more.
    fn show(&self, now: Instant, display: usize, host: &mut dyn Host) -> bool {
        if !host.looks_on() {
            return false;
        }
        let (skin, recorder, look) = self.session.look();
        host.turn(&TurnView {
            now,
            display,
            events: &recorder.events,
            counts: recorder.counts.as_deref().unwrap_or_default(),
            buses: &|| skin.buses().iter().map(BusReport::words).collect(),
            state: &|wants| look.state(wants),
        })
    }

    /// Outcome of the finger until `end`, with everything off. Buses and frames of its skin are the run's.
    fn outcome(mut self, end: Instant, host: &mut dyn Host) -> Result<Outcome, Failure> {
        self.end(end);
        let (display, projector, recorder) = self.session.all();
        display.settle(end, projector, recorder)?;
        self.hand_on(true, host)?;
        let (setup, session) = (self.run.setup, &mut self.session);
        let costs = session.take_costs();
        let failure = session.take_failure();
        let mut effort = Effort::new(&costs, session.traffic());
        effort.calibrated = known_levels(&setup.scene.value.compression).is_none();
        let (display, projector, _) = session.all();
        let (ledger, warmth) = display.ledger(projector.guard().limits(), end);
        let bench = &setup.bench.value;
        let (trace, mut summary) = finished(session, self.header, ledger, &costs, bench);
        if let Some(texture) = &mut summary.texture {
            texture.compared(setup)?;
        }
        if let (Some(read), Some(began)) = (host.stopwatch(), self.run.began) {
            summary.wall_s = read().saturating_sub(began).as_secs_f64();
        }
        let (display, projector, recorder) = session.all();
        effort.finish(projector, recorder);
        summary.faults = display.faults();
        let pass = display.complete(setup, projector, &mut summary, end)?;
        Ok(Outcome {
            readings: recorder.readings.take(),
            warmth,
            i2c: display.take_transfers(),
            sound: display.take_sound(),
            trace,
            summary,
            frame_us: costs.iter().map(|c| c.us).collect(),
            effort,
            failure,
            can: Vec::new(),
            notes: Vec::new(),
            displays: Vec::new(),
            pass,
        })
    }
}

impl Run<'_> {
    /// Plays the pass that counts on the only display of a bench.
    pub(super) fn one(
        &self,
        levels: Levels,
        skin: &mut dyn SkinEnd,
        truth: Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        match self.setup.bench.value.haptics {
            None => self.alone::<EmulatedDisplay>(levels, skin, truth, end, host),
            Some(_) => self.alone::<EmulatedMotors>(levels, skin, truth, end, host),
        }
    }

    /// The loop of this run's setup.
    fn projector(&self, levels: Levels) -> Result<Projector, Failure> {
        build_with(self.setup, self.seed, levels, self.responses)
    }

    /// Plays the pass that counts on a display that is the only one.
    fn alone<D: EmulatedEnd>(
        &self,
        levels: Levels,
        skin: &mut dyn SkinEnd,
        truth: Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        let projector = self.projector(levels)?;
        let display = D::at_rest(self.setup, &projector, self.seed)?;
        let ends = (projector, display);
        let whole = Place::whole(&self.setup.bench.value);
        let own = Box::new(&mut *skin);
        let mut one = Finger::new(*self, own, ends, (truth, whole), host)?;
        let last = self.play(slice::from_mut(&mut one), None, end, host)?;
        let mut outcome = one.outcome(last, host)?;
        skin.advance_to(last);
        outcome.can = skin.take_frames();
        outcome.summary.buses = skin.buses();
        Ok(outcome)
    }

    /// Plays the pass that counts on several displays, with one skin.
    pub(super) fn several(
        &self,
        levels: &Levels,
        skin: &mut dyn SkinEnd,
        truth: &Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        let alone = fingers(self.setup);
        let shared = RefCell::new(Shared::new(self, skin, &alone));
        let mut fingers = Vec::new();
        for (number, ((place, setup), finger)) in alone.iter().zip(&self.setup.fingers).enumerate()
        {
            let truth = match truth {
                Truth::Scene(_) => Truth::of_finger(self.setup, finger),
                _ => Truth::Unknown,
            };
            let run = Run { setup, ..*self };
            let pads = Box::new(Pads::new(&shared, number));
            let buses = &shared.borrow().buses;
            let bus = buses.iter().find(|bus| bus.carries(place));
            let projector = run.projector(levels.clone())?;
            let on = (place.clone(), bus);
            let display = EmulatedDisplay::at(setup, on, &projector, run.seed)?;
            let (ends, own) = ((projector, display), (truth, place.clone()));
            fingers.push(Finger {
                gate: finger.when.map(|gate| (gate, true)),
                ..Finger::new(run, pads, ends, own, host)?
            });
        }
        let loops = fingers.iter_mut();
        let loops = loops.map(|f| (&f.place, f.session.projector_mut()));
        stagger(self.setup, loops.collect())?;
        let last = self.play(&mut fingers, Some(&shared), end, host)?;
        shared.borrow_mut().end(last, end);
        // Boards that fingers share go off before any of them is looked at.
        fingers.iter_mut().for_each(|finger| finger.end(last));
        let common = shared.borrow_mut().common();
        let replayed = matches!(truth, Truth::Unknown);
        let mut parts = Vec::new();
        for finger in fingers {
            let (place, setup) = (finger.place.clone(), finger.run.setup);
            let limits = *finger.session.projector().guard().limits();
            let mut outcome = finger.outcome(last, host)?;
            let own = plan::boards(&setup.bench.value);
            let of_boards = |t: &&Transfer| t.bus == place.bus && own.contains(&t.address);
            outcome.i2c = common.i2c.iter().filter(of_boards).cloned().collect();
            // The whole scene's faults tell what may be missing; the person is the finger's.
            let mut judged = self.setup.clone();
            judged.person.clone_from(&setup.person);
            parts.push(Part {
                place,
                limits,
                outcome: outcome.concluded(&judged, replayed),
            });
        }
        Ok(join(self.setup, parts, common))
    }

    /// Plays turn after turn; returns when the run ended. The end of the only finger is that of the run, the end of one of
    /// several is not.
    fn play(
        &self,
        fingers: &mut [Finger<'_, impl EmulatedEnd>],
        shared: Option<&RefCell<Shared<'_>>>,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Instant, Failure> {
        let mut now = Instant::ZERO;
        if let Some(shared) = shared {
            shared.borrow_mut().fail(now, false);
        }
        for finger in &mut *fingers {
            finger.begin(end, host)?;
        }
        let calibrated = known_levels(&self.setup.scene.value.compression).is_none();
        let before = if calibrated { HALF } else { 0.0 };
        let mut order: Vec<usize> = (0..fingers.len()).collect();
        loop {
            let due = shared.map_or(Instant::FAR_FUTURE, |shared| shared.borrow().due);
            let turns = fingers.iter_mut().filter(|f| !f.ended);
            let next = turns.map(|f| f.due(now)).fold(due, Instant::min);
            if next >= end {
                return Ok(end);
            }
            now = next;
            if let Some(Err(e)) = shared.map(|shared| shared.borrow_mut().turn(now)) {
                let failed = || Failure::Device(format!("sensor bus: {e}"));
                let fingers = fingers.iter_mut();
                fingers.for_each(|f| f.session.set_failure(failed()));
                return Ok(now);
            }
            // The finger that waits longest comes first: tries to bring a board back must not hold up the end of a
            // burst.
            order.sort_unstable_by_key(|number| (fingers[*number].session.next(), *number));
            let mut is_stopped = false;
            for &number in &order {
                let finger = &mut fingers[number];
                finger.turn(now, host)?;
                if finger.ended && shared.is_none() {
                    return Ok(now);
                }
                is_stopped |= finger.show(now, number, host);
            }
            if let Some(wish) = host.wish() {
                let sessions = fingers.iter_mut().map(|finger| &mut finger.session);
                sessions.for_each(|session| session.grant(wish, now));
            }
            if is_stopped {
                let note = || Event::note(now, format!("{STOPPED_BY}the person who watched"));
                let recorders = fingers.iter_mut().map(|f| f.session.recorder());
                recorders.for_each(|recorder| recorder.events.push(note()));
                if let Some(shared) = shared {
                    shared.borrow_mut().events.push(note());
                }
            }
            if is_stopped || host.passed(before + (1.0 - before) * part(now, end)) {
                return Ok(now);
            }
        }
    }
}
