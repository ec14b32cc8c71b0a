//! Bad scenes and what is said about them.

use super::super::*;
use super::bad_toml::{SCENE, check};

#[test]
fn scenes() {
    check(
        SCENE,
        Scene::read,
        &[
            (
                "name = \"sphere-along\"",
                "",
                "f.toml:1: name: expected lower-case letters, digits and hyphens, found nothing",
            ),
            (
                "start_s = 0.8\n",
                "",
                "f.toml:31: touches[0].start_s: expected a value, found nothing",
            ),
            (
                "mean = 0.7, ",
                "",
                "f.toml:37: touches[0].force_n.mean: expected a value, found nothing",
            ),
            (
                "{ mean = 0.7, amplitude = 0.3, period_s = 2.7 }",
                "[0.7, 0.3, 2.7]",
                "f.toml:37: touches[0].force_n: expected a table, found [0.7, 0.3, 2.7]",
            ),
            (
                "\"A 19.45 mm sphere rolls along the pad's y axis, edge to edge and back\"",
                "2026-11-24",
                "f.toml:3: description: expected a string, found 2026-11-24",
            ),
            (
                "kc = 1",
                "kc = 1\nkx = 2",
                "f.toml:16: compression.kx: expected one of the keys `kc`, `kc_touches`, `ki`, `levels`, `vectors`, `weight_exponent`, `norm`, `axes`, `scope`, `iterations`, `stop_mm`, found the unknown key `kx`",
            ),
            (
                "ramp_s",
                "ramps",
                "f.toml:35: touches[0].ramps: expected one of the keys `module`, `diameter_mm`, `start_s`, `end_s`, `ramp_s`, `path`, `force_n`, found the unknown key `ramps`; did you mean `ramp_s`?",
            ),
            (
                "amplitude",
                "amplitud",
                "f.toml:37: touches[0].force_n.amplitud: expected one of the keys `mean`, `amplitude`, `period_s`, found the unknown key `amplitud`; did you mean `amplitude`?",
            ),
            (
                "kc = 1",
                "kc = 0",
                "f.toml:15: compression.kc: expected a number from 1 to 1024, found 0",
            ),
            (
                "kc = 1",
                "kc = 1\nlevels = \"often\"",
                "f.toml:16: compression.levels: expected `static` or `dynamic`, found `often`",
            ),
            (
                "kc = 1",
                "kc = -1",
                "f.toml:15: compression.kc: expected a whole number, 0 or more, found -1",
            ),
            (
                "kc = 1",
                "kc = 1.5",
                "f.toml:15: compression.kc: expected a whole number, 0 or more, found 1.5",
            ),
            (
                "kc = 1",
                "kc = 99999999999999999999",
                "f.toml:15: compression.kc: expected a whole number of at most 64 bits, found 99999999999999999999",
            ),
            (
                "ki = 10",
                "ki = \"ten\"",
                "f.toml:16: compression.ki: expected a whole number, 0 or more, found \"ten\"",
            ),
            (
                "rate_hz = 100.0",
                "rate_hz = 0.0",
                "f.toml:7: rate_hz: expected a number from 0.1 to 10000 Hz, found 0.0",
            ),
            (
                "rate_hz = 100.0",
                "rate_hz = nan",
                "f.toml:7: rate_hz: expected a finite number, found nan",
            ),
            (
                "length_s = 10.0",
                "length_s = -10.0",
                "f.toml:4: length_s: expected a number from 0.01 to 86400 s, found -10.0",
            ),
            (
                "length_s = 10.0",
                "length_s = 1e300",
                "f.toml:4: length_s: expected a number from 0.01 to 86400 s, found 1e300",
            ),
            (
                "length_s = 10.0",
                "length_s = inf",
                "f.toml:4: length_s: expected a finite number, found inf",
            ),
            (
                "length_s = 10.0",
                "length_s = true",
                "f.toml:4: length_s: expected a number, found true",
            ),
            (
                "length_s = 10.0",
                "length_s = ",
                "f.toml:4: expected valid TOML, found string values must be quoted, expected literal string",
            ),
            (
                "length_s = 10.0",
                "length_s = 10.0\nlength_s = 9.0",
                "f.toml:5: expected valid TOML, found duplicate key",
            ),
            (
                "[0.0, -7.05]",
                "[nan, -7.05]",
                "f.toml:36: touches[0].path.points_mm[0][0]: expected a finite number, found nan",
            ),
            (
                "[0.0, -7.05]",
                "[0.0]",
                "f.toml:36: touches[0].path.points_mm[0]: expected an array of 2 numbers, found [0.0]",
            ),
            (
                "[0.0, -7.05]",
                "[0.0, -7.05], [1, 1]",
                "f.toml:36: touches[0].path.points_mm: expected two points for a line, found [[0.0, -7.05], [1, 1], [0.0, 7.05]]",
            ),
            (
                "kind = \"line\"",
                "kind = \"spiral\"",
                "f.toml:36: touches[0].path.kind: expected one of `hold`, `line`, `polyline`, `circle`, `hand`, found `spiral`",
            ),
            (
                "kind = \"line\"",
                "kind = \"line\", radius_mm = 1",
                "f.toml:36: touches[0].path.radius_mm: expected this key for circles only, found 1",
            ),
            (
                "kind = \"line\", points_mm = [[0.0, -7.05], [0.0, 7.05]]",
                "kind = \"circle\"",
                "f.toml:36: touches[0].path.radius_mm: expected a value for a circle, found nothing",
            ),
            (
                "norm = \"l2\"",
                "norm = \"l3\"",
                "f.toml:18: compression.norm: expected one of `l1`, `l2`, `linf`, found `l3`",
            ),
            (
                "end_s = 10.0",
                "end_s = 11.0",
                "f.toml:34: touches[0].end_s: expected a number from 0 to 10 s (the scene's length), found 11.0",
            ),
            (
                "start_s = 0.8",
                "start_s = 0.3",
                "f.toml:33: touches[0].start_s: expected at least 0.51 s: reference and threshold frames are contact-free, found 0.3",
            ),
            (
                "mean = 0.7",
                "mean = 0.2",
                "f.toml:37: touches[0].force_n.amplitude: expected a number from 0 to 0.2 N (the mean), found 0.3",
            ),
            (
                "beta = 0.0244140625",
                "beta = 1.5",
                "f.toml:26: illusion.beta: expected a number from 0 to 1, found 1.5",
            ),
            (
                "tau_d_ms = 35.0",
                "tau_d_ms = 80.0",
                "f.toml:27: illusion.tau_d_ms: expected at most the time between onsets, 72.9 ms, found 80.0",
            ),
            (
                "model = \"balanced\"",
                "model = \"ghost\"",
                "f.toml:23: illusion.model: expected one of `phantom`, `energy`, `linear`, `square`, `balanced`, `inverse`, `three-nearest`, `gaussian`, `nearest`, found `ghost`",
            ),
            (
                "model = \"balanced\"\nshape = 0.65",
                "model = \"inverse\"\nlevel_db = -1.0",
                "f.toml:24: illusion.level_db: expected a number from 0 to 60 dB over threshold, found -1.0",
            ),
            (
                "model = \"balanced\"\nshape = 0.65",
                "model = \"inverse\"\nlevel_db = 1e9",
                "f.toml:24: illusion.level_db: expected a number from 0 to 60 dB over threshold, found 1e9",
            ),
            (
                "model = \"balanced\"\nshape = 0.65",
                "model = \"inverse\"\nlevel_db = nan",
                "f.toml:24: illusion.level_db: expected a finite number, found nan",
            ),
            (
                "shape = 0.65",
                "level_db = 6.0",
                "f.toml:24: illusion.level_db: expected nothing: only `inverse` aims at a level, found 6.0",
            ),
            (
                "intensity = true",
                "intensity = \"on\"",
                "f.toml:28: illusion.intensity: expected true or false, found \"on\"",
            ),
            (
                "shape = 0.65",
                "shape = 0.0",
                "f.toml:24: illusion.shape: expected a number from 0.01 to 100, found 0.0",
            ),
            (
                "shape = 0.65",
                "shape = 0.65\nflat = true",
                "f.toml:25: illusion.flat: expected a shape or a flat midpoint, not both, found true",
            ),
            (
                "tau_d_ms = 35.0",
                "soa_ms = 47.0",
                "f.toml:27: illusion.soa_ms: expected a stimulus duration above zero, or more than 47.3 ms between onsets for the law to give one, found 47.0",
            ),
            (
                "shape = 0.65",
                "sharing = \"loudest\"",
                "f.toml:24: illusion.sharing: expected one of `strongest`, `sum`, `slices`, found `loudest`",
            ),
            (
                "generation = \"2021\"",
                "generation = \"2020\"",
                "f.toml:6: generation: expected one of `2019`, `2021`, `current`, found `2020`; did you mean `2021`?",
            ),
            (
                "name = \"sphere-along\"",
                "name = \"Sphere\"",
                "f.toml:2: name: expected lower-case letters, digits and hyphens, found \"Sphere\"",
            ),
            (
                "[expect]",
                "[map]\nsensor_mm = [0, 0, 2, 2]\nwindow_mm = [1, 1]\n[expect]",
                "f.toml:41: map.window_mm: expected map.sensor_mm, which stays, or map.window_mm, which follows, found [1, 1]",
            ),
            (
                "[expect]",
                "[stream]\nloss = 1.0\n[expect]",
                "f.toml:40: stream.loss: expected a number from 0 to 0.99, found 1.0",
            ),
            (
                "[expect]",
                "[map]\nsensor_mm = [1, 0, -1, 2]\n[expect]",
                "f.toml:40: map.sensor_mm: expected [left, bottom, right, top] with an area, found [1, 0, -1, 2]",
            ),
        ],
    );
}
