//! Datagrams that are malformed, forged, reordered, stale; hosts that lie; ends that die.

use super::*;

/// What a datagram may become on its way, or in the hands of a person who means harm.
fn spoil(s: &mut RandomStream, datagram: &mut Vec<u8>) {
    let length = datagram.len() as u64;
    let pick = |s: &mut RandomStream, n: u64| (s.next_u64() % n.max(1)) as usize;
    match s.next_u64() % 4 {
        0 => {
            let bit = pick(s, 8 * length);
            datagram[bit / 8] ^= 1 << (bit % 8);
        }
        1 => datagram.truncate(pick(s, length)),
        2 => {
            let more = pick(s, 40);
            datagram.extend((0..more).map(|n| n as u8));
            datagram.truncate(MOST);
            if more == 0 {
                datagram.pop();
            }
        }
        _ => {
            let from = pick(s, length);
            datagram[from..]
                .iter_mut()
                .for_each(|b| *b = s.next_u64() as u8);
        }
    }
}

#[test]
fn spoiled_and_repeated_datagrams_switch_nothing_on() {
    let mut rig = Rig::new();
    rig.run(50, true);
    rig.burst(0, &[1, 5], 100);
    rig.burst(1, &[9], 100);
    rig.run(300, true);
    assert!(!rig.any_on());
    let applied = rig.driver.status().unwrap().applied;
    let recorded = rig.seen.clone();
    let mut s = RandomStream::new(1, "spoiled datagrams");
    let mut refused = 0;
    for n in 0..100_000u64 {
        let mut datagram = recorded[(s.next_u64() as usize) % recorded.len()].clone();
        if n % 3 > 0 {
            spoil(&mut s, &mut datagram);
        }
        let knock = Header::read(&datagram).is_ok_and(|h| h.kind == Kind::Knock);
        refused += u32::from(!knock);
        rig.air.there.push_back(datagram);
        let now = rig.unit_now();
        rig.unit.turn(now, &mut rig.air);
        rig.air.back.clear();
        assert!(!rig.any_on(), "{n}");
    }
    rig.run(5, true);
    let status = rig.driver.status().unwrap();
    assert_eq!(status.applied, applied);
    assert!(status.refused >= refused, "{} {refused}", status.refused);
}

/// A host with the key that asks for anything, also for what no driver would.
struct Liar {
    key: Key,
    host: u64,
    unit: u64,
    sequence: u64,
    s: RandomStream,
}

impl Liar {
    fn planned(&mut self, now: Instant) -> Planned {
        let s = &mut self.s;
        let at = now.as_micros() + s.next_u64() % 20_000;
        let length = match s.next_u64() % 3 {
            0 => s.next_u64() % 5_000_000,
            _ => s.next_u64() % 60_000,
        };
        Planned {
            board: Board((s.next_u64() % 3) as u8),
            channel: Channel((s.next_u64() % 16) as u8),
            width: Ticks::new((s.next_u64() % 4097) as u16),
            current: Milliamps((s.next_u64() % 4097) as u32),
            at: Instant::from_micros(at.saturating_sub(3000)),
            until: Instant::from_micros(at + length),
        }
    }

    fn command(&mut self, now: Instant) -> Vec<u8> {
        self.sequence += 1;
        let count = self.s.next_u64() % 24;
        let plan: Vec<_> = (0..count).map(|_| self.planned(now)).collect();
        // Its readings are from the future, and every stop is seen.
        let reading = now + Duration::from_millis(self.s.next_u64() % 1_000_000);
        let header = Header {
            kind: Kind::Command,
            host: self.host,
            unit: self.unit,
            sequence: self.sequence,
        };
        let mut buffer = [0; MOST];
        let said = Said {
            reading,
            warmth: Some(Warmth {
                face_mc: (self.s.next_u64() % 65_536) as u16,
                ceiling_mc: u16::MAX,
            }),
            ..Said::default()
        };
        let write = |out: &mut [u8]| Command::write(out, &said, &plan);
        self.key.seal(&header, &mut buffer, write).to_vec()
    }
}

#[test]
fn a_host_that_lies_gets_nothing_over_a_limit() {
    let mut rig = Rig::new();
    let mut liar = Liar {
        key: Key::new(&KEY),
        host: 99,
        unit: 77,
        sequence: 0,
        s: RandomStream::new(2, "a host that lies"),
    };
    let widest = rig.guard.widest().get();
    // Of each wire: since when it is on without a gap of 15 ms, and when it was last on.
    let mut bursts = [(0u64, None); 16];
    let (mut on, mut charge) = (0u64, [0u64; 16]);
    for n in 0..100_000u64 {
        rig.now += 1000;
        let now = rig.unit_now();
        rig.air.there.push_back(liar.command(now));
        rig.unit.turn(now, &mut rig.air);
        rig.air.back.clear();
        let chips = rig.chips.0.borrow();
        for (wire, burst) in bursts.iter_mut().enumerate() {
            let width = chips.width(wire / 8, wire % 8);
            assert!(width <= widest, "{n}: {width} ticks");
            if width == 0 {
                continue;
            }
            on += 1;
            charge[wire] += u64::from(width);
            if burst.1.is_none_or(|last| rig.now > last + 15_000) {
                burst.0 = rig.now;
            }
            burst.1 = Some(rig.now);
            assert!(
                rig.now - burst.0 < 50_000,
                "{n}: wire {wire} for {} us",
                rig.now - burst.0
            );
        }
        if n % 10_000 == 9_999 {
            // Mean power over 10 s: I^2 R width / 4096.
            for charge in &mut charge {
                let uw = *charge * 990 * 990 * 1900 / 4096 / 10_000 / 1_000_000;
                assert!(uw <= 20_000, "{uw} uW");
                *charge = 0;
            }
        }
    }
    assert!(
        on > 10_000,
        "a test that drives nothing shows nothing: {on}"
    );
}

#[test]
fn whatever_dies_no_output_is_left_on() {
    let mut s = RandomStream::new(3, "deaths");
    for death in 0..200u64 {
        let mut rig = Rig::new();
        rig.run(50, true);
        let wire = (s.next_u64() % 16) as u16;
        rig.burst((wire / 8) as u8, &[wire], 100);
        rig.run(21 + s.next_u64() % 30, true);
        assert!(rig.any_on(), "{death}");
        let died = rig.now;
        match death % 5 {
            0 => rig.killed = true,
            1 => rig.cut = true,
            2 => {
                let wires = wires();
                let unit = Unit::new(
                    &settings(&wires, 200 + death),
                    rig.chips.clone(),
                    rig.chips.clone(),
                );
                rig.unit = unit.unwrap();
                let now = rig.unit_now();
                rig.unit.start(now);
            }
            3 => rig.chips.0.borrow_mut().reset(usize::from(wire / 8)),
            _ => rig.chips.0.borrow_mut().dead = true,
        }
        let mut last = died;
        for _ in 0..2000 {
            rig.step(death % 5 != 0);
            if rig.any_on() {
                last = rig.now;
            }
        }
        assert!(last - died <= 60_000, "{death}: on for {} us", last - died);
    }
}

#[test]
fn a_turn_opens_one_seal_and_does_what_is_due() {
    let mut rig = Rig::new();
    rig.run(50, true);
    rig.burst(0, &[3], 100);
    rig.run(30, true);
    assert!(rig.any_on());
    // Of the session, newer than anything, and forged: only the seal tells.
    let mut forged = rig.seen.last().unwrap().clone();
    forged[26] = 1;
    rig.air.there.extend((0..8).map(|_| forged.clone()));
    rig.now += 40_000;
    let now = rig.unit_now();
    rig.unit.turn(now, &mut rig.air);
    assert_eq!(rig.air.there.len(), 7);
    assert!(!rig.any_on());
}
