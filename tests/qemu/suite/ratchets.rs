//! What an image may take: flash, memory, instructions. Each number may fall, and no number may rise without a reason; they
//! stand in `ratchets.toml` with the compiler that they are of.

use std::collections::BTreeMap;
use std::path::Path;

use palpate_core::codec::link::{HEADER, MOST};
use palpate_core::units::{Board, Duration, Instant, Ticks};
use palpate_emulators::time::Nanos;
use palpate_image::Question;
use palpate_qemu::{Image, Machine, free_of};
use serde::Deserialize;

use super::decisions::Pair;
use super::face::cooling;
use super::machines::{PICO, image, in_qemu, met};
use super::sessions::play;

/// The numbers of a machine's images.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    compiler: String,
    figures: BTreeMap<String, u64>,
}

/// Bytes of flash, and instructions per admitted stimulus, that no compiler excuses.
const MOST_FLASH: u64 = 256 * 1024;
const MOST_ADMIT: u64 = 20_000;

/// Instructions that the image's clock counted.
fn instructions(machine: &Machine, ticks: u32) -> u64 {
    (u64::from(ticks) * machine.tick_ns) >> machine.shift
}

/// A guard's onsets in an image.
struct Onsets {
    pair: Pair,
    at: Instant,
}

impl Onsets {
    /// Lets a time pass in which the unit turns and the skin is read.
    fn pass(&mut self, ms: u64) {
        for _ in 0..ms / 10 {
            self.at += Duration::from_millis(10);
            for question in [Question::Hear, Question::Watch, Question::Expire(Board(0))] {
                self.pair.ask(self.at, &question);
            }
        }
    }

    /// Instructions of an onset of these wires, each for 38 ms.
    fn instructions(&mut self, wires: impl Iterator<Item = u16>) -> u64 {
        let one = |wire| (wire, Ticks::new(60), Duration::from_millis(38));
        let stimuli: Vec<_> = wires.map(one).collect();
        let took = self
            .pair
            .ask(self.at, &Question::Change(Board(0), &stimuli));
        assert!(
            self.pair.here().next_expiry().is_some(),
            "nothing was admitted"
        );
        instructions(self.pair.machine(), took)
    }
}

/// Instructions per stimulus that a guard admits: the mean and the most of bursts of one wire after the other, as a contact
/// that moves asks for them; of eight at once; of one after 11 s of quiet.
fn admitted(machine: Machine) -> [u64; 4] {
    let mut onsets = Onsets {
        pair: Pair::new(machine),
        at: Instant::from_micros(1000),
    };
    let turns: Vec<u64> = (0..200)
        .map(|n| {
            onsets.pass(60);
            onsets.instructions(std::iter::once(n % 8))
        })
        .collect();
    let mean = turns.iter().sum::<u64>() / 200;
    let most = turns.into_iter().max().unwrap_or(0);
    onsets.pass(60);
    let together = onsets.instructions(0..8) / 8;
    onsets.pass(11_000);
    let quiet = onsets.instructions(std::iter::once(0));
    [mean, most, together, quiet]
}

/// Instructions until a forged datagram of the greatest length is refused.
fn forged(machine: Machine) -> u64 {
    let mut run = met(machine, true);
    run.run(Duration::from_millis(100)).unwrap();
    let mut datagram = run.host.sent.last().unwrap()[..HEADER].to_vec();
    // Of this session, and newer than anything: the seal alone tells.
    datagram[26] = 1;
    datagram.resize(MOST, 0x55);
    run.longest = Nanos::ZERO;
    for _ in 0..64 {
        run.host.injected.push_back(datagram.clone());
    }
    run.run(Duration::from_millis(500)).unwrap();
    assert!(run.host.injected.is_empty());
    assert_eq!(run.chips.boots.len(), 1);
    run.longest.0 >> machine.shift
}

/// Instructions from a look at the thermistors to the current that it comes to: a turn of the regulator that cools.
fn regulated(machine: Machine) -> u64 {
    let run = cooling(machine);
    let chips = &run.chips;
    let took = |look: &Nanos| {
        let set = chips.currents.iter().find(|current| current.at >= *look);
        set.map(|current| current.at.since(*look).0)
    };
    let longest = chips.looks.iter().filter_map(took).max();
    longest.unwrap_or(0) >> machine.shift
}

fn measured(machine: Machine) -> (String, BTreeMap<String, u64>) {
    let (from, length) = machine.memory;
    let unit = Image::read(&image(&machine, "unit"), from).unwrap();
    let lockstep = Image::read(&image(&machine, "lockstep"), from).unwrap();
    let mut run = cooling(machine);
    play(&mut run, 20);
    let command = run.longest.0 >> machine.shift;
    run.chips.dead = true;
    run.run(Duration::from_millis(50)).unwrap();
    let free = free_of(&run.memory().unwrap(), &lockstep) as u64;
    let stack = length as u64 - lockstep.variables - free;
    let [admit, admit_most, admit_of_eight, admit_after_11_s] = admitted(machine);
    let figures = [
        ("flash", unit.flash),
        ("variables", unit.variables),
        ("stack", stack),
        ("admit", admit),
        ("admit_most", admit_most),
        ("admit_of_eight", admit_of_eight),
        ("admit_after_11_s", admit_after_11_s),
        ("command", command),
        ("forged", forged(machine)),
        ("regulated", regulated(machine)),
    ];
    let named = figures.map(|(name, figure)| (name.to_owned(), figure));
    (unit.compiler, named.into())
}

/// The image for a Cortex-M0+ runs in an emulator that counts no instructions: its size alone is held.
#[test]
fn a_pico_takes_no_more_than_it_did() {
    let pico = Image::read(&image(&PICO, "pico"), PICO.memory.0).unwrap();
    let figures = [("flash", pico.flash), ("variables", pico.variables)];
    let figures = figures.map(|(name, figure)| (name.to_owned(), figure));
    hold(&PICO, &pico.compiler, &figures.into());
}

in_qemu!(an_image_takes_no_more_than_it_did);

fn an_image_takes_no_more_than_it_did(machine: Machine) {
    let (compiler, figures) = measured(machine);
    assert!(figures["admit"] <= MOST_ADMIT, "{}", figures["admit"]);
    let [variables, stack] = ["variables", "stack"].map(|name| figures[name]);
    assert!(variables + stack <= machine.memory.1 as u64);
    hold(&machine, &compiler, &figures);
}

/// Holds figures of a compiler against those that are written down.
fn hold(machine: &Machine, compiler: &str, figures: &BTreeMap<String, u64>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("ratchets.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let kept: BTreeMap<String, Kept> = toml::from_str(&text).unwrap();
    let kept = &kept[machine.name];
    println!("{}, rustc {compiler}: {figures:#?}", machine.name);
    assert!(figures["flash"] <= MOST_FLASH, "{}", figures["flash"]);
    if compiler != kept.compiler {
        println!(
            "ratchets.toml is of rustc {}: no ratchet for this one",
            kept.compiler
        );
        return;
    }
    let mut worse = Vec::new();
    for (name, figure) in figures {
        let most = kept.figures.get(name).copied().unwrap_or(0);
        match figure.cmp(&most) {
            std::cmp::Ordering::Greater => worse.push(format!("{name}: {figure}, was {most}")),
            std::cmp::Ordering::Less => {
                println!("ratchets.toml: tighten {name} from {most} to {figure}");
            }
            std::cmp::Ordering::Equal => {}
        }
    }
    assert!(worse.is_empty(), "say in ratchets.toml why: {worse:?}");
}
