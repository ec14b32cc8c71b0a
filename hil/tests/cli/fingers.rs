//! Benches of several displays that cannot be: refused with file, key and arithmetic.

use super::*;

/// `allegro-grasp` on `allegro-hand`, with both files changed.
fn run(name: &str, scene: impl Fn(String) -> String, bench: impl Fn(String) -> String) -> String {
    let folder = Folder::new(name);
    let text = |text: Option<&str>| text.unwrap().to_owned();
    let scene = scene(text(palpate_fixtures::scene("allegro-grasp")));
    let bench = bench(text(palpate_fixtures::bench("allegro-hand")));
    let scene = folder.write("scene.toml", &scene);
    let bench = folder.write("hand.toml", &bench);
    folder.write(
        "weak.toml",
        "name = \"weak\"\ndescription = \"A weak hand.\"\n\n[hand_power]\nover_60s_mw = 100.0\n",
    );
    let args = [
        OsStr::new("run"),
        scene.as_os_str(),
        OsStr::new("--bench"),
        bench.as_os_str(),
    ];
    refused(&args)
}

const fn as_is(text: String) -> String {
    text
}

fn on_channels(first: u8) -> String {
    let output = |c| format!("{{ board = 0x40, channel = {c} }}");
    let outputs: Vec<String> = (first..first + 8).map(output).collect();
    format!("outputs = [{}]\n", outputs.join(", "))
}

#[test]
fn displays_that_cannot_be_end_with_status_2() {
    let says = |message: &str, words: &[&str]| {
        for word in words {
            assert!(message.contains(word), "no `{word}` in: {message}");
        }
    };
    let twice = |text: String| {
        let (head, _) = text.split_once("[[displays]]").unwrap();
        let display =
            |name: &str, first| format!("[[displays]]\nname = \"{name}\"\n{}", on_channels(first));
        format!("{head}{}{}", display("index", 0), display("middle", 7))
    };
    says(
        &run("channel", as_is, twice),
        &[
            "hand.toml:",
            "displays[1].outputs[0].channel: expected an output of its own: display `index` has channel 7 of board 0x40, found 7",
        ],
    );
    let supply = |text: String| {
        text.replace(
            "[amplifier]",
            "drive.supply_limit_ma = 2000.0\n\n[amplifier]",
        )
    };
    says(
        &run("supply", as_is, supply),
        &[
            "hand.toml:",
            "drive.supply_limit_ma: expected at least 2400 mA: 2 boards with one wire of 1200 mA each",
            "found 2000 mA",
        ],
    );
    let idle = |text: String| text.replace("modules = [12, 13, 14]", "modules = [12, 13]");
    says(
        &run("idle", idle, as_is),
        &[
            "scene.toml:",
            "fingers: expected all 15 modules of `allegro`, each once",
            "found none with module 14 (`thumb-middle`), which drives nothing",
        ],
    );
    let no_rule = |text: String| text.replacen("rule = \"first\"\n", "", 1);
    says(
        &run("rule", no_rule, as_is),
        &[
            "scene.toml:",
            "fingers[0].rule: expected \"first\" or \"merged\": how several modules drive one display",
        ],
    );
    let close = |text: String| {
        format!("illusion = {{ model = \"balanced\", soa_ms = 60.0, tau_d_ms = 38.0 }}\n{text}")
    };
    says(
        &run("stagger", close, as_is),
        &[
            "hand.toml:",
            "displays: expected at most 1 per board: bursts of 38",
        ],
    );
    let weak = |text: String| text.replacen("wire.kind", "limits = \"weak.toml\"\nwire.kind", 1);
    says(
        &run("hand", as_is, weak),
        &[
            "weak.toml:5: hand_power.over_60s_mw: expected at least 120 mW: 4 displays on one hand with a moving contact of 30 mW each, found 100 mW",
        ],
    );
}

#[test]
fn a_plan_says_what_drives_each_finger_and_when() {
    let folder = Folder::new("plan-of-fingers");
    let scene = palpate_fixtures::scene("allegro-grasp").unwrap();
    let scene = scene.replacen("rule = \"first\"", "rule = \"merged\"", 1);
    let (thumb, joint) = (
        "modules = [12, 13, 14]\nrule = \"first\"\n",
        "when = { joint = \"mcp\", above_deg = 20.0 }\n",
    );
    let scene = scene.replace(thumb, &format!("{thumb}{joint}"));
    let joints = "\n[[joints]]\nname = \"mcp\"\npoints_s_deg = [[0.0, 0.0], [1.0, 40.0]]\n";
    let scene = folder.write("scene.toml", &format!("{scene}{joints}"));
    let scene = scene.display().to_string();
    let said = good(&["run", &scene, "--bench", "allegro-hand", "--explain"]);
    for words in [
        "fingers         index: 4 modules merged; middle: `middle-tip` of 4 modules;",
        "thumb: `thumb-tip` of 3 modules, felt while joint mcp is above 20 degrees",
        "for each of 15 modules, for all together where they are merged",
        "the hull of the modules that drive a finger fills its display",
    ] {
        assert!(said.contains(words), "no `{words}` in: {said}");
    }
}
