//! Samples of the display in a run: the felt place of an onset, and the temperatures of wires and skin.

use palpate_core::projector::Projector;
use palpate_core::schedule::Entry;
use palpate_core::units::{Instant, Ticks};
use palpate_emulators::person::channels::{Felt, Perceiver};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;
use palpate_files::Setup;
use palpate_records::trace::{EnergyPermille, Event, PlaceUm, event};

use super::failure::Failure;
use super::plan;
use super::recorder::{Onset, Recorder, milli_c};
use super::states::{States, felt_at};

/// A contact this close to the display's hull counts as inside it, mm.
const HULL_MARGIN: f32 = 1e-3;

/// Felt energy of one wire at full drive, alone and from rest: the unit for the energy of an onset.
pub(super) struct FullDrive {
    /// Integral of its squared filtered displacement, um2 s.
    energy: f64,
    /// Pulses that gave it.
    pulses: u64,
}

impl FullDrive {
    /// A burst of a setup's wire at the top level, to the end of its last period.
    pub(super) fn new(setup: &Setup, projector: &Projector) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        let prescale = projector.guard().prescale();
        let impossible = |e| Failure::Input(format!("bench `{}`: {e}", bench.name));
        let mut alone = plan::felt_wire(setup)?;
        let width = Nanos(u64::from(projector.width(1.0).get()) * prescale.tick_ns());
        let (mut at, mut pulses) = (Nanos::ZERO, 0);
        let end = Nanos::from_micros(projector.timing().duration.as_micros());
        while at < end {
            alone.set_current(at, bench.drive.current_ma * 1e-3);
            alone.set_current(at + width, 0.0);
            at = at + Nanos(prescale.period_ns());
            pulses += 1;
        }
        let person = plan::emulated_person(setup);
        let mut perceiver = Perceiver::new(person, &[(0.0, 0.0)]).map_err(impossible)?;
        alone.take_stretches(at, |stretch| perceiver.pass(0, stretch));
        perceiver.settle();
        let energy = perceiver.felt(bench.tissue.rest_c);
        let energy = energy.map_or(0.0, |felt| felt.energy);
        Ok(Self { energy, pulses })
    }

    /// A unit of this felt energy, um2 s, of a stimulus of the loop's length.
    pub(super) fn with_energy(energy: f64, projector: &Projector) -> Self {
        let period_ns = projector.guard().prescale().period_ns();
        let length_ns = projector.timing().duration.as_micros() * 1000;
        Self {
            energy,
            pulses: length_ns.div_ceil(period_ns),
        }
    }

    /// Energies of an onset with these contacts in thousandths of one wire's at full drive for their levels.
    fn permille(
        &self,
        projector: &Projector,
        onset: &Onset,
        felt: Option<&Felt>,
    ) -> EnergyPermille {
        let period_ns = projector.guard().prescale().period_ns();
        let square = |width: Ticks| u64::from(width.get()).pow(2);
        let top = |weight: f32| self.pulses * square(projector.width(weight));
        let full = onset.targets.iter().map(|t| top(t.weight));
        let full = full.sum::<u64>().max(1);
        let of = |sum: u64| u32::try_from(1000 * sum / full).unwrap_or(u32::MAX);
        let control = projector.guard().current_control();
        // The square of an energy that goes with the square of the current.
        let by_current = |e: &Entry, sum: u64| match (e.current, control) {
            (Some(current), Some(control)) => {
                let amps = current.amps() / control.full_scale.amps();
                let energy = amps * amps;
                (sum as f64 * energy * energy).round() as u64
            }
            _ => sum,
        };
        let requested =
            |e: &Entry| by_current(e, e.requested_pulses(period_ns) * square(e.requested));
        let applied = |e: &Entry| by_current(e, e.pulses(period_ns) * square(e.width()));
        let requested = of(onset.entries.iter().map(requested).sum());
        let applied = of(onset.entries.iter().map(applied).sum());
        let at_full = self.energy * full as f64 / top(1.0).max(1) as f64;
        // Rounded; not a number counts as zero.
        let felt = felt.map_or(0.0, |felt| 1e3 * felt.energy / at_full);
        EnergyPermille {
            requested,
            applied,
            felt: felt.round() as u32,
        }
    }
}

/// Records the sensation of an onset that is over. A felt place is compared with a single touch: an onset with several
/// contacts counts only where they are known to come from one.
pub(super) fn feel(
    onset: Option<Onset>,
    met: Option<Felt>,
    projector: &Projector,
    full: &FullDrive,
    recorder: &mut Recorder,
    states: Option<&mut States>,
) {
    let Some(onset) = onset else {
        return;
    };
    let (at, targets) = (onset.at, &onset.targets);
    let pulsed = std::mem::take(&mut recorder.pulsed);
    if pulsed && projector.plays_texture_alone() && targets.is_empty() {
        recorder.met.add_texture();
        recorder.met.meet(met.as_ref());
    } else if !targets.is_empty() {
        recorder.met.meet(met.as_ref());
    }
    let true_place = recorder
        .truth_at(at)
        .filter(|(place, _)| projector.map().shows(*place))
        .map(|(place, _)| projector.map().apply(place));
    let strongest = targets.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
    let Some(seen) = strongest.filter(|_| targets.len() == 1 || true_place.is_some()) else {
        return;
    };
    let event = event::Felt {
        t_us: at.as_micros(),
        target: PlaceUm::from(true_place.unwrap_or(seen.place)),
        inside: projector.display().contains(seen.place, HULL_MARGIN),
        met: met.as_ref().map(felt_at),
        energy: full.permille(projector, &onset, met.as_ref()),
    };
    recorder.events.push(Event::Felt(event));
    if let Some(states) = states {
        states.add(event);
    }
}

/// Records the temperature of every wire and of the skin under it.
pub(super) fn sample_wires(
    now: Instant,
    display: &mut WornDisplay,
    projector: &Projector,
    recorder: &mut Recorder,
) {
    let t_us = now.as_micros();
    for index in 0..projector.display().wires().len() {
        let wire = index as u16;
        let now = |milli_c| event::Temperature {
            t_us,
            wire,
            milli_c,
        };
        let hot = display.wire_c(index).and_then(milli_c).map(now);
        recorder.events.extend(hot.map(Event::Wire));
        let warm = display.tissue_c(index).and_then(milli_c).map(now);
        recorder.events.extend(warm.map(Event::Skin));
    }
}
