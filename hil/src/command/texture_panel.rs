//! `hil texture panel`: what a simulated panel says of textures, as a table, JSON and a drawing.

use std::io::{self, Write};

use palpate_emulators::panel::{Dimension, REPEATS, SUBJECTS, Sensation};
use serde_json::{Value, json};

use crate::cli::PanelArgs;
use crate::failure::Failure;
use crate::output::{print, write_file};
use crate::texture::TextureModel;
use crate::texture::panel::draw::{SIGNIFICANT, draw};
use crate::texture::panel::statistics::Box5;
use crate::texture::panel::{self, Label, Rated, Study, Test};
use palpate_emulators::surface::spearman;
use palpate_files::{Setup, load_textures};

/// The scene whose texture section says how latent vectors become pulses.
const SCENE: &str = "texture-wood";

/// Rates textures, emulated or recorded.
///
/// # Errors
/// A model, bench, table or recording that cannot be used; a file that cannot be written.
pub fn panel(args: &PanelArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let setup = Setup::load(SCENE, &args.bench)?;
    let (title, study, found) = match (&args.recordings, args.rate) {
        (Some(folder), Some(rate_hz)) => {
            let labels = Label::all(folder)?;
            let study = panel::recorded(&model, &labels, rate_hz, &setup, args.seed)?;
            let title = format!("Recordings of {} rated", folder.display());
            let found = of_recordings(&study);
            (title, study, found)
        }
        _ => {
            let table = load_textures(&args.textures)?.value;
            let rate = |pairing| panel::emulated(&model, &table, pairing, &setup, args.seed);
            let (study, skin) = (rate(panel::taped)?, rate(panel::bare)?);
            let truth: Vec<f64> = table
                .texture
                .iter()
                .map(|t| crate::texture::explore::surface(t).drag_roughness())
                .collect();
            let found = of_textures(&study, &skin, &truth);
            ("The eight textures rated".to_owned(), study, found)
        }
    };
    if let Some(path) = &args.svg {
        write_file(path, |out| out.write_all(draw(&study, &title).as_bytes()))?;
    }
    let mut whole = json!({
        "source": "simulated panel on an emulated display",
        "model": args.model,
        "bench": args.bench,
        "seed": args.seed,
        "subjects": SUBJECTS,
        "repeats": REPEATS,
        "ends": {"smooth": sensation(&study.ends.smooth), "rough": sensation(&study.ends.rough)},
    });
    if let (Some(whole), Some(found)) = (whole.as_object_mut(), found.as_object()) {
        whole.extend(found.clone());
    }
    print(|out| {
        if args.json {
            writeln!(out, "{whole}")
        } else {
            table(&whole, out)
        }
    })
}

/// Three decimals; no minus before a zero.
fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    (count > 0.0).then(|| sum / count)
}

fn sensation(felt: &Sensation) -> Value {
    json!({
        "pulses_apart_ms": felt.coarseness.map(|log| round(1e3 * log.exp())),
        "wires_apart_ms": felt.slowness.map(|log| round(1e3 * log.exp())),
    })
}

/// A texture's ratings and what was felt of it on the display.
fn of_texture(rated: &Rated, tests: Vec<Test>) -> Value {
    let mut ratings = serde_json::Map::new();
    let mut add = |name: String, all: &[u8]| ratings.insert(name, json!(Box5::of(all)));
    for (d, all) in rated.bare.iter().flat_map(|b| Dimension::ALL.iter().zip(b)) {
        add(format!("bare {}", d.name()), all);
    }
    for (d, all) in panel::ON_DISPLAY.iter().zip(&rated.display) {
        add(format!("display {}", d.name()), all);
    }
    let of = |part: fn(&Sensation) -> Option<f64>| {
        mean(rated.shown.iter().filter_map(|s| part(&s.sensation)))
    };
    json!({
        "name": rated.name,
        "driven": round(rated.driven),
        "felt": sensation(&Sensation { coarseness: of(|s| s.coarseness), slowness: of(|s| s.slowness) }),
        "intensity": mean(rated.shown.iter().map(|s| s.intensity.felt())).map(round),
        "pulses": mean(rated.shown.iter().map(|s| s.pulses as f64)).map(round),
        "boxes": ratings,
        "tests": tests,
    })
}

/// Emulated textures, and the same ones under a module that slides as a finger does.
fn of_textures(study: &Study, skin: &Study, truth: &[f64]) -> Value {
    let textures = study
        .textures
        .iter()
        .map(|t| of_texture(t, t.against_bare()));
    let paired = skin
        .textures
        .iter()
        .map(|t| of_texture(t, t.against_bare()));
    let rank = |of: &dyn Fn(&Rated) -> f64, with: &[f64]| {
        let values: Vec<f64> = study.textures.iter().map(of).collect();
        round(spearman(&values, with))
    };
    let middle = |ratings: &[u8]| mean(ratings.iter().map(|r| f64::from(*r))).unwrap_or(f64::NAN);
    let bare: Vec<f64> = study
        .textures
        .iter()
        .map(|t| t.bare.as_ref().map_or(f64::NAN, |b| middle(&b[1])))
        .collect();
    json!({
        "textures": textures.collect::<Vec<_>>(),
        "with_a_fingers_friction": paired.collect::<Vec<_>>(),
        "spearman": {
            "roughness that drives, with the surface's": rank(&|t| t.driven, truth),
            "roughness rated on the display, with the surface's": rank(&|t| middle(&t.display[0]), truth),
            "roughness rated on the display, with the bare finger's": rank(&|t| middle(&t.display[0]), &bare),
        },
    })
}

/// Recordings: who is told from whom.
fn of_recordings(study: &Study) -> Value {
    let textures: Vec<Value> = study
        .textures
        .iter()
        .enumerate()
        .map(|(n, t)| of_texture(t, t.against(&study.textures[n + 1..])))
        .collect();
    json!({"textures": textures})
}

fn number(value: &Value) -> String {
    match value.as_f64() {
        Some(v) if v.fract() == 0.0 => format!("{v:.0}"),
        Some(v) => format!("{v:.2}"),
        None => "-".into(),
    }
}

/// p of a texture's test of a dimension.
fn p(texture: &Value, dimension: &str) -> Option<f64> {
    let tests = texture["tests"].as_array()?;
    tests.iter().find(|t| t["dimension"] == dimension)?["p"].as_f64()
}

fn marked(p: Option<f64>) -> String {
    p.map_or("-".into(), |p| {
        format!("{p:.3}{}", if p < SIGNIFICANT { "*" } else { " " })
    })
}

fn table(whole: &Value, out: &mut dyn Write) -> io::Result<()> {
    let textures = || whole["textures"].as_array().into_iter().flatten();
    let skin = whole["with_a_fingers_friction"].as_array();
    writeln!(
        out,
        "SIMULATED panel on an emulated display: {SUBJECTS} subjects, {REPEATS} repeats, medians of ratings 1 to 6\n"
    )?;
    if let Some(skin) = skin {
        writeln!(
            out,
            "{:<14} {:>8} | {:^24} | {:^24} | finger's friction",
            "", "hardness", "roughness", "friction"
        )?;
        writeln!(
            out,
            "{:<14} {:>8} | {:>7} {:>8} {:>7} | {:>7} {:>8} {:>7} | {:>9} {:>8}",
            "",
            "finger",
            "finger",
            "display",
            "p",
            "finger",
            "display",
            "p",
            "roughness",
            "friction"
        )?;
        for (texture, skin) in textures().zip(skin) {
            let median = |key: &str| number(&texture["boxes"][key]["median"]);
            writeln!(
                out,
                "{:<14} {:>8} | {:>7} {:>8} {:>7} | {:>7} {:>8} {:>7} | {:>9} {:>8}",
                texture["name"].as_str().unwrap_or_default(),
                median("bare hardness"),
                median("bare roughness"),
                median("display roughness"),
                marked(p(texture, "roughness")),
                median("bare friction"),
                median("display friction"),
                marked(p(texture, "friction")),
                number(&skin["boxes"]["display roughness"]["median"]),
                number(&skin["boxes"]["display friction"]["median"]),
            )?;
        }
        writeln!(
            out,
            "\n* differs from the bare finger, Mann-Whitney U, p < {SIGNIFICANT}"
        )?;
        writeln!(
            out,
            "finger's friction: the display's medians, had the module slid as a finger does\n"
        )?;
        for (what, value) in whole["spearman"].as_object().into_iter().flatten() {
            writeln!(out, "{what:<54} rank correlation {:>5}", number(value))?;
        }
        return Ok(());
    }
    writeln!(
        out,
        "{:<20} {:>7} {:>9} {:>8}",
        "", "driven", "roughness", "friction"
    )?;
    for texture in textures() {
        let median = |key: &str| number(&texture["boxes"][key]["median"]);
        writeln!(
            out,
            "{:<20} {:>7} {:>9} {:>8}",
            texture["name"].as_str().unwrap_or_default(),
            number(&texture["driven"]),
            median("display roughness"),
            median("display friction"),
        )?;
    }
    for dimension in panel::ON_DISPLAY {
        let tests = || textures().flat_map(|t| t["tests"].as_array().into_iter().flatten());
        let of = || tests().filter(|t| t["dimension"] == dimension.name());
        let apart = of().filter(|t| t["p"].as_f64().is_some_and(|p| p < SIGNIFICANT));
        writeln!(
            out,
            "\ntold apart by {} (Mann-Whitney U, p < {SIGNIFICANT}): {} of {} pairs",
            dimension.name(),
            apart.count(),
            of().count()
        )?;
    }
    Ok(())
}
