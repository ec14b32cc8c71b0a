//! Tests of `gain.rs`.

use super::*;

fn proposed(values: &[&str]) -> Option<String> {
    let rows: Vec<Vec<String>> = values.iter().map(|v| vec![(*v).to_owned()]).collect();
    Gain::needless(&rows, &[0])
        .err()
        .map(|(expected, found)| format!("{expected} {found}"))
}

#[test]
fn counts_need_no_gain_and_other_values_have_one_by_their_noise() {
    assert_eq!(proposed(&["1", "2.0", "65535"]), None);
    // One value that is none is a fault of its own.
    assert_eq!(proposed(&["1", "2", "2.5"]), None);
    let cases: [(&[&str], &str); 5] = [
        (&["-12.50", "-12.45", "-12.55"], "--gain 100:32768"),
        (&["0.0012", "0.0013", "0.0012"], "--gain 100000:32768"),
        (&["-1", "-1", "-1"], "--gain 1000:32768"),
        // Noise alone would leave no room for the values.
        (&["49.001", "49.002", "49.001", "16.5"], "--gain 1000:0"),
        (
            &["-900.50", "-900.25", "-900.50", "-890.0"],
            "--gain 100:122293",
        ),
    ];
    for (values, gain) in cases {
        let told = proposed(values).unwrap();
        assert!(told.contains(gain), "{told}");
    }
}

#[test]
fn a_gain_is_read_and_shown_and_has_a_range() {
    let gain: Gain = "100:32768".parse().unwrap();
    assert_eq!(gain.to_string(), "100:32768");
    assert!((gain.counts(-12.5) - 31_518.0).abs() < 1e-9);
    assert_eq!(
        gain.range(),
        "a value from -327.680 to 327.670 (--gain makes counts of it)"
    );
    let twice: Gain = "2".parse().unwrap();
    assert!((twice.counts(4.0) - 8.0).abs() < 1e-9);
    for bad in ["", "0", "a", "1:", "1:b", "inf", "nan:1"] {
        assert!(bad.parse::<Gain>().is_err(), "{bad}");
    }
}
