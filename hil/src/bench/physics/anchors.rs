//! The values that a correct model gives, from two published wires and three assumptions about the contact: maxima
//! over continuous time, to be met within 1 K.

use palpate_core::physics::{SkinParameters, WireParameters};
use palpate_emulators::wire::Wire;

use super::train::{Bursts, PULSE_W, START_C, ms, pwm};
use crate::bench::{Findings, Row};

/// Share of the electrical power that heats the wire, and heat transfer of the contact, W/(m2 K).
const SHARES: [f64; 2] = [0.602, 1.0];
const CONTACTS: [f64; 2] = [2000.0, 10_000.0];

/// A case and, by contact, quantity (wire, skin at 0.1 mm, at 0.4 mm) and share, its maxima, degrees C.
type Anchor = (&'static str, Bursts, u64, [[[f64; 2]; 3]; 2]);

fn anchors() -> [Anchor; 4] {
    let seconds = |n: u64| ms(1000 * n);
    let once = Bursts {
        burst: ms(35),
        cycle: seconds(2),
        end: seconds(2),
    };
    let always = Bursts {
        burst: seconds(10),
        cycle: seconds(10),
        end: seconds(10),
    };
    [
        (
            "one 35 ms burst",
            once,
            2,
            [
                [[70.6, 85.1], [34.4, 35.0], [33.1, 33.2]],
                [[64.1, 73.9], [35.0, 36.0], [33.2, 33.3]],
            ],
        ),
        (
            "round-robin",
            Bursts::round_robin(seconds(10)),
            10,
            [
                [[71.0, 88.4], [35.8, 37.6], [34.0, 34.7]],
                [[65.8, 75.1], [36.7, 38.8], [34.1, 34.9]],
            ],
        ),
        (
            "dwelling on one wire",
            Bursts::dwelling(seconds(10)),
            10,
            [
                [[119.0, 176.4], [53.5, 67.2], [41.4, 47.0]],
                [[94.0, 134.7], [56.7, 72.6], [42.7, 49.2]],
            ],
        ),
        (
            "continuous",
            always,
            10,
            [
                [[156.6, 239.0], [66.8, 89.4], [46.9, 56.1]],
                [[118.4, 175.2], [72.1, 98.1], [49.0, 59.7]],
            ],
        ),
    ]
}

fn wire(share: f64, contact_h: f64) -> Result<Wire, String> {
    let wire = WireParameters {
        wire_share: share,
        ..WireParameters::FINAL
    };
    let skin = SkinParameters {
        contact_h,
        ..SkinParameters::DEFAULT
    };
    Wire::new(&wire, &skin, START_C).map_err(|e| e.to_string())
}

/// Every case, its largest deviation from the values above.
///
/// # Errors
/// A wire that cannot be computed.
pub fn measure(findings: &mut Findings) -> Result<(), String> {
    let mut row = |case: &str, off: f64| {
        findings.rows.push(Row {
            family: "physics",
            case: format!("table: {case}"),
            method: "default".into(),
            error: off,
            error_unit: "K off the table",
            median_us: f64::NAN,
            peer: false,
        });
    };
    for (name, bursts, seconds, expected) in anchors() {
        let mut worst = 0.0_f64;
        for (contact_h, expected) in CONTACTS.into_iter().zip(expected) {
            for (s, share) in SHARES.into_iter().enumerate() {
                let mut wire = wire(share, contact_h)?;
                for (at, watts) in bursts.edges() {
                    wire.set_power(at, watts);
                }
                // The skin is warmest after the last pulse.
                let p = wire.peaks(ms(1000 * seconds + 100));
                let got = [p.wire_c, p.shallow_c, p.deep_c];
                for (got, expected) in got.into_iter().zip(expected) {
                    worst = worst.max((got - expected[s]).abs());
                }
            }
        }
        row(name, worst);
    }
    let mut worst = 0.0_f64;
    for (share, expected) in SHARES.into_iter().zip([335.0, 551.0]) {
        let mut wire = wire(share, CONTACTS[0])?;
        wire.set_power(ms(0), PULSE_W);
        wire.set_power(pwm().0, 0.0);
        worst = worst.max((wire.peaks(ms(100)).wire_c - expected).abs());
    }
    row("full on for one PWM period", worst);
    Ok(())
}
