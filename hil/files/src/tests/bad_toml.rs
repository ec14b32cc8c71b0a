//! Bad benches, layouts and limit tables, files that do not fit together, and what is said about them.
//! Each case edits a shipped file, so that the rest of it stays right.

use super::super::*;

/// A scene, a bench and a layout that state their keys.
pub(super) const SCENE: &str = include_str!("scene.toml");
pub(super) const BENCH: &str = include_str!("bench.toml");
const LAYOUT: &str = include_str!("layout.toml");

/// (what to replace, with what, the whole message)
type Case = (&'static str, &'static str, &'static str);

pub(super) fn check<T: std::fmt::Debug>(
    text: &str,
    read: fn(&Source) -> Result<T, FileError>,
    cases: &[Case],
) {
    let mut wrong = Vec::new();
    for (old, new, message) in cases {
        assert!(text.contains(old), "{old} is not in the file");
        let source = Source::new("f.toml", text.replacen(old, new, 1));
        let said = read(&source).expect_err(message).to_string();
        if said != *message {
            wrong.push(format!("is  {said}\nnot {message}\n"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn benches() {
    check(
        BENCH,
        Bench::read,
        &[
            (
                "current_ma = 990.0",
                "current_ma = 0.0",
                "f.toml:10: drive.current_ma: expected a number from 1 to 5000 mA, found 0.0",
            ),
            (
                "supply_limit_ma = 4000.0",
                "supply_limit_ma = 900",
                "f.toml:11: drive.supply_limit_ma: expected at least the current of one wire, 990 mA, found 900",
            ),
            (
                "pwm_hz = 200.0",
                "pwm_hz = 1600.0",
                "f.toml:12: drive.pwm_hz: expected a number from 24 to 1526 Hz, found 1600.0",
            ),
            (
                "pwm_hz = 200.0",
                "pwm_hz = 20.0\nclock = { hz = 25_000_000, tolerance_ppm = 100 }",
                "f.toml:12: drive.pwm_hz: expected a number from 23.84185791015625 to 1525.87890625 Hz, found 20.0",
            ),
            (
                "pwm_hz = 200.0",
                "clock = { hz = 50_000_001, tolerance_ppm = 100 }",
                "f.toml:12: drive.clock.hz: expected a number from 100000 to 50000000 Hz, found 50_000_001",
            ),
            (
                "pwm_hz = 200.0",
                "clock = { hz = 25_000_000, tolerance_ppm = 60_000 }",
                "f.toml:12: drive.clock.tolerance_ppm: expected a number from 0 to 50000 ppm, found 60_000",
            ),
            (
                "oscillator = 1.0",
                "oscillator = 1.001\nclock = { hz = 25_000_000, tolerance_ppm = 100 }",
                "f.toml:13: drive.oscillator: expected a number from 0.9999 to 1.0001, found 1.001",
            ),
            (
                "oscillator = 1.0",
                "oscillator = 1.0\n[heat]\nair_c = 50.0",
                "f.toml:15: heat.air_c: expected a number from 0 to 40 C, found 50.0",
            ),
            (
                "oscillator = 1.0",
                "oscillator = 1.0\n[unit]\ndelay_ms = 41\n[heat]\nair_c = 20.0",
                "f.toml:15: unit.delay_ms: expected a number from 0 to 40 ms, found 41",
            ),
            (
                "alloy = \"low\"",
                "alloy = 7",
                "f.toml:7: wire.alloy: expected a string, found 7",
            ),
            (
                "kind = \"emulated\"",
                "kind = \"toy\"",
                "f.toml:4: kind: expected `emulated` or `real`, found `toy`",
            ),
            (
                "channel = 1\n",
                "channel = 0\n",
                "f.toml:22: outputs[1].channel: expected an output of its own: wire 0 has this channel of this board, found 0",
            ),
            (
                "channel = 1\n",
                "channel = 16\n",
                "f.toml:22: outputs[1].channel: expected a number from 0 to 15, found 16",
            ),
            (
                "channel = 1\n",
                "channel = 300\n",
                "f.toml:22: outputs[1].channel: expected a whole number from 0 to 255, found 300",
            ),
            (
                "channel = 1\n",
                "",
                "f.toml:20: outputs[1].channel: expected a value, found nothing",
            ),
            (
                "channel = 1\n",
                "chanel = 1\n",
                "f.toml:22: outputs[1].chanel: expected one of the keys `bus`, `board`, `channel`, found the unknown key `chanel`; did you mean `channel`?",
            ),
            (
                "kind = \"emulated\"",
                "kind = \"real\"",
                "f.toml:4: kind: expected a [real] table that names the buses, found \"real\"",
            ),
            (
                "[drive]",
                "[real]\ncan = []\ni2c = []\n[drive]",
                "f.toml:9: real: expected nothing: this bench is of kind \"emulated\", found [real]",
            ),
            (
                "channel = 1\n",
                "channel = 1\nbus = 1\n",
                "f.toml:23: outputs[1].bus: expected a number from 0 to 0, found 1",
            ),
        ],
    );
}

/// Addresses at which more than one chip would answer, with the reason; those beside them are good.
#[test]
fn boards_that_would_answer_together() {
    let board = |address: u8| {
        let text = BENCH.replace("board = 0x40", &format!("board = {address:#04x}"));
        Bench::read(&Source::new("f.toml", text)).map_err(|e| e.to_string())
    };
    for (address, why) in [
        (0x00, "the general call, which resets every chip"),
        (0x07, "0x00 to 0x07 are reserved"),
        (0x08, "0x40 and up"),
        (0x3F, "0x40 and up"),
        (0x70, "0x70 is all-call, which every chip of the bus obeys"),
        (0x71, "sub-calls"),
        (0x72, "sub-calls"),
        (0x74, "sub-calls"),
        (0x78, "0x78 and up are reserved"),
        (0x7F, "0x78 and up are reserved"),
        (0xFF, "0x78 and up are reserved"),
    ] {
        let said = board(address).unwrap_err();
        let place = "f.toml:17: outputs[0].board: expected 0x40 to 0x77 without 0x70, ";
        let found = format!(", found {address:#04x}");
        assert!(
            said.starts_with(place) && said.contains(why) && said.ends_with(&found),
            "{said}"
        );
    }
    for address in [0x40, 0x6F, 0x73, 0x75, 0x77] {
        board(address).unwrap();
    }
}

/// One address on two adapters is two boards; on one adapter under two names it is one.
#[test]
fn buses_are_listed_once() {
    let read = |can: &str, i2c: &str| {
        let real = format!("kind = \"real\"\nreal = {{ can = {can}, i2c = {i2c} }}");
        let text = BENCH.replace("kind = \"emulated\"", &real);
        let text = text.replacen("channel = 1\n", "channel = 0\nbus = 1\n", 1);
        let read = Bench::read(&Source::new("f.toml", text));
        read.map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(
        read("[\"can0\"]", "[\"/dev/i2c-1\", \"/dev/i2c-2\"]"),
        Ok(())
    );
    let said = read("[\"can0\"]", "[\"/dev/i2c-1\", \"/dev/./i2c-1\"]").unwrap_err();
    assert_eq!(
        said,
        "f.toml:5: real.i2c[1]: expected a bus of its own: number 0 is the same, and so are its addresses, found \"/dev/./i2c-1\""
    );
    let said = read(
        "[\"can1\", \"can0\", \"can0\"]",
        "[\"/dev/i2c-1\", \"/dev/i2c-2\"]",
    );
    assert!(said.unwrap_err().contains("real.can[2]"));
}

#[test]
fn layouts() {
    check(
        LAYOUT,
        LayoutFile::read,
        &[
            (
                "kind = \"sensor\"",
                "",
                "f.toml:1: kind: expected \"sensor\" or \"display\", found nothing",
            ),
            (
                "kind = \"sensor\"",
                "kind = \"both\"",
                "f.toml:2: kind: expected \"sensor\" or \"display\", found \"both\"",
            ),
            (
                "axes = 3",
                "axes = 2",
                "f.toml:5: axes: expected 1 or 3, found 2",
            ),
            (
                "rows = 4",
                "rows = 0",
                "f.toml:9: modules[0].grid.rows: expected a number from 1 to 4096, found 0",
            ),
            (
                "grid = {",
                "points_mm = [[0, 0]]\ngrid = {",
                "f.toml:9: modules[0].points_mm: expected one of grid, hex and points_mm, found [[0, 0]]",
            ),
            (
                "boards = [4]",
                "boards = [4, 5]",
                "f.toml:11: modules[0].boards: expected 1 boards (16 taxels, 16 a board), found [4, 5]",
            ),
            (
                "pitch_mm = 4.7",
                "pitch_mm = 0.0",
                "f.toml:9: modules[0].grid.pitch_mm: expected a number from 0.01 to 1000 mm, found 0.0",
            ),
            (
                "pitch_mm = 4.7",
                "pitch = 4.7",
                "f.toml:9: modules[0].grid.pitch: expected one of the keys `rows`, `columns`, `pitch_mm`, found the unknown key `pitch`; did you mean `pitch_mm`?",
            ),
            (
                "boards = [4]",
                "boards = [16]",
                "f.toml:11: modules[0].boards[0]: expected a number from 0 to 15, found 16",
            ),
            (
                "boards = [4]",
                "boards = [4]\ninactive = [16]",
                "f.toml:12: modules[0].inactive[0]: expected a number from 0 to 15, found 16",
            ),
            (
                "bus = 0\n",
                "",
                "f.toml:7: modules[0].bus: expected bus and boards together, or neither, found nothing",
            ),
        ],
    );
    let text = palpate_fixtures::layout("uskin-4x4-pair").unwrap();
    check(
        text,
        LayoutFile::read,
        &[(
            "boards = [5]",
            "boards = [4]",
            "f.toml:18: modules[1].boards[0]: expected an address of its own on its bus, found 4",
        )],
    );
    let text = palpate_fixtures::layout("allegro").unwrap();
    check(
        text,
        LayoutFile::read,
        &[
            (
                "row = 4, column = 0",
                "row = 3, column = 0",
                "f.toml:23: modules[1].image: expected free cells inside the 16x16 image, found { row = 3, column = 0 }",
            ),
            (
                "image = { row = 0, column = 0 }\n",
                "",
                "f.toml:11: modules[0].image: expected an image for the layout and for every module, or for none, found nothing",
            ),
        ],
    );
    let text = palpate_fixtures::layout("three-in-line").unwrap();
    check(
        text,
        LayoutFile::read,
        &[
            (
                "[6.5, 0.0]]",
                "[0.0, -0.0]]",
                "f.toml:6: wires_mm[2]: expected a place of its own, not that of number 1, found [0.0, -0.0]",
            ),
            (
                "[[-6.5, 0.0], [0.0, 0.0], [6.5, 0.0]]",
                "[]",
                "f.toml:6: wires_mm: expected 1 to 256 places, found []",
            ),
            (
                "[6.5, 0.0]]",
                "[0.5, 0.5]]",
                "f.toml:6: wires_mm[2]: expected at least 0.76 mm to every other wire, number 1 overlaps, found [0.5, 0.5]",
            ),
            (
                "spacing_mm = [6.5, 6.5]",
                "spacing_mm = [0.0, 6.5]",
                "f.toml:5: spacing_mm[0]: expected a number from 0.1 to 1000 mm, found 0.0",
            ),
        ],
    );
}

#[test]
fn limit_tables_may_only_tighten() {
    let text = palpate_fixtures::limits("default").unwrap();
    check(
        text,
        LimitTable::read,
        &[
            (
                "width_us = 200.0",
                "width_us = 201",
                "f.toml:7: pulse.width_us: expected at most the hard limit 200 (a file may only tighten), found 201",
            ),
            (
                "width_us = 200.0",
                "width_us = 0.0",
                "f.toml:7: pulse.width_us: expected more than 0, found 0.0",
            ),
            (
                "peak_c = 43.0",
                "peak_c = 43.001",
                "f.toml:23: skin.peak_c: expected at most the hard limit 43 (a file may only tighten), found 43.001",
            ),
            (
                "deep_c = 41.0",
                "deep_c = 20.0",
                "f.toml:24: skin.deep_c: expected more than 33, found 20.0",
            ),
            (
                "over_60s_mw = 60.0",
                "over_60s_mw = -1",
                "f.toml:19: fingertip_power.over_60s_mw: expected more than 0, found -1",
            ),
            (
                "cem43_min = 2.0",
                "cem43 = 2.0",
                "f.toml:28: dose.cem43: expected `henriques_omega` or `cem43_min`, found the unknown key `cem43`; did you mean `cem43_min`?",
            ),
            (
                "off_within_ms = 100.0",
                "off_within_ms = nan",
                "f.toml:31: watchdog.off_within_ms: expected a finite number, found nan",
            ),
        ],
    );
}

#[test]
fn a_real_bench_states_its_hardware() {
    let real = BENCH.replace(
        "kind = \"emulated\"",
        "kind = \"real\"\nreal = { can = [\"can0\"], i2c = [\"/dev/i2c-1\"] }",
    );
    let read = |text: &str| Bench::read(&Source::new("b.toml", text));
    assert!(read(&real).is_ok());
    for (stated, key) in [
        ("display = \"thimble-8\"\n", "display"),
        ("kind = \"final-75um\", ", "wire.kind"),
        ("current_ma = 990.0\n", "drive.current_ma"),
        ("supply_limit_ma = 4000.0 ", "drive.supply_limit_ma"),
    ] {
        assert!(real.contains(stated), "{stated}");
        let error = read(&real.replace(stated, if stated.ends_with(' ') { "" } else { "\n" }));
        let error = error.unwrap_err();
        assert_eq!(error.key.as_deref(), Some(key));
        assert!(error.expected.starts_with("a value"), "{error}");
    }
    let outputs = real.find("# One line").unwrap();
    let error = read(&real[..outputs]).unwrap_err();
    assert_eq!(error.key.as_deref(), Some("outputs"));
}

#[test]
fn files_that_do_not_fit_together() {
    let join = |scene: (&str, &str), bench: (&str, &str)| {
        let source = Source::new("s.toml", SCENE.replacen(scene.0, scene.1, 1));
        let value = Scene::read(&source).unwrap();
        let scene = Loaded { value, source };
        let source = Source::new("b.toml", BENCH.replacen(bench.0, bench.1, 1));
        let value = Bench::read(&source).unwrap();
        Setup::join(scene, Loaded { value, source })
            .unwrap_err()
            .to_string()
    };
    let same = ("", "");
    assert_eq!(
        join(("drives = 0", "drives = 1"), same),
        "s.toml:12: drives: expected a module of `uskin-4x4`, 0 to 0, found 1"
    );
    assert_eq!(
        join(("diameter_mm", "module = 2\ndiameter_mm"), same),
        "s.toml:32: touches[0].module: expected a module of `uskin-4x4`, 0 to 0, found 2"
    );
    assert_eq!(
        join(("uskin-4x4", "thimble-8"), same),
        "s.toml:5: layout: expected a layout of kind \"sensor\", found the display `thimble-8`"
    );
    assert_eq!(
        join(("uskin-4x4", "uskin"), same),
        "s.toml:5: layout: expected a layout (allegro, digit, digit-64x48, h1-body, icub-body, icub-forearm, icub-patch, million, mtb-finger, scattered-12, tactile-brush-4x3, ten-fingertips, thimble-8, three-in-line, uskin-4x4, uskin-4x4-pair, uskin-4x6) or a file, found \"uskin\"; did you mean `uskin-4x4`?"
    );
    assert_eq!(
        join(
            ("[expect]", "[map]\ndisplay = \"three-in-line\"\n[expect]"),
            same
        ),
        "s.toml:40: map.display: expected the bench's display, `thimble-8`, found \"three-in-line\""
    );
    assert_eq!(
        join(same, ("thimble-8", "uskin-4x4")),
        "b.toml:5: display: expected a layout of kind \"display\", found the sensor `uskin-4x4`"
    );
    assert_eq!(
        join(same, ("final-75um", "final-80um")),
        "b.toml:7: wire.kind: expected a wire (final-75um, first-100um, loose-50um, taut) or a file, found \"final-80um\"; did you mean `final-75um`?"
    );
    assert_eq!(
        join(same, ("thimble-8", "three-in-line")),
        "b.toml:16: outputs: expected 3 outputs, one per wire of `three-in-line`, found 8"
    );
}

/// A real bench of motors that states all it has to.
const COINS: &str = "name = \"coins\"\ndescription = \"Eight coins\"\nkind = \"real\"\ndisplay = \"thimble-8\"\n\
    [real]\ncan = [\"can0\"]\ni2c = [\"/dev/i2c-1\"]\n\
    [haptics]\nkind = \"lra\"\nrated_v = 1.8\nfull_v = 0.3\noverdrive_v = 2.7\nresonance_hz = 235.0\nohm = 25.0\ntravel_um = 300.0\n\
    calibration = [232, 166, 3]\n\
    drivers = [{ switch = 0x70 }, { switch = 0x70, channel = 1 }, { switch = 0x70, channel = 2 }, { switch = 0x70, channel = 3 }, { switch = 0x70, channel = 4 }, { switch = 0x70, channel = 5 }, { switch = 0x70, channel = 6 }, { switch = 0x70, channel = 7 }]\n";

#[test]
fn a_real_bench_of_motors_states_them_and_nothing_else() {
    let read = |text: &str| Bench::read(&Source::new("b.toml", text));
    assert!(read(COINS).is_ok(), "{:?}", read(COINS));
    for line in COINS.lines().filter(|line| {
        [
            "display",
            "kind = \"lra\"",
            "rated_v",
            "full_v",
            "overdrive_v",
            "resonance_hz",
            "ohm",
        ]
        .iter()
        .chain(&["travel_um", "calibration", "drivers"])
        .any(|key| line.starts_with(key))
    }) {
        let error = read(&COINS.replace(line, "")).unwrap_err();
        let (key, _) = line.split_once(" =").unwrap();
        let found = error.key.as_deref().unwrap_or_default();
        assert_eq!(found.rsplit('.').next(), Some(key), "{error}");
        assert!(error.expected.starts_with("a value"), "{error}");
    }
    let card = "kind = \"voice-coil\"";
    for (from, to, words) in [
        (
            "kind = \"lra\"",
            card,
            "this program opens no sound card, and `--wav -`",
        ),
        (
            "/dev/i2c-1\"]",
            "/dev/i2c-1\", \"/dev/i2c-2\"]",
            "one adapter with [haptics], found 2",
        ),
        (
            "[haptics]",
            "oe = { chip = \"/dev/gpiochip0\", line = 1 }\n[haptics]",
            "nothing with [haptics]: drivers",
        ),
        (
            "[haptics]",
            "[[outputs]]\nboard = 0x40\nchannel = 0\n[haptics]",
            "nothing beside [haptics]",
        ),
        (
            "[haptics]",
            "[drive]\ncurrent_ma = 900.0\n[haptics]",
            "nothing beside [haptics]",
        ),
    ] {
        let said = read(&COINS.replace(from, to)).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
}
