//! The pass that counts on a bench of motors.

use palpate_core::contact::Levels;
use palpate_core::units::Instant;
use palpate_files::BenchHaptics;
use palpate_records::felt::FeltPath;
use palpate_records::margin::sort;
use palpate_records::readings::Readings;
use palpate_records::trace::{Event, Ledger};

use super::{HALF, Run, part};
use crate::display_end::DisplayEnd;
use crate::effort::Effort;
use crate::failure::Failure;
use crate::header::header;
use crate::levels::known_levels;
use crate::loops::build_with;
use crate::motors::EmulatedMotors;
use crate::piece::Pieces;
use crate::policy::Policy;
use crate::recorder::{Recorder, Truth};
use crate::session::{Session, Turn};
use crate::skin_end::SkinEnd;
use crate::summary::finished;
use crate::verdict::STOPPED_BY;
use crate::{Beginning, BusReport, Host, KeptReadings, Outcome, TurnView};

/// A session of motors on a skin of any kind.
type Played<'a> = Session<Box<dyn SkinEnd + 'a>, EmulatedMotors>;

/// Hands events to a host that records.
fn hand_on(
    pieces: &mut Pieces,
    session: &mut Played<'_>,
    end: bool,
    host: &mut dyn Host,
) -> Result<(), Failure> {
    let piece = pieces.take(session, end);
    piece.map_or(Ok(()), |piece| host.record(piece))
}

impl Run<'_> {
    /// Plays the pass that counts on motors.
    pub(super) fn on_motors(
        &self,
        haptics: &BenchHaptics,
        (levels, truth): (Levels, Truth),
        skin: &mut dyn SkinEnd,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        let setup = self.setup;
        let projector = build_with(setup, self.seed, levels, self.responses)?;
        let mut display = EmulatedMotors::new(setup, haptics, &projector, self.seed)?;
        if self.keep.i2c {
            display.keep_log()?;
        }
        let header = header(setup, self.seed, &projector)?;
        let mut recorder = Recorder::new(truth, projector.layout());
        recorder.joints.clone_from(&setup.scene.value.joints);
        recorder.counts = host.looks_on().then(Vec::new);
        recorder.felt = self.keep.summary.then(|| FeltPath::new(&header));
        let drives = setup.scene.value.drives;
        let streams = self.keep.summary && host.records();
        recorder.handed = streams.then(Vec::new);
        recorder.taxels = (streams && self.keep.readings == KeptReadings::All)
            .then(|| Readings::whole(projector.layout(), drives));
        recorder.readings = match self.keep.readings {
            KeptReadings::None => None,
            _ if streams => None,
            KeptReadings::Sampled => Some(Readings::sampled(projector.layout(), drives)),
            KeptReadings::All => Some(Readings::whole(projector.layout(), drives)),
        };
        host.begin(&Beginning {
            setup,
            header: &header,
            projector: &projector,
            end,
            display: None,
        })?;
        let watch = host.stopwatch().filter(|_| !self.waits);
        let own: Box<dyn SkinEnd + '_> = Box::new(&mut *skin);
        let ends = (own, display);
        let mut session = Session::new(projector, ends, Policy::emulated(false), recorder, watch);
        session.thin_costs(self.keep.summary);
        // The policy waits for drivers that do not answer, so this cannot fail.
        let _ = session.start(Instant::ZERO);
        let mut pieces = Pieces::new(header.soa_us);
        let last = self.turns((&mut session, &mut pieces), end, host)?;
        session.conclude(last);
        let (display, projector, recorder) = session.all();
        display.settle(last, projector, recorder)?;
        hand_on(&mut pieces, &mut session, true, host)?;
        let costs = session.take_costs();
        let failure = session.take_failure();
        let mut effort = Effort::of(&costs, session.traffic());
        effort.calibrated = known_levels(&setup.scene.value.compression).is_none();
        let mut margins = session.display().margins();
        sort(&mut margins);
        let ledger = Ledger {
            margins,
            length_us: last.as_micros(),
            ..Ledger::default()
        };
        let (trace, mut summary) =
            finished(&mut session, header, ledger, &costs, &setup.bench.value);
        if let (Some(read), Some(began)) = (host.stopwatch(), self.began) {
            summary.wall_s = read().saturating_sub(began).as_secs_f64();
        }
        let (display, projector, recorder) = session.all();
        effort.finish(projector, recorder);
        summary.faults = display.faults();
        summary.motors = Some(display.report(last));
        let readings = recorder.readings.take();
        let i2c = display.take_transfers();
        drop(session);
        skin.advance_to(last);
        summary.buses = skin.buses();
        Ok(Outcome {
            readings,
            warmth: Vec::new(),
            i2c,
            trace,
            summary,
            frame_us: costs.iter().map(|c| c.us).collect(),
            effort,
            failure,
            can: skin.take_frames(),
            notes: Vec::new(),
            displays: Vec::new(),
            pass: None,
        })
    }

    /// Takes turn after turn; returns when the run ended.
    fn turns(
        &self,
        (session, pieces): (&mut Played<'_>, &mut Pieces),
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Instant, Failure> {
        let calibrated = known_levels(&self.setup.scene.value.compression).is_none();
        let before = if calibrated { HALF } else { 0.0 };
        loop {
            let now = session.next();
            if now >= end {
                return Ok(end);
            }
            let turn = session.turn(now)?;
            hand_on(pieces, session, false, host)?;
            if turn == Turn::Last {
                return Ok(now);
            }
            let is_stopped = host.looks_on() && {
                let (skin, recorder, look) = session.look();
                host.turn(&TurnView {
                    now,
                    display: 0,
                    events: &recorder.events,
                    counts: recorder.counts.as_deref().unwrap_or_default(),
                    buses: &|| skin.buses().iter().map(BusReport::words).collect(),
                    state: &|wants| look.state(wants),
                })
            };
            if let Some(wish) = host.wish() {
                session.grant(wish, now);
            }
            if is_stopped {
                let note = Event::note(now, format!("{STOPPED_BY}the person who watched"));
                session.recorder().events.push(note);
            }
            if is_stopped || host.passed(before + (1.0 - before) * part(now, end)) {
                return Ok(now);
            }
        }
    }
}
