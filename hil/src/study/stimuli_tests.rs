//! Tests of `stimuli.rs`: what a condition changes of a bench of hardware.

use palpate_files::{load_bench, load_protocol};

use super::*;

const BENCH: &str = r#"
name = "real"
description = "Hardware"
kind = "real"
display = "three-in-line"
wire = { kind = "final-75um", alloy = "low" }
outputs = [{ board = 0x40, channel = 0 }, { board = 0x40, channel = 1 }, { board = 0x40, channel = 2 }]
real = { can = ["can0"], i2c = ["/dev/i2c-1"] }
drive = { current_ma = 990.0, supply_limit_ma = 4000.0, hot_pass = false }
"#;

const PROTOCOL: &str = r#"
name = "p"
description = "A limit that is tightened"
[[conditions]]
name = "watched"
scene = "brush-strokes"
set = ["bench.real.heartbeat_ms=20"]
[rating]
scales = [{ name = "strength", low = "none", high = "much" }]
conditions = ["watched"]
compare = []
groups = "within"
repeats = 1
simulated = { rating = { mean = 3.0, sd = 0.5 }, noise = 0.5, difference = 1.0 }
"#;

#[test]
fn a_limit_that_a_condition_tightens_holds_on_the_buses_that_the_command_line_named() {
    let folder = std::env::temp_dir().join(format!("palpate-stimuli-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let mut bench = load_bench(&file("real.toml", BENCH)).unwrap();
    bench.value.real.as_mut().unwrap().can = vec!["can7".into()];
    let protocol = load_protocol(&file("p.toml", PROTOCOL)).unwrap();
    let stimuli = Stimuli::new(protocol, bench).unwrap();
    let watched = stimuli.setup(&Stimulus::Condition("watched".into()));
    let real = watched.unwrap().bench.value.real.unwrap();
    assert_eq!((real.heartbeat_ms, real.transfer_ms), (20, 30));
    assert_eq!(real.can, ["can7"]);
    let _ = std::fs::remove_dir_all(&folder);
}
