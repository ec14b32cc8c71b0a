//! `hil replay` and `hil record` on an interface, with candump listening to both.

use palpate_core::codec::can::CanFrame;
use palpate_records::candump::{Log, read};
use palpate_records::mcap;

use super::tools::{in_lab, scratch, sh, vcan};

fn frames(log: &Log) -> Vec<CanFrame> {
    log.frames.iter().map(|l| l.frame).collect()
}

#[test]
fn what_is_replayed_is_what_candump_hears_and_what_is_recorded() {
    if !in_lab("record and replay") {
        return;
    }
    vcan("vcan7");
    let hil = std::env::var("PALPATE_HIL").unwrap();
    let path = |name: &str| scratch(name).display().to_string();
    let (run, log, recording, heard) =
        (path("a.log"), path("b.log"), path("b.mcap"), path("c.log"));
    sh(&format!("{hil} run idle --quiet --record {run}"));
    let played = sh(&format!(
        "{hil} record {log} {recording} --can vcan7 --quiet & recorder=$!
         candump -L vcan7 > {heard} & listener=$!
         sleep 3
         {hil} replay {run} --can vcan7 --json
         sleep 2
         kill -INT $recorder $listener
         wait $recorder"
    ));
    let played: serde_json::Value = serde_json::from_str(&played).unwrap();
    let text = |path: &str| std::fs::read_to_string(path).unwrap();
    let expected = frames(&read(&text(&run)).unwrap());
    assert!(expected.len() > 1000);
    assert_eq!(played["sent"], expected.len(), "{played}");
    assert_eq!(
        (&played["lost"], &played["left"]),
        (&0.into(), &0.into()),
        "{played}"
    );
    assert_eq!(frames(&read(&text(&heard)).unwrap()), expected, "candump");
    assert_eq!(
        frames(&read(&text(&log)).unwrap()),
        expected,
        "hil record, candump format"
    );
    let recorded = mcap::read(&std::fs::read(&recording).unwrap()).unwrap();
    assert_eq!(recorded.damages, []);
    let recorded: Vec<_> = recorded.frames.iter().map(|r| r.frame).collect();
    assert_eq!(recorded, expected, "hil record, MCAP");
}
