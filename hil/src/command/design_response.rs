//! `hil design --response`: the frequency response of a bench's wire as a table, a drawing and a page.

use std::io;

use palpate_files::{Format, Setup, load_bench, load_person, load_scene};
use palpate_records::report::page::wide;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{self, dot, escape, line_key};
use palpate_records::verdict::Conclusion;
use palpate_run::Failure;
use palpate_run::frequency::{RESPONSE_W, ResponsePoint, frequencies, frequency_response};
use rayon::prelude::*;
use serde_json::Value;

use super::design::{axes, table, thousandth};
use crate::cli::{Color, DesignArgs};
use crate::sweep::page;
use palpate_live::output::{Outputs, RESPONSES, list_written};
use palpate_live::progress::Progress;

/// Ends of the frequencies, Hz, and their number.
const FROM_TO_HZ: (f64, f64) = (10.0, 300.0);
const COUNT: usize = 24;
/// Columns of the terminal's drawing.
const BAR: usize = 34;

/// Responses, and the names of bench, wire and person.
struct Response {
    names: [String; 3],
    points: Vec<ResponsePoint>,
}

/// Computes and shows the response of a bench's wire.
///
/// # Errors
/// [`Failure`] for files and values that cannot be, and outputs that cannot be written.
pub fn response(args: &DesignArgs, bench: &str, color: Color) -> Result<(), Failure> {
    let outputs = Outputs::new(args.force);
    outputs.check_csv(args.out.as_deref(), RESPONSES)?;
    outputs.check_some(args.html.as_deref(), Format::Html)?;
    let mut setup = Setup::join(load_scene("idle")?, load_bench(bench)?)?;
    setup.person = load_person(&args.person)?;
    let all = frequencies(FROM_TO_HZ.0, FROM_TO_HZ.1, COUNT);
    let progress = Progress::counted("response", all.len() as u64, "frequencies");
    let of = |hz: &f64| {
        let points = frequency_response(&setup, &[*hz]);
        progress.step();
        points
    };
    let points: Vec<Vec<ResponsePoint>> = all.par_iter().map(of).collect::<Result<_, _>>()?;
    drop(progress);
    let response = Response {
        names: [
            setup.bench.value.name.clone(),
            setup.wire.value.name.clone(),
            setup.person.value.name.clone(),
        ],
        points: points.into_iter().flatten().collect(),
    };
    outputs.write_some(args.out.as_deref(), Format::Csv, || {
        table(response.points.iter().map(fields))
    })?;
    outputs.write_some(args.html.as_deref(), Format::Html, || response.html())?;
    response.tell(args, color)
}

/// A point as columns of the file and keys of the JSON.
fn fields(of: &ResponsePoint) -> [(&'static str, Value); 9] {
    [
        ("hz", thousandth(of.hz)),
        ("width_us", thousandth(of.width_s * 1e6)),
        ("skin_um", thousandth(of.swing_um)),
        ("amplitude_um", thousandth(of.amplitude_um)),
        ("threshold_um", thousandth(of.threshold_um)),
        ("felt_db", thousandth(of.levels.db())),
        ("vibration_db", thousandth(of.levels.vibration_db)),
        ("flutter_db", thousandth(of.levels.flutter_db)),
        ("wire_c", thousandth(of.wire_c)),
    ]
}

impl Response {
    /// Least and most displacement or threshold, um, over four decades at most.
    fn ends(&self) -> (f64, f64) {
        let all = || {
            self.points
                .iter()
                .flat_map(|p| [p.amplitude_um, p.threshold_um, p.swing_um])
        };
        let most = all().fold(1e-9, f64::max);
        (all().fold(most, f64::min).max(most * 1e-4), most)
    }

    /// Heading of the page's drawing, as HTML.
    fn heading(&self) -> String {
        let [bench, wire, _] = self.names.each_ref().map(|name| escape(name));
        format!(
            "Skin under one wire <code>{wire}</code> of bench <code>{bench}</code>: one pulse per period, {:.0} mW at every frequency (emulated)",
            RESPONSE_W * 1e3
        )
    }

    fn tell(&self, args: &DesignArgs, color: Color) -> Result<(), Failure> {
        let all = || -> Vec<Value> {
            let each = self.points.iter().map(|p| Value::from_iter(fields(p)));
            each.collect()
        };
        let [bench, wire, person] = &self.names;
        let (low, high) = self.ends();
        args.voice.tell(all, |out| {
            Conclusion::default().write(out, color.on(&io::stdout()))?;
            writeln!(
                out,
                "skin under one wire `{wire}` of bench `{bench}`, {:.0} mW at every frequency (emulated)\n",
                RESPONSE_W * 1e3
            )?;
            writeln!(
                out,
                "      Hz  pulse us  skin um  part um  felt dB  part, {low:.2} to {high:.1} um"
            )?;
            for point in &self.points {
                writeln!(out, "{}", row(point, (low, high)))?;
            }
            writeln!(
                out,
                "\nskin: from end to end; part (=): amplitude at that frequency; |: `{person}` feels a sine"
            )?;
            list_written(args.out.iter().chain(&args.html), out)
        })
    }

    /// The page: amplitudes over frequency, the person's threshold beside them, and the table.
    fn html(&self) -> String {
        let mut keys = String::new();
        line_key(&mut keys, "series", "part at that frequency");
        line_key(&mut keys, "median", "from end to end");
        line_key(&mut keys, "bound", "long sine that is just felt");
        let columns = [
            ("num", "Hz"),
            ("num", "pulse [\u{b5}s]"),
            ("num", "from end to end [\u{b5}m]"),
            ("num", "amplitude at Hz [\u{b5}m]"),
            ("num", "threshold [\u{b5}m]"),
            ("num", "felt [dB]"),
            ("num", "wire [\u{b0}C]"),
        ];
        let row = |p: &ResponsePoint| {
            let cells = vec![
                format!("{:.1}", p.hz),
                format!("{:.1}", p.width_s * 1e6),
                format!("{:.2}", p.swing_um),
                format!("{:.2}", p.amplitude_um),
                format!("{:.2}", p.threshold_um),
                format!("{:+.1}", p.levels.db()),
                format!("{:.1}", p.wire_c),
            ];
            (false, cells)
        };
        let [_, _, person] = &self.names;
        format!(
            "{}<section><h2>Displacement over frequency</h2>\n<p>{}. Line with dots: the part at the frequency of the pulses, as \
             a spectrum shows it. Thin line: all of the motion, from end to end. Dashes: amplitude of a long sine that \
             <code>{}</code> just feels. A pulse has harmonics too, so it may be felt where its first part is not.</p>\n\
             <div class=\"chart\">{}</div><div class=\"legend\">{keys}</div></section>\n\
             <section><h2>Values</h2>{}</section>\n{}",
            page::head("Frequency response of a wire", &Conclusion::default()),
            self.heading(),
            escape(person),
            self.chart(),
            wide(&columns, self.points.iter().map(row)),
            page::foot()
        )
    }

    fn chart(&self) -> String {
        let (low, high) = self.ends();
        let scales = [
            Scale::logarithmic(FROM_TO_HZ.0, FROM_TO_HZ.1),
            Scale::logarithmic(low / 1.3, high * 1.3),
        ];
        let labels = [
            "pulses per second [Hz]",
            "displacement of the skin [\u{b5}m]",
        ];
        let (plot, mut svg) = axes("Displacement of the skin over frequency", scales, labels);
        let path = |of: fn(&ResponsePoint) -> f64| {
            let mut path = String::new();
            for p in &self.points {
                svg::line(&mut path, plot.at((p.hz, of(p))));
            }
            path
        };
        svg.path(&path(|p| p.swing_um), "series median");
        svg.path(&path(|p| p.threshold_um), "series bound");
        svg.path(&path(|p| p.amplitude_um), "series");
        let mut dots = String::new();
        for p in &self.points {
            dot(&mut dots, plot.at((p.hz, p.amplitude_um)));
        }
        svg.path(&dots, "series-dots dots");
        plot.frame(&mut svg);
        svg.finish()
    }
}

/// A row of the terminal: figures, and a bar up to the amplitude with a mark at the threshold.
fn row(point: &ResponsePoint, (low, high): (f64, f64)) -> String {
    let scale = Scale::logarithmic(low, high);
    let column =
        |um: f64| ((scale.at(um) * (BAR - 1) as f64).round().max(0.0) as usize).min(BAR - 1);
    let (end, mark) = (column(point.amplitude_um), column(point.threshold_um));
    let bar: String = (0..=end.max(mark))
        .map(|at| match at {
            at if at == mark => '|',
            at if at <= end => '=',
            _ => ' ',
        })
        .collect();
    format!(
        "{:>8.1}  {:>8.1}  {:>7.2}  {:>7.2}  {:>+7.1}  {bar}",
        point.hz,
        point.width_s * 1e6,
        point.swing_um,
        point.amplitude_um,
        point.levels.db()
    )
}
