//! Benches of several displays, and scenes that drive them.

use crate::{Bench, FingerRule, Loaded, Scene, Setup, Source, load_bench, load_scene};

const HEAD: &str = "name = \"hand\"\ndescription = \"A hand.\"\n";

fn bench(text: &str) -> Result<Loaded<Bench>, String> {
    let source = Source::new("b.toml", format!("{HEAD}{text}"));
    let value = Bench::read(&source).map_err(|e| e.to_string())?;
    Ok(Loaded { value, source })
}

/// `allegro-grasp` with other [[fingers]].
fn grasp(fingers: &str) -> Loaded<Scene> {
    let text = palpate_fixtures::scene("allegro-grasp").unwrap();
    let first = text.find("[[fingers]]").unwrap();
    let (head, rest) = text.split_at(first);
    let rest = &rest[rest.find("# A tennis ball").unwrap()..];
    let source = Source::new("s.toml", format!("{head}{fingers}\n{rest}"));
    let value = Scene::read(&source).unwrap();
    Loaded { value, source }
}

fn refused(fingers: &str) -> String {
    let hand = load_bench("allegro-hand").unwrap();
    Setup::join(grasp(fingers), hand).unwrap_err().to_string()
}

fn finger(display: &str, modules: &str, rule: &str) -> String {
    format!("[[fingers]]\ndisplay = \"{display}\"\nmodules = {modules}\n{rule}\n")
}

#[test]
fn displays_take_the_outputs_of_one_chip_after_the_other() {
    let bench = load_bench("allegro-hand").unwrap().value;
    let outputs: Vec<_> = bench.outputs.iter().map(|o| (o.board, o.channel)).collect();
    let counted = (0..32).map(|n| (0x40 + n / 16, n % 16));
    assert_eq!(outputs, counted.collect::<Vec<_>>());
    assert_eq!((bench.displays.len(), bench.boards()), (4, 2));
}

#[test]
fn a_scene_says_which_modules_drive_which_display() {
    let hand = load_bench("allegro-hand").unwrap();
    let setup = Setup::join(load_scene("allegro-grasp").unwrap(), hand).unwrap();
    let fingers: Vec<_> = setup
        .fingers
        .iter()
        .map(|f| (&*f.name, f.wires.clone()))
        .collect();
    let wires = [0..8, 8..16, 16..24, 24..32];
    let names = ["index", "middle", "ring", "thumb"];
    assert_eq!(fingers, names.into_iter().zip(wires).collect::<Vec<_>>());
    assert_eq!(setup.fingers[3].modules, [12, 13, 14]);
    assert_eq!(setup.scene.value.fingers[0].rule, Some(FingerRule::First));
    // A bench of one display has `drives`.
    let one = load_bench("emulated").unwrap();
    let setup = Setup::join(load_scene("allegro-grasp").unwrap(), one).unwrap();
    assert!(setup.fingers.is_empty());
}

#[test]
fn benches_that_cannot_be_are_refused() {
    let two =
        |keys: &str| format!("{keys}\n[[displays]]\nname = \"a\"\n[[displays]]\nname = \"b\"\n");
    let on = |name: &str, channels: [u8; 3]| {
        let output = |c| format!("{{ board = 0x40, channel = {c} }}");
        let outputs = channels.map(output).join(", ");
        format!(
            "[[displays]]\nname = \"{name}\"\nlayout = \"three-in-line\"\noutputs = [{outputs}]\n"
        )
    };
    for (text, expected) in [
        (
            on("a", [0, 1, 2]) + &on("b", [3, 1, 4]),
            "displays[1].outputs[1].channel: expected an output of its own: display `a` has channel 1 of board 0x40",
        ),
        (
            on("a", [0, 1, 2]) + &on("a", [3, 4, 5]),
            "displays[1].name: expected a name of its own",
        ),
        (
            on("a", [0, 1, 2]).replace("three-in-line", "thimble-8"),
            "displays[0].outputs: expected 8 outputs, one per wire of `thimble-8`, found 3",
        ),
        (
            on("a", [0, 1, 2]).replacen("{ board", "{ bus = 1, board", 1),
            "displays[0].outputs[1].bus: expected 1: the wires of one display are on one bus",
        ),
        (
            two("drive.current_ma = 1970.0\ndrive.supply_limit_ma = 1975.0")
                + "[[displays]]\nname = \"c\"\n",
            "drive.supply_limit_ma: expected at least 3940 mA: 2 boards with one wire of 1970 mA each, which are not in step, found 1975 mA",
        ),
        (
            two("outputs = [{ board = 0x40, channel = 0 }]"),
            "outputs: expected nothing: every one of [[displays]] has its own",
        ),
        (
            "[[displays]]\nname = \"Index\"\n".to_owned(),
            "displays[0].name: expected lower-case letters",
        ),
        (
            "[[displays]]\nname = \"a\"\nlayout = \"uskin-4x4\"\n".to_owned(),
            "displays[0].layout: expected a layout of kind \"display\"",
        ),
    ] {
        let error = bench(&text).unwrap_err();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

/// A bench of hardware whose displays say this.
fn real(adapters: &str, displays: &str) -> Result<Loaded<Bench>, String> {
    bench(&format!(
        "kind = \"real\"\nwire = {{ kind = \"final-75um\", alloy = \"low\" }}\n[real]\ncan = [\"can0\"]\ni2c = [{adapters}]\n[drive]\ncurrent_ma = 990.0\nsupply_limit_ma = 4000.0\n{displays}"
    ))
}

fn three(name: &str, keys: &str, bus: u8) -> String {
    let output = |channel| format!("{{ bus = {bus}, board = 0x40, channel = {channel} }}");
    let outputs = [0, 1, 2].map(output).join(", ");
    format!("[[displays]]\nname = \"{name}\"\n{keys}\noutputs = [{outputs}]\n")
}

#[test]
fn displays_of_hardware_state_layout_outputs_and_adapter() {
    let layout = "layout = \"three-in-line\"";
    let two = three("a", layout, 0) + &three("b", layout, 1);
    let hand = real("\"/dev/i2c-0\", \"/dev/i2c-1\"", &two).unwrap();
    assert_eq!((hand.value.displays.len(), hand.value.boards()), (2, 2));
    for (displays, expected) in [
        (
            two.clone(),
            "displays[1].outputs[0].bus: expected a number from 0 to 0",
        ),
        (
            three("a", "", 0),
            "displays[0].layout: expected a value: no default stands for a real bench's hardware",
        ),
        (
            format!("[[displays]]\nname = \"a\"\n{layout}\n"),
            "displays[0].outputs: expected a value: no default stands for a real bench's hardware",
        ),
    ] {
        let error = real("\"/dev/i2c-0\"", &displays).unwrap_err();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

#[test]
fn a_real_bench_reads_no_joints() {
    let hand = real(
        "\"/dev/i2c-0\"",
        &three("index", "layout = \"three-in-line\"", 0),
    )
    .unwrap();
    let all = "[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14]";
    let when = "rule = \"first\"\nwhen = { joint = \"mcp\", above_deg = 5 }";
    let error = Setup::join(grasp(&finger("index", all, when)), hand).unwrap_err();
    let expected = "fingers[0].when: expected nothing: a real bench reads no joints";
    assert!(error.to_string().contains(expected), "{error}");
}

fn joint(name: &str, points: &str) -> String {
    format!("[[joints]]\nname = \"{name}\"\npoints_s_deg = {points}\n")
}

#[test]
fn a_joint_is_straight_between_its_points() {
    let joint = crate::Joint {
        name: "mcp".to_owned(),
        points_s_deg: vec![[1.0, 10.0], [3.0, 30.0]],
        press: None,
    };
    let angles = [0.0, 1.0, 2.0, 3.0, 9.0].map(|t| joint.at(t).to_string());
    assert_eq!(angles, ["10", "10", "20", "30", "30"]);
    let gate = crate::Gate {
        joint: 0,
        above_deg: 15.0,
        below_deg: 30.0,
    };
    let joints = [joint];
    let open = [1.0, 2.0, 3.0].map(|t| gate.is_open(&joints, t));
    assert_eq!(open, [false, true, false]);
    assert!(!gate.is_open(&[], 2.0));
}

#[test]
fn joints_that_cannot_be_are_refused() {
    for (joints, expected) in [
        (
            joint("mcp", "[[0.0, 1.0], [0.0, 2.0]]"),
            "joints[0].points_s_deg[1]: expected a time after 0 s",
        ),
        (
            joint("mcp", "[[0.0, nan]]"),
            "joints[0].points_s_deg[0][1]: expected a finite number, found nan",
        ),
        (
            joint("mcp", "[[0.0, 361.0]]"),
            "joints[0].points_s_deg[0]: expected a number from -360 to 360 degrees",
        ),
        (
            joint("mcp", "[]"),
            "joints[0].points_s_deg: expected at least one point",
        ),
        (
            joint("m cp", "[[0.0, 1.0]]"),
            "joints[0].name: expected a name of letters",
        ),
        (
            joint("mcp", "[[0.0, 1.0]]") + &joint("mcp", "[[0.0, 1.0]]"),
            "joints[1].name: expected a name of its own",
        ),
    ] {
        let text = format!("name = \"s\"\ndescription = \"A scene.\"\n{joints}");
        let error = Scene::read(&Source::new("s.toml", text)).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}\n{expected}");
    }
}

const PADS: [(&str, &str); 4] = [
    ("index", "[0, 1, 2, 3]"),
    ("middle", "[4, 5, 6, 7]"),
    ("ring", "[8, 9, 10, 11]"),
    ("thumb", "[12, 13, 14]"),
];

/// All four fingers of the grasp; this is added to the one of that number.
fn fingers_with(number: usize, more: &str) -> String {
    let all = PADS.iter().enumerate().map(|(index, (display, modules))| {
        let more = if index == number { more } else { "" };
        finger(display, modules, &format!("rule = \"first\"\n{more}"))
    });
    all.collect()
}

#[test]
fn each_finger_has_its_own_texture_and_strokes() {
    let more = "[fingers.texture]\nsurface = \"wood\"\nrubs = true\ncarrier = \"contacts\"\n[[fingers.strokes]]\nstart_s = 20.0\nlength_s = 0.5\nfrom_mm = [0, -9]\nto_mm = [0, 9]";
    let hand = load_bench("allegro-hand").unwrap();
    let setup = Setup::join(grasp(&fingers_with(2, more)), hand).unwrap();
    let (felt, stroked) = setup.fingers[2].texture.as_ref().unwrap();
    assert_eq!((felt.module, felt.rubs), (Some(8), true));
    assert_eq!(stroked.surface.as_ref().unwrap().name, "wood");
    assert_eq!(setup.fingers[2].strokes.len(), 1);
    assert!(setup.texture.is_none() && setup.fingers[3].texture.is_none());
    // A bench of one display takes no notice.
    let one = load_bench("emulated").unwrap();
    let setup = Setup::join(grasp(&fingers_with(2, more)), one).unwrap();
    assert!(setup.texture.is_none());
}

#[test]
fn textures_and_strokes_that_cannot_be_a_fingers_are_refused() {
    let of = |more: &str| fingers_with(3, more);
    for (fingers, expected) in [
        (
            of("texture = { surface = \"wood\", carrier = \"contacts\", module = 0 }"),
            "fingers[3].texture.module: expected one of the finger's modules, [12, 13, 14], found 0",
        ),
        (
            of("texture = { surface = \"wood\" }"),
            "fingers[3].texture.carrier: expected \"contacts\", or a board of its own: display `ring` has bursts on board 0x41 too",
        ),
        (
            of("texture = { surface = \"wool\", carrier = \"contacts\" }"),
            "fingers[3].texture.surface: expected a texture of `thesis`",
        ),
    ] {
        let error = refused(&fingers);
        assert!(error.contains(expected), "{error}\n{expected}");
    }
    for (more, expected) in [
        (
            "texture = { surface = \"wood\", strokes_s = [0.1] }",
            "fingers[3].texture.strokes_s[0]: expected a number from 0.51",
        ),
        (
            "strokes = [{ start_s = 31.0, length_s = 0.5, from_mm = [0, 0], to_mm = [1, 0] }]",
            "fingers[3].strokes[0].start_s: expected from 0 s",
        ),
    ] {
        let text = format!("name = \"s\"\ndescription = \"A scene.\"\n{}", of(more));
        let error = Scene::read(&Source::new("s.toml", text)).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}\n{expected}");
    }
    // What a bench of one display takes is no finger's.
    let hand = load_bench("allegro-hand").unwrap();
    let rubs = load_scene("sphere-rubs-sponge1").unwrap();
    let text = format!("{}\n{}", rubs.source.text(), finger("index", "[0]", ""));
    let source = Source::new("s.toml", text);
    let value = Scene::read(&source).unwrap();
    let error = Setup::join(Loaded { value, source }, hand).unwrap_err();
    let expected = "texture: expected nothing on a bench of several displays: each of [[fingers]] has its own, such as `fingers[0].texture`";
    assert!(error.to_string().contains(expected), "{error}");
}

#[test]
fn scenes_that_cannot_drive_them_are_refused() {
    let first = "rule = \"first\"";
    let all = "[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14]";
    for (fingers, expected) in [
        (
            String::new(),
            "fingers: expected [[fingers]]: what drives the bench's displays `index`",
        ),
        (
            finger("index", "[0, 1, 2, 3]", first),
            "fingers: expected all 15 modules of `allegro`, each once",
        ),
        (
            finger("index", "[0, 1, 2, 3]", first),
            "found none with module 4 (`middle-tip`), which drives nothing",
        ),
        (
            finger("index", all, first) + &finger("ring", "[8]", ""),
            "fingers[1].modules[0]: expected a module of one finger: it drives `index` already, found 8",
        ),
        (
            finger("index", all, ""),
            "fingers[0].rule: expected \"first\" or \"merged\"",
        ),
        (
            finger("index", "[0]", first),
            "fingers[0].rule: expected nothing: one module needs no rule",
        ),
        (
            finger(
                "index",
                all,
                "rule = \"first\"\nwhen = { joint = \"mcp\", above_deg = 5 }",
            ),
            "fingers[0].when.joint: expected a joint of [[joints]], or of a recording with a column joint_NAME: there is none, found `mcp`",
        ),
        (
            finger("index", all, "rule = \"first\"\nwhen = { joint = \"mcp\" }"),
            "fingers[0].when: expected above_deg, below_deg or both",
        ),
        (
            finger(
                "index",
                all,
                "rule = \"first\"\nwhen = { joint = \"mcp\", above_deg = 5, below_deg = 5 }",
            ),
            "fingers[0].when.below_deg: expected more than above_deg, 5 degrees",
        ),
        (
            finger("index", "[15]", ""),
            "fingers[0].modules[0]: expected a number from 0 to 14",
        ),
        (
            finger("index", "[]", ""),
            "fingers[0].modules: expected at least one module",
        ),
        (
            finger("toe", all, first),
            "fingers[0].display: expected a display of bench `allegro-hand`: `index`, `middle`, `ring`, `thumb`, found \"toe\"",
        ),
    ] {
        let error = refused(&fingers);
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}
