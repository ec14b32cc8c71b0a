//! Chip, amplifiers, wires and finger with every parameter its own, and an audit of the whole limit table over
//! what they did.

use std::collections::{BTreeMap, VecDeque};

use palpate_core::codec::pca9685::PRE_SCALE_RESET;
use palpate_core::guard::{HARD, Limits, WornWire};
use palpate_core::physics::{Alloy, History, RPhase, TissueParameters, WireParameters, WireState};
use palpate_core::random::RandomStream;
use palpate_core::units::{Channel, Clock, Milliamps, Prescale};
use palpate_emulators::display::amplifier::Amplifier;
use palpate_emulators::display::amplifier::supply::Supply;
use palpate_emulators::display::finger::dose::Dose;
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Edge, Oscillator, Pca9685, Pin, UpdateModel};
use palpate_emulators::display::solver::record::Peaks;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;

/// Wires of the fingertip, on the first channels of one chip.
pub const WIRES: usize = 8;
/// The chip's address.
pub const ADDRESS: u8 = 0x40;
/// How often the skin is looked at for its 10 s mean.
const SAMPLE: u64 = 50_000_000;

/// A bench's parameters, each drawn from its stated range, ends included.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    pub wire: WireParameters,
    pub skin: TissueParameters,
    pub oscillator_hz: u32,
    pub prescale: Prescale,
    /// On the EXTCLK pin, Hz; zero: no clock there.
    pub external_hz: u32,
    pub updates: UpdateModel,
    pub clock: BusClock,
    pub current: Milliamps,
    pub supply: Milliamps,
}

/// One of the ends of a range half of the time, else anything between.
pub fn pick(stream: &mut RandomStream, low: f64, high: f64) -> f64 {
    match stream.next_u64() % 4 {
        0 => low,
        1 => high,
        _ => low + (high - low) * stream.uniform(),
    }
}

impl Parameters {
    /// The assumed range of every parameter, both prototypes' wires and alloys, oscillators from 23 to 27.4 MHz.
    pub fn draw(s: &mut RandomStream) -> Self {
        let first = s.next_u64().is_multiple_of(2);
        let base = if first {
            WireParameters::FIRST.taut()
        } else {
            WireParameters::FINAL.taut()
        };
        let alloy = if s.next_u64().is_multiple_of(2) {
            Alloy::LOW
        } else {
            Alloy::HIGH
        };
        let wire = WireParameters {
            wire_share: pick(s, 0.6, 1.0),
            specific_heat: pick(s, 322.0, 837.0),
            latent_heat: pick(s, 0.0, 24e3),
            alloy,
            ..base
        };
        let skin = TissueParameters {
            contact_h: pick(s, 1000.0, 10_000.0),
            contact_fraction: pick(s, 0.1, 0.5),
            ..TissueParameters::DEFAULT
        };
        Self {
            wire,
            skin,
            oscillator_hz: pick(s, 23e6, 27.4e6) as u32,
            prescale: Prescale::new(PRE_SCALE_RESET),
            external_hz: 0,
            updates: if s.next_u64().is_multiple_of(2) {
                UpdateModel::EndOfLow
            } else {
                UpdateModel::Immediate
            },
            clock: if s.next_u64().is_multiple_of(2) {
                BusClock::Fast
            } else {
                BusClock::FastPlus
            },
            current: Milliamps(pick(s, 800.0, 2500.0) as u32),
            supply: Milliamps(pick(s, 2500.0, 8000.0) as u32),
        }
    }

    /// Makes the wires loose: low stress, so that bands lie around the skin's own temperature, and an R phase with latent
    /// heat of its own, which the martensite's exceeds.
    pub fn loose(self, s: &mut RandomStream) -> Self {
        let latent_heat = pick(s, 3e3, 8e3);
        let wire = WireParameters {
            r_phase: Some(RPhase {
                latent_heat,
                ..RPhase::LOW
            }),
            bias_stress_pa: pick(s, 2e6, 40e6),
            reversible: pick(s, 0.002, 0.3),
            latent_heat: pick(s, latent_heat, 24e3),
            ..self.wire
        };
        Self { wire, ..self }
    }

    /// Makes the wires loose ones of the low alloy after a hot pass, their sags measured before it or after.
    pub fn passed(self, s: &mut RandomStream) -> Self {
        let loose = self.loose(s);
        let sag_state = if s.next_u64().is_multiple_of(2) {
            WireState::Cold
        } else {
            WireState::Passed
        };
        let wire = WireParameters {
            alloy: Alloy::LOW,
            history: History {
                state: WireState::Passed,
                sag_state,
                coldest_c: None,
            },
            ..loose.wire
        };
        Self { wire, ..loose }
    }

    /// Makes the wire another size, on a finger of another temperature at rest. Its resistance goes with its size, that of
    /// crimps and leads does not.
    pub fn sized(self, wire: WireParameters, rest_c: f64) -> Self {
        let slender = |w: &WireParameters| w.length_m / (w.diameter_m * w.diameter_m);
        let by = slender(&wire) / slender(&self.wire);
        let share = self.wire.wire_share;
        let wire = WireParameters {
            diameter_m: wire.diameter_m,
            length_m: wire.length_m,
            air_h: wire.air_h,
            ends_c: rest_c,
            resistance_ohm: self.wire.resistance_ohm * (1.0 + share * (by - 1.0)),
            ..self.wire
        };
        let skin = TissueParameters {
            body_c: rest_c,
            ..self.skin
        };
        Self { wire, skin, ..self }
    }

    /// Puts the bench into the corner that the guard expects: all heat in a wire of the largest heat capacity, or of the
    /// least, and the best contact.
    pub fn in_the_worst_corner(self, s: &mut RandomStream) -> Self {
        let wire = WireParameters {
            wire_share: 1.0,
            specific_heat: if s.next_u64().is_multiple_of(4) {
                322.0
            } else {
                837.0
            },
            ..self.wire
        };
        let skin = TissueParameters {
            contact_h: 10_000.0,
            contact_fraction: 0.5,
            ..self.skin
        };
        Self { wire, skin, ..self }
    }

    /// What the guard knows of wire and finger.
    pub fn worn(&self) -> WornWire {
        WornWire::new(&self.wire, &self.skin)
    }

    /// Puts the chips on an external clock, anywhere within its tolerance.
    pub fn clocked(self, s: &mut RandomStream) -> Self {
        let hz = pick(s, 4e6, f64::from(Clock::MOST_HZ));
        let ppm = pick(s, 0.0, f64::from(Clock::MOST_PPM));
        let clock = Clock::external(hz as u32, ppm as u32).unwrap();
        let true_hz = hz.trunc() * (1.0 + pick(s, -1.0, 1.0) * ppm.trunc() * 1e-6);
        Self {
            prescale: Prescale::from_hz(clock, pick(s, 100.0, 400.0)).unwrap(),
            // Rounded towards what the clock is stated to be.
            external_hz: if true_hz < hz {
                true_hz.ceil()
            } else {
                true_hz
            } as u32,
            ..self
        }
    }

    /// The limits of this bench.
    pub fn limits(&self) -> Limits {
        Limits {
            supply: self.supply,
            ..HARD
        }
    }
}

/// Pulses of one wire, as the audit remembers them.
#[derive(Clone, Debug, Default)]
struct Pulses {
    /// When the pulse under way began.
    since: Option<u64>,
    /// Start and end of the burst, and its energy, J.
    burst: Option<(u64, u64, f64)>,
    /// Start and end of every pulse in the last 60 s.
    past: VecDeque<(u64, u64)>,
    /// Skin 0.1 mm deep above rest at the samples of the last 10 s, K.
    samples: VecDeque<f64>,
}

/// Where a limit was passed.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    pub limit: &'static str,
    pub at_s: f64,
    pub value: f64,
}

/// The bench.
pub struct Rig {
    pub bus: I2cHandle,
    pub parameters: Parameters,
    amplifier: Amplifier,
    supply: Supply,
    pub wires: Vec<Wire>,
    pulses: Vec<Pulses>,
    edges: Vec<Edge>,
    now: u64,
    next_sample: u64,
    /// The first limit that was passed.
    pub breach: Option<Breach>,
    /// Largest part of each limit of heat and power that was reached, 0 at rest.
    pub reached: BTreeMap<&'static str, f64>,
    /// Hottest 10 s mean.
    pub mean_c: f64,
}

impl Rig {
    /// A bench at rest. Dose takes time to add up, in the skin and here: it is kept only where asked for.
    pub fn new(parameters: Parameters, dose: bool) -> Self {
        let mut chip = Pca9685::new(Config {
            oscillator: Oscillator::from_hz(parameters.oscillator_hz),
            updates: parameters.updates,
            ..Config::new(ADDRESS)
        });
        chip.set_external_clock(Nanos::ZERO, parameters.external_hz);
        let rest_c = parameters.skin.body_c;
        let wire = Wire::new(&parameters.wire, &parameters.skin, rest_c).unwrap();
        let wire = if dose { wire.with_dose() } else { wire };
        Self {
            bus: I2cHandle::new(I2cSegment::new(parameters.clock, vec![chip])),
            parameters,
            amplifier: Amplifier::new(parameters.current),
            supply: Supply::default(),
            wires: vec![wire; WIRES],
            pulses: vec![Pulses::default(); WIRES],
            edges: Vec::new(),
            now: 0,
            next_sample: SAMPLE,
            breach: None,
            reached: BTreeMap::new(),
            mean_c: rest_c,
        }
    }

    /// The time of the bus, which transfers move.
    pub fn now(&self) -> u64 {
        self.bus.with(|segment| segment.now().0).unwrap()
    }

    /// Lets time pass until `to`, ns.
    pub fn advance(&mut self, to: u64) {
        while self.next_sample <= to {
            self.run(self.next_sample);
            self.sample();
            self.next_sample += SAMPLE;
        }
        self.run(to);
    }

    fn run(&mut self, to: u64) {
        let edges = &mut self.edges;
        let reached = self.bus.with(|segment| {
            segment.set_now(Nanos(to));
            let chip = &mut segment.chips_mut()[0];
            let until = Nanos(to).max(chip.now());
            chip.advance(until, &mut |edge| edges.push(edge));
            until.0
        });
        self.now = self.now.max(reached.unwrap());
        for edge in std::mem::take(&mut self.edges) {
            self.take(edge);
        }
    }

    fn take(&mut self, edge: Edge) {
        let wire = usize::from(edge.channel.0);
        let Some(change) = self.amplifier.edge(edge) else {
            return;
        };
        self.supply.set(change.at, self.amplifier.sum());
        if wire >= WIRES {
            return;
        }
        self.wires[wire].set_current(change.at, change.current.amps());
        match edge.pin {
            Pin::High => self.pulses[wire].since = Some(edge.at.0),
            _ => {
                if let Some(since) = self.pulses[wire].since.take() {
                    self.pulse(wire, since, edge.at.0);
                }
            }
        }
    }

    /// Electrical power while a pulse is high, W.
    fn watts(&self) -> f64 {
        self.parameters.current.amps().powi(2) * self.parameters.wire.resistance_ohm
    }

    fn pulse(&mut self, wire: usize, since: u64, until: u64) {
        let watts = self.watts();
        let joules = |from: u64, to: u64| watts * to.saturating_sub(from) as f64 * 1e-9;
        self.limit("pulse width", (until - since) as f64, 200e3);
        let p = &mut self.pulses[wire];
        let (start, _, spent) = p
            .burst
            .filter(|b| since < b.1 + 20_000_000)
            .unwrap_or((since, since, 0.0));
        let burst = (start, until, spent + joules(since, until));
        p.burst = Some(burst);
        p.past.push_back((since, until));
        while p.past.front().is_some_and(|x| x.1 + 60_000_000_000 < until) {
            p.past.pop_front();
        }
        self.limit("burst length", (burst.1 - burst.0) as f64, 50e6);
        self.heat("burst energy", burst.2, 10e-3);
    }

    /// Mean power of one wire over the last `window` ns, W.
    fn mean_w(&self, wire: usize, window: u64) -> f64 {
        let since = self.now.saturating_sub(window);
        let past = self.pulses[wire].past.iter().rev();
        let recent = past.take_while(|x| x.1 > since);
        let on: u64 = recent.map(|x| x.1 - x.0.max(since)).sum();
        self.watts() * on as f64 / window as f64
    }

    fn sample(&mut self) {
        const S: u64 = 1_000_000_000;
        let mut tip = [0.0, 0.0];
        for wire in 0..WIRES {
            if self.pulses[wire]
                .since
                .is_some_and(|since| self.now > since + 200_000)
            {
                self.limit("pulse width", f64::INFINITY, 200e3);
            }
            if self.pulses[wire].past.is_empty() {
                continue;
            }
            self.heat("wire power over 1 s", self.mean_w(wire, S), 45e-3);
            self.heat("wire power over 10 s", self.mean_w(wire, 10 * S), 20e-3);
            tip[0] += self.mean_w(wire, S);
            tip[1] += self.mean_w(wire, 60 * S);
            let shallow = self.wires[wire].tissue(Nanos(self.now)).0;
            let samples = &mut self.pulses[wire].samples;
            let rest_c = self.parameters.skin.body_c;
            samples.push_back(shallow - rest_c);
            if samples.len() > 200 {
                samples.pop_front();
            }
            let mean_c = rest_c + samples.iter().sum::<f64>() / 200.0;
            self.mean_c = self.mean_c.max(mean_c);
        }
        self.heat("fingertip power over 1 s", tip[0], 110e-3);
        self.heat("fingertip power over 60 s", tip[1], 60e-3);
        self.tissue("skin mean", self.mean_c, 41.0);
    }

    /// Looks at what is only known of the whole: skin, dose, supply. Pulses under way count as well.
    pub fn inspect(&mut self) {
        for wire in 0..WIRES {
            if self.pulses[wire]
                .since
                .is_some_and(|since| self.now > since + 200_000)
            {
                self.limit("pulse width", f64::INFINITY, 200e3);
            }
            if self.pulses[wire].past.is_empty() && self.pulses[wire].since.is_none() {
                continue;
            }
            let now = Nanos(self.now);
            let peaks = self.wires[wire].peaks(now);
            let dose = self.wires[wire].dose(now).unwrap_or_default();
            self.tissue("skin at 0.1 mm", peaks.shallow_c, 43.0);
            self.tissue("skin at 0.4 mm", peaks.deep_c, 41.0);
            self.heat("Henriques' Omega", dose.omega, 0.01);
            self.heat("CEM43", dose.cem43_min, 2.0);
        }
        let peak = f64::from(self.supply.peak().0.0);
        self.limit("supply", peak, f64::from(self.parameters.supply.0));
    }

    /// Hottest skin under any wire: 0.1 mm at any time, its 10 s mean, 0.4 mm, degrees C.
    pub fn hottest(&mut self) -> [f64; 3] {
        let now = Nanos(self.now);
        let peaks: Vec<_> = self.wires.iter_mut().map(|w| w.peaks(now)).collect();
        let most = |of: fn(&Peaks) -> f64| peaks.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        [most(|p| p.shallow_c), self.mean_c, most(|p| p.deep_c)]
    }

    /// Largest dose under any wire; none where it is not kept.
    pub fn dose(&mut self) -> Dose {
        let now = Nanos(self.now);
        let mut most = Dose::default();
        for dose in self.wires.iter_mut().filter_map(|w| w.dose(now)) {
            most.omega = most.omega.max(dose.omega);
            most.cem43_min = most.cem43_min.max(dose.cem43_min);
        }
        most
    }

    /// A limit of tissue, degrees C, of which rest takes nothing.
    fn tissue(&mut self, limit: &'static str, value: f64, most: f64) {
        let rest_c = self.parameters.skin.body_c;
        self.heat(limit, value - rest_c, most - rest_c);
    }

    /// A limit of heat or power, with the part of it that was reached.
    fn heat(&mut self, limit: &'static str, value: f64, most: f64) {
        let reached = self.reached.entry(limit).or_default();
        *reached = reached.max(value / most);
        self.limit(limit, value, most);
    }

    /// Hottest wire, degrees C.
    pub fn hottest_wire(&mut self) -> f64 {
        let now = Nanos(self.now);
        let peaks = self.wires.iter_mut().map(|w| w.peaks(now).wire_c);
        peaks.fold(f64::NEG_INFINITY, f64::max)
    }

    fn limit(&mut self, limit: &'static str, value: f64, most: f64) {
        if value > most && self.breach.is_none() {
            let at_s = self.now as f64 * 1e-9;
            self.breach = Some(Breach { limit, at_s, value });
        }
    }

    /// Channel of a wire.
    pub const fn channel(wire: usize) -> Channel {
        Channel(wire as u8)
    }
}
