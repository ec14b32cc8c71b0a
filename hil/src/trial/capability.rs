//! Capabilities that a scene needs and a bench may lack.

use palpate_files::{Bench, BenchKind, Overload, Scene, SensorLayout};

/// Names of the capabilities that a bench lacks for a scene; empty where the bench can run it.
pub fn lacks(scene: &Scene, sensor: &SensorLayout, bench: &Bench) -> Vec<String> {
    let mut missing = Vec::new();
    if let Some(display) = &scene.map.display
        && *display != bench.display
    {
        missing.push(format!("display {display}"));
    }
    if !bench.displays.is_empty() && scene.fingers.is_empty() {
        missing.push("one display: the scene has no [[fingers]]".to_owned());
    }
    let (BenchKind::Real, Some(real)) = (bench.kind, &bench.real) else {
        return missing;
    };
    if !scene.faults.is_empty() {
        missing.push("fault injection".to_owned());
    }
    if !scene.touches.is_empty() && !real.touch {
        missing.push("touch (`real.touch`)".to_owned());
    }
    if scene.boards.overload == Some(Overload::Overwrite) {
        missing.push("boards that overwrite".to_owned());
    }
    let moved = scene.boards.bus.is_some();
    let buses = sensor.modules.iter().filter_map(|m| m.bus).max();
    let buses = buses.map_or(0, |last| usize::from(last) + 1);
    if moved {
        missing.push("boards that can be moved to one bus".to_owned());
    } else if buses > real.can.len() {
        missing.push(format!("{buses} CAN interfaces"));
    }
    missing
}

#[cfg(test)]
#[path = "capability_tests.rs"]
mod tests;
