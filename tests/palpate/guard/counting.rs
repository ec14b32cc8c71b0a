//! A clock of stated tolerance makes pulses countable: whatever phase the counter has, wires never get more than is
//! booked, and where it starts with the stimulus they get exactly that many pulses.

use palpate_core::driver::{Actuators, Pca9685Bank};
use palpate_core::guard::{Guard, Guarded, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::schedule::{Reason, Stimulus};
use palpate_core::units::{
    Board, Channel, Clock, Duration, Instant, Milliamps, Point, Prescale, Ticks,
};
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Oscillator, Pca9685, Pin, UpdateModel};
use palpate_emulators::time::Nanos;
use proptest::prelude::*;

const ADDRESS: u8 = 0x40;
const WIRES: [u8; 2] = [0, 9];
const PEAK: Milliamps = Milliamps(1970);
const MILLIOHM: u32 = 1900;

/// A chip behind guard and driver, and the pulses of its first wire.
struct Rig {
    bus: I2cHandle,
    bank: Pca9685Bank<I2cHandle>,
    guard: Guard,
    rose: u64,
    pulses: u32,
    on_ns: u64,
}

impl Rig {
    fn new(prescale: Prescale, external_hz: u32, updates: UpdateModel, clock: BusClock) -> Self {
        let mut chip = Pca9685::new(Config {
            // Far from both ends: what is counted by it is not counted by the external clock.
            oscillator: Oscillator::from_hz(25_000_000),
            updates,
            ..Config::new(ADDRESS)
        });
        chip.set_external_clock(Nanos::ZERO, external_hz);
        let bus = I2cHandle::new(I2cSegment::new(clock, vec![chip]));
        let mut bank = Pca9685Bank::new(bus.clone(), &[ADDRESS], prescale);
        bank.start(Instant::ZERO).unwrap();
        let plant = Plant {
            prescale,
            wire_milliohm: MILLIOHM,
            peak: PEAK,
            bus: Duration::ZERO,
        };
        let wire = |&channel: &u8| DisplayWire {
            place: Point::new(f32::from(channel), 0.0),
            board: Board(0),
            channel: Channel(channel),
        };
        let guard = Guard::new(
            HARD,
            plant,
            &WIRES.each_ref().map(wire),
            WornWire::default(),
        )
        .unwrap();
        let (rose, pulses, on_ns) = (0, 0, 0);
        Self {
            bus,
            bank,
            guard,
            rose,
            pulses,
            on_ns,
        }
    }

    /// Lets time pass until `us`, at least to where transfers have moved it; returns the time.
    fn until(&mut self, us: u64) -> Instant {
        let (rose, pulses, on_ns) = (&mut self.rose, &mut self.pulses, &mut self.on_ns);
        let reached = self.bus.with(|segment| {
            let to = Nanos::from_micros(us).max(segment.now());
            segment.set_now(to);
            segment.chips_mut()[0].advance(to, &mut |edge| match edge.pin {
                _ if edge.channel.0 != WIRES[0] => {}
                Pin::High => *rose = edge.at.0,
                _ => (*pulses, *on_ns) = (*pulses + 1, *on_ns + edge.at.0 - *rose),
            });
            to
        });
        Instant::from_micros(reached.unwrap().0.div_ceil(1000))
    }

    fn apply(&mut self, update: &Guarded) {
        self.bank.apply(update).unwrap();
    }

    fn admit(&mut self, now: Instant, wires: &[u16], width: u16, length: Duration) {
        let stimulus = |&wire: &u16| Stimulus {
            wire,
            width: Ticks::new(width),
            peak: PEAK,
            at: now,
            until: now + length,
        };
        let stimuli: Vec<_> = wires.iter().map(stimulus).collect();
        self.guard.hear(now);
        let update = self.guard.admit(now, Board(0), &stimuli, |entry| {
            // The other wire's burst may be over its time.
            assert!(
                entry.reason.is_none() || entry.channel.0 != WIRES[0],
                "{entry:?}"
            );
        });
        self.apply(&update);
    }

    fn expire(&mut self, now: Instant) {
        let update = self.guard.expire(now, Board(0));
        self.apply(&update);
    }

    /// Energy, nJ, that the first wire's burst is booked with.
    fn booked_nj(&self, now: Instant) -> u64 {
        let left = self.guard.budget(0, now, now + Duration::from_micros(1));
        let row = left.unwrap().energy_nj[0];
        assert_eq!(row.0, Reason::Burst);
        HARD.burst_energy_nj - row.1
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_more_pulses_than_booked_and_exactly_as_many_from_a_held_counter(
        (hz, ppm, off) in (4_000_000u32..50_000_000, 0u32..3_000, -1.0f64..=1.0),
        pwm in 60.0f64..450.0,
        (immediate, fast) in (any::<bool>(), any::<bool>()),
        (pulses, width) in (1u64..20, 1u16..30),
        (before_us, gap_us, together) in (0u64..30_000, 0u64..60_000, any::<bool>()),
        (late_on, late_off) in (0u64..8_000, 0u64..8_000),
    ) {
        let prescale = Prescale::from_hz(Clock::external(hz, ppm).unwrap(), pwm).unwrap();
        let true_hz = (f64::from(hz) + f64::from(hz) * off * f64::from(ppm) * 1e-6).trunc() as u32;
        let updates = if immediate { UpdateModel::Immediate } else { UpdateModel::EndOfLow };
        let bus = if fast { BusClock::FastPlus } else { BusClock::Fast };
        let mut rig = Rig::new(prescale, true_hz, updates, bus);
        let period_us = prescale.period_ns() as f64 * 1e-3;
        let most = (38_000.0 / period_us + 0.5) as u64;
        let pulses = pulses.min(most);
        let length = prescale.counted(Duration::from_micros((pulses as f64 * period_us) as u64));

        // The wire beside it leaves the counter running, at any phase, or long held.
        let begun = rig.until(2_000);
        rig.admit(begun, &[1], width, Duration::from_micros(before_us));
        let end = begun + Duration::from_micros(before_us);
        let onset = end + Duration::from_micros(gap_us);
        let expired = (gap_us > 0).then(|| {
            let now = rig.until(end.as_micros());
            rig.expire(now);
            now
        });
        let lead = late_on / 8;
        let at = rig.until(onset.as_micros() + lead);
        rig.admit(at, if together { &[0, 1] } else { &[0] }, width, length);
        let off = rig.until((at + length).as_micros() + late_off);
        rig.expire(off);
        let booked = rig.booked_nj(off);
        rig.until(off.as_micros() + 4 * period_us as u64 + 1_000);

        let watts = PEAK.amps().powi(2) * f64::from(MILLIOHM) * 1e-3;
        let delivered = watts * rig.on_ns as f64;
        // Edges are whole nanoseconds.
        let rounding = watts * f64::from(rig.pulses) + 1.0;
        prop_assert!(delivered <= booked as f64 + rounding, "{} nJ delivered, {} booked", delivered, booked);

        let quiet = expired.is_none_or(|end| at.since(end).as_micros() as f64 > 2.0 * period_us + 1_000.0);
        let held = quiet && (before_us == 0 || expired.is_some());
        // What a host may be late: half a period, less the bus and what the tolerance comes to.
        let slack = period_us * (0.5 - 2e-6 * f64::from(ppm) * pulses as f64) - 1_010.0;
        if held && (late_off as f64) < slack {
            prop_assert_eq!(u64::from(rig.pulses), pulses);
            let exact = pulses as f64 * f64::from(width) / 4096.0 * period_us * 1e3 * watts;
            let excess = booked as f64 / exact - 1.0;
            let rounding = 1.5 / period_us + 2.0 / exact;
            prop_assert!(excess.abs() < 1.01e-6 * f64::from(ppm) + rounding, "booked {} too much", excess);
        }
    }
}
