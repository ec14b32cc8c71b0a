//! Rows of chapter 5: duty, the phantom law, timing, power and the display's geometry.

use palpate_core::illusion::{
    Display, DisplayWire, Drive, IllusionModel, ModelSettings, ShapeChoice, TimingLaw, build,
};
use palpate_core::units::{Board, Channel, Clock, Duration, Point, Prescale};
use palpate_files::{LayoutFile, Setup, load_bench, load_layout, load_wire};
use palpate_run::{Failure, plan};
use serde_json::json;

use super::row::{Answer, Mark, Row, broken};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-5.2.2-spacing",
        says: "The final module's wires lie 9 to 14 mm apart.",
        assumed: "The wires' places: the thesis prints only the spacings.",
        compute: spacing,
    },
    Row {
        id: "eq-5.1",
        says: "A wire's duty is alpha + beta times its activation; beta = 2.44 %.",
        assumed: "alpha = 0: the thesis prints none.",
        compute: duty,
    },
    Row {
        id: "eq-5.2",
        says: "On a wire its activation is 1 and that of all others is 0; between wires it falls with the logarithm.",
        assumed: "s_x = s_y = 1: the thesis prints neither.",
        compute: law,
    },
    Row {
        id: "claim-5.5-centre",
        says: "Around the centre between wires the vibration falls below the sensation level.",
        assumed: "s = 1; the energy of both wires over that of one. Whether that is below a person's level is theirs.",
        compute: dip,
    },
    Row {
        id: "claim-5.4-soa",
        says: "A stimulus of 35 ms gives 58.5 ms between onsets.",
        assumed: "The law 0.32 tau_d + 47.3 ms of the paper that the thesis cites.",
        compute: onset,
    },
    Row {
        id: "claim-5.4-motion",
        says: "Successive stimuli are felt as a motion from wire to wire.",
        assumed: "Timing alone: bursts that do not overlap need a law that was fitted to people.",
        compute: motion,
    },
    Row {
        id: "claim-5.4-power",
        says: "A fully active wire of 1.9 Ohm takes 180 mW at a duty of 2.44 %.",
        assumed: "The current, 1.97 A, follows from these three: the thesis prints none.",
        compute: power,
    },
    Row {
        id: "claim-5.4-pwm",
        says: "The PWM driver is set to 200 Hz.",
        assumed: "A PCA9685 with its own 25 MHz clock.",
        compute: frequency,
    },
    Row {
        id: "claim-2.2.3-resistance",
        says: "The first module's wires have 100 um, 5 mm, 1.4 Ohm; the final one's 75 um, 5 mm, 1.9 Ohm.",
        assumed: "Crimps and leads have what is left of both resistances when the wires' part goes with 1/d^2.",
        compute: resistance,
    },
];

fn spacing() -> Result<Answer, Failure> {
    let LayoutFile::Display(file) = load_layout("thimble-8")?.value else {
        return Err(broken("`thimble-8` is no display"));
    };
    let nearest = |(i, a): (usize, &[f64; 2])| {
        let others = file.wires_mm.iter().enumerate().filter(|(j, _)| *j != i);
        let gaps = others.map(|(_, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let gaps: Vec<f64> = file.wires_mm.iter().enumerate().map(nearest).collect();
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let most = gaps.iter().copied().fold(0.0, f64::max);
    let [dx, dy] = file.spacing_mm;
    let same = least >= 9.0 && dx.max(dy).max(most) <= 14.0;
    Ok(Answer::new(
        Mark::new(same, || "the layout has other places".into()),
        format!(
            "Layout `thimble-8`: nearest wires {least} to {most} mm apart, columns {dx} and rows {dy} mm."
        ),
        json!({ "nearest_mm": gaps, "spacing_mm": [dx, dy] }),
    ))
}

/// The published drive: no offset, full duty of 100 ticks, no levels.
fn published() -> Drive {
    Drive {
        floor: 1.0,
        ..Drive::default()
    }
}

fn duty() -> Result<Answer, Failure> {
    let drive = published();
    let activations = [0.0_f32, 0.25, 0.5, 0.75, 1.0];
    let ticks = activations.map(|a| drive.width(a).get());
    let full = drive.width(1.0).duty();
    Ok(Answer::new(
        Mark::new((full - 0.0244).abs() < 5e-5, || {
            "full drive is another duty".into()
        }),
        format!(
            "{} of 4096 ticks at full activation: {:.2} %.",
            ticks[4],
            100.0 * full
        ),
        json!({ "alpha": drive.alpha, "beta": drive.beta, "activations": activations, "ticks": ticks }),
    ))
}

/// Wires in a line along x, this far apart.
fn line(gap_mm: f32) -> Result<Display, Failure> {
    let wire = |n: u8| DisplayWire {
        place: Point::new(f32::from(n) * gap_mm, 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    Display::new(&[0, 1, 2].map(wire)).map_err(broken)
}

/// Activations of three wires in a line by (5.2) with a shape, for a contact at `x` mm.
fn activations(gap_mm: f32, shape: ShapeChoice, x: f32) -> Result<[f32; 3], Failure> {
    let settings = ModelSettings {
        model: IllusionModel::Phantom,
        shape,
        ..ModelSettings::default()
    };
    let law = build(&line(gap_mm)?, &settings).map_err(broken)?;
    let mut found = [0.0; 3];
    law.activate(Point::new(x, 0.0), &mut found);
    Ok(found)
}

/// Spacings of both modules, mm.
const GAPS: [f32; 3] = [6.5, 9.0, 14.0];

fn law() -> Result<Answer, Failure> {
    let gap = 9.0;
    let on = activations(gap, ShapeChoice::Model, gap)?;
    let places = [0.0_f32, 1.0, 2.0, 4.5, 6.0, 9.0];
    let mut found = Vec::new();
    for x in places {
        found.push(activations(gap, ShapeChoice::Model, x)?);
    }
    let same = on
        .iter()
        .zip([0.0, 1.0, 0.0])
        .all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6);
    Ok(Answer::new(
        Mark::new(same, || {
            "a neighbour is active where a wire is touched".into()
        }),
        format!(
            "On a wire {on:?}; halfway to the next, 9 mm away, {:.3} each.",
            found[3][0]
        ),
        json!({ "gap_mm": gap, "shape": 1.0, "places_mm": places, "activations": found }),
    ))
}

/// Energy halfway between two wires over that on one, dB.
fn halfway_db(gap_mm: f32, shape: ShapeChoice) -> Result<f64, Failure> {
    let found = activations(gap_mm, shape, gap_mm / 2.0)?;
    let energy: f64 = found.iter().map(|a| f64::from(*a).powi(2)).sum();
    Ok(10.0 * energy.log10())
}

fn dip() -> Result<Answer, Failure> {
    let (mut dips, mut flat) = (Vec::new(), Vec::new());
    for gap in GAPS {
        dips.push(halfway_db(gap, ShapeChoice::Model)?);
        flat.push(halfway_db(gap, ShapeChoice::Flat)?);
    }
    let told = |v: &[f64]| {
        let each: Vec<String> = v.iter().map(|db| format!("{db:.1}")).collect();
        each.join(", ")
    };
    Ok(Answer::new(
        Mark::new(dips.iter().all(|db| *db < -3.0), || {
            "the law is flat".into()
        }),
        format!(
            "{} dB halfway between wires 6.5, 9 and 14 mm apart; with the shape that makes it flat {} dB.",
            told(&dips),
            told(&flat.iter().map(|db| db.abs()).collect::<Vec<_>>())
        ),
        json!({ "gaps_mm": GAPS, "dip_db": dips, "flat_db": flat }),
    ))
}

fn onset() -> Result<Answer, Failure> {
    let tau = Duration::from_millis(35);
    let timing = TimingLaw::TactileBrush
        .timing(Some(tau), None)
        .map_err(broken)?;
    let ms = timing.soa.as_micros() as f64 * 1e-3;
    Ok(Answer::new(
        Mark::new((ms - 58.5).abs() < 1e-9, || "another law of onsets".into()),
        format!("{ms} ms."),
        json!({ "tau_d_ms": 35.0, "soa_ms": ms }),
    ))
}

fn motion() -> Result<Answer, Failure> {
    let law = |law: TimingLaw| -> Result<[f64; 2], Failure> {
        let timing = law.timing(None, None).map_err(broken)?;
        let ms = |d: Duration| d.as_micros() as f64 * 1e-3;
        Ok([ms(timing.duration), ms(timing.soa)])
    };
    let [brush, pad] = [law(TimingLaw::TactileBrush)?, law(TimingLaw::Fingerpad)?];
    Ok(Answer::new(
        Mark::Unknown(
            "people feel motion; on a fingerpad they mostly did with 105 to 125 ms between onsets"
                .into(),
        ),
        format!(
            "{:.1} ms of silence between bursts by the published timing, {:.1} ms by `fingerpad` ({:.1} ms every {:.1} ms): neither overlaps.",
            brush[1] - brush[0],
            pad[1] - pad[0],
            pad[0],
            pad[1]
        ),
        json!({ "tactile_brush_ms": brush, "fingerpad_ms": pad }),
    ))
}

fn power() -> Result<Answer, Failure> {
    let setup = Setup::load("sphere-along", "thesis")?;
    let ohm = plan::wire(&setup).resistance_ohm;
    let amps = setup.bench.value.drive.current_ma * 1e-3;
    let duty = published().width(1.0).duty();
    let milliwatts = 1e3 * amps * amps * ohm * duty;
    let follows = (0.180 / (1.9 * 0.0244_f64)).sqrt();
    Ok(Answer::new(
        Mark::new((milliwatts - 180.0).abs() < 1.0, || {
            "bench `thesis` has another drive".into()
        }),
        format!("{milliwatts:.1} mW at {amps} A through {ohm} Ohm; 180 mW ask for {follows:.3} A."),
        json!({ "current_a": amps, "resistance_ohm": ohm, "duty": duty, "power_mw": milliwatts, "follows_a": follows }),
    ))
}

fn frequency() -> Result<Answer, Failure> {
    let bench = load_bench("thesis")?.value;
    let chosen = plan::prescale(&bench)?;
    let around = [chosen.get() - 1, chosen.get(), chosen.get() + 1];
    let hz = around.map(|pre| Prescale::new(pre).hz());
    let told: Vec<String> = around
        .iter()
        .zip(hz)
        .map(|(pre, hz)| format!("{pre} gives {hz:.2} Hz"))
        .collect();
    Ok(Answer::new(
        Mark::new((chosen.hz() - 200.0).abs() < 0.005, || {
            format!(
                "the chip divides its clock by a whole number: {}",
                told.join(", ")
            )
        }),
        format!("{:.2} Hz with PRE_SCALE {}.", chosen.hz(), chosen.get()),
        json!({ "clock_hz": Clock::INTERNAL.hz(), "prescale": around, "hz": hz, "chosen": chosen.get() }),
    ))
}

fn resistance() -> Result<Answer, Failure> {
    let part = |name: &str| -> Result<[f64; 4], Failure> {
        let wire = load_wire(name)?.value;
        let e = wire.electrical;
        Ok([
            wire.diameter_um,
            wire.length_mm,
            e.resistance_ohm,
            e.wire_share,
        ])
    };
    let (first, last) = (part("first-100um")?, part("final-75um")?);
    let rest = |wire: &[f64; 4]| wire[2] * (1.0 - wire[3]);
    let same = first[..3] == [100.0, 5.0, 1.4] && last[..3] == [75.0, 5.0, 1.9];
    Ok(Answer::new(
        Mark::new(same, || "the shipped wires have other figures".into()),
        format!(
            "Both wires ship. Crimps and leads take {:.2} and {:.2} Ohm of them.",
            rest(&first),
            rest(&last)
        ),
        json!({ "first": first, "final": last }),
    ))
}
