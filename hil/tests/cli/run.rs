//! `hil run`: what it prints, and what a seed means.

use serde_json::Value;

use super::*;

/// A scene short enough to run many times.
fn short(folder: &Folder, seconds: &str) -> String {
    let text = format!(
        "name = \"short\"\ndescription = \"a sphere for a moment\"\nlength_s = {seconds}\n[[touches]]\nstart_s = 0.8\n\
         path = {{ kind = \"line\", points_mm = [[0.0, -7.05], [0.0, 7.05]], period_s = 4.0 }}\n\
         force_n = {{ mean = 0.7, amplitude = 0.3, period_s = 2.7 }}\n"
    );
    folder.write("short.toml", &text).display().to_string()
}

#[test]
fn the_default_is_a_sphere_on_the_emulated_bench() {
    let bare = hil::<&str>(&[]);
    let named = good(&["run", "sphere-along", "--bench", "emulated", "--seed", "1"]);
    assert_eq!(bare.status, Some(0));
    let lines: Vec<&str> = bare.out.lines().collect();
    assert!(lines[0].starts_with("sphere-along on emulated, seed 1: 10.0 s emulated in "));
    assert_eq!((lines.len(), lines[7]), (8, "OK"), "{}", bare.out);
    // All but computing times.
    let timeless = |text: &str| {
        let kept = text.lines().skip(1);
        kept.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(timeless(&bare.out), timeless(&named));
    assert_eq!(good(&["run", "--quiet"]), "");
}

#[test]
fn json_is_one_object_with_every_key_of_the_contract() {
    let text = good(&["run", "--json", "--seed", "7"]);
    assert_eq!(text.lines().count(), 1);
    let summary: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary["source"], "emulated");
    assert_eq!(summary["scene"], "sphere-along");
    assert_eq!(summary["seed"], 7);
    for key in ["frames", "contacts", "stimuli", "limiter_events"] {
        assert!(summary[key].is_u64(), "{key}: {}", summary[key]);
    }
    for key in [
        "energy_mj",
        "peak_supply_a",
        "hottest_wire_c",
        "hottest_skin_c",
        "pwm_hz",
        "sim_s",
        "wall_s",
    ] {
        assert!(summary[key].is_f64(), "{key}: {}", summary[key]);
    }
    for (object, keys) in [
        ("path_error_mm", &["rmse", "max"][..]),
        ("felt_error_mm", &["rmse", "max", "breaks"]),
        ("frame_us", &["median", "p99"]),
        ("taxels", &["frozen", "dead"]),
    ] {
        for key in keys {
            assert!(
                summary[object][key].is_number(),
                "{object}.{key}: {}",
                summary[object]
            );
        }
    }
    for key in ["median", "min"] {
        assert!(summary["taxels"]["refresh_hz"][key].is_number());
    }
    assert!((summary["pwm_hz"].as_f64().unwrap() - 65.63).abs() < 0.01);
    assert!(summary["path_error_mm"]["rmse"].as_f64().unwrap() <= 0.5);
    assert!((summary["sim_s"].as_f64().unwrap() - 10.0).abs() < 1e-9);
}

#[test]
fn without_a_touch_there_is_no_path_to_err_from() {
    let summary: Value = serde_json::from_str(&good(&["run", "idle", "--json"])).unwrap();
    assert_eq!(summary["path_error_mm"], Value::Null);
    assert_eq!(summary["contacts"], 0);
    assert_eq!(summary["stimuli"], 0);
    assert_eq!(summary["felt_error_mm"]["rmse"], Value::Null);
    assert_eq!(summary["felt_error_mm"]["breaks"], Value::Null);
    assert_eq!(summary["onsets"]["meant"], 0);
}

#[test]
fn the_long_summary_has_every_figure_and_ends_with_the_verdict() {
    let said = good(&["run", "idle", "--long"]);
    assert!(
        said.starts_with("idle on emulated (emulated), seed 1\n"),
        "{said}"
    );
    for line in ["  contacts  ", "  felt level ", "  taxels  ", "  margins  "] {
        assert!(said.contains(line), "no `{line}` in: {said}");
    }
    assert!(!said.contains("no break"), "{said}");
    let last = said.lines().last();
    assert_eq!(last, Some("OK: no stimulus: the scene touches nothing"));
    refused(&["run", "idle", "--long", "--json"]);
}

#[test]
fn a_scene_runs_on_the_bench_that_it_wants_and_on_no_bench_without_it() {
    let said = good(&["run", "wifi-outage", "--set", "length_s=3", "--json"]);
    let summary: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(summary["bench"], "unit");
    assert!(summary["unit"].is_object(), "{}", summary["unit"]);
    let needs = [
        "wants: expected a bench with a driver unit, such as `unit`",
        "found bench `emulated`",
    ];
    refused_with(&["run", "wifi-outage", "--bench", "emulated"], &needs);
    refused_with(
        &[
            "sweep",
            "wifi-outage",
            "--bench",
            "warm",
            "--seeds",
            "1..2",
            "--out",
            "no.csv",
        ],
        &needs[..1],
    );
}

#[test]
fn every_built_in_scene_runs_on_every_built_in_bench() {
    for scene in palpate_fixtures::scene_names() {
        for bench in palpate_fixtures::bench_names() {
            let said = hil(&["run", scene, "--bench", bench, "--json"]);
            let bench_file = palpate_files::load_bench(bench).unwrap().value;
            let fingers = palpate_files::load_scene(scene).unwrap().value.fingers;
            let fits = |f: &palpate_files::SceneFinger| {
                bench_file.displays.iter().any(|d| d.name == f.display)
            };
            if palpate_files::load_scene(scene)
                .unwrap()
                .value
                .misses(&bench_file)
                .is_some()
            {
                assert_eq!(said.status, Some(2), "{scene} on {bench}");
                assert!(said.err.contains(": wants: "), "{}", said.err);
                continue;
            }
            if !bench_file.displays.is_empty() && (fingers.is_empty() || !fingers.iter().all(fits))
            {
                assert_eq!(said.status, Some(2), "{scene} on {bench}");
                assert!(said.err.contains("fingers"), "{}", said.err);
                continue;
            }
            if bench_file.haptics.is_some() && said.status == Some(2) {
                // A law, a texture or a fault of wires.
                assert!(said.err.contains("motors"), "{scene}: {}", said.err);
                continue;
            }
            let summary: Value = serde_json::from_str(&said.out).unwrap();
            let meant = summary["onsets"]["meant"].as_u64().unwrap();
            let verdict = match scene {
                "stuck-amplifier" if summary["hottest_wire_c"].is_null() => "beyond-the-model",
                // Where the bench's current is too small to melt anything.
                "stuck-amplifier" => "limit-exceeded",
                _ if 2 * summary["onsets"]["felt"].as_u64().unwrap() < meant => "not-felt",
                _ => "ok",
            };
            let status = i32::from(scene == "stuck-amplifier");
            assert_eq!(
                said.status,
                Some(status),
                "{scene} on {bench}: {}",
                said.err
            );
            assert_eq!(summary["verdict"], verdict, "{scene} on {bench}");
            println!("{scene} on {bench}: {verdict}, {}", summary["onsets"]);
        }
    }
}

#[test]
fn a_bench_with_converters_sets_currents_and_its_records_say_them() {
    let folder = Folder::new("set-current");
    let path = folder.path("a.jsonl").display().to_string();
    let on_bench = ["run", "sphere-along", "--bench", "set-current"];
    good(&[&on_bench[..], &["--quiet", "--schedule", &path]].concat());
    let schedule = folder.text("a.jsonl");
    let lines = schedule
        .lines()
        .map(|l| serde_json::from_str::<Value>(l).unwrap());
    let set: Vec<u64> = lines.filter_map(|l| l["current_ma"].as_u64()).collect();
    assert!(set.iter().all(|ma| (1..=1200).contains(ma)));
    assert!(set.iter().any(|ma| *ma < 1200) && set.contains(&1200));
    let same = hil(&["diff", &path, &path]);
    assert_eq!(same.status, Some(0), "{}", same.err);
    let observed = hil(&[&on_bench[..], &["--observe"]].concat());
    assert_eq!(observed.status, Some(0), "{}", observed.err);
}

#[test]
fn a_run_that_the_guard_only_observes_heats_more_and_says_so_everywhere() {
    const BANNER: &str = "observed: the guard changed nothing; not for a person";
    let folder = Folder::new("observed");
    let run = |observe: bool, more: &[&str]| {
        let mut args = vec!["run", "sphere-along", "--bench", "thesis"];
        args.extend(["--illusion", "phantom"]);
        args.extend(observe.then_some("--observe"));
        args.extend(more);
        hil_in(&folder.0, &args)
    };
    let summary = |observe| {
        let said = run(observe, &["--json"]);
        (
            said.status,
            serde_json::from_str::<Value>(&said.out).unwrap(),
        )
    };
    let ((guarded_status, guarded), (status, observed)) = (summary(false), summary(true));
    assert_eq!((guarded_status, status), (Some(0), Some(1)));
    assert_eq!(observed["verdict"], "limit-exceeded");
    assert_eq!(observed["source"], "observed");
    assert!(observed["why"].as_array().unwrap().contains(&BANNER.into()));
    for hotter in ["hottest_skin_c", "hottest_wire_c", "energy_mj"] {
        let [cool, hot] = [&guarded, &observed].map(|s| s[hotter].as_f64().unwrap());
        assert!(hot > cool, "{hotter}: {hot} after {cool}");
    }
    let records = ["a.jsonl", "a.snap", "a.vcd", "a.mcap", "a.csv"];
    let mut more = vec!["--long", "--html", "a.html"];
    more.extend(records.iter().flat_map(|name| ["--record", name]));
    let said = run(true, &more);
    assert!(
        said.out.contains(&format!("also: {BANNER}")),
        "{}",
        said.out
    );
    assert!(
        said.out
            .contains(&format!("sphere-along on thesis ({BANNER}), seed 1"))
    );
    let noted = observed["limiter_events"].as_u64().unwrap();
    assert!(noted > 100);
    let line = format!("limiter events  0 stimuli changed, {noted} noted");
    assert!(said.out.contains(&line), "{}", said.out);
    for name in [
        "a.html",
        "a.jsonl",
        "a.snap",
        "a.vcd",
        "a.mcap",
        "a.schema.json",
    ] {
        let bytes = fs::read(folder.path(name)).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains(BANNER), "{name}");
    }
    let mut reasons = 0;
    for line in folder.text("a.jsonl").lines().skip(1) {
        let entry: Value = serde_json::from_str(line).unwrap();
        if let Some(asked) = entry["requested"].as_u64() {
            let applied = entry["off"].as_u64().unwrap() - entry["on"].as_u64().unwrap();
            assert_eq!(applied, asked, "{line}");
            reasons += u64::from(entry["reason"].is_string());
        }
    }
    assert_eq!(reasons, noted);
    // Its own schedule and golden read back, and what was noted is no difference between them.
    let same = hil_in(&folder.0, &["diff", "a.snap", "a.snap"]);
    assert_eq!((same.status, same.err.as_str()), (Some(0), ""));
}

#[test]
fn hardware_and_trials_are_never_only_observed() {
    let observe = ["run", "sphere-along", "--observe"];
    let folder = Folder::new("observed");
    let bench = real_bench(&folder);
    let real = ["--bench", &bench];
    let words = ["kind", "\"emulated\"", "found \"real\""];
    refused_with(&[&observe[..], &real].concat(), &words);
    let junit = [&observe[..], &["--junit", "a.xml"]].concat();
    assert_eq!(hil(&junit).status, Some(2));
    assert_eq!(hil(&["test", "--observe"]).status, Some(2));
}

#[test]
fn one_seed_is_one_outcome_byte_for_byte() {
    let folder = Folder::new("seeds");
    let scene = short(&folder, "3.0");
    for (name, seed) in [("a", "5"), ("b", "5"), ("c", "6")] {
        let out = folder.path(name).display().to_string();
        good(&["run", &scene, "--seed", seed, "--out", &out]);
    }
    for file in ["schedule.jsonl", "contacts.csv"] {
        let read = |run: &str| fs::read(folder.path(run).join(file)).unwrap();
        assert!(
            read("a") == read("b"),
            "{file} differs between two runs of one seed"
        );
        assert!(read("a") != read("c"), "{file} is the same for two seeds");
    }
}

#[test]
fn illusion_options_change_the_run_and_are_checked() {
    let folder = Folder::new("illusion");
    let scene = short(&folder, "2.0");
    let schedule = |options: &[&str]| {
        let path = folder.path("s.jsonl").display().to_string();
        let mut args = vec!["run", &scene, "--schedule", &path];
        args.extend(options);
        good(&args);
        folder.text("s.jsonl")
    };
    let balanced = |options: &[&str]| schedule(&[&["--illusion", "balanced"], options].concat());
    let plain = balanced(&[]);
    for options in [
        ["--set", "illusion.shape=2"],
        ["--set", "illusion.alpha=0.005"],
        ["--set", "illusion.beta=0.02"],
        ["--set", "illusion.tau_d_ms=30"],
        ["--set", "illusion.soa_ms=70"],
        ["--intensity", "off"],
    ] {
        assert_ne!(balanced(&options), plain, "{options:?}");
    }
    assert_eq!(schedule(&["--illusion", "inverse"]), schedule(&[]));
    assert_ne!(schedule(&[]), plain);
    assert_ne!(schedule(&["--illusion", "phantom"]), plain);
    assert_eq!(balanced(&["--intensity", "on"]), plain);
    for (options, word) in [
        (
            &["--set", "illusion.shape=nan"][..],
            "--set: illusion.shape: expected",
        ),
        (
            &["--illusion", "magic"],
            "--illusion: illusion.model: expected one of `phantom`, `energy`",
        ),
        (&["--set", "drives=1"], "--set: drives: expected a module"),
        (&["--intensity", "half"], "half"),
    ] {
        let mut args = vec!["run", &scene];
        args.extend(options);
        refused_with(&args, &[word]);
    }
}

#[test]
fn another_person_feels_the_same_run_otherwise() {
    let felt = |person: &str| {
        let text = good(&["run", "--json", "--person", person]);
        let summary: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(summary["felt"]["person"], person);
        summary["felt"]["level_db"]["median"].as_f64().unwrap()
    };
    // Their thresholds of vibration: 0.3 and 1.2 um.
    let apart = felt("sensitive") - felt("dull");
    assert!(
        (apart - 20.0 * (1.2_f64 / 0.3).log10()).abs() < 0.01,
        "{apart}"
    );
    refused_with(
        &["run", "--person", "dul"],
        &["--person: illusion.person", "did you mean `dull`"],
    );
}

#[test]
fn what_is_not_built_is_refused_and_not_ignored() {
    for option in ["--limits", "--seeds"] {
        refused_with(&["run", option], &[option]);
    }
    for name in ["record", "replay", "bench"] {
        refused_with(&[name], &[name]);
    }
    refused(&["run", "--seed", "-1"]);
    refused(&["run", "--seed", "1.5"]);
    refused(&["run", "sphere-along", "idle"]);
    refused(&["run", "--layout", "uskin-4x4"]); // a scene has its own
}

#[test]
fn help_and_version_are_no_errors() {
    for args in [
        &["--help"][..],
        &["--version"],
        &["run", "--help"],
        &["contacts", "--help"],
    ] {
        assert!(!good(args).is_empty());
    }
}

#[test]
fn colour_is_for_terminals_unless_asked_for() {
    let plain = hil(&["run", "nowhere"]).err;
    assert!(!plain.contains('\x1b'), "{plain:?}");
    assert!(
        hil(&["run", "nowhere", "--color", "always"])
            .err
            .contains("\x1b[")
    );
    assert_eq!(hil(&["--color", "never", "run", "nowhere"]).err, plain);
    refused(&["run", "--color", "sometimes"]);
}

#[test]
fn what_burns_is_the_last_that_one_reads_and_has_no_temperature() {
    let said = hil(&["run", "stuck-amplifier"]);
    assert_eq!(said.status, Some(1));
    let last = said.out.lines().last().unwrap();
    let verdict = "BEYOND THE MODEL: a wire passed 400 C, skin passed 100 C by ";
    assert!(last.starts_with(verdict), "{last}");
    assert!(said.out.contains("also: 12 of 13 rows of the limit table"));
    assert!(said.err.contains("BEYOND THE MODEL"), "{}", said.err);
    let widest = said.out.lines().map(|l| l.chars().count()).max().unwrap();
    assert!(widest <= 80, "{widest} columns:\n{}", said.out);
    // No temperature is told as if it were known.
    let long = hil(&["run", "stuck-amplifier", "--long"]).out;
    for number in ["5322", "1202"] {
        assert!(!long.contains(number), "{long}");
    }
    assert!(
        long.contains("hottest wire    beyond the model (over 400 C)"),
        "{long}"
    );
    let json = hil(&["run", "stuck-amplifier", "--json"]).out;
    let summary: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(summary["hottest_wire_c"], Value::Null);
    let folder = Folder::new("run-burns");
    let page = folder.path("burns.html").display().to_string();
    hil(&["run", "stuck-amplifier", "--quiet", "--html", &page]);
    let page = fs::read_to_string(page).unwrap();
    let shown = [
        "&gt; 100 \u{b0}C",
        "> 400 \u{b0}C",
        "Lines end where the model does",
    ];
    for words in shown {
        assert!(page.contains(words), "no `{words}`");
    }
    let mut numbers = page.split(|c: char| !c.is_ascii_digit() && c != '.');
    let told = ["5322.8", "1202.1"];
    assert!(numbers.all(|number| !told.contains(&number)));
    // A scene that expects it passes as a trial, and its run is none the better.
    assert_eq!(hil(&["test", "stuck-amplifier"]).status, Some(0));
    let colored = hil(&["--color", "always", "run", "stuck-amplifier"]);
    let red = "\n\u{1b}[1m\u{1b}[31mBEYOND THE MODEL\u{1b}[0m: ";
    assert!(colored.out.contains(red), "{}", colored.out);
}

#[test]
fn a_log_without_some_boards_is_incomplete_and_names_them() {
    let folder = Folder::new("run-boards-missing");
    let log = folder.path("all.log").display().to_string();
    good(&["run", "allegro-four-buses", "--quiet", "--record", &log]);
    let text = fs::read_to_string(&log).unwrap();
    let first_bus: String = text
        .lines()
        .filter(|l| l.contains(" can0 "))
        .fold(String::new(), |all, line| all + line + "\n");
    assert_ne!(first_bus, "");
    let part = folder.write("part.log", &first_bus).display().to_string();
    let said = hil(&["run", "allegro-four-buses", "--replay", &part]);
    assert_eq!(said.status, Some(1), "{}", said.err);
    let verdict = said.out.split_once("\nINCOMPLETE: no reading of board ");
    let words = verdict.unwrap().1.replace("\n    ", " ");
    assert!(words.contains("the layout expects 15"), "{}", said.out);
}
