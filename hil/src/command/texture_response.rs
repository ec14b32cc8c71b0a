//! `hil texture response` and `materials`: one property at a time.

use std::io::{self, Write};
use std::sync::atomic::{AtomicU32, Ordering};

use palpate_files::{Format, TextureModel, load_textures};
use palpate_run::Failure;
use palpate_texture::response::{self, Coordinate};
use palpate_texture::round;
use palpate_texture::world::{self, Factor};
use serde_json::json;

use crate::cli::{MaterialsArgs, ResponseArgs};
use palpate_live::output::{Outputs, note, print, print_json};
use palpate_live::progress::Progress;

/// Draws materials and writes their table.
///
/// # Errors
/// More materials unseen than there are, a file that cannot be written.
pub fn materials(args: &MaterialsArgs) -> Result<(), Failure> {
    let (count, unseen) = (args.count as usize, args.unseen as usize);
    if unseen > count {
        return Err(Failure::Input(format!(
            "--unseen {unseen}: expected at most --count, which is {count}"
        )));
    }
    let materials = world::draw(count, args.seed);
    let outputs = Outputs::new(args.force);
    outputs.write(&args.out, Format::Toml, |out| {
        world::write_table(&materials, (unseen, args.seed), out)
    })?;
    let out = args.out.display();
    note(&format!(
        "{out}: {count} materials, {unseen} of them unseen; `hil texture strokes --out FOLDER --varied --textures {out}` strokes them"
    ));
    Ok(())
}

/// Prints what a model's coordinates make of each property.
///
/// # Errors
/// A model that cannot be read or is not for a flat module.
pub fn response(args: &ResponseArgs) -> Result<(), Failure> {
    let model = TextureModel::open(&args.model)?;
    let dead = load_textures("thesis")?.value.dead_taxel;
    let shown = Progress::of_part("strokes");
    let materials = args.seeds.map_or(args.materials, |_| 0);
    let (done, each) = (AtomicU32::new(0), response::surfaces(materials));
    let all = f64::from(each) * args.seeds.unwrap_or(1) as f64;
    let passed = || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        shown.part(f64::from(done) / all);
    };
    let how = (args.strokes, materials as usize);
    let of = |seed| response::response(&model, how, (dead, seed), passed);
    if let Some(seeds) = args.seeds {
        let found: Vec<_> = (1..=seeds).map(of).collect::<Result<_, _>>()?;
        drop(shown);
        return spreads(args, &found);
    }
    let found = of(args.seed)?;
    drop(shown);
    if args.json {
        let rows: Vec<_> = found.iter().flat_map(rows).collect();
        return print_json(&rows);
    }
    print(|out| tables(args, &found, out))
}

/// Prints the crosstalk of each coordinate over all seeds.
fn spreads(args: &ResponseArgs, seeds: &[Vec<Coordinate>]) -> Result<(), Failure> {
    let coordinates = seeds.first().map_or(&[][..], Vec::as_slice);
    let of = |place: usize, factor: Factor| response::spread(seeds, place, factor);
    if args.json {
        let row = |(place, coordinate): (usize, &Coordinate), factor: Factor| {
            json!({
                "coordinate": standing(coordinate),
                "property": factor.name(),
                "own": coordinate.own() == factor,
                "seeds": seeds.len(),
                "crosstalk": of(place, factor).map(|spread| json!({
                    "median": round(spread.median),
                    "least": round(spread.least),
                    "largest": round(spread.largest),
                })),
            })
        };
        let each = coordinates.iter().enumerate();
        let rows = each.flat_map(|one| Factor::ALL.map(|factor| row(one, factor)));
        return print_json(&rows.collect::<Vec<_>>());
    }
    print(|out| {
        writeln!(
            out,
            "Crosstalk over seeds 1 to {}: the median, and the least to the largest; {} emulated strokes each.\n",
            seeds.len(),
            args.strokes
        )?;
        write!(out, "{:<14}", "")?;
        for factor in Factor::ALL {
            write!(out, " {:>18}", factor.name())?;
        }
        writeln!(out)?;
        for (place, coordinate) in coordinates.iter().enumerate() {
            write!(out, "{:<14}", name(coordinate))?;
            for factor in Factor::ALL {
                let cell = match of(place, factor) {
                    _ if factor == coordinate.own() => "own".to_owned(),
                    None => "-".to_owned(),
                    Some(found) => format!(
                        "{:.2} ({:.2} to {:.2})",
                        round(found.median),
                        round(found.least),
                        round(found.largest)
                    ),
                };
                write!(out, " {cell:>18}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

/// Response of one coordinate to each factor, as objects. Correlations are over unseen materials where some were drawn,
/// and over one factor at a time else.
fn rows(coordinate: &Coordinate) -> Vec<serde_json::Value> {
    let row = |(n, factor): (usize, Factor)| {
        let answer = coordinate.answer(factor);
        let partial = coordinate.partial.and_then(|p| p.get(n).copied());
        json!({
            "coordinate": standing(coordinate),
            "number": coordinate.number,
            "sign": coordinate.sign,
            "property": factor.name(),
            "own": coordinate.own() == factor,
            "rank_correlation": round(partial.map_or(answer.rank, |p| p.rank)),
            "materials": partial.map_or("probes", |_| "unseen"),
            "interval": partial.map(|p| [round(p.low), round(p.high)]),
            "probe_rank_correlation": round(answer.rank),
            "span": round(answer.span),
            "crosstalk": coordinate.crosstalk(factor).map(round),
        })
    };
    (0..).zip(Factor::ALL).map(row).collect()
}

/// A row for each coordinate, a column for each factor.
fn table(
    title: &str,
    found: &[Coordinate],
    out: &mut dyn Write,
    cell: impl Fn(&Coordinate, Factor) -> String,
) -> io::Result<()> {
    write!(out, "\n{title:<16}")?;
    for factor in Factor::ALL {
        write!(out, " {:>10}", factor.name())?;
    }
    writeln!(out)?;
    for coordinate in found {
        write!(out, "{:<16}", name(coordinate))?;
        for factor in Factor::ALL {
            write!(out, " {:>10}", cell(coordinate, factor))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The property that a coordinate stands for, else its number as in `z1`.
fn standing(coordinate: &Coordinate) -> String {
    match coordinate.stands_for {
        "" => format!("z{}", coordinate.number),
        property => property.to_owned(),
    }
}

fn name(coordinate: &Coordinate) -> String {
    let sign = if coordinate.sign < 0 { "-" } else { "" };
    format!("{sign}z{} {}", coordinate.number, coordinate.stands_for)
}

fn tables(args: &ResponseArgs, found: &[Coordinate], out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "One factor over its range, the others at a quarter, half and three quarters of theirs; {} emulated strokes each.",
        args.strokes
    )?;
    let figure = |value: f64| format!("{:.2}", round(value));
    table("rank correlation", found, out, |coordinate, factor| {
        figure(coordinate.answer(factor).rank)
    })?;
    table("span, of whole", found, out, |coordinate, factor| {
        figure(coordinate.answer(factor).span)
    })?;
    table(
        "crosstalk",
        found,
        out,
        |coordinate, factor| match coordinate.crosstalk(factor) {
            _ if factor == coordinate.own() => "own".to_owned(),
            share => share.map_or_else(|| "-".to_owned(), figure),
        },
    )?;
    if found.iter().all(|c| c.partial.is_none()) {
        return Ok(());
    }
    write!(
        out,
        "\n{} materials with independent properties, force, speed and direction of each stroke drawn.\nPartial rank correlation, the other properties held, 95 % interval below it:\n\n{:<16}",
        args.materials, ""
    )?;
    let wide = |text: &str| format!(" {text:>14}");
    for factor in Factor::PROPERTIES {
        write!(out, "{}", wide(factor.name()))?;
    }
    writeln!(out)?;
    for coordinate in found {
        let partial = coordinate.partial.unwrap_or_default();
        write!(out, "{:<16}", name(coordinate))?;
        for one in partial {
            write!(out, "{}", wide(&format!("{:.2}", round(one.rank))))?;
        }
        write!(out, "\n{:<16}", "")?;
        for one in partial {
            let interval = format!("{:.2} to {:.2}", round(one.low), round(one.high));
            write!(out, "{}", wide(&interval))?;
        }
        writeln!(out)?;
    }
    Ok(())
}
