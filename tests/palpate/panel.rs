//! The simulated panel over emulated textures and over recordings of real sensors, the whole way to the wires.

use std::path::{Path, PathBuf};

use palpate_files::{Setup, TextureModel, TextureTable, load_textures};
use palpate_texture::panel::{Label, Study, bare, emulated, recorded, taped};

const BENCHES: [&str; 2] = ["emulated", "three-in-line"];

/// The default person's fingers on a bench.
fn setup(bench: &str) -> Setup {
    Setup::load("texture-wood", bench).unwrap()
}

/// What the studies are told by: a rough texture, the one that fails, one that grips.
fn table() -> TextureTable {
    let mut table = load_textures("thesis").unwrap().value;
    let kept = ["sponge1", "handkerchief", "shoe-sole"];
    table.texture.retain(|t| kept.contains(&t.name.as_str()));
    table
}

fn tell(what: &str, study: &Study) {
    for t in &study.textures {
        let mean = |all: &[u8]| all.iter().map(|r| f64::from(*r)).sum::<f64>() / all.len() as f64;
        let pulses: usize = t.shown.iter().map(|s| s.pulses).sum();
        println!(
            "{what} {:<14} driven {:.2}, display {:.2} {:.2}, {pulses} pulses",
            t.name,
            t.driven,
            mean(&t.display[0]),
            mean(&t.display[1]),
        );
    }
}

/// Twelve trials of each texture on both displays, the same again from the same seed, and pulses in all of them.
#[test]
fn a_panel_rates_textures_on_both_displays() {
    let model = TextureModel::open("default").unwrap();
    let table = table();
    for bench in BENCHES {
        let setup = setup(bench);
        let rate = |seed| emulated(&model, &table, taped, (&setup, seed), |_| ()).unwrap();
        let study = rate(2);
        tell(bench, &study);
        assert_eq!(study.textures.len(), 3);
        for t in &study.textures {
            let sets = t.bare.iter().flatten().chain(&t.display);
            for ratings in sets {
                assert_eq!(ratings.len(), 12);
                assert!(ratings.iter().all(|r| (1..=6).contains(r)));
            }
            assert!(t.shown.iter().all(|s| s.pulses > 0), "{}", t.name);
            // Met again, each is felt; three weak wires cannot do that.
            let is_felt = t.shown.iter().all(|s| s.tap_db.unwrap() > 0.0);
            assert_eq!(is_felt, bench == "emulated", "{t:?}");
            assert_eq!(t.against_bare().len(), 2);
        }
        let tap_db = |name: &str, pick: fn(f64, f64) -> f64| {
            let of = study.textures.iter().find(|t| t.name == name).unwrap();
            let all = of.shown.iter().filter_map(|s| s.tap_db);
            all.reduce(pick).unwrap()
        };
        let (soft, hard) = (tap_db("sponge1", f64::max), tap_db("shoe-sole", f64::min));
        println!("{bench}: taps of sponge1 at most {soft:.1} dB, of shoe-sole at least {hard:.1}");
        let at_least = if bench == "emulated" { 1.65 } else { 0.0 };
        assert!(hard > soft + at_least);
        let (smooth, rough) = (study.ends.smooth, study.ends.rough);
        if bench == "emulated" {
            assert!(smooth.coarseness < rough.coarseness, "{:?}", study.ends);
            assert!(smooth.slowness < rough.slowness, "{:?}", study.ends);
        } else {
            // Who does not feel the rough end has no scale.
            assert_eq!([rough.coarseness, rough.slowness], [None; 2]);
        }
        if bench == "emulated" {
            assert_eq!(study, rate(2));
            assert_ne!(study, rate(3));
        }
    }
}

/// The thesis blames the handkerchief's failure on the sensor's friction: under a module that slides as a finger does, it is
/// felt to slide faster, and as rough as before.
#[test]
fn the_sensors_friction_slows_the_handkerchief_and_leaves_its_roughness_alone() {
    let model = TextureModel::open("default").unwrap();
    let table = table();
    let setup = setup("emulated");
    let of = |study: &Study| {
        let mut all = study.textures.iter();
        let found = all.find(|t| t.name == "handkerchief").unwrap();
        let slow = found.shown.iter().filter_map(|s| s.sensation.slowness);
        let (sum, count) = slow.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
        (found.driven, sum / count)
    };
    let tape = of(&emulated(&model, &table, taped, (&setup, 2), |_| ()).unwrap());
    let skin = of(&emulated(&model, &table, bare, (&setup, 2), |_| ()).unwrap());
    println!("handkerchief, roughness and log of slowness: {tape:?} with tape, {skin:?} with skin");
    assert!((skin.0 - tape.0).abs() < 0.1);
    assert!(skin.1 < tape.1 - 0.5);
}

/// The folder of recordings, and a model that was trained on them; said visibly where one is not at hand.
fn real(set: &str, model: &str) -> Option<(PathBuf, TextureModel)> {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let folder = data.join(set);
    if !folder.is_dir() {
        println!("skipped: no recordings");
        return None;
    }
    let Some(models) = std::env::var_os("PALPATE_MODELS") else {
        println!(
            "skipped: no models of recordings; PALPATE_MODELS names their folder, docs/texture-training.md says how they are trained"
        );
        return None;
    };
    let path = Path::new(&models).join(format!("{model}.safetensors"));
    if !path.is_file() {
        println!("skipped: no model {}", path.display());
        return None;
    }
    Some((folder, TextureModel::open(&path.to_string_lossy()).unwrap()))
}

fn check(study: &Study, labels: usize) {
    assert_eq!(study.textures.len(), labels);
    for t in &study.textures {
        assert_eq!(t.bare, None);
        assert!(t.display.iter().all(|all| all.len() == 12));
        assert!(t.shown.iter().all(|s| s.pulses > 0), "{}", t.name);
    }
}

#[test]
fn seven_fabrics_reach_the_wires() {
    let Some((folder, model)) = real("fabric_slide", "fabric") else {
        return;
    };
    let labels = Label::all(&folder).unwrap();
    let study = recorded(&model, &labels, 34.0, (&setup("emulated"), 2), |_| ()).unwrap();
    tell("fabric", &study);
    check(&study, 7);
}

/// The iCub's slides as CSV files, `MATERIAL_SLIDE.csv`: in memory 10 columns x 75 steps x 6 rows a slide.
fn slides(folder: &Path, out: &Path) {
    std::fs::create_dir_all(out).unwrap();
    let body = |name: &str| {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        bytes[10 + header..].to_vec()
    };
    for blob in 0..4 {
        let (values, labels) = (
            body(&format!("icub_{blob}.npy")),
            body(&format!("labels_{blob}.npy")),
        );
        let slides = values.chunks_exact(4 * 4500).zip(labels.chunks_exact(8));
        for (n, (slide, label)) in slides.enumerate() {
            let value = |i: usize| f32::from_le_bytes(slide[4 * i..][..4].try_into().unwrap());
            let row = |t: usize| {
                let cell = |f: usize| value((f / 6) * 450 + t * 6 + f % 6).to_string();
                (0..60).map(cell).collect::<Vec<_>>().join(",")
            };
            let text: Vec<String> = (0..75).map(row).collect();
            let name = format!("material{:02}_{blob}{n:03}.csv", label[0]);
            std::fs::write(out.join(name), text.join("\n") + "\n").unwrap();
        }
    }
}

#[test]
fn twenty_materials_reach_the_wires() {
    let Some((folder, model)) = real("icub_texture", "icub") else {
        return;
    };
    let out = std::env::temp_dir().join(format!("palpate-icub-{}", std::process::id()));
    slides(&folder, &out);
    let study = recorded(
        &model,
        &Label::all(&out).unwrap(),
        50.0,
        (&setup("emulated"), 2),
        |_| (),
    )
    .unwrap();
    let _ = std::fs::remove_dir_all(out);
    tell("icub", &study);
    check(&study, 20);
}
