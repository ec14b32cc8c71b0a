//! Hostile schedules: the same wishes for the guard to judge, and as raw register bytes without it.

use embedded_hal::i2c::I2c;
use palpate_core::codec::pca9685::{self as regs, mode1, mode2};
use palpate_core::driver::Actuators;
use palpate_core::driver::Pca9685Bank;
use palpate_core::guard::{Guard, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::random::RandomStream;
use palpate_core::schedule::Stimulus;
use palpate_core::texture::{Activation, Control, Draw, Pulses};
use palpate_core::units::{Board, Duration, Instant, Milliamps, Point, Prescale, Ticks};

use super::rig::{ADDRESS, Rig, WIRES, pick};

/// What a program wants of the wires.
#[derive(Clone, Debug)]
pub enum Wish {
    /// Pulses of a width on some wires for a while.
    Pulses {
        wires: u8,
        width: u16,
        until_us: u64,
    },
    /// The same, written register by register: mixed pairs are in force between.
    Torn {
        wires: u8,
        width: u16,
        until_us: u64,
    },
    /// On for good.
    FullOn { wires: u8 },
    /// Another PRE_SCALE.
    Prescale(u8),
    /// A clock that does not exist: the counter stands where it is.
    DeadClock,
    /// Everything off.
    Off,
}

/// Wishes with their times, in order.
pub type Schedule = Vec<(u64, Wish)>;

/// How a schedule is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Anything at any time.
    Wild,
    /// One or a few wires, burst after burst.
    Dwelling,
    /// A contact that moves on, with pauses.
    Moving,
    /// A texture's pulses, period by period, at any density there is.
    Textured,
}

fn near(s: &mut RandomStream, values: &[u64], spread: u64) -> u64 {
    let value = values[s.next_u64() as usize % values.len()];
    (value + s.next_u64() % (2 * spread + 1)).saturating_sub(spread)
}

/// Half of the time close to a boundary of a limit, else anything.
fn width(s: &mut RandomStream) -> u16 {
    let wanted = match s.next_u64() % 4 {
        0 => near(s, &[0, 2, 100, 148, 148, 149, 256, 2048, 4095], 1),
        1 => near(s, &[100, 148], 40),
        2 => s.next_u64() % 300,
        _ => s.next_u64() % 4097,
    };
    wanted.min(4096) as u16
}

fn length_us(s: &mut RandomStream) -> u64 {
    match s.next_u64() % 4 {
        0 => near(s, &[35_000, 48_300, 50_000, 50_000], 2),
        1 => near(s, &[5_000, 35_000, 50_000], 4_000),
        2 => s.next_u64() % 60_000,
        _ => s.next_u64() % 500_000,
    }
}

fn pause_us(s: &mut RandomStream) -> u64 {
    match s.next_u64() % 4 {
        0 => near(s, &[20_000, 21_700, 23_500, 58_500], 2),
        1 => near(s, &[20_000, 58_500], 3_000),
        2 => s.next_u64() % 5_000,
        _ => s.next_u64() % 120_000,
    }
}

fn wires(s: &mut RandomStream) -> u8 {
    match s.next_u64() % 4 {
        0 => 0xFF,
        1 => 1 << (s.next_u64() % 8),
        _ => (s.next_u64() & s.next_u64()) as u8,
    }
}

/// A texture beyond any that is rendered: any density up to every period, any stroke.
fn texture(s: &mut RandomStream) -> (Pulses, Control) {
    let beta = pick(s, 0.0, 0.999);
    let alpha = pick(s, 0.0, 0.9999 - beta);
    let lead = Duration::from_micros(s.next_u64() % 500_000);
    let interval = Duration::from_micros(1 + s.next_u64() % 2_000_000);
    let activation = Activation::new(alpha, beta, lead, interval).unwrap();
    let draw = if s.next_u64().is_multiple_of(2) {
        Draw::Bernoulli
    } else {
        Draw::Diffusion
    };
    let control = Control {
        delta_mu: Duration::from_micros(s.next_u64() % 500_000),
        sigma: Duration::from_micros(1 + s.next_u64() % 2_000_000),
        rate_mhz: pick(s, 1_000.0, 400_000.0) as u32,
    };
    let gaps: Vec<f32> = (0..WIRES).map(|n| (n % 4) as f32).collect();
    let carrier = Prescale::new(regs::PRE_SCALE_RESET);
    let pulses = Pulses::new(activation, draw, carrier, &gaps, s.next_u64());
    (pulses, control)
}

/// A schedule of `length_s` seconds.
pub fn draw(s: &mut RandomStream, kind: Kind, length_s: u64) -> Schedule {
    let mut schedule = Schedule::new();
    let mut at = 1_000;
    let mut place = s.next_u64() % 8;
    let fixed = (width(s), wires(s).max(1));
    let mut texture = (kind == Kind::Textured).then(|| texture(s));
    while at < length_s * 1_000_000 {
        let (wish, pause) = match kind {
            Kind::Textured => {
                let fired = texture.as_mut().map_or(0, |(pulses, control)| {
                    let fired = pulses.next(control).iter().enumerate();
                    fired.fold(0, |mask, (wire, on)| mask | u8::from(*on) << wire)
                });
                const PERIOD_US: u64 = 5_079;
                let wish = Wish::Pulses {
                    wires: fired,
                    width: fixed.0,
                    until_us: at + PERIOD_US,
                };
                (wish, PERIOD_US)
            }
            Kind::Wild => {
                let until_us = at + length_us(s);
                let (wires, width) = (wires(s), width(s));
                let wish = match s.next_u64() % 16 {
                    0 => Wish::FullOn { wires },
                    1 => Wish::Prescale(near(s, &[3, 30, 255], 3).clamp(3, 255) as u8),
                    2 => Wish::DeadClock,
                    3 => Wish::Off,
                    4..=6 => Wish::Torn {
                        wires,
                        width,
                        until_us,
                    },
                    _ => Wish::Pulses {
                        wires,
                        width,
                        until_us,
                    },
                };
                let overlap = s.next_u64().is_multiple_of(4);
                (
                    wish,
                    if overlap {
                        pause_us(s)
                    } else {
                        until_us - at + pause_us(s)
                    },
                )
            }
            Kind::Dwelling => {
                let wish = Wish::Pulses {
                    wires: fixed.1,
                    width: fixed.0,
                    until_us: at + 35_000,
                };
                (
                    wish,
                    if s.next_u64().is_multiple_of(200) {
                        3_000_000
                    } else {
                        58_500
                    },
                )
            }
            Kind::Moving => {
                if s.next_u64().is_multiple_of(6) {
                    place = (place + 1) % 8;
                }
                let pair = (1u8 << place) | (1 << ((place + 1) % 8));
                let wish = Wish::Pulses {
                    wires: pair,
                    width: fixed.0.min(200),
                    until_us: at + 35_000,
                };
                (
                    wish,
                    if s.next_u64().is_multiple_of(60) {
                        1_000_000
                    } else {
                        58_500
                    },
                )
            }
        };
        schedule.push((at, wish));
        at += pause.max(200);
    }
    schedule
}

/// The display that the guard protects.
pub fn display() -> Vec<DisplayWire> {
    let wire = |n: usize| DisplayWire {
        place: Point::new(n as f32, 0.0),
        board: Board(0),
        channel: Rig::channel(n),
    };
    (0..WIRES).map(wire).collect()
}

/// The guard of a rig.
pub fn guard(rig: &Rig) -> Guard {
    guard_of(rig, rig.parameters.worn())
}

/// A guard on a rig that takes its wires for others.
pub fn guard_of(rig: &Rig, worn: WornWire) -> Guard {
    let plant = Plant {
        prescale: rig.parameters.prescale,
        wire_milliohm: (rig.parameters.wire.resistance_ohm * 1e3).round() as u32,
        peak: rig.parameters.current,
        bus: Duration::ZERO,
    };
    Guard::new(rig.parameters.limits(), plant, &display(), worn).unwrap()
}

/// Plays a schedule through guard and driver. The host is at most `late_us` late with each call.
pub fn with_guard(rig: &mut Rig, schedule: &Schedule, s: &mut RandomStream, late_us: u64) -> Guard {
    let guard = guard(rig);
    through(guard, rig, schedule, s, late_us)
}

/// The same through some guard.
pub fn through(
    mut guard: Guard,
    rig: &mut Rig,
    schedule: &Schedule,
    s: &mut RandomStream,
    late_us: u64,
) -> Guard {
    let mut bank = Pca9685Bank::new(rig.bus.clone(), &[ADDRESS], rig.parameters.prescale);
    bank.start(Instant::ZERO).unwrap();
    rig.advance(rig.now() + 500_000);
    let mut host = |rig: &mut Rig, at: u64| {
        let late = if late_us > 0 {
            s.next_u64() % late_us
        } else {
            0
        };
        let ns = ((at + late) * 1000).max(rig.now());
        rig.advance(ns);
        Instant::from_micros(ns.div_ceil(1000))
    };
    for (at, wish) in schedule {
        while let Some(end) = guard.next_expiry().filter(|end| end.as_micros() <= *at) {
            let now = host(rig, end.as_micros());
            bank.apply(&guard.expire(now, Board(0))).unwrap();
        }
        let now = host(rig, *at);
        let (mask, width, until_us) = match *wish {
            Wish::Pulses {
                wires,
                width,
                until_us,
            }
            | Wish::Torn {
                wires,
                width,
                until_us,
            } => (wires, width, until_us),
            Wish::FullOn { wires } => (wires, 4096, u64::MAX),
            Wish::Prescale(_) | Wish::DeadClock => continue,
            Wish::Off => (0, 0, 0),
        };
        let stimuli: Vec<Stimulus> = (0..WIRES as u16)
            .filter(|wire| mask & (1 << wire) != 0)
            .map(|wire| Stimulus {
                wire,
                width: Ticks::new(width),
                peak: Milliamps(1),
                at: now,
                until: Instant::from_micros(until_us),
            })
            .collect();
        let update = guard.admit(now, Board(0), &stimuli, |_| ());
        bank.apply(&update).unwrap();
    }
    while let Some(end) = guard.next_expiry() {
        let now = host(rig, end.as_micros());
        bank.apply(&guard.expire(now, Board(0))).unwrap();
    }
    guard
}

/// Plays a schedule as register bytes until a limit is passed.
pub fn without_guard(rig: &mut Rig, schedule: &Schedule) {
    let mut bus = rig.bus.clone();
    let awake = mode1::AI | mode1::ALLCALL;
    bus.write(ADDRESS, &[regs::MODE1, awake, mode2::OUTDRV])
        .unwrap();
    rig.advance(rig.now() + 500_000);
    let off = [0, 0, 0, regs::FULL];
    let mut ends: Vec<(u64, u8)> = Vec::new();
    for (at, wish) in schedule {
        ends.sort_unstable();
        while let Some(&(end, mask)) = ends.first().filter(|end| end.0 <= *at) {
            ends.remove(0);
            let ns = (end * 1000).max(rig.now());
            rig.advance(ns);
            write(rig, mask, off, false);
        }
        rig.advance((at * 1000).max(rig.now()));
        rig.inspect();
        if rig.breach.is_some() {
            return;
        }
        match *wish {
            Wish::Pulses {
                wires,
                width,
                until_us,
            } => {
                write(rig, wires, pair(width), false);
                ends.push((until_us, wires));
            }
            Wish::Torn {
                wires,
                width,
                until_us,
            } => {
                write(rig, wires, pair(width), true);
                ends.push((until_us, wires));
            }
            Wish::FullOn { wires } => write(rig, wires, [0, regs::FULL, 0, 0], false),
            Wish::Prescale(value) => {
                for bytes in [
                    [regs::MODE1, awake | mode1::SLEEP],
                    [regs::PRE_SCALE, value],
                    [regs::MODE1, awake],
                ] {
                    bus.write(ADDRESS, &bytes).unwrap();
                }
                rig.advance(rig.now() + 500_000);
                bus.write(ADDRESS, &[regs::MODE1, awake | mode1::RESTART])
                    .unwrap();
            }
            Wish::DeadClock => {
                bus.write(ADDRESS, &[regs::MODE1, awake | mode1::SLEEP])
                    .unwrap();
                bus.write(
                    ADDRESS,
                    &[regs::MODE1, awake | mode1::SLEEP | mode1::EXTCLK],
                )
                .unwrap();
                bus.write(ADDRESS, &[regs::MODE1, awake | mode1::EXTCLK])
                    .unwrap();
            }
            Wish::Off => write(rig, 0xFF, off, false),
        }
    }
}

/// Registers of a pulse that starts where nothing staggers it.
fn pair(width: u16) -> [u8; 4] {
    let [low, high] = width.min(4095).to_le_bytes();
    [0, 0, low, high]
}

fn write(rig: &mut Rig, mask: u8, values: [u8; 4], torn: bool) {
    for wire in (0..WIRES as u8).filter(|wire| mask & (1 << wire) != 0) {
        let first = regs::led(wire);
        if torn {
            for (register, value) in (first..).zip(values) {
                rig.bus.write(ADDRESS, &[register, value]).unwrap();
            }
        } else {
            let [a, b, c, d] = values;
            rig.bus.write(ADDRESS, &[first, a, b, c, d]).unwrap();
        }
    }
}
