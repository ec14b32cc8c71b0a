//! Benches with `[dac]`: which are refused, and with which words.

use crate::{Bench, Source};

const HEAD: &str = "name = \"set\"\ndescription = \"Set.\"\n";

fn bench(text: &str) -> Result<Bench, String> {
    let source = Source::new("b.toml", format!("{HEAD}{text}"));
    Bench::read(&source).map_err(|e| e.to_string())
}

#[test]
fn a_converter_is_beside_each_board() {
    let one = bench("[dac]\n").unwrap().dac.unwrap();
    assert_eq!(one.addresses, [0x48]);
    let outputs = |n| format!("{{ board = 0x4{}, channel = {} }}", n / 4, n % 4);
    let outputs: Vec<String> = (0..8).map(outputs).collect();
    let two = format!(
        "outputs = [{}]\n[dac]\naddresses = [0x4e, 0x4f]",
        outputs.join(", ")
    );
    assert_eq!(bench(&two).unwrap().boards(), 2);
}

/// Two displays, each on a board of its own of one bus.
fn hand(dac: &str, supply_ma: u32) -> String {
    let outputs = |board: u8| {
        let each: Vec<String> = (0..8)
            .map(|n| format!("{{ board = {board:#04x}, channel = {n} }}"))
            .collect();
        each.join(", ")
    };
    format!(
        "drive.supply_limit_ma = {supply_ma}.0\n[[displays]]\nname = \"a\"\noutputs = [{}]\n[[displays]]\nname = \"b\"\noutputs = [{}]\n[dac]\n{dac}\n",
        outputs(0x40),
        outputs(0x41)
    )
}

#[test]
fn a_unit_and_several_displays_may_have_converters() {
    assert!(
        bench("[unit]\nnetwork = \"wifi\"\n[dac]\n")
            .unwrap()
            .dac
            .is_some()
    );
    let two = bench(&hand("addresses = [0x48, 0x49]", 2100)).unwrap();
    assert!((two.most_ma() - 1005.0).abs() < 1e-9);
    // Each bus has addresses of its own.
    let buses =
        hand("addresses = [0x48, 0x48]", 2100).replace("board = 0x41", "bus = 1, board = 0x41");
    assert_eq!(bench(&buses).unwrap().boards(), 2);
}

#[test]
fn converters_that_cannot_be_are_refused() {
    let on = |board: u8, channel: u8, addresses: &str| {
        let output = |n: u8| match n {
            7 => format!("{{ board = {board:#04x}, channel = {channel} }}"),
            n => format!("{{ board = {board:#04x}, channel = {n} }}"),
        };
        let outputs: Vec<String> = (0..8).map(output).collect();
        format!(
            "outputs = [{}]\n[dac]\naddresses = {addresses}",
            outputs.join(", ")
        )
    };
    for (text, expected) in [
        (
            "[dac]\naddresses = [0x41]".to_owned(),
            "b.toml:4: dac.addresses[0]: expected 0x48 to 0x4f, which the pins ADDR0 and ADDR1 give, found 0x41",
        ),
        (
            "[dac]\naddresses = [0x48, 0x49]".to_owned(),
            "b.toml:4: dac.addresses: expected as many addresses as boards, 1, found 2",
        ),
        (
            on(0x48, 7, "[0x48]"),
            "b.toml:5: dac.addresses[0]: expected an address of its own: another chip answers at 0x48, found 0x48",
        ),
        (
            on(0x47, 7, "[0x48]"),
            "outputs[0].board: expected another address than 0x47 with [dac]: every DAC7578 obeys that, found 0x47",
        ),
        (
            on(0x40, 8, "[0x48]"),
            "outputs[7].channel: expected channels 0 to 7 with [dac]: a DAC7578 has eight outputs, found 8",
        ),
        (
            "[dac]\ngain = 1.02".to_owned(),
            "b.toml:4: dac.gain: expected a number from 0.99 to 1.01, found 1.02",
        ),
        (
            "[dac]\noffset_ma = -6.0".to_owned(),
            "b.toml:4: dac.offset_ma: expected a number from -5 to 5 mA, found -6.0",
        ),
        (
            "drive.supply_limit_ma = 1000.0\n[dac]\noffset_tolerance_ma = 3.0".to_owned(),
            "b.toml:3: drive.supply_limit_ma: expected at least 1003 mA: one wire set to 990 mA, 1 % and 3 mA more by [dac], found 1000 mA",
        ),
        (
            "drive.current_ma = 4100.0\ndrive.supply_limit_ma = 5000.0\n[unit]\nnetwork = \"wifi\"\n[dac]\n".to_owned(),
            "drive.current_ma: expected at most 4095 mA with [unit]: its link carries no more, found 4100 mA",
        ),
        (
            hand("addresses = [0x48, 0x48]", 3000),
            "dac.addresses[1]: expected an address of its own: another chip answers at 0x48, found 0x48",
        ),
        (
            hand("addresses = [0x48, 0x49]", 2000),
            "drive.supply_limit_ma: expected at least 2010 mA: a wire of each of 2 boards set to 990 mA, 1 % and 5 mA more by [dac], found 2000 mA",
        ),
    ] {
        let found = bench(&text).unwrap_err();
        assert!(found.contains(expected), "{found}\nnot {expected}");
    }
}
