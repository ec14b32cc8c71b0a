//! `hil bench`.

use crate::cli::BenchArgs;
use crate::failure::Failure;

/// Says how to build a program that can do it.
///
/// # Errors
/// Always [`Failure::Input`].
#[cfg(not(feature = "bench"))]
pub fn bench(_: &BenchArgs) -> Result<(), Failure> {
    Err(Failure::Input(
        "this program was built without `hil bench`, which needs other people's solvers to compare \
         with; build and run it with: cargo run --release -p palpate-hil --features bench -- bench"
            .into(),
    ))
}

/// Measures one family or all and writes what was asked for.
///
/// # Errors
/// [`Failure`] with its exit status.
#[cfg(feature = "bench")]
pub fn bench(args: &BenchArgs) -> Result<(), Failure> {
    use crate::bench::plot::styled;
    use crate::bench::{Row, chosen, page, table};
    use crate::output::{make_folder, print, write_file};

    let families = chosen(args.family.as_deref())?;
    let mut found = Vec::new();
    for family in families {
        if !args.quiet {
            crate::output::note(&format!("measuring {}", family.name));
        }
        found.push((family.name, (family.measure)()?));
    }
    let rows: Vec<&Row> = found.iter().flat_map(|(_, f)| &f.rows).collect();
    if let Some(folder) = &args.out {
        make_folder(folder)?;
        write_file(&folder.join("bench.json"), |out| {
            serde_json::to_writer_pretty(&mut *out, &rows)?;
            writeln!(out)
        })?;
        for (name, findings) in &found {
            for plot in &findings.plots {
                let path = folder.join(format!("{name}-{}.svg", plot.name));
                write_file(&path, |out| out.write_all(plot.file().as_bytes()))?;
            }
            for figure in &findings.figures {
                let path = folder.join(format!("{name}-{}.svg", figure.name));
                let text = styled(&figure.svg);
                write_file(&path, |out| out.write_all(text.as_bytes()))?;
            }
        }
        let page = page::html(&found);
        write_file(&folder.join("bench.html"), |out| {
            out.write_all(page.as_bytes())
        })?;
    }
    if args.quiet {
        return Ok(());
    }
    print(|out| {
        if args.json {
            serde_json::to_writer(&mut *out, &rows)?;
            return writeln!(out);
        }
        for (name, findings) in &found {
            table::write(out, name, findings)?;
        }
        Ok(())
    })
}
