//! `hil reproduce`: rows of the thesis as text, JSON or a page.

use std::collections::BTreeMap;
use std::io::{self, Write};

use palpate_files::{Format, did_you_mean};
use palpate_live::output::{Outputs, print};
use palpate_live::progress::Progress;
use palpate_records::report::page::{foot, head, wide};
use palpate_records::report::svg::escape;
use palpate_records::verdict::{COLUMNS, wrapped};
use palpate_run::Failure;
use palpate_texture::draw as map;
use palpate_texture::panel::draw as boxes;
use serde_json::{Value, json};

use crate::cli::ReproduceArgs;
use crate::reproduce::{Answer, Mark, Row, rows};

/// Computes rows of the thesis; each is printed as soon as it is there.
///
/// # Errors
/// [`Failure`] for a row that there is not, and outputs that cannot be written.
pub fn reproduce(args: &ReproduceArgs) -> Result<(), Failure> {
    let chosen = chosen(&args.rows)?;
    let outputs = Outputs::new(args.force);
    outputs.check_some(args.html.as_deref(), Format::Html)?;
    let progress = Progress::counted("thesis", chosen.len() as u64, "rows");
    let speaks = !(args.voice.quiet || args.voice.json);
    let mut done = Vec::new();
    for row in chosen {
        let answer = (row.compute)()?;
        progress.step();
        if speaks {
            print(|out| tell(row, &answer, out))?;
        }
        done.push((row, answer));
    }
    drop(progress);
    outputs.write_some(args.html.as_deref(), Format::Html, || page(&done))?;
    let all = || done.iter().map(as_json).collect::<Vec<_>>();
    args.voice.tell(all, |out| {
        writeln!(out, "{}", wrapped(&count(&done), COLUMNS))
    })
}

/// The rows of these names. A name that is no row's stands for all rows that begin with it.
fn chosen(names: &[String]) -> Result<Vec<&'static Row>, Failure> {
    for name in names {
        if !rows().any(|row| row.id.starts_with(name.as_str())) {
            let near = did_you_mean(name, rows().map(|row| row.id));
            let ids: Vec<&str> = rows().map(|row| row.id).collect();
            return Err(Failure::Input(format!(
                "hil reproduce: expected a row, found `{name}`{near}; rows: {}",
                ids.join(", ")
            )));
        }
    }
    let is = |name: &str, row: &Row| match rows().any(|row| row.id == name) {
        true => row.id == name,
        false => row.id.starts_with(name),
    };
    let wanted = |row: &&Row| names.is_empty() || names.iter().any(|name| is(name, row));
    Ok(rows().filter(wanted).collect())
}

fn tell(row: &Row, answer: &Answer, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{}  {}", row.id, answer.mark.word())?;
    let cause = answer.mark.cause();
    let lines = [
        ("thesis", Some(row.says)),
        ("here", Some(answer.found.as_str())),
        ("assumed", Some(row.assumed)),
        ("cause", cause),
    ];
    for (name, text) in lines {
        if let Some(text) = text {
            writeln!(out, "{}", wrapped(&format!("  {name}: {text}"), COLUMNS))?;
        }
    }
    writeln!(out, "  alone: {}\n", row.command())
}

/// Rows by mark, in words.
fn count(done: &[(&Row, Answer)]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, answer) in done {
        *counts.entry(answer.mark.word()).or_default() += 1;
    }
    let unexplained = done.iter().filter(|(_, a)| a.mark == Mark::Unexplained);
    let each = Mark::WORDS.map(|word| format!("{word} {}", counts.get(word).copied().unwrap_or(0)));
    format!(
        "{} {}: {}. Of those that differ, {} unexplained.",
        done.len(),
        if done.len() == 1 { "row" } else { "rows" },
        each.join(", "),
        unexplained.count()
    )
}

fn as_json((row, answer): &(&Row, Answer)) -> Value {
    json!({
        "id": row.id,
        "thesis": row.says,
        "here": answer.found,
        "mark": answer.mark.word(),
        "cause": answer.mark.cause(),
        "assumed": row.assumed,
        "command": row.command(),
        "values": answer.values,
    })
}

fn page(done: &[(&Row, Answer)]) -> String {
    let columns = [
        ("", "row"),
        ("", "mark"),
        ("", "the thesis"),
        ("", "here"),
        ("", "assumed"),
        ("", "cause"),
        ("", "alone"),
    ];
    let row = |(row, answer): &(&Row, Answer)| {
        let cells = vec![
            row.id.to_owned(),
            answer.mark.word().to_owned(),
            row.says.to_owned(),
            answer.found.clone(),
            row.assumed.to_owned(),
            answer.mark.cause().unwrap_or_default().to_owned(),
            row.command(),
        ];
        (answer.mark.word() == Mark::WORDS[1], cells)
    };
    let figure = |(row, answer): &(&Row, Answer)| {
        let panels = answer.panels.iter();
        // Boxes of eight surfaces are read at their own width: a narrow page scrolls them.
        let panels: String = panels
            .map(|svg| match svg.contains("box") {
                true => format!("<figure class=\"wide\" tabindex=\"0\">{svg}</figure>"),
                false => format!("<figure>{svg}</figure>"),
            })
            .collect();
        match panels.is_empty() {
            true => panels,
            false => format!(
                "<section id=\"{0}\"><h2>{0}</h2><div class=\"row\">{panels}</div></section>\n",
                escape(row.id)
            ),
        }
    };
    format!(
        "{}<style>{}{}.row figure{{flex:1 1 300px}}.row figure.wide{{flex-basis:100%}}.row svg{{max-height:420px}}</style><header><h1>The thesis, reproduced</h1><p class=\"sub\">{}</p></header>\n<section>{}</section>\n{}{}",
        head("The thesis, reproduced"),
        map::RULES,
        boxes::RULES,
        escape(&count(done)),
        wide(&columns, done.iter().map(row)),
        done.iter().map(figure).collect::<String>(),
        foot(
            ". Every value here comes from emulated hardware and a model of the skin.",
            ""
        )
    )
}
