//! Motors from a bench file to emulated chips: the driver of core over the emulated bus, and whole runs.

use embedded_hal::delay::DelayNs;
use palpate_core::driver::{
    Actuators, DriverError, HapticChannel, HapticFault, HapticMotor, HapticPlanError,
};
use palpate_files::{Bench, Loaded, Overrides, Scene, Source};
use palpate_records::verdict::Verdict;

use super::*;
use crate::{Input, Outcome, run};

/// A setup on a bench of motors, and its motors.
fn lra_8() -> (Setup, BenchHaptics) {
    let setup = Setup::load("sphere-along", "lra-8").unwrap();
    let haptics = setup.bench.value.haptics.clone().unwrap();
    (setup, haptics)
}

/// Motors at rest on the bus of a bench, with their drivers, which are awake.
fn worn() -> (WornMotors, Haptics<I2cHandle>, Vec<HapticChannel>) {
    let (setup, haptics) = lra_8();
    let (motor, contact) = (motors::motor(&haptics), motors::contact(&haptics));
    let worn = WornMotors::new(&motor, contact, &motors::places(&setup, &haptics));
    let channels = motors::channels(&haptics);
    worn.bus().delay_ms(1);
    let driver = Haptics::new(worn.bus(), &channels).unwrap();
    (worn, driver, channels)
}

fn with(changes: &[&str]) -> Setup {
    let mut overrides = Overrides::default();
    for change in changes {
        overrides.set("--set", change).unwrap();
    }
    lra_8().0.with(&overrides).unwrap()
}

fn ran(setup: &Setup) -> Outcome {
    run(setup, &Input::Scene, 1).unwrap()
}

#[test]
fn the_stored_calibration_is_the_one_that_every_chip_finds() {
    let (worn, mut driver, channels) = worn();
    for (number, channel) in (0..).zip(&channels) {
        let found = driver.calibrate(number, &mut worn.bus()).unwrap();
        assert_eq!(found, channel.calibration, "actuator {number}");
    }
}

#[test]
fn a_scene_is_felt_where_it_touches_and_no_limit_is_passed() {
    let outcome = ran(&lra_8().0);
    let summary = &outcome.summary;
    assert_eq!(
        summary.conclusion.verdict,
        Verdict::Ok,
        "{:?}",
        summary.conclusion
    );
    assert_eq!(
        summary.onsets.felt,
        Some(summary.onsets.meant - summary.onsets.unfound)
    );
    let everywhere = summary.felt_error_mm.everywhere.as_ref().unwrap();
    assert!(
        everywhere.rmse < 0.5 && everywhere.onsets > 150,
        "{everywhere:?}"
    );
    // Far over threshold, unlike wires.
    assert!(summary.felt.level_db.as_ref().unwrap().p5 > 40.0);
    assert_eq!(summary.margins.len(), 3);
    assert!(
        summary.margins.iter().all(|m| !m.over()),
        "{:?}",
        summary.margins
    );
    let report = summary.motors.as_ref().unwrap();
    assert!(
        report.face_um > 20.0 && report.exposure_m_s2 > 0.0,
        "{report:?}"
    );
}

/// A host that records, and counts the stimuli in its pieces.
struct Counts(u64);

impl crate::Host for Counts {
    fn records(&self) -> bool {
        true
    }

    fn record(&mut self, piece: crate::Piece) -> Result<(), Failure> {
        let stimuli = piece.events.iter();
        self.0 += stimuli.filter(|e| matches!(e, Event::Schedule(_))).count() as u64;
        Ok(())
    }
}

#[test]
fn a_record_that_grows_has_every_stimulus() {
    let keep = Keep {
        summary: true,
        ..Keep::default()
    };
    let mut host = Counts(0);
    let outcome = crate::run_with(&lra_8().0, &Input::Scene, 1, keep, &mut host).unwrap();
    assert!(host.0 > 500);
    assert_eq!(host.0, outcome.summary.stimuli);
}

#[test]
fn laws_put_the_centroid_that_they_are_made_for_at_the_contact() {
    let errors = |law: &str| {
        let setup = with(&[&format!("illusion.model=\"{law}\"")]);
        let summary = ran(&setup).summary;
        let of = |error: &crate::FeltError| error.rmse.unwrap();
        (
            of(&summary.felt_error_mm),
            of(&summary.felt_error_amplitude_mm),
        )
    };
    let (energy, amplitude) = errors("energy");
    assert!(
        energy < 0.5 && energy < 0.5 * amplitude,
        "{energy} {amplitude}"
    );
    let (energy, amplitude) = errors("linear");
    assert!(
        amplitude < 0.5 && amplitude < 0.5 * energy,
        "{energy} {amplitude}"
    );
    let (nearest, _) = errors("nearest");
    assert!(nearest > 2.0, "{nearest}");
}

#[test]
fn limits_of_motors_hold_behind_the_guard() {
    let free = ran(&lra_8().0);
    let face_um = free.summary.motors.as_ref().unwrap().face_um;
    let half = format!("bench.haptics.travel_um={}", 0.5 * face_um);
    let bound = ran(&with(&[&half]));
    assert!(bound.summary.limiter_events > 0);
    assert!(
        bound.summary.margins.iter().all(|m| !m.over()),
        "{:?}",
        bound.summary.margins
    );
    let reasons = bound.trace.events.iter().filter_map(|event| match event {
        Event::Schedule(entry) => entry.reason,
        _ => None,
    });
    let displacement = palpate_core::schedule::Reason::Displacement;
    assert!(reasons.into_iter().all(|reason| reason == displacement));
}

#[test]
fn a_law_of_wires_a_texture_and_a_look_on_are_refused() {
    let mut inverse = Overrides::default();
    inverse.set("--set", "illusion.model=\"inverse\"").unwrap();
    let refused = lra_8().0.with(&inverse).unwrap_err().to_string();
    assert!(
        refused.contains("energy, linear") && refused.contains("inverse"),
        "{refused}"
    );
    let texture = Setup::load("texture-wood", "lra-8")
        .unwrap_err()
        .to_string();
    assert!(
        texture.contains("texture: expected nothing on a bench of motors"),
        "{texture}"
    );
    let observed = lra_8().0.observed().unwrap_err().to_string();
    assert!(observed.contains("only a guard of wires"), "{observed}");
}

/// A bench of motors with these lines, refused.
fn refused(lines: &str) -> String {
    let text = format!("name = \"mine\"\ndescription = \"d\"\n{lines}");
    let bench = Bench::read(&Source::new("b.toml", text));
    bench.unwrap_err().to_string()
}

#[test]
fn benches_that_cannot_be_are_refused_in_a_sentence() {
    let table = [
        (
            "[haptics]\nrated_v = 0.0\n",
            "b.toml:4: haptics.rated_v: expected a number from 0.1",
        ),
        (
            "drive.current_ma = 900.0\n[haptics]\n",
            "b.toml:3: drive: expected nothing beside [haptics]: a finger has actuators of one kind",
        ),
        (
            "[haptics]\ndrivers = [{ switch = 0x70 }]\n",
            "expected 8 drivers",
        ),
        (
            "[haptics]\ndrivers = [{}, {}]\n",
            "every DRV2605L answers at 0x5a",
        ),
        (
            "[haptics]\ndrivers = [{ switch = 0x70, channel = 3 }, { switch = 0x70, channel = 3 }]\n",
            "motor 0 has this channel of this switch",
        ),
        (
            "[haptics]\ndrivers = [{ switch = 0x60 }]\n",
            "haptics.drivers[0].switch",
        ),
        ("kind = \"real\"\n[haptics]\n", "kind"),
    ];
    for (lines, wanted) in table {
        let found = refused(lines);
        assert!(found.contains(wanted), "{lines}: {found}");
    }
}

#[test]
fn drivers_that_cannot_be_are_refused_by_the_driver_too() {
    let (worn, _, channels) = worn();
    let new = |channels: &[HapticChannel]| Haptics::new(worn.bus(), channels).unwrap_err();
    let twice = [channels[0], channels[0]];
    assert_eq!(new(&twice), HapticPlanError::ChannelTwice(1, 0, 0x70));
    let mut alone = [channels[0], channels[1]];
    alone[1].behind = None;
    assert_eq!(new(&alone), HapticPlanError::NoSwitch(1));
    let mut nowhere = [channels[0]];
    nowhere[0].behind = Some((0x70, 8));
    assert_eq!(new(&nowhere), HapticPlanError::NoChannel(0, 8, 0x70));
    let mut slow = [channels[0]];
    slow[0].motor = HapticMotor::Lra {
        rated_v: 1.0,
        overdrive_v: 2.0,
        resonance_hz: 50.0,
    };
    assert_eq!(new(&slow), HapticPlanError::Resonance(0, 50.0));
    slow[0].motor = HapticMotor::Erm {
        rated_v: 0.0,
        overdrive_v: 2.0,
    };
    assert!(matches!(
        new(&slow),
        HapticPlanError::Voltage(0, "rated", ..)
    ));
}

/// A run with a fault of motor 1 from 3 s on.
fn faulty(kind: &str) -> Outcome {
    let setup = lra_8().0;
    let scene = setup.scene.source.text();
    let faults = format!("{scene}\n[[faults]]\nat_s = 3.0\nkind = \"{kind}\"\nmotor = 1\n");
    let source = Source::new("s.toml", faults);
    let value = Scene::read(&source).unwrap();
    let bench = palpate_files::load_bench("lra-8").unwrap();
    let setup = Setup::join(Loaded { value, source }, bench).unwrap();
    ran(&setup)
}

#[test]
fn a_motor_that_does_not_move_is_missed_where_it_is() {
    for kind in ["motor-open", "motor-stuck"] {
        let summary = faulty(kind).summary;
        let error = summary.felt_error_mm.rmse.unwrap();
        assert!(error > 1.0, "{kind}: {error}");
    }
}

#[test]
fn a_hot_driver_and_a_stuck_switch_end_the_run() {
    for (kind, wanted) in [
        ("driver-hot", "actuator 1: its driver is over temperature"),
        ("switch-stuck", "answers; the switch is stuck"),
    ] {
        let outcome = faulty(kind);
        let failure = outcome.failure.map(|f| f.to_string()).unwrap_or_default();
        assert!(failure.contains(wanted), "{kind}: {failure}");
        assert!(outcome.summary.sim_s < 4.0, "{kind}");
    }
}

#[test]
fn a_chip_that_lost_its_settings_is_found_and_started_anew() {
    let (worn, mut driver, _) = worn();
    driver.start(Instant::ZERO).unwrap();
    driver.verify().unwrap();
    // A brown-out of chip 5.
    let now = worn.bus().with(|bus| bus.now()).unwrap();
    worn.on_chip(5, |chip| chip.power_cycle(now)).unwrap();
    worn.bus().delay_ms(1);
    let fault = driver.verify().unwrap_err();
    assert!(
        matches!(fault, DriverError::Haptic(HapticFault::Readback(5, ..))),
        "{fault}"
    );
    driver.start(Instant::ZERO).unwrap();
    driver.verify().unwrap();
}

#[test]
fn all_off_brings_every_motor_to_rest() {
    let (mut worn, mut driver, _) = worn();
    driver.start(Instant::ZERO).unwrap();
    let mut bus = worn.bus();
    // Channel 2 at full level, past the guard: this is no driver of hardware.
    bus.write(0x70, &[1 << 2]).unwrap();
    bus.write(0x5A, &[0x02, 127]).unwrap();
    let at = |worn: &mut WornMotors, ms: u64| {
        let now = worn.bus().with(|bus| bus.now()).unwrap() + Nanos::from_micros(1000 * ms);
        worn.advance(now).unwrap();
        let mut um = 0.0;
        worn.on_chip(2, |chip| um = 1e6 * chip.motor().amplitude_m())
            .unwrap();
        um
    };
    let driven = at(&mut worn, 60);
    driver.all_off().unwrap();
    let braked = at(&mut worn, 60);
    assert!(driven > 50.0 && braked < 0.1 * driven, "{driven} {braked}");
}
