//! Random benches on chips that obey all-call and every sub-call: what the file check accepts drives exactly the
//! wires it names, and what it refuses would not.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::PathBuf;

use palpate_core::driver::{Actuators, Banks, Driver};
use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Instant, Milliamps, Ticks};
use palpate_files::{Bench as BenchFile, Loaded, Setup, Source, load_scene};
use palpate_run::plan;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::*;

/// Adapter, address, channel.
type Place = (u8, u8, u8);

/// The chips of a bench, one segment for each adapter.
struct Chips {
    /// By the adapter's name: two entries of one name are one segment.
    segments: Vec<(PathBuf, I2cHandle)>,
    /// Segment of each entry of the bench's adapters.
    of_bus: Vec<usize>,
    /// Adapter and address of every chip of a segment, in its order.
    names: Vec<Vec<(u8, u8)>>,
}

impl Chips {
    fn new(bench: &BenchFile) -> Self {
        let adapters = match &bench.real {
            Some(real) => real.i2c.clone(),
            None => vec![PathBuf::new()],
        };
        let mut paths: Vec<PathBuf> = Vec::new();
        let mut of_bus = Vec::new();
        for adapter in adapters {
            let known = paths.iter().position(|p| *p == adapter);
            of_bus.push(known.unwrap_or(paths.len()));
            if known.is_none() {
                paths.push(adapter);
            }
        }
        let mut names = vec![Vec::new(); paths.len()];
        let boards: BTreeSet<(u8, u8)> = bench.outputs.iter().map(|o| (o.bus, o.board)).collect();
        for (bus, board) in boards {
            names[of_bus[usize::from(bus)]].push((bus, board));
        }
        let segment = |(path, names): (PathBuf, &Vec<(u8, u8)>)| {
            let chips = names.iter().map(|n| Pca9685::new(Config::new(n.1)));
            let segment = I2cSegment::new(BusClock::Fast, chips.collect());
            (path, I2cHandle::new(segment))
        };
        let segments = paths.into_iter().zip(&names).map(segment).collect();
        Self {
            segments,
            of_bus,
            names,
        }
    }

    /// Has every chip obey all-call and all sub-calls, whatever its driver wrote.
    fn obey(&self) {
        use map::mode1::{AI, ALLCALL, SUB1, SUB2, SUB3};
        let all = |segment: &mut I2cSegment| {
            let now = segment.now();
            for chip in segment.chips_mut() {
                chip.start(now, chip.config().address, false);
                chip.write(now, map::MODE1);
                chip.write(now, AI | ALLCALL | SUB1 | SUB2 | SUB3);
                chip.stop(now);
            }
        };
        self.segments
            .iter()
            .for_each(|(_, bus)| bus.with(all).unwrap());
    }

    /// Lets time pass; which outputs rose.
    fn pass(&self, to: Instant) -> BTreeSet<Place> {
        let mut rose = BTreeSet::new();
        for ((_, bus), names) in self.segments.iter().zip(&self.names) {
            let mut sink = |chip: usize, edge: Edge| {
                if edge.pin == Pin::High {
                    rose.insert((names[chip].0, names[chip].1, edge.channel.0));
                }
            };
            bus.with(|segment| {
                segment.set_now(segment.now().max(Nanos::from_micros(to.as_micros())));
                segment.advance(segment.now(), &mut sink);
            })
            .unwrap();
        }
        rose
    }
}

/// Drives each wire of a bench alone through guard and driver; what rose each time, or what failed.
fn driven(file: BenchFile) -> Result<Vec<BTreeSet<Place>>, String> {
    let text = |e: &dyn std::fmt::Display| e.to_string();
    let chips = Chips::new(&file);
    let bench = Loaded {
        value: file,
        source: Source::new("b.toml", ""),
    };
    let setup = Setup::join(load_scene("idle").unwrap(), bench).map_err(|e| text(&e))?;
    let display = plan::display(&setup).map_err(|e| text(&e))?;
    let bench = &setup.bench.value;
    let prescale = plan::prescale(bench).map_err(|e| text(&e))?;
    let plant = Plant {
        prescale,
        wire_milliohm: 1900,
        peak: Milliamps(990),
        bus: palpate_core::units::Duration::ZERO,
    };
    let mut guard = Guard::new(HARD, plant, display.wires(), WornWire::default())
        .map_err(|e| format!("{e:?}"))?;
    let buses = plan::buses(bench);
    let lines = (chips.of_bus.iter().zip(&buses))
        .map(|(segment, addresses)| (chips.segments[*segment].1.clone(), addresses.as_slice()));
    let mut banks = Banks::new(lines, prescale);
    banks.start(Instant::ZERO).map_err(|e| text(&e))?;
    chips.obey();
    let mut now = Instant::from_micros(20_000);
    let mut found = Vec::new();
    for (index, wire) in display.wires().iter().enumerate() {
        chips.pass(now);
        guard.hear(now);
        let stimulus = Stimulus {
            wire: index as u16,
            width: Ticks::new(50),
            peak: Milliamps(990),
            at: now,
            until: now + palpate_core::units::Duration::from_millis(35),
        };
        let update = guard.admit(now, wire.board, &[stimulus], |_| ());
        banks.apply(&update).map_err(|e| text(&e))?;
        now += palpate_core::units::Duration::from_millis(35);
        let rose = chips.pass(now);
        guard.hear(now);
        let update = guard.release(now, wire.board);
        banks.apply(&update).map_err(|e| text(&e))?;
        now += palpate_core::units::Duration::from_millis(15);
        found.push(rose);
    }
    Ok(found)
}

/// What each wire of a bench names.
fn named(bench: &BenchFile) -> Vec<BTreeSet<Place>> {
    let place = |o: &palpate_files::Output| BTreeSet::from([(o.bus, o.board, o.channel)]);
    bench.outputs.iter().map(place).collect()
}

/// A bench file: an emulated one without adapters, else a real one.
fn text(adapters: &[String], outputs: &[Place]) -> String {
    let mut text = String::from(
        "name = \"random\"\ndescription = \"Eight wires anywhere\"\ndisplay = \"thimble-8\"\n\
         wire = { kind = \"final-75um\", alloy = \"low\" }\n\
         drive = { current_ma = 990.0, supply_limit_ma = 4000.0 }\n",
    );
    if !adapters.is_empty() {
        text += &format!("kind = \"real\"\nreal = {{ can = [\"can0\"], i2c = {adapters:?} }}\n");
    }
    for (bus, board, channel) in outputs {
        text += &format!("[[outputs]]\nbus = {bus}\nboard = {board:#04x}\nchannel = {channel}\n");
    }
    text
}

/// Adapters, some spelled twice, and eight outputs, most of them on few chips.
fn benches() -> impl Strategy<Value = String> {
    let adapter = (1..9u8, any::<bool>())
        .prop_map(|(n, dot)| format!("/dev/{}i2c-{n}", if dot { "./" } else { "" }));
    let board = prop_oneof![
        40 => prop::sample::select(vec![0x40, 0x41, 0x5A, 0x6F, 0x73, 0x75, 0x77]),
        1 => prop::sample::select(vec![0x70, 0x71, 0x72, 0x74]),
        1 => 0..=0x7F_u8,
    ];
    let outputs = prop::collection::vec((0..3_u8, board, 0..16_u8), 8);
    (prop::collection::vec(adapter, 0..4), outputs).prop_map(|(adapters, mut outputs)| {
        let buses = adapters.len().max(1) as u8;
        outputs.iter_mut().for_each(|o| o.0 %= buses);
        text(&adapters, &outputs)
    })
}

#[test]
fn what_is_accepted_drives_exactly_the_wires_it_names() {
    let accepted = Cell::new(0);
    let mut runner = TestRunner::new(ProptestConfig::with_cases(400));
    let result = runner.run(&benches(), |text| {
        if let Ok(bench) = BenchFile::read(&Source::new("b.toml", text)) {
            accepted.set(accepted.get() + 1);
            prop_assert_eq!(Ok(named(&bench)), driven(bench));
        }
        Ok(())
    });
    result.unwrap();
    let accepted = accepted.get();
    assert!((100..350).contains(&accepted), "{accepted} of 400");
}

#[test]
fn what_is_refused_drives_a_neighbour_or_fails() {
    let good: Vec<Place> = (0..8).map(|n| (0, 0x41, n)).collect();
    let two = || vec!["/dev/i2c-1".to_owned(), "/dev/i2c-2".to_owned()];
    let read = |text: String| BenchFile::read(&Source::new("b.toml", text));
    let bench = read(text(&two(), &good)).unwrap();
    assert_eq!(driven(bench.clone()), Ok(named(&bench)));
    for shared in [0x70, 0x71, 0x72, 0x74] {
        let mut aliased = bench.clone();
        aliased.outputs[0].board = shared;
        assert_ne!(driven(aliased.clone()), Ok(named(&aliased)), "{shared:#x}");
    }
    let mut one_channel = bench.clone();
    one_channel.outputs[1].channel = 0;
    assert!(driven(one_channel).is_err());
    let mut one_adapter = bench.clone();
    one_adapter.outputs[1].bus = 1;
    assert_eq!(driven(one_adapter.clone()), Ok(named(&one_adapter)));
    one_adapter.real.as_mut().unwrap().i2c[1] = "/dev/i2c-1".into();
    assert_ne!(driven(one_adapter.clone()), Ok(named(&one_adapter)));
}
