//! The skins that the generator of truth disturbs.

use palpate_core::skin::{Layout, Module};

/// A skin at rest, in counts.
pub struct Skin {
    pub name: &'static str,
    pub layout: Layout,
    pub rest: [f64; 3],
    pub noise: f64,
    pub most: f64,
    pub force: [f64; 2],
    pub floor: f32,
}

/// The four skins of the generator.
pub fn skins() -> [Skin; 4] {
    let skin = |name, module: Module, rest, noise, most, force, floor| Skin {
        name,
        layout: Layout::single(module).unwrap(),
        rest,
        noise,
        most,
        force,
        floor,
    };
    let uskin = [33_000.0, 33_000.0, 37_400.0];
    let one = |rows, columns, pitch| {
        Module::grid("pad", rows, columns, pitch)
            .and_then(|m| m.with_axes(1))
            .unwrap()
    };
    [
        skin(
            "4x4",
            Module::grid("pad", 4, 4, 4.7).unwrap(),
            uskin,
            1.8,
            65_535.0,
            [200.0, 4000.0],
            20.0,
        ),
        skin(
            "4x6",
            Module::grid("pad", 4, 6, 4.7).unwrap(),
            uskin,
            1.8,
            65_535.0,
            [200.0, 4000.0],
            20.0,
        ),
        skin(
            "patch",
            one(10, 6, 6.5),
            [0.0, 0.0, 20.0],
            0.4,
            255.0,
            [60.0, 200.0],
            6.0,
        ),
        skin(
            "mat",
            one(12, 20, 10.0),
            [0.0, 0.0, 300.0],
            1.5,
            4095.0,
            [150.0, 2000.0],
            20.0,
        ),
    ]
}
