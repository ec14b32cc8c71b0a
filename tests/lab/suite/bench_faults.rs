//! What a bench can do to a run: transfers that fail, an adapter that is unplugged, a chip that loses its
//! supply, two adapters, a second program. The emulator's own record is the judge.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fmt::Write;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use serde_json::Value;

use super::emulator::{Emulator, at};
use super::tools::{hil, in_lab, number_of, scene, scratch, sh, text, try_sh, vcan};
use super::ward::{Fate, LIMIT_NS, Moments, TooSlow, Ward, fate, now_ns, patiently, unlatch};

const KINDS: [&str; 5] = [
    "i2c-address-nack",
    "i2c-data-nack",
    "i2c-eio",
    "i2c-arbitration-loss",
    "i2c-stuck",
];

/// The scene of the suite with a bus that fails `count` times, each time for 0.25 to 0.45 s at a random moment,
/// and with a supply that dips once between two of them.
fn scene_with_faults(count: u64, moments: &mut Moments) -> String {
    let mut scene = std::fs::read_to_string(scene("press.toml")).unwrap();
    for n in 0..count {
        let at = 1.5 * n as f64 + 1.0 + moments.below(Duration::from_millis(400)).as_secs_f64();
        let until = at + 0.25 + moments.below(Duration::from_millis(200)).as_secs_f64();
        let kind = KINDS[n as usize % KINDS.len()];
        let rate = if kind == "i2c-stuck" {
            ""
        } else {
            "rate = 1.0\n"
        };
        let fault = format!(
            "\n[[faults]]\nat_s = {at:.4}\nuntil_s = {until:.4}\nkind = \"{kind}\"\n{rate}"
        );
        scene.push_str(&fault);
    }
    let at = 1.5 * count as f64 + 1.0;
    write!(
        scene,
        "\n[[faults]]\nat_s = {at:.4}\nkind = \"brown-out\"\nboard = 0\n"
    )
    .unwrap();
    let file = scratch("faults.toml");
    std::fs::write(&file, scene).unwrap();
    file.display().to_string()
}

#[test]
fn a_bus_that_fails_has_its_outputs_cut_by_oe_and_comes_back() {
    if !in_lab("I2C errors with an OE line") {
        return;
    }
    patiently(bus_fails);
}

fn bus_fails() -> Result<(), TooSlow> {
    let count = number_of("PALPATE_DEATHS", 20);
    let faults = scene_with_faults(count, &mut Moments(3));
    let mut ward = Ward::open(&faults, &["--oe"]);
    let mut run = ward.run(&scene("press.toml"), &[]);
    let started = now_ns();
    let whole = Duration::from_millis(1500 * count + 3000);
    while now_ns() - started < whole.as_nanos() as u64 {
        ward.emulator.hear(Duration::from_millis(200));
    }
    let driven = ward.emulator.told.last().map(at);
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.end();
    let said = ward.said();
    ward.check_speed()?;
    assert!(ended.success(), "{ended}: {said}");
    assert!(matches!(ward.fate(0), Fate::Off(_)));

    let told = &ward.emulator.told;
    let is_high = |t: &&Value| t["event"] == "edge" && t["high"] == true;
    let ends = |t: &Value| {
        t["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("fault over"))
    };
    let begins: Vec<&Value> = told
        .iter()
        .filter(|t| t["event"] == "fault" && !ends(t))
        .collect();
    let mut delays = Vec::new();
    for fault in &begins[..count as usize] {
        let over = told
            .iter()
            .find(|t| ends(t) && at(t) > at(fault))
            .map_or(u64::MAX, at);
        let within = |t: &&Value| at(t) > at(fault) && at(t) < over;
        let last = told.iter().filter(within).filter(is_high).map(at).max();
        let delay = last.map_or(0, |last| last - at(fault));
        assert!(
            delay <= LIMIT_NS,
            "{fault}: driven {} ms later",
            delay / 1_000_000
        );
        delays.push(delay as f64 * 1e-6);
    }
    delays.sort_by(f64::total_cmp);
    println!(
        "I2C errors with an OE line: {count} times, last pulse {:.1} ms after (median), {:.1} ms at worst",
        delays[delays.len() / 2],
        delays[delays.len() - 1]
    );
    assert_eq!(begins.len() as u64, count + 1, "{begins:?}");
    let cuts = told
        .iter()
        .filter(|t| t["event"] == "oe" && t["high"] == true)
        .count();
    assert!(cuts as u64 >= count, "{cuts} cuts");
    // Each time the boards were started anew, after the dip of the supply as well, and driven again.
    let anew = said.matches("started anew").count();
    assert!(anew as u64 > count, "{anew} times: {said}");
    assert!(
        driven > begins.last().map(|t| at(t) + LIMIT_NS),
        "driven on after the last fault"
    );
    ward.emulator.stop();
    Ok(())
}

#[test]
fn an_adapter_that_was_unplugged_and_comes_back_is_switched_off_first() {
    if !in_lab("an adapter unplugged") {
        return;
    }
    patiently(unplug);
}

fn unplug() -> Result<(), TooSlow> {
    let press = scene("press.toml");
    let mut ward = Ward::open(&press, &[]);
    let mut moments = Moments(5);
    let mut run = ward.run(&press, &[]);
    let driver = "/sys/bus/hid/drivers/mcp2221";
    let device = sh(&format!("ls {driver} | grep -m1 04D8"));
    let mut delays = Vec::new();
    let (count, mut ends) = (number_of("PALPATE_DEATHS", 20), 0);
    for n in 0..count {
        ward.wait_for_outputs(true)?;
        std::thread::sleep(moments.below(Duration::from_millis(234)));
        std::fs::write(format!("{driver}/unbind"), device.trim()).unwrap();
        std::thread::sleep(moments.below(Duration::from_millis(500)));
        ward.emulator.hear(Duration::from_millis(50));
        let was_on = ward.emulator.is_driving;
        let back = now_ns();
        std::fs::write(format!("{driver}/bind"), device.trim()).unwrap();
        if was_on {
            let from = ward.emulator.told.len();
            ward.emulator.wait_for("all_off");
            let off = ward.emulator.told[from..].last().map_or(0, at);
            delays.push(off.saturating_sub(back) as f64 * 1e-6);
        }
        // A wire that was on meanwhile was so for too long, which ends the run. A transfer that was under way hangs in the
        // kernel's driver for 4 s; a run gives up after 3 s without its bus, and the guardian switches off.
        for _ in 0..20 {
            ward.emulator.hear(Duration::from_millis(50));
            if run.child.try_wait().unwrap().is_some() {
                break;
            }
        }
        if run.child.try_wait().unwrap().is_some() {
            let (ended, said) = (run.end(), ward.said());
            let is_known = match ended.code() {
                Some(1) => said.contains("overrun: wire"),
                Some(3) => said.contains("no answer from the adapter in time"),
                _ => false,
            };
            assert!(is_known, "{n}: {ended}: {said}");
            assert!(matches!(ward.fate(0), Fate::Off(_)), "{n}: {said}");
            ward.unlatch();
            ends += 1;
            run = ward.run(&press, &[]);
        }
    }
    kill(run.pid(), Signal::SIGINT).unwrap();
    let ended = run.end();
    assert!(ended.success(), "{ended}: {}", ward.said());
    assert!(matches!(ward.fate(0), Fate::Off(_)));
    delays.sort_by(f64::total_cmp);
    println!(
        "unplugged: {count} times, {} with an output on; off {:.1} ms after it came back (median), {:.1} ms at worst; {ends} ended the run",
        delays.len(),
        delays.get(delays.len() / 2).unwrap_or(&f64::NAN),
        delays.last().unwrap_or(&f64::NAN)
    );
    ward.emulator.stop();
    Ok(())
}

#[test]
fn a_second_program_on_the_bus_is_refused_and_a_stop_is_refused_until_it_is_cleared() {
    if !in_lab("two programs, a latched stop") {
        return;
    }
    patiently(second_program);
}

fn second_program() -> Result<(), TooSlow> {
    let press = scene("press.toml");
    let mut ward = Ward::open(&press, &[]);
    let mut run = ward.run(&press, &[]);
    let second = ward.command(&press, &[]).output().unwrap();
    let said = text(&second.stderr);
    ward.check_speed()?;
    assert_eq!(second.status.code(), Some(3), "{said}");
    let who = format!("in use by process {} (hil)", run.guardian);
    assert!(said.contains(&who), "{said}");
    assert!(run.child.try_wait().unwrap().is_none(), "the first goes on");
    ward.check_speed()?;
    kill(run.pid(), Signal::SIGKILL).unwrap();
    run.end();

    // The stop outlives everybody: refused, shown, cleared by one command.
    let refused = ward.command(&press, &[]).output().unwrap();
    let said = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(4), "{said}");
    assert!(
        said.contains("the run died without a word") && said.contains("hil off --unlatch"),
        "{said}"
    );
    let (hil, bench) = (hil().display(), ward.bench().display());
    let doctor = text(&try_sh(&format!("{hil} doctor --bench {bench}")).stdout);
    assert!(
        doctor.contains("stopped earlier: the run died without a word"),
        "{doctor}"
    );
    let kept = sh(&format!("{hil} off --bench {bench}"));
    assert!(kept.contains("stays latched"), "{kept}");
    let cleared = sh(&format!("{hil} off --unlatch --bench {bench}"));
    assert!(cleared.contains("the stop is cleared"), "{cleared}");
    let doctor = text(&try_sh(&format!("{hil} doctor --bench {bench}")).stdout);
    assert!(!doctor.contains("stopped earlier"), "{doctor}");

    // A chip that a crashed program left driving is found and switched off before anything else.
    ward.emulator.hear(Duration::ZERO);
    sh(&format!(
        "i2ctransfer -y {} w3@0x40 0x00 0x21 0x04",
        ward.emulator.number()
    ));
    sh(&format!(
        "i2ctransfer -y {} w5@0x40 0x12 0 0 50 0",
        ward.emulator.number()
    ));
    ward.emulator.wait_for("driving");
    let mut run = ward.run_until("all_off", &press, &[]);
    ward.emulator.wait_for("driving");
    assert!(
        ward.said()
            .contains("0x40: was driving channels 3; switched off"),
        "{}",
        ward.said()
    );
    kill(run.pid(), Signal::SIGTERM).unwrap();
    let ended = run.end();
    ward.check_speed()?;
    assert!(ended.success());
    ward.emulator.stop();
    Ok(())
}

#[test]
fn two_adapters_are_driven_at_once_and_switched_off_at_once() {
    if !in_lab("two adapters") {
        return;
    }
    patiently(two_adapters);
}

fn two_adapters() -> Result<(), TooSlow> {
    let press = scene("press.toml");
    vcan("vcan1");
    let mut other = Emulator::start(&["--await-start", "--scene", &press, "--can", "vcan1"]);
    unlatch(&other.node);
    let mut ward = Ward::open(&press, &[]);
    let bench = std::fs::read_to_string(ward.bench()).unwrap();
    let node = format!("\"{}\"", ward.emulator.node);
    let mut bench = bench.replace(&node, &format!("{node}, \"{}\"", other.node));
    for channel in 4..8 {
        let output = format!("board = 0x40\nchannel = {channel}\n");
        bench = bench.replace(&output, &format!("bus = 1\n{output}"));
    }
    std::fs::write(ward.bench(), bench).unwrap();
    let mut run = ward.run(&press, &[]);
    other.wait_for("driving");
    kill(run.pid(), Signal::SIGKILL).unwrap();
    run.end();
    assert!(matches!(ward.fate(0), Fate::Off(_)), "first bus");
    assert!(matches!(fate(&mut other, 0), Fate::Off(_)), "second bus");
    ward.unlatch();
    unlatch(&other.node);
    let pulses = |record: &Value| {
        let wires = record["wires"].as_array().unwrap();
        wires
            .iter()
            .map(|w| w["pulses"].as_u64().unwrap())
            .collect::<Vec<_>>()
    };
    let (first, second) = (pulses(&ward.emulator.stop()), pulses(&other.stop()));
    println!("two adapters: pulses {first:?} and {second:?}");
    assert!(
        first[..4].iter().any(|p| *p > 0) && first[4..].iter().all(|p| *p == 0),
        "{first:?}"
    );
    assert!(
        second[4..].iter().any(|p| *p > 0) && second[..4].iter().all(|p| *p == 0),
        "{second:?}"
    );
    Ok(())
}
