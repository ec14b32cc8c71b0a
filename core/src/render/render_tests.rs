//! Tests of `mod.rs`: what every wire gets, and that the guard has nothing left to change.

use super::*;
use crate::guard::{Cause, HARD, Plant, WornWire};
use crate::illusion::{Display, DisplayWire, ModelSettings, inverse};
use crate::schedule::{Entry, Stimulus};
use crate::units::{Board, Channel, Milliamps, Point};

/// Gap of the array below, mm.
const GAP: f32 = 9.0;

/// Two by four wires, their guard and their renderer at the published current.
struct Rig {
    guard: Guard,
    renderer: Renderer,
    now: Instant,
}

impl Rig {
    fn new(style: Style) -> Self {
        let wire = |n: u8| DisplayWire {
            place: Point::new(GAP * f32::from(n % 2), GAP * f32::from(n / 2)),
            board: Board(0),
            channel: Channel(n),
        };
        let display = Display::new(&core::array::from_fn::<_, 8, _>(|n| wire(n as u8))).unwrap();
        let pattern = Pattern::new(CADENCE, 2).unwrap();
        let plant = Plant {
            prescale: pattern.prescale(),
            peak: Milliamps(1970),
            ..Plant::default()
        };
        let guard = Guard::new(HARD, plant, display.wires(), WornWire::default()).unwrap();
        let settings = RenderSettings {
            law: inverse(&display, &ModelSettings::default()).unwrap(),
            style,
            pattern,
            full: Response::linear(guard.widest()).largest(),
            response: Response::linear(guard.widest()),
            sharing: Sharing::default(),
            calibration: Calibration::even(8),
        };
        Self {
            renderer: Renderer::new(settings, &guard, 8),
            guard,
            now: Instant::from_micros(1_000_000),
        }
    }

    /// One onset, through the guard, which must change nothing; what every wire got.
    fn onset(&mut self, contacts: &[Point]) -> [Volley; 8] {
        self.weighted(contacts, 1.0)
    }

    /// The same for contacts of this weight.
    fn weighted(&mut self, contacts: &[Point], weight: f32) -> [Volley; 8] {
        self.now += CADENCE;
        self.guard.hear(self.now);
        let target = |place: &Point| Target {
            place: *place,
            weight,
        };
        let targets: vec::Vec<Target> = contacts.iter().map(target).collect();
        let volleys = self.renderer.render(self.now, &targets, None, &self.guard);
        let volleys: [Volley; 8] = volleys.try_into().unwrap();
        let stimulus = |(wire, volley): (usize, &Volley)| Stimulus {
            wire: wire as u16,
            width: volley.width,
            peak: Milliamps(1970),
            at: self.now,
            until: self.now + volley.length,
        };
        let on = volleys
            .iter()
            .enumerate()
            .filter(|(_, v)| v.width > Ticks::ZERO);
        let stimuli: vec::Vec<Stimulus> = on.map(stimulus).collect();
        let (at, mut touched) = (self.now, vec::Vec::<Entry>::new());
        self.guard.admit(at, Board(0), &stimuli, |entry| {
            if entry.reason.is_some() {
                touched.push(entry);
            }
        });
        while let Some(end) = self.guard.next_expiry() {
            self.guard.expire(end, Board(0));
        }
        assert_eq!(touched, [], "{at}");
        volleys
    }

    /// Felt energy over one wire's at full level, and the energy centroid, of linear wires.
    fn felt(&self, volleys: &[Volley; 8]) -> (f32, Point) {
        let period = self.guard.prescale().period_ns() / 1000;
        let full = f32::from(self.renderer.width(1.0).get());
        let (mut all, mut x, mut y) = (0.0, 0.0, 0.0);
        for (n, volley) in volleys.iter().enumerate() {
            let pulses = volley.length.as_micros().div_ceil(period) as f32;
            let width = f32::from(volley.width.get()) / full;
            let energy = pulses * width * width;
            all += energy;
            x += energy * GAP * (n % 2) as f32;
            y += energy * GAP * (n / 2) as f32;
        }
        (all / 3.0, Point::new(x / all, y / all))
    }
}

/// Decibels of an energy.
fn db(energy: f32) -> f32 {
    10.0 * libm::log10f(energy)
}

#[test]
fn a_contact_that_rests_ten_minutes_stays_felt_where_it_is() {
    let places = [
        Point::new(0.0, GAP),
        Point::new(GAP / 2.0, GAP),
        Point::new(GAP / 2.0, 1.5 * GAP),
        Point::new(0.3 * GAP, 0.0),
    ];
    for style in Style::ALL {
        for place in places {
            let mut rig = Rig::new(style);
            let start = rig.now;
            let mut settled = None;
            while rig.now.since(start) < Duration::from_millis(600_000) {
                let volleys = rig.onset(&[place]);
                let (energy, felt) = rig.felt(&volleys);
                assert!(felt.distance(place) < 1.0, "{felt:?} for {place:?}");
                if rig.now.since(start) > Duration::from_millis(5000) {
                    let settled = *settled.get_or_insert(energy);
                    let change = db(energy) - db(settled);
                    assert!(
                        change.abs() < 1.0,
                        "{change} dB at {} for {place:?}",
                        rig.now
                    );
                }
            }
        }
    }
}

#[test]
fn a_scale_rises_by_no_more_than_a_difference_that_is_just_noticeable() {
    let mut rig = Rig::new(Style::Smooth);
    for _ in 0..100 {
        rig.onset(&[Point::new(0.0, GAP)]);
    }
    // Off to a wire that has rested.
    let (mut last, mut most) = (None, 0.0f32);
    for step in 0..60 {
        let y = GAP + 2.0 * GAP * (step as f32 / 30.0).min(1.0);
        let volleys = rig.onset(&[Point::new(0.0, y)]);
        let (energy, _) = rig.felt(&volleys);
        most = most.max(energy);
        let last = last.replace(energy).unwrap_or(energy);
        // The widths of weak wires are whole ticks: half a decibel.
        assert!(
            db(energy) - db(last) < 1.65 + 0.5,
            "{} dB",
            db(energy) - db(last)
        );
    }
    assert!(db(most) > -2.0, "recovers: {} dB", db(most));
}

#[test]
fn many_contacts_share_the_fingertip_in_proportion() {
    let mut rig = Rig::new(Style::Smooth);
    let all: [Point; 8] =
        core::array::from_fn(|n| Point::new(GAP * (n % 2) as f32, GAP * (n / 2) as f32));
    for _ in 0..600 {
        let volleys = rig.onset(&all);
        let widths = volleys.map(|v| v.width.get());
        let (least, most) = (widths.iter().min().unwrap(), widths.iter().max().unwrap());
        assert!(*least > 0 && most - least <= 1, "{widths:?}");
    }
}

#[test]
fn a_tap_has_the_level_of_a_vibration_and_two_pulses() {
    let on_wire = Point::new(0.0, GAP);
    let (mut smooth, mut tap) = (Rig::new(Style::Smooth), Rig::new(Style::Tap));
    let second = |rig: &mut Rig| [(); 2].map(|()| rig.onset(&[on_wire]))[1];
    let (long, short) = (second(&mut smooth), second(&mut tap));
    let (one, other) = (smooth.felt(&long).0, tap.felt(&short).0);
    assert!(
        (db(one) - db(other)).abs() < 1.0,
        "{} {}",
        db(one),
        db(other)
    );
    // Two and a half periods, one and a half.
    let thirds = (3 * long[2].length.as_micros()).abs_diff(5 * short[2].length.as_micros());
    assert!(thirds < 9, "{long:?} {short:?}");
}

#[test]
fn a_weight_is_heard_as_a_level() {
    let mut last = None;
    for weight in [0.35, 0.5, 0.7, 1.0] {
        let mut rig = Rig::new(Style::Smooth);
        let volleys = rig.weighted(&[Point::new(0.0, GAP)], weight);
        let level = db(rig.felt(&volleys).0) - db(weight * weight);
        // Half a tick of 15 is 0.3 dB.
        let last: f32 = last.replace(level).unwrap_or(level);
        assert!(
            (level - last).abs() < 0.6,
            "{weight}: {level} dB and {last} dB over the weight"
        );
    }
}

/// A person adds up the energy of bursts with a leak of 0.2 s: the first one stands alone.
#[test]
fn a_contacts_first_burst_is_as_much_stronger_as_it_stands_alone() {
    let mut rig = Rig::new(Style::Smooth);
    rig.renderer.settings.full /= 4.0;
    let here = [Point::new(0.0, GAP)];
    let [first, second] = [(); 2].map(|()| {
        let volleys = rig.onset(&here);
        rig.felt(&volleys).0
    });
    let left = libm::expf(-0.117 / 0.2);
    let alone = 10.0 * libm::log10f(1.0 / (1.0 - left));
    let stronger = db(first) - db(second);
    // Half a tick of 6, twice.
    assert!((stronger - alone).abs() < 1.4, "{stronger} dB, {alone} dB");
}

#[test]
fn a_level_asked_for_takes_no_more() {
    let mut rig = Rig::new(Style::Smooth);
    rig.renderer.settings.full /= 4.0;
    for place in [Point::new(0.0, GAP), Point::new(GAP / 2.0, 1.5 * GAP)] {
        let [_, volleys] = [(); 2].map(|()| rig.onset(&[place]));
        let level = db(rig.felt(&volleys).0);
        // Half a tick of 6.
        assert!(level.abs() < 0.9, "{level} dB at {place:?}");
    }
    assert_eq!(
        rig.renderer.reached(),
        Reached {
            onsets: 4,
            ..Reached::default()
        }
    );
}

/// Beside a test that plays ten minutes: what a contact at rest settles at is what the arithmetic says.
#[test]
fn what_is_borne_at_rest_is_what_a_contact_settles_at() {
    for style in Style::ALL {
        let mut rig = Rig::new(style);
        let Borne {
            once,
            moving,
            resting,
        } = rig.renderer.borne();
        assert!(resting < moving && moving <= once, "{style:?}");
        let mut level = 0.0;
        for _ in 0..1000 {
            let volleys = rig.onset(&[Point::new(0.0, GAP)]);
            level = db(rig.felt(&volleys).0);
        }
        let told = 2.0 * db(resting);
        assert!(
            (level - told).abs() < 1.0,
            "{style:?}: {level} dB, {told} dB"
        );
        let reached = rig.renderer.reached();
        assert!(
            reached.onsets == 1000 && reached.weaker > 900,
            "{reached:?}"
        );
        assert!(
            (2.0 * db(reached.least / resting)).abs() < 1.4,
            "{reached:?}"
        );
    }
}

#[test]
fn a_latched_guard_gets_nothing() {
    let mut rig = Rig::new(Style::Smooth);
    rig.guard.latch(Cause::End);
    let target = Target {
        place: Point::new(0.0, 0.0),
        weight: 1.0,
    };
    let volleys = rig.renderer.render(rig.now, &[target], None, &rig.guard);
    assert!(volleys.iter().all(|v| v.width == Ticks::ZERO));
}

/// While the guard is latched there is nothing to render; afterwards a contact is felt again within a second.
#[test]
fn a_contact_comes_back_after_a_stop() {
    let mut rig = Rig::new(Style::Smooth);
    let here = [Point::new(GAP, GAP)];
    let before = rig.onset(&here)[3].width;
    assert!(before > Ticks::ZERO);
    rig.guard.latch(Cause::ActuatorError);
    rig.guard.all_off(rig.now);
    assert_eq!(rig.onset(&here), [Volley::default(); 8]);
    let _ = rig.guard.watch(rig.now);
    rig.guard.reset(rig.now).unwrap();
    let first = rig.onset(&here)[3].width;
    assert!(first > Ticks::ZERO && first < before);
    let after = (0..9).map(|_| rig.onset(&here)[3].width).last();
    // As many onsets that nothing stopped.
    let mut whole = Rig::new(Style::Smooth);
    let whole = (0..12).map(|_| whole.onset(&here)[3].width).last();
    let regained = f32::from(after.unwrap().get()) / f32::from(whole.unwrap().get());
    assert!(regained > 0.9, "{regained}");
}
