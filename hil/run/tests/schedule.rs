//! A snapshot of a schedule, to copy into a crate of one's own: what wires are told while a finger presses the skin.

use std::error::Error;

use palpate_files::{Loaded, Scene, Setup, Source, load_bench};
use palpate_records::story::schedule_golden;
use palpate_run::{Input, run};

const SCENE: &str = r#"
name = "press"
description = "A finger presses the middle of the pad"
length_s = 1.6

[[touches]]
start_s = 0.8
path = { kind = "hold", points_mm = [[0.0, 0.0]] }
force_n = { mean = 0.8 }
"#;

#[test]
fn a_press_plays_as_it_was_accepted() -> Result<(), Box<dyn Error>> {
    let source = Source::new("press.toml", SCENE);
    let value = Scene::read(&source)?;
    let setup = Setup::join(Loaded { value, source }, load_bench("emulated")?)?;
    let outcome = run(&setup, &Input::Scene, 1)?; // of seed 1
    insta::assert_snapshot!("press", schedule_golden(&outcome.trace));
    Ok(())
}
