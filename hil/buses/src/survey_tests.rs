//! Tests of `survey.rs`.

use super::*;

#[test]
fn what_is_missing_comes_with_a_command() {
    let wanted = ["no-such-can".to_owned()];
    let watch = Watch {
        buses: vec![WatchedBus {
            path: "/dev/i2c-999".into(),
            boards: vec![0x40],
            converters: Vec::new(),
            motors: Vec::new(),
        }],
        oe: Some(("/dev/no-such-chip".into(), 1)),
        heartbeat: std::time::Duration::from_millis(50),
        transfer: std::time::Duration::from_millis(30),
    };
    let findings = survey(Some(&wanted), Some(&watch));
    for about in ["CAN", "I2C", "OE line"] {
        let of: Vec<_> = findings.iter().filter(|f| f.about == about).collect();
        assert_eq!(of.len(), 1, "{findings:?}");
        assert!(
            !of[0].ok && of[0].needed && of[0].remedy.is_some(),
            "{:?}",
            of[0]
        );
    }
    assert!(findings.iter().any(|f| f.about == "clock"));
}
