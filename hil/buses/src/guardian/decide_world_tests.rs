//! The guardian's decisions in a world drawn at random: buses that hang or fail, a run that dies, hangs, trips, stops, leaves or
//! sleeps, and what it had on its way. Nothing may stay on for longer than its bus cannot be reached, and 50 ms.

use proptest::prelude::*;

use super::*;

/// What becomes of the run at a time.
#[derive(Clone, Copy, Debug)]
enum Blow {
    /// Its end closes; it is gone so much later.
    Dies(u64),
    /// It falls silent and drives on.
    Hangs,
    /// It cannot switch off.
    Trips,
    /// It stops, and lives.
    Stops,
    /// It ends in order.
    Leaves,
    /// Another program wants everything off.
    Ended,
    /// The machine sleeps.
    Sleeps,
}

/// A stretch in which a bus cannot be reached, and whether it hangs or answers with an error.
type Dead = (u64, u64, bool);

#[derive(Clone, Debug)]
struct Drawn {
    blow: Blow,
    at: u64,
    dead: Vec<Vec<Dead>>,
    /// Microseconds after the blow at which something of the run that was on its way arrives, by bus.
    strays: Vec<Option<u64>>,
    /// How long it takes to kill the run.
    dies_in: u64,
}

fn blow() -> impl Strategy<Value = Blow> {
    prop_oneof![
        (0..2_000_000_u64).prop_map(Blow::Dies),
        Just(Blow::Hangs),
        Just(Blow::Trips),
        Just(Blow::Stops),
        Just(Blow::Leaves),
        Just(Blow::Ended),
        Just(Blow::Sleeps),
    ]
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let dead = (0..400_000_u64, 1..3_000_000_u64, any::<bool>());
    let dead = proptest::collection::vec(dead, 0..3);
    (1..4_usize).prop_flat_map(move |buses| {
        (
            blow(),
            100_000..150_000_u64,
            proptest::collection::vec(dead.clone(), buses),
            proptest::collection::vec(proptest::option::of(0..600_000_u64), buses),
            0..100_000_u64,
        )
            .prop_map(|(blow, at, dead, strays, dies_in)| Drawn {
                blow,
                at,
                dead,
                strays,
                dies_in,
            })
    })
}

/// What a transfer takes.
const TRANSFER: u64 = 1000;

/// The hands of the guardian in this world. Latch and words may hang for ever: nothing comes back of them.
struct World<'a> {
    drawn: &'a Drawn,
    now: u64,
    /// When the order of a bus is carried out, and whether it succeeds.
    orders: Vec<Option<(u64, bool)>>,
    killed: Option<u64>,
    ended: bool,
}

impl World<'_> {
    /// When a bus can be reached that cannot be now, and whether it hangs until then.
    fn dead_until(&self, bus: usize, from: u64) -> Option<(u64, bool)> {
        let dead = self.drawn.dead[bus].iter();
        let now = dead.filter(|(start, length, _)| (*start..start + length).contains(&from));
        now.map(|(start, length, hangs)| (start + length, *hangs))
            .max()
    }
}

impl Post for World<'_> {
    fn cut(&mut self, _cut: bool) -> bool {
        true
    }

    fn off(&mut self, bus: usize) {
        assert!(self.orders[bus].is_none(), "an order at a time");
        let mut from = self.now;
        let mut done = true;
        while let Some((until, hangs)) = self.dead_until(bus, from) {
            if !hangs {
                done = false;
                break;
            }
            from = until;
        }
        self.orders[bus] = Some((from + TRANSFER, done));
    }

    fn kill(&mut self) {
        let _ = self.killed.get_or_insert(self.now + self.drawn.dies_in);
    }

    fn latch(&mut self, _cause: &Cause, _verified: bool) {}

    fn tell(&mut self, _cause: &Cause, _news: News) {}

    fn answer(&mut self, answer: Answer, _cause: Option<&Cause>) {
        self.ended |= answer == Answer::Off;
    }
}

/// For each bus when it went on and off, and since when it is still on; and the end.
type Played = (Vec<Vec<(u64, u64)>>, Vec<Option<u64>>, u64);

/// Plays a world until its guardian ends.
fn play(drawn: &Drawn) -> Played {
    let buses = drawn.dead.len();
    let mut world = World {
        drawn,
        now: 0,
        orders: vec![None; buses],
        killed: None,
        ended: false,
    };
    let mut decider = Decider::new(buses, Duration::from_millis(30));
    let (mut on, mut offs) = (vec![Some(0); buses], vec![Vec::new(); buses]);
    let (mut next_beat, mut struck, mut gone) = (0, false, None);
    let mut strays: Vec<Option<u64>> = drawn
        .strays
        .iter()
        .map(|stray| stray.map(|after| drawn.at + after))
        .collect();
    let mut slept = 0;
    loop {
        let orders = world.orders.iter().flatten().map(|order| order.0);
        let blow = (!struck).then_some(drawn.at);
        let beat = (next_beat < u64::MAX).then_some(next_beat);
        let others = [blow, beat, gone, world.killed].into_iter().flatten();
        let arrive = strays.iter().flatten().copied();
        let all = orders.chain(others).chain(arrive);
        let now = all
            .fold(decider.next().as_micros(), u64::min)
            .max(world.now);
        world.now = now;
        let time = |slept: u64| Now {
            at: Instant::from_micros(now),
            asleep: Duration::from_micros(slept),
        };
        for bus in 0..buses {
            // What the run had on its way arrives while it is not gone.
            if strays[bus].is_some_and(|at| at <= now) {
                strays[bus] = None;
                if world.dead_until(bus, now).is_none() {
                    on[bus].get_or_insert(now);
                }
            }
            if let Some((_, done)) = world.orders[bus].filter(|order| order.0 <= now) {
                world.orders[bus] = None;
                if done && let Some(since) = on[bus].take() {
                    offs[bus].push((since, now));
                }
                decider.step(time(slept), Event::Swept { bus, off: done }, &mut world);
            }
        }
        if next_beat <= now {
            next_beat = now + 6000;
            decider.step(time(slept), Event::Beat, &mut world);
        }
        if !struck && drawn.at <= now {
            struck = true;
            let quiet = matches!(
                drawn.blow,
                Blow::Dies(_) | Blow::Hangs | Blow::Trips | Blow::Leaves
            );
            if quiet {
                next_beat = u64::MAX;
            }
            // A run that promises drives nothing any more.
            if matches!(drawn.blow, Blow::Trips | Blow::Stops | Blow::Leaves) {
                strays.fill(None);
            }
            let event = match drawn.blow {
                Blow::Dies(after) => {
                    gone = Some(now + after);
                    Event::Closed
                }
                Blow::Hangs => Event::Time,
                Blow::Trips => Event::Trip("it cannot"),
                Blow::Stops => Event::Stop("stale-input"),
                Blow::Leaves => Event::Bye,
                Blow::Ended => Event::Ended,
                Blow::Sleeps => {
                    slept = 3_000_000;
                    Event::Time
                }
            };
            decider.step(time(slept), event, &mut world);
        }
        let dead = [gone, world.killed]
            .into_iter()
            .flatten()
            .any(|at| at <= now);
        if dead {
            (gone, world.killed, next_beat) = (None, Some(u64::MAX), u64::MAX);
            strays.fill(None);
            decider.step(time(slept), Event::Gone, &mut world);
        }
        decider.step(time(slept), Event::Time, &mut world);
        let over = match drawn.blow {
            // The run lives on, with its outputs off.
            Blow::Stops | Blow::Sleeps => now > drawn.at + 8_000_000,
            _ => decider.end().is_some(),
        };
        if over {
            assert!(decider.end().is_none() || world.ended);
            return (offs, on, now);
        }
        assert!(now < 60_000_000, "it never ends");
    }
}

/// From the blow the run is silent for, at most, a heartbeat.
const NOTICED: u64 = 31_000;
/// What has to be met beyond the time that a bus cannot be reached.
const BOUND: u64 = 50_000;

proptest! {
    #[test]
    fn nothing_stays_on_for_longer_than_its_bus_is_unreachable_and_50_ms(drawn in drawn()) {
        let (offs, on, end) = play(&drawn);
        for (bus, still) in on.iter().enumerate() {
            prop_assert_eq!(*still, None, "bus {} is left on at {}", bus, end);
            for &(since, off) in &offs[bus] {
                // From the moment at which the guardian could know, or the outputs went on after that.
                let hangs = matches!(drawn.blow, Blow::Hangs);
                let known = drawn.at + if hangs { NOTICED } else { 0 };
                let from = since.max(known);
                let dead = drawn.dead[bus].iter().map(|&(start, length, _)| {
                    (start + length).min(off).saturating_sub(start.max(from))
                });
                let allowed = from + dead.sum::<u64>() + BOUND;
                prop_assert!(off <= allowed, "bus {} went off at {}, allowed {}", bus, off, allowed);
            }
        }
    }
}
