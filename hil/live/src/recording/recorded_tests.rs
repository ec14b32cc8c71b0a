//! Tests of recordings that are read by their recipes wherever recordings are.

use palpate_files::{LayoutFile, load_layout};
use palpate_run::Input;

use super::super::recorded;
use super::*;

const RECIPE: &str = "kind = \"recording\"\nname = \"press\"\ndescription = \"A press on a finger\"\nrecording = \"press.csv\"\n\
                      layout = \"mtb-finger\"\ntime = { column = \"clock\", unit = \"ms\" }\n\n[[modules]]\nprefix = \"c\"\n\
                      without = [99]\n";

#[test]
fn a_recipe_stands_for_its_recording_and_is_found_beside_it() {
    let folder = std::env::temp_dir().join(format!("palpate-recorded-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let names: Vec<String> = (0..16).rev().map(|n| format!("c{n}")).collect();
    let row = |n: u64| {
        let counts: Vec<String> = (0..16).rev().map(|c| (100 * n + c).to_string()).collect();
        format!("{},{},7\n", 20 * n, counts.join(","))
    };
    let rows: String = (0..3).map(row).collect();
    let text = format!("clock,{},c99\n{rows}", names.join(","));
    let [table, recipe] = ["press.csv", "press.toml"].map(|name| folder.join(name));
    std::fs::write(&table, text).unwrap();
    std::fs::write(&recipe, RECIPE).unwrap();
    let LayoutFile::Sensor(sensor) = load_layout("mtb-finger").unwrap().value else {
        panic!("a skin");
    };
    for (path, is_noted) in [(&recipe, false), (&table, true)] {
        let (input, notes) =
            recorded(std::slice::from_ref(path), &sensor, &Reading::default()).unwrap();
        let Input::Rows(sources) = input else {
            panic!("rows");
        };
        let (mut read, mut counts) = (sources[0].rows().unwrap(), Vec::new());
        for n in 0..3_u16 {
            let time = read.next_row(&mut counts).unwrap();
            assert_eq!(time, Some(u64::from(n) * 20_000));
            let expected: Vec<u16> = (0..16).map(|c| 100 * n + c).collect();
            assert_eq!(counts, expected);
        }
        let said = notes.iter().any(|note| note.contains("read by the recipe"));
        assert_eq!(said, is_noted, "{notes:?}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
