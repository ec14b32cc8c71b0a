//! `hil texture panel`: what a simulated panel says of textures, as a table, JSON and a drawing.

use std::io::{self, Write};

use palpate_core::statistics::mean;
use palpate_emulators::person::panel::{Dimension, REPEATS, SUBJECTS, Sensation};
use palpate_emulators::sensor::surface::{SurfaceTexture, spearman};
use palpate_files::{Format, Overrides, Setup, TextureModel, TextureTable, load_textures};
use palpate_run::Failure;
use palpate_run::plan::surface;
use palpate_texture::panel::draw::{SIGNIFICANT, draw};
use palpate_texture::panel::stage::Shown;
use palpate_texture::panel::statistics::Box5;
use palpate_texture::panel::{self, Label, Rated, Study, Test};
use palpate_texture::round;
use serde_json::{Map, Value, json};

use crate::cli::PanelArgs;
use palpate_live::output::{Outputs, print, print_json};
use palpate_live::progress::Progress;

/// The scene whose texture section says how latent vectors become pulses.
const SCENE: &str = "texture-wood";

/// Rates textures, emulated or recorded.
///
/// # Errors
/// A model, bench, table or recording that cannot be used; a file that cannot be written.
pub fn panel(args: &PanelArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let mut overrides = Overrides::default();
    overrides.scene("--person", "illusion.person", &args.person);
    overrides.scene("--driver", "texture.driver", &args.driver);
    if let Some(level_db) = args.level {
        overrides.scene("--level", "illusion.level_db", level_db);
    }
    let setup = Setup::load(SCENE, &args.bench)?.with(&overrides)?;
    let outputs = Outputs::new(args.force);
    outputs.check_some(args.svg.as_deref(), Format::Svg)?;
    let shown = Progress::of_part("panel");
    let (title, study, bare) = match (&args.recordings, args.rate) {
        (Some(folder), Some(rate_hz)) => {
            let labels = Label::all(folder)?;
            let passed = |part| shown.part(part);
            let study = panel::recorded(&model, &labels, rate_hz, (&setup, args.seed), passed)?;
            let title = format!("Recordings of {} rated", folder.display());
            (title, study, None)
        }
        _ => {
            let table = load_textures(&args.textures)?.value;
            // One panel with tape, then one without.
            let rate = |pairing, before: f64| {
                let passed = |part: f64| shown.part((before + part) / 2.0);
                panel::emulated(&model, &table, pairing, (&setup, args.seed), passed)
            };
            let (study, bare) = (rate(panel::taped, 0.0)?, rate(panel::bare, 1.0)?);
            let ranks = ranks(&study, &table);
            let title = format!("{} textures rated", study.textures.len());
            (title, study, Some((bare, ranks)))
        }
    };
    drop(shown);
    outputs.write_some(args.svg.as_deref(), Format::Svg, || draw(&study, &title))?;
    if args.json {
        return print_json(&as_json(args, &study, bare.as_ref()));
    }
    print(|out| match &bare {
        Some((bare, ranks)) => table_of_textures(&study, bare, ranks, out),
        None => table_of_recordings(&study, out),
    })
}

/// Spearman's rank correlations of pairs of quantities over textures, three decimals, each by its name.
type Ranks = [(&'static str, f64); 6];

fn ranks(study: &Study, table: &TextureTable) -> Ranks {
    let surfaces = || table.texture.iter().map(surface);
    let of = |rated: &dyn Fn(&Rated) -> Option<f64>| -> Vec<f64> {
        let each = study.textures.iter().map(rated);
        each.map(|value| value.unwrap_or(f64::NAN)).collect()
    };
    let felt = |part: fn(&Shown) -> Option<f64>| of(&|t| mean(t.shown.iter().filter_map(part)));
    let middle = |ratings: &[u8]| mean(ratings.iter().map(|r| f64::from(*r)));
    let display = |d: usize| of(&|t| middle(&t.display[d]));
    let bare = |d: usize| of(&|t| middle(&t.bare.as_ref()?[d + 1]));
    let rank = |of: &[f64], with: &[f64]| round(spearman(of, with));
    let own = |property: fn(&SurfaceTexture) -> f64| -> Vec<f64> {
        surfaces().map(|surface| property(&surface)).collect()
    };
    let relief = own(|s| s.relief_mm);
    [
        (
            "roughness felt, from pulse to pulse: with relief",
            rank(&felt(|s| s.sensation.coarseness), &relief),
        ),
        (
            "friction felt, from wire to wire: with friction",
            rank(&felt(|s| s.sensation.slowness), &own(|s| s.friction)),
        ),
        (
            "hardness felt, strength of taps: with stiffness",
            rank(&felt(|s| s.tap_db), &own(|s| s.stiffness_n_per_mm)),
        ),
        (
            "roughness that drives: with relief",
            rank(&of(&|t| Some(t.driven)), &relief),
        ),
        (
            "roughness rated on the display: with the bare finger's",
            rank(&display(0), &bare(0)),
        ),
        (
            "friction rated on the display: with the bare finger's",
            rank(&display(1), &bare(1)),
        ),
    ]
}

fn sensation(felt: &Sensation) -> Value {
    json!({
        "pulses_apart_ms": felt.coarseness.map(|log| round(1e3 * log.exp())),
        "wires_apart_ms": felt.slowness.map(|log| round(1e3 * log.exp())),
    })
}

/// A texture's ratings and what was felt of it on the display.
fn of_texture(rated: &Rated, tests: Vec<Test>) -> Value {
    let mut ratings = Map::new();
    let mut add = |name: String, all: &[u8]| ratings.insert(name, json!(Box5::new(all)));
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
        "intensity": mean(rated.shown.iter().map(|s| s.intensity)).map(round),
        "level_db": mean(rated.shown.iter().filter_map(|s| s.level_db)).map(round),
        "tap_db": mean(rated.shown.iter().filter_map(|s| s.tap_db)).map(round),
        "pulses": mean(rated.shown.iter().map(|s| s.pulses as f64)).map(round),
        "boxes": ratings,
        "tests": tests,
    })
}

/// Everything that was rated, and the same textures under a module that slides as a finger does.
fn as_json(args: &PanelArgs, study: &Study, bare: Option<&(Study, Ranks)>) -> Value {
    let all = |study: &Study, tests: &dyn Fn(usize, &Rated) -> Vec<Test>| -> Value {
        let textures = study.textures.iter().enumerate();
        textures.map(|(n, t)| of_texture(t, tests(n, t))).collect()
    };
    let mut whole = json!({
        "source": "simulated panel on an emulated display",
        "model": args.model,
        "driver": args.driver,
        "bench": args.bench,
        "person": args.person,
        "seed": args.seed,
        "subjects": SUBJECTS,
        "repeats": REPEATS,
        "ends": {"smooth": sensation(&study.ends.smooth), "rough": sensation(&study.ends.rough)},
        "textures": all(study, &|n, t| match bare {
            Some(_) => t.against_bare(),
            None => t.against(&study.textures[n + 1..]),
        }),
    });
    if let Some((bare, ranks)) = bare {
        whole["with_a_fingers_friction"] = all(bare, &|_, t| t.against_bare());
        let ranks = ranks.iter().map(|(what, rank)| (*what, *rank));
        whole["spearman"] = ranks.collect();
    }
    whole
}

/// Whole numbers as such, others with two decimals.
fn number(value: f64) -> String {
    let decimals = if value.fract() == 0.0 { 0 } else { 2 };
    format!("{value:.decimals$}")
}

fn median(ratings: Option<&[u8]>) -> String {
    let found = ratings.and_then(Box5::new);
    found.map_or("-".into(), |found| number(found.median))
}

fn heading(out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "SIMULATED panel on an emulated display: {SUBJECTS} subjects, {REPEATS} repeats, medians of ratings 1 to 6\n"
    )
}

fn table_of_textures(
    study: &Study,
    bare: &Study,
    ranks: &Ranks,
    out: &mut dyn Write,
) -> io::Result<()> {
    heading(out)?;
    writeln!(
        out,
        "               hardness |        roughness         |         friction         | finger's friction"
    )?;
    writeln!(
        out,
        "                 finger |  finger  display       p |  finger  display       p | roughness friction"
    )?;
    for (t, bare) in study.textures.iter().zip(&bare.textures) {
        let finger = |d: usize| median(t.bare.as_ref().map(|all| &*all[d]));
        let tests = t.against_bare();
        let p = |d: usize| {
            tests.get(d).map_or("-".into(), |test| {
                format!(
                    "{:.3}{}",
                    test.p,
                    if test.p < SIGNIFICANT { "*" } else { " " }
                )
            })
        };
        write!(out, "{:<14} {:>8}", t.name, finger(0))?;
        for d in 0..2 {
            let display = median(Some(&t.display[d]));
            write!(out, " | {:>7} {display:>8} {:>7}", finger(d + 1), p(d))?;
        }
        let [roughness, friction] = bare.display.each_ref().map(|all| median(Some(all)));
        writeln!(out, " | {roughness:>9} {friction:>8}")?;
    }
    writeln!(
        out,
        "\n* differs from the bare finger, Mann-Whitney U, p < {SIGNIFICANT}\n\
         finger's friction: the display's medians, had the module slid as a finger does\n"
    )?;
    for (what, rank) in ranks {
        writeln!(out, "{what:<54} rank correlation {:>5}", number(*rank))?;
    }
    Ok(())
}

fn table_of_recordings(study: &Study, out: &mut dyn Write) -> io::Result<()> {
    heading(out)?;
    writeln!(out, "                      driven roughness friction")?;
    for t in &study.textures {
        let [roughness, friction] = t.display.each_ref().map(|all| median(Some(all)));
        let driven = number(round(t.driven));
        writeln!(
            out,
            "{:<20} {driven:>7} {roughness:>9} {friction:>8}",
            t.name
        )?;
    }
    let pairs = study.textures.iter().enumerate();
    let tests: Vec<Test> = pairs
        .flat_map(|(n, t)| t.against(&study.textures[n + 1..]))
        .collect();
    for dimension in panel::ON_DISPLAY.map(Dimension::name) {
        let of = || tests.iter().filter(|t| t.dimension == dimension);
        writeln!(
            out,
            "\ntold apart by {dimension} (Mann-Whitney U, p < {SIGNIFICANT}): {} of {} pairs",
            of().filter(|t| t.p < SIGNIFICANT).count(),
            of().count()
        )?;
    }
    Ok(())
}
