//! `hil design`: what makes of wire are felt like, at which tissue temperature and current.

use std::fmt::Write as _;
use std::io;

use palpate_core::physics::{ParameterError, WireParameters};
use palpate_files::{BenchTissue, Format, load_alloy, load_person, load_wire};
use palpate_records::report::page::wide;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{self, Plot, Svg, dot, escape, path_key};
use palpate_records::table::as_csv;
use palpate_records::verdict::Conclusion;
use palpate_run::design::{DesignOutcome, PulsePattern, outcome, resized, undominated};
use palpate_run::pass::lasting;
use palpate_run::{Failure, plan};
use rayon::prelude::*;
use serde_json::Value;

use crate::cli::{Color, DesignArgs, Numbers};
use crate::sweep::page;
use palpate_live::output::{DESIGNS, Outputs, list_written};
use palpate_live::progress::Progress;

/// Most points: an hour of two cores.
const MOST: usize = 1_000_000;
/// Rows of the terminal's table.
const SHOWN: usize = 20;

/// A point of the design space.
struct DesignPoint {
    /// Names of wire and alloy.
    names: [String; 2],
    wire: WireParameters,
    pattern: PulsePattern,
}

/// A point with its outcome, and whether no other point beats it.
type Computed = (DesignPoint, DesignOutcome, bool);

/// Computes every combination.
///
/// # Errors
/// [`Failure`] for files and values that cannot be, and outputs that cannot be written.
pub fn design(args: &DesignArgs, color: Color) -> Result<(), Failure> {
    let outputs = Outputs::new(args.force);
    outputs.check_csv(args.out.as_deref(), DESIGNS)?;
    outputs.check_some(args.html.as_deref(), Format::Html)?;
    let person = load_person(&args.person)?.value;
    let points = points(args)?;
    let progress = Progress::counted("designs", points.len() as u64, "points");
    let tissue = BenchTissue::default().parameters();
    let of = |point: &DesignPoint| {
        // A bench passes its wires before a run, where that lasts.
        let wire = lasting(&point.wire, &tissue).unwrap_or(point.wire);
        let felt_by = plan::person(&person, &wire, &tissue);
        let outcome = outcome(&wire, &tissue, &point.pattern, felt_by, args.seconds);
        progress.step();
        outcome.map_err(|e: ParameterError| {
            Failure::Input(format!("{} with {}: {e}", point.names[0], place(point)))
        })
    };
    let outcomes: Vec<DesignOutcome> = points.par_iter().map(of).collect::<Result<_, _>>()?;
    drop(progress);
    let pairs: Vec<_> = points
        .iter()
        .map(|p| p.pattern)
        .zip(outcomes.iter().copied())
        .collect();
    let best = undominated(&pairs);
    let mut computed: Vec<Computed> = points
        .into_iter()
        .zip(outcomes)
        .zip(best)
        .map(|((point, outcome), best)| (point, outcome, best))
        .collect();
    outputs.write_some(args.out.as_deref(), Format::Csv, || {
        table(computed.iter().map(fields))
    })?;
    // The most strongly felt first; those that none beats before all others of their level.
    computed.sort_by(|a, b| b.1.levels.db().total_cmp(&a.1.levels.db()));
    outputs.write_some(args.html.as_deref(), Format::Html, || {
        html(&computed, &person.name)
    })?;
    tell(args, &computed, &person.name, color)
}

/// All combinations, wires slowest and powers fastest.
fn points(args: &DesignArgs) -> Result<Vec<DesignPoint>, Failure> {
    let own = |list: &Option<Numbers>, value: f64| match list {
        Some(numbers) => numbers.0.clone(),
        None => vec![value],
    };
    let mut patterns = Vec::new();
    for &amps in &args.current_a.0 {
        for &pulses in &args.pulses.0 {
            for &cadence_ms in &args.cadence_ms.0 {
                for &milliwatts in &args.power_mw.0 {
                    patterns.push(PulsePattern {
                        amps,
                        pulses: pulses as u32,
                        cadence_s: cadence_ms / 1e3,
                        watts: milliwatts / 1e3,
                    });
                }
            }
        }
    }
    let mut points = Vec::new();
    for name in &args.wire {
        let file = load_wire(name)?.value;
        for alloy in &args.alloy {
            let alloy = load_alloy(alloy)?.value;
            let base = file.parameters(&alloy);
            for diameter_um in own(&args.diameter_um, file.diameter_um) {
                for length_mm in own(&args.length_mm, file.length_mm) {
                    for stress_mpa in own(&args.stress_mpa, file.mechanical.bias_stress_mpa) {
                        let sized = resized(&base, diameter_um / 1e6, length_mm / 1e3);
                        let wire = WireParameters {
                            bias_stress_pa: stress_mpa * 1e6,
                            ends_c: BenchTissue::default().rest_c,
                            ..sized
                        };
                        if points.len() + patterns.len() > MOST {
                            return Err(Failure::Input(format!(
                                "hil design: expected at most {MOST} points, found more"
                            )));
                        }
                        points.extend(patterns.iter().map(|&pattern| DesignPoint {
                            names: [file.name.clone(), alloy.name.clone()],
                            wire,
                            pattern,
                        }));
                    }
                }
            }
        }
    }
    Ok(points)
}

/// Geometry and stress of a point.
fn place(point: &DesignPoint) -> String {
    let wire = &point.wire;
    format!(
        "{:.0} um, {:.1} mm, {:.0} MPa",
        wire.diameter_m * 1e6,
        wire.length_m * 1e3,
        wire.bias_stress_pa / 1e6
    )
}

/// Drive of a point in words: pulses, width, current and cadence.
fn drive(point: &DesignPoint, outcome: &DesignOutcome) -> String {
    let p = &point.pattern;
    format!(
        "{} x {:.0} us at {:.2} A every {:.1} ms",
        p.pulses,
        outcome.width_s * 1e6,
        p.amps,
        p.cadence_s * 1e3
    )
}

/// Value of a column, to a thousandth.
pub(super) fn thousandth(value: f64) -> Value {
    Value::from((value * 1e3).round() / 1e3)
}

/// A point as columns of the file and keys of the JSON.
fn fields((point, of, best): &Computed) -> [(&'static str, Value); 19] {
    let (w, p) = (&point.wire, &point.pattern);
    [
        ("wire", point.names[0].as_str().into()),
        ("alloy", point.names[1].as_str().into()),
        ("diameter_um", thousandth(w.diameter_m * 1e6)),
        ("length_mm", thousandth(w.length_m * 1e3)),
        ("stress_mpa", thousandth(w.bias_stress_pa / 1e6)),
        ("current_a", thousandth(p.amps)),
        ("pulses", p.pulses.into()),
        ("width_us", thousandth(of.width_s * 1e6)),
        ("cadence_ms", thousandth(p.cadence_s * 1e3)),
        ("power_mw", thousandth(p.watts * 1e3)),
        ("felt_db", thousandth(of.levels.db())),
        ("vibration_db", thousandth(of.levels.vibration_db)),
        ("flutter_db", thousandth(of.levels.flutter_db)),
        ("skin_um", thousandth(of.skin_um)),
        ("wire_c", thousandth(of.wire_c)),
        ("skin_c", thousandth(of.skin_c[0])),
        ("skin_worst_c", thousandth(of.skin_c[1])),
        ("excluded_by", of.excluded.map_or(Value::Null, Value::from)),
        ("undominated", (*best).into()),
    ]
}

/// Columns of points as a table of text.
pub(super) fn table<const N: usize>(
    rows: impl Iterator<Item = [(&'static str, Value); N]> + Clone,
) -> String {
    let head = rows
        .clone()
        .take(1)
        .map(|fields| fields.map(|f| f.0).to_vec());
    as_csv(head) + &as_csv(rows.map(|fields| fields.map(|f| f.1).to_vec()))
}

fn tell(
    args: &DesignArgs,
    computed: &[Computed],
    person: &str,
    color: Color,
) -> Result<(), Failure> {
    let all = || -> Vec<Value> {
        let each = computed.iter().map(|c| Value::from_iter(fields(c)));
        each.collect()
    };
    let allowed = computed.iter().filter(|c| c.1.excluded.is_none()).count();
    let best: Vec<&Computed> = computed.iter().filter(|c| c.2).collect();
    args.voice.tell(all, |out| {
        Conclusion::default().write(out, color.on(&io::stdout()))?;
        writeln!(
            out,
            "{} points, {allowed} within the limit table and the bow; felt by `{person}` after {} s, one wire (emulated)",
            computed.len(),
            args.seconds
        )?;
        writeln!(
            out,
            "No other point is felt as strongly at tissue as cool and as small a current as these:\n"
        )?;
        writeln!(out, "{}", HEADING)?;
        for (point, of, _) in best.iter().take(SHOWN) {
            writeln!(out, "{}", line(point, of))?;
        }
        if best.len() > SHOWN {
            writeln!(
                out,
                ".. and {} more; --out FILE.csv keeps all",
                best.len() - SHOWN
            )?;
        }
        list_written(args.out.iter().chain(&args.html), out)
    })
}

const HEADING: &str = "    felt      skin   tissue, worst   wire     wire, alloy            geometry and stress       drive";

fn line(point: &DesignPoint, of: &DesignOutcome) -> String {
    let [wire, alloy] = &point.names;
    format!(
        "{:>+5.1} dB  {:>5.1} um   {:>5.1}, {:>5.1} C  {:>5.1} C   {:<22} {:<25} {}",
        of.levels.db(),
        of.skin_um,
        of.skin_c[0],
        of.skin_c[1],
        of.wire_c,
        format!("{wire}, {alloy}"),
        place(point),
        drive(point, of)
    )
}

/// The page: level over tissue temperature, and the points that none beats.
fn html(computed: &[Computed], person: &str) -> String {
    let mut out = page::head("Designs of a wire", &Conclusion::default());
    let currents: Vec<f64> = {
        let mut all: Vec<f64> = computed.iter().map(|c| c.0.pattern.amps).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.dedup();
        all
    };
    let mut keys = String::new();
    for (n, amps) in currents.iter().enumerate() {
        let class = format!("dots big w{}", n % 8);
        path_key(&mut keys, &class, "M13 6h0", &format!("{amps:.2} A"));
    }
    let _ = write!(
        out,
        "<section><h2>Felt level over tissue temperature</h2>\n<p>{} points; those that the limit table or the bow excludes are left out. The line joins what no other point beats in \
         level and temperature. Temperatures are at 0.1 mm in the worst corner of the guard's range; the limit is 43 \u{b0}C. \
         Felt by <code>{}</code>.</p>\n<div class=\"chart\">{}</div><div class=\"legend\">{keys}</div></section>\n",
        computed.len(),
        escape(person),
        chart(computed, &currents)
    );
    let columns = [
        ("num", "felt [dB]"),
        ("num", "skin [\u{b5}m]"),
        ("num", "tissue, worst [\u{b0}C]"),
        ("num", "wire [\u{b0}C]"),
        ("", "wire, alloy"),
        ("", "geometry, stress"),
        ("", "drive"),
    ];
    let row = |(point, of, _): &Computed| {
        let cells = vec![
            format!("{:+.1}", of.levels.db()),
            format!("{:.1}", of.skin_um),
            format!("{:.1}, {:.1}", of.skin_c[0], of.skin_c[1]),
            format!("{:.1}", of.wire_c),
            point.names.join(", "),
            place(point),
            drive(point, of),
        ];
        (false, cells)
    };
    let _ = writeln!(
        out,
        "<section><h2>Points that no other beats in level, temperature and current</h2>\n\
         {}</section>",
        wide(&columns, computed.iter().filter(|c| c.2).map(row))
    );
    out + &page::foot()
}

/// A drawing's frame with its axes.
pub(super) fn axes(title: &str, [x, y]: [Scale; 2], labels: [&str; 2]) -> (Plot, Svg) {
    let plot = Plot {
        left: 52.0,
        top: 30.0,
        width: 386.0,
        height: 230.0,
        x,
        y,
    };
    let mut svg = Svg::new(460.0, 306.0, title);
    plot.x_axis(&mut svg, labels[0]);
    plot.y_axis(&mut svg, labels[1]);
    (plot, svg)
}

fn chart(computed: &[Computed], currents: &[f64]) -> String {
    let allowed = || computed.iter().filter(|c| c.1.excluded.is_none());
    let at = |c: &Computed| (c.1.skin_c[1], c.1.levels.db().max(-30.0));
    let ends = |of: fn((f64, f64)) -> f64| {
        let all = || allowed().map(|c| of(at(c)));
        (
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let (x, y) = (ends(|p| p.0), ends(|p| p.1));
    let scales = [Scale::round(x.0, x.1), Scale::round(y.0.min(0.0), y.1)];
    let labels = [
        "tissue at 0.1 mm, worst corner [\u{b0}C]",
        "felt level over threshold [dB]",
    ];
    let (plot, mut svg) = axes("Felt level over tissue temperature", scales, labels);
    // From the coolest on, whatever is felt more strongly than all before.
    let mut cooler: Vec<(f64, f64)> = allowed().map(at).collect();
    cooler.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let (mut front, mut most) = (String::new(), f64::NEG_INFINITY);
    for (skin, level) in cooler.into_iter().filter(|p| p.0.is_finite()) {
        if level > most {
            most = level;
            svg::line(&mut front, plot.at((skin, level)));
        }
    }
    // Equal points of several currents show the smallest.
    for (n, amps) in currents.iter().enumerate().rev() {
        let mut dots = String::new();
        for c in allowed().filter(|c| (c.0.pattern.amps - amps).abs() < 1e-12) {
            dot(&mut dots, plot.at(at(c)));
        }
        svg.path(&dots, &format!("dots big w{}", n % 8));
    }
    svg.path(&front, "series");
    let zero = plot.py(0.0);
    svg.line((plot.left, zero), (plot.left + plot.width, zero), "limit");
    plot.frame(&mut svg);
    svg.finish()
}
