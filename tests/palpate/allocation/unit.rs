//! A driver unit allocates nothing once it is built: through stimuli, stops, spoiled datagrams and a dead bus.

use palpate_core::codec::link::Request;
use palpate_core::guard::WornWire;
use palpate_core::random::RandomStream;
use palpate_tests::unit::{Host, LetterBox, plan, unit};

use super::*;

/// Where the unit's clock stands at its start.
const START: Instant = Instant::from_micros(1_000_000);

/// Makes the datagram that lies in the box another one: a bit, its end, its version, all of it.
fn spoil(s: &mut RandomStream, letters: &mut LetterBox) {
    let mut pick = |n: usize| (s.next_u64() % n as u64) as usize;
    let (kind, length) = (pick(4), 1 + pick(1400));
    let there = letters.there();
    match kind {
        0 => there[pick(44)] ^= 1 << pick(8),
        1 => {}
        2 => (there[2], there[3]) = (2, 1),
        _ => there.iter_mut().for_each(|byte| *byte = pick(256) as u8),
    }
    letters.waits = Some(length);
}

#[test]
fn a_unit_allocates_nothing_once_built() {
    for worn in [None, Some(WornWire::default())] {
        let answers = Cell::new(true);
        let mut unit = unit(worn, &answers).unwrap();
        let (mut host, mut letters) = (Host::default(), LetterBox::default());
        let mut s = RandomStream::new(1, "datagrams to a unit");
        let before = ALLOCATIONS.with(Cell::get);
        unit.start(START);
        host.knock(&mut letters);
        unit.turn(START, &mut letters);
        host.greet(&letters).unwrap();
        for ms in 1..10_000u64 {
            let now = START + Duration::from_millis(ms);
            answers.set(!(7000..7700).contains(&ms));
            let stops = unit.counts().stops;
            // The host is silent for 300 ms, then stops the unit; later the bus is dead. Its end is the third stop.
            match ms {
                3000..3300 => {}
                5000 => host.command(&mut letters, now, (stops, Request::Stop), &[]),
                _ if ms % 100 == 50 => host.knock(&mut letters),
                _ if ms % 5 == 0 => {
                    let onset = START + Duration::from_millis(ms.div_ceil(100) * 100);
                    host.command(&mut letters, now, (stops, Request::Play), &plan(onset));
                }
                _ if ms % 5 == 3 => spoil(&mut s, &mut letters),
                _ => {}
            }
            unit.turn(now, &mut letters);
        }
        unit.end(START + Duration::from_millis(10_000));
        let spent = ALLOCATIONS.with(Cell::get) - before;
        let counts = unit.counts();
        assert!(counts.applied > 1000 && counts.limited > 0, "{counts:?}");
        assert!(counts.refused > 1000 && counts.stops == 3, "{counts:?}");
        assert!(letters.answers > 1500, "{}", letters.answers);
        assert_eq!(spent, 0, "thermal rows: {worn:?}");
    }
}
