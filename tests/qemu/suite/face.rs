//! The Peltier module of an image: what fails there, and what it costs.

use palpate_core::codec::link::Warmth;
use palpate_core::peltier::{PeltierReason, SensorFault};
use palpate_core::units::Duration;
use palpate_emulators::display::peltier::{ModuleState, Peltier};
use palpate_emulators::time::Nanos;
use palpate_qemu::{Chips, Lockstep, Machine};

use super::machines::{PICO, in_qemu, met_on};
use super::sessions::play;

in_qemu! {
    a_thermistor_that_fails_switches_the_bridge_off
    a_dead_host_leaves_no_current_100_ms_after_its_last_reading
    a_unit_that_hangs_leaves_no_current_after_its_reset
    pulses_are_on_time_beside_it
}

/// A genuine converter, a genuine PWM and a genuine watchdog.
mod pico {
    use super::PICO;

    #[test]
    fn a_thermistor_that_fails_switches_the_bridge_off() {
        super::a_thermistor_that_fails_switches_the_bridge_off(PICO);
    }

    #[test]
    fn a_dead_host_leaves_no_current_100_ms_after_its_last_reading() {
        super::a_dead_host_leaves_no_current_100_ms_after_its_last_reading(PICO);
    }

    #[test]
    fn a_unit_that_hangs_leaves_no_current_after_its_reset() {
        super::a_unit_that_hangs_leaves_no_current_after_its_reset(PICO);
    }
}

fn ms(n: u64) -> Duration {
    Duration::from_millis(n)
}

fn module(run: &mut Lockstep) -> &mut Peltier {
    run.chips.module.as_mut().unwrap()
}

fn now(run: &Lockstep) -> ModuleState {
    run.chips.module.as_ref().unwrap().state()
}

/// A unit whose module cools, for half a second already.
pub fn cooling(machine: Machine) -> Lockstep {
    let mut run = met_on(machine, Chips::new(true).warm());
    run.host.driver.warm(Some(Warmth {
        face_mc: 20_000,
        ceiling_mc: 41_000,
    }));
    run.run(ms(500)).unwrap();
    let state = now(&run);
    assert!(state.milliamps > 200 && state.face_c < 32.8, "{state:?}");
    run
}

fn a_thermistor_that_fails_switches_the_bridge_off(machine: Machine) {
    let mut run = cooling(machine);
    for (fault, within) in [
        (SensorFault::Open, 40),
        (SensorFault::Short, 40),
        (SensorFault::Stale, 140),
    ] {
        // What converts on the processor itself does not stand still.
        if fault == SensorFault::Stale && !machine.is_qemu() {
            continue;
        }
        module(&mut run).set_sensor(Some(fault));
        run.run(ms(within)).unwrap();
        assert_eq!(now(&run).milliamps, 0, "{fault:?}");
        run.run(ms(30)).unwrap();
        let face = run.host.driver.status().unwrap().face;
        let told = (0, 0, Some(PeltierReason::Sensor(fault)));
        assert_eq!((face.face_mc, face.milliamps, face.reason), told);
        module(&mut run).set_sensor(None);
        run.run(ms(900)).unwrap();
        assert_eq!(now(&run).milliamps, 0, "{fault:?}");
        run.run(ms(200)).unwrap();
        assert!(now(&run).milliamps > 0, "{fault:?}");
    }
    assert_eq!(run.chips.boots.len(), 1);
}

fn a_dead_host_leaves_no_current_100_ms_after_its_last_reading(machine: Machine) {
    let mut run = cooling(machine);
    let died = run.now();
    run.host.lives = false;
    run.run(ms(300)).unwrap();
    let currents = &run.chips.currents;
    let last = currents.iter().rposition(|c| c.milliamps != 0).unwrap();
    let off = currents[last + 1].at;
    assert!(currents[last].at > died);
    assert!(off.since(died) <= Nanos(100_000_000), "{off:?} {died:?}");
    assert_eq!(now(&run).milliamps, 0);
}

fn a_unit_that_hangs_leaves_no_current_after_its_reset(machine: Machine) {
    let mut run = cooling(machine);
    // The next transfer never ends.
    run.chips.stuck = true;
    assert_eq!(run.host.burst(0, &[3], 60, ms(38)), Ok(1));
    run.run(ms(200)).unwrap();
    let [_, again] = run.chips.boots[..] else {
        panic!("{:?}", run.chips.boots);
    };
    let first = run.chips.currents.iter().find(|c| c.at >= again).unwrap();
    assert_eq!(first.milliamps, 0);
    let took = first.at.since(again).0;
    assert!(took <= 2_000_000, "{took}");
    // The host finds it again and goes on.
    run.run(ms(600)).unwrap();
    assert!(now(&run).milliamps > 0);
}

fn pulses_are_on_time_beside_it(machine: Machine) {
    let mut run = cooling(machine);
    let (passed, before) = (play(&mut run, 20), now(&run));
    let status = run.host.driver.status().unwrap();
    assert_eq!((status.limited, status.dropped), (0, 0), "{status:?}");
    assert_eq!(status.applied, passed);
    println!("latest beginning beside a module: {} us", status.late_us);
    // A period of PRE_SCALE 30.
    assert!(status.late_us < 5080, "{status:?}");
    assert!(before.face_c < 30.5, "{before:?}");
    assert_eq!(run.chips.boots.len(), 1);
}
