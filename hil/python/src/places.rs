//! Places of taxels and wires.

use palpate_core::skin::Layout;
use palpate_records::trace::WireInfo;

/// Place of a wire, mm.
pub fn wire(wire: &WireInfo) -> (f64, f64) {
    let mm = |um: i32| f64::from(um) * 1e-3;
    (mm(wire.place.x), mm(wire.place.y))
}

/// Module, x and y of each taxel, mm.
pub fn taxels(layout: &Layout) -> Vec<(u16, f64, f64)> {
    let mut taxels = Vec::new();
    for (number, module) in (0..).zip(layout.modules()) {
        let points = module.points().iter();
        taxels.extend(points.map(|p| (number, f64::from(p.x), f64::from(p.y))));
    }
    taxels
}
