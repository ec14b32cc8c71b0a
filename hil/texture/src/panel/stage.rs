//! Stage of a panel: control parameters on the emulated wires of a bench, through guard, driver and chip, and the
//! sensation of a person from the wires' motion.

use palpate_core::contact::Levels;
use palpate_core::driver::{Actuators, Driver};
use palpate_core::projector::{Carrier, Output};
use palpate_core::texture::{Control, ControlMap, Drivers, along};
use palpate_core::units::{Duration, Instant, Point};
use palpate_emulators::person::channels::{Felt, Kick};
use palpate_emulators::person::panel::{ScaleEnds, Sensation, apart_s, step_s};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;

use palpate_files::Setup;
use palpate_run::Failure;
use palpate_run::plan;
use palpate_run::wires::emulated;

/// Time for which a texture is shown: a stroke of 2 s less the second of its first window, as in the loop.
pub const SHOWN: Duration = Duration::from_millis(1000);
/// Time for which the ends of the scales are shown.
const SHOWN_BEFORE: Duration = Duration::from_millis(5000);
/// Pause before the surface is met again: earlier sensation is over, in the receptors too.
const REST: Duration = Duration::from_millis(1000);
/// Time after which a tap is over.
const TAP: Duration = Duration::from_millis(70);
/// Longest time between two calls of the loop.
const TICK: Duration = Duration::from_millis(1);

/// A bench with its display, and the projection of textures onto it.
pub struct Stage<'a> {
    setup: &'a Setup,
    drivers: Drivers,
    /// Map from driving coordinates to control parameters (3.2).
    pub map: ControlMap,
}

/// Sensation of a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Level over threshold, dB; `None` where no wire moved.
    pub level_db: Option<f64>,
    /// Felt intensity, 1 at threshold; 0 below.
    pub intensity: f64,
    /// Sensation that is rated.
    pub sensation: Sensation,
    /// Pulses that reached the wires.
    pub pulses: usize,
    /// Level over threshold of the tap that ends it, dB; `None` where no wire moved.
    pub tap_db: Option<f64>,
}

fn device(e: &dyn std::fmt::Debug) -> Failure {
    Failure::Device(format!("emulated wires: {e:?}"))
}

impl<'a> Stage<'a> {
    /// The bench of a setup, whose scene has a texture that has the display to itself.
    ///
    /// # Errors
    /// [`Failure::Input`] for what does not fit together.
    pub fn new(setup: &'a Setup, drivers: Drivers) -> Result<Self, Failure> {
        let prescale = plan::prescale(&setup.bench.value)?;
        let display = plan::display(setup)?;
        let (map, _) = plan::projection(setup, drivers, &display, prescale, 0)?;
        Ok(Self {
            setup,
            drivers,
            map,
        })
    }

    /// The ends of the scales: sensations at both ends of the driving coordinates.
    ///
    /// # Errors
    /// Errors of [`Stage::show`].
    pub fn ends(&self, seed: u64) -> Result<ScaleEnds, Failure> {
        let Drivers {
            roughness,
            friction,
            ..
        } = self.drivers;
        let at = |is_rough: bool| {
            let all = [Some(roughness), friction];
            let all = all.into_iter().flatten();
            let width = all.clone().map(|d| d.coordinate + 1).max().unwrap_or(0);
            let mut latent = vec![0.0; width];
            for driver in all {
                latent[driver.coordinate] = match is_rough == driver.falls {
                    true => driver.low,
                    false => driver.high,
                };
            }
            let control = self.map.control(&latent);
            let shown = [(Duration::ZERO, control)];
            let shown = self.show((&shown, None), SHOWN_BEFORE, seed)?;
            Ok::<_, Failure>(shown.sensation)
        };
        Ok(ScaleEnds {
            smooth: at(false)?,
            rough: at(true)?,
        })
    }

    /// Shows controls, each from its time on, for `length`, and then the tap of a surface that is left.
    ///
    /// # Errors
    /// [`Failure::Device`] where the emulated bus fails.
    pub fn show(
        &self,
        (controls, hardness): (&[(Duration, Control)], Option<f64>),
        length: Duration,
        seed: u64,
    ) -> Result<Shown, Failure> {
        let setup = self.setup;
        let plan = plan::untextured(setup, seed, Levels::Off, &plan::Responses::default())?;
        let prescale = plan::prescale(&setup.bench.value)?;
        let carrier = plan::projection(setup, self.drivers, &plan.display, prescale, seed)?.1;
        if !matches!(carrier, Carrier::Display(..)) {
            let expected =
                "\"display\": a panel rates textures that have the display to themselves";
            let bad = setup.scene.source.bad("texture.carrier", expected);
            return Err(Failure::File(bad));
        }
        let places: Vec<Point> = plan.display.wires().iter().map(|w| w.place).collect();
        let gaps = along(&places, plan.display.gap());
        let mut display = emulated(setup, plan.display.wires())?;
        display.keep_flows();
        let person = plan::emulated_person(setup);
        let impossible = |e| Failure::Input(format!("person `{}`: {e}", setup.person.value.name));
        display.worn_by(person).map_err(impossible)?;
        let mut bank = plan::banks(&setup.bench.value, display.bus(), prescale);
        let mut output = Output::new(plan.display, plan.output, plan.guard);
        output.carry(carrier);

        let begun = bank.start(Instant::ZERO).map_err(|e| device(&e))?;
        let mut now = begun;
        let end = begun + length + REST;
        let mut mets = [None, None];
        for (part, met) in mets.iter_mut().enumerate() {
            let until = match (part, hardness) {
                (0, _) => end,
                (_, Some(hardness)) => {
                    output.tap(now, hardness);
                    end + TAP
                }
                (_, None) => break,
            };
            while now < until {
                display
                    .advance(Nanos::from(now), &mut |_| {})
                    .map_err(|e| device(&e))?;
                output.hear(now);
                let due = controls.iter().rev().find(|c| c.0 <= now.since(begun));
                let control = due.map(|c| &c.1).filter(|_| now < begun + length);
                output
                    .turn(now, &[], control, &mut bank, &mut ())
                    .map_err(|e| device(&e))?;
                now = output.next().max(now + Duration::from_micros(1));
                now = now.min(until).min(now + TICK);
                display.settle();
            }
            display
                .advance(Nanos::from(now), &mut |_| {})
                .map_err(|e| device(&e))?;
            *met = display.onset();
        }
        bank.all_off().map_err(|e| device(&e))?;
        let mut kicks = self.kicks(&mut display, gaps.len(), Nanos::from(begun));
        let textured = end.since(begun).as_micros() as f64 * 1e-6;
        kicks
            .iter_mut()
            .for_each(|wire| wire.retain(|kick| kick.at_s < textured));
        let [met, tap] = mets;
        let intensity = met.map_or(0.0, |met| met.levels.intensity(person.growth));
        Ok(Shown {
            tap_db: tap.map(|tap| tap.levels.db()),
            ..shown((met, intensity), &kicks, &gaps, length)
        })
    }

    /// Pulses of every wire since `begun`, as the skin meets them.
    fn kicks(&self, display: &mut WornDisplay, wires: usize, begun: Nanos) -> Vec<Vec<Kick>> {
        let wire = plan::wire(self.setup);
        // Only times and shares are read of the kicks: the unit does not matter.
        let um_per_j = 1.0 / wire.heat_capacity();
        // The supply's share may change in the midst of a pulse: stretches that touch are one.
        let mut pulses: Vec<Vec<(Nanos, Nanos, f64)>> = vec![Vec::new(); wires];
        for flow in display.take_flows() {
            let joule = flow.watts * flow.to.since(flow.from).as_secs_f64() * wire.wire_share;
            match pulses[flow.wire].last_mut() {
                Some(last) if last.1 == flow.from => *last = (last.0, flow.to, last.2 + joule),
                _ => pulses[flow.wire].push((flow.from, flow.to, joule)),
            }
        }
        let kick = |&(from, _, joule): &(Nanos, Nanos, f64)| Kick {
            at_s: from.since(begun).as_secs_f64(),
            um: joule * um_per_j,
        };
        let of_wire = |pulses: &Vec<_>| pulses.iter().map(kick).collect();
        pulses.iter().map(of_wire).collect()
    }
}

/// Sensation of wires at these places along the stroke.
fn shown(
    (met, intensity): (Option<Felt>, f64),
    kicks: &[Vec<Kick>],
    gaps: &[f32],
    length: Duration,
) -> Shown {
    let seconds = length.as_micros() as f64 * 1e-6;
    // Wires side by side are one position of the stroke.
    let mut order: Vec<usize> = (0..gaps.len()).collect();
    order.sort_by(|a, b| gaps[*a].total_cmp(&gaps[*b]));
    let beside = |a: &usize, b: &usize| (gaps[*a] - gaps[*b]).abs() < 0.01;
    let merged = |wires: &[usize]| wires.iter().flat_map(|w| kicks[*w].clone()).collect();
    let positions: Vec<Vec<Kick>> = order.chunk_by(beside).map(merged).collect();
    let is_felt = intensity > 0.0;
    Shown {
        level_db: met.map(|met| met.levels.db()),
        intensity,
        sensation: Sensation {
            coarseness: apart_s(kicks).filter(|_| is_felt).map(f64::ln),
            slowness: step_s(&positions, seconds).filter(|_| is_felt).map(f64::ln),
        },
        pulses: kicks.iter().map(Vec::len).sum(),
        tap_db: None,
    }
}
