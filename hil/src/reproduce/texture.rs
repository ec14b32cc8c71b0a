//! Rows of chapter 3: the network, its windows, and the pulses that a latent vector becomes.

use palpate_core::texture::{Control, Drivers, LatentDriver};
use palpate_core::units::Duration;
use palpate_emulators::sensor::surface::SAMPLES;
use palpate_files::{
    Layer, LayoutFile, TextureDecoder, TextureModel, load_activation, load_layout,
};
use palpate_run::Failure;
use serde_json::json;

use super::row::{Answer, Mark, Row, broken};

/// The model that learned by reconstruction alone.
pub(super) const THESIS: &str = "thesis";

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-3.3.2-spacing",
        says: "The first module's three wires lie 6.5 mm apart in a line.",
        assumed: "Nothing.",
        compute: spacing,
    },
    Row {
        id: "tab-3.1",
        says: "The autoencoder for 45 inputs has 299,106 parameters.",
        assumed: "Two biases for each gate. The numbers of model `thesis` are counted.",
        compute: parameters,
    },
    Row {
        id: "claim-3.4.1-windows",
        says: "80 recordings of 200 steps give 6335, 1188 and 397 windows of 100 steps.",
        assumed: "Windows begin a stride apart. How the thesis split them is not printed.",
        compute: windows,
    },
    Row {
        id: "eq-3.1",
        says: "A wire pulses with the probability alpha + beta exp(-(t - mu)^2 / (2 sigma^2)).",
        assumed: "alpha, beta, T, mu and sigma: the thesis prints none (activation `assumed`).",
        compute: activation,
    },
    Row {
        id: "eq-3.2",
        says: "A control parameter is linear in a latent coordinate between the limits of both.",
        assumed: "z1 from -0.75 to 0.75; the limits of mu, sigma and f_PWM are those of the activation `assumed`.",
        compute: control,
    },
];

fn spacing() -> Result<Answer, Failure> {
    let LayoutFile::Display(file) = load_layout("three-in-line")?.value else {
        return Err(broken("`three-in-line` is no display"));
    };
    let mut along: Vec<f64> = file.wires_mm.iter().map(|w| w[0] + w[1]).collect();
    along.sort_unstable_by(f64::total_cmp);
    let gaps: Vec<f64> = along.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let same = gaps.len() == 2 && gaps.iter().all(|gap| (gap - 6.5).abs() < 1e-9);
    Ok(Answer::new(
        Mark::new(same, || "the layout has other places".into()),
        format!("Layout `three-in-line`: {gaps:?} mm."),
        json!({ "gaps_mm": gaps }),
    ))
}

fn parameters() -> Result<Answer, Failure> {
    let model = TextureModel::open(THESIS)?;
    let decoder = TextureDecoder::open(THESIS, &model)?.parameters();
    let layers = model.layers();
    let sizes: Vec<[usize; 2]> = layers.iter().map(|l| [l.inputs(), l.units()]).collect();
    let encoder: usize = layers.iter().map(Layer::parameters).sum();
    let all = encoder + decoder;
    let told: Vec<String> = sizes.iter().map(|[i, u]| format!("{i}-{u}")).collect();
    let told = told.join(", ");
    Ok(Answer::new(
        Mark::new(all == 299_106, || {
            format!("model `thesis` has other layers: {told}")
        }),
        format!(
            "{encoder} to z (layers {told}), {decoder} back: {all}. Window {}.",
            model.window()
        ),
        json!({
            "layers": sizes, "features": model.features(), "encoder": encoder, "decoder": decoder,
            "all": all,
        }),
    ))
}

/// Recordings of the first set: four textures, 20 times each.
const RECORDINGS: usize = 80;
/// Windows that the thesis counts: training, test, validation.
const PRINTED: [usize; 3] = [6335, 1188, 397];

/// Windows of a recording that begin `stride` rows apart.
const fn starts(rows: usize, window: usize, stride: usize) -> usize {
    (rows - window) / stride + 1
}

fn windows() -> Result<Answer, Failure> {
    let window = TextureModel::open(THESIS)?.window();
    let ours = [64, 12, 4].map(|recordings| recordings * starts(SAMPLES, window, 1));
    let all: usize = PRINTED.iter().sum();
    let per_recording = all / RECORDINGS;
    let strides: Vec<usize> = (1..=window)
        .filter(|s| RECORDINGS * starts(SAMPLES, window, *s) == all)
        .collect();
    let lengths: Vec<usize> = (window..=SAMPLES)
        .filter(|rows| RECORDINGS * starts(*rows, window, 1) == all)
        .collect();
    let by_recording = [64, 12, 4].map(|recordings| recordings * per_recording);
    // Shares of windows as a program in floating point takes them: the rest of 1 loses its last bit.
    let train = (all as f64 * (1.0 - 0.15 - 0.05)) as usize;
    let test = (all as f64 * 0.15) as usize;
    let by_window = [train, test, all - train - test];
    let cause = format!(
        "strides of 1 to {window}: {} give 7920 windows. Rows, at stride 1: {lengths:?} do, {per_recording} windows a recording. Split by recordings these are {by_recording:?}; split by windows at 80, 15 and 5 % in floating point, {by_window:?}",
        match strides.as_slice() {
            [] => "none".to_owned(),
            some => format!("{some:?}"),
        }
    );
    Ok(Answer::new(
        Mark::new(ours == PRINTED, || cause),
        format!(
            "{ours:?}: {} windows a recording at stride 1, split by recordings 64, 12 and 4.",
            starts(SAMPLES, window, 1)
        ),
        json!({
            "rows": SAMPLES, "window": window, "ours": ours, "strides": strides,
            "lengths": lengths, "by_recording": by_recording, "by_window": by_window,
        }),
    ))
}

/// Control parameters in the middle of a stroke.
fn middle() -> Control {
    Control {
        delta_mu: Duration::from_millis(120),
        sigma: Duration::from_millis(90),
        rate_mhz: 66_000,
    }
}

fn activation() -> Result<Answer, Failure> {
    let file = load_activation("assumed")?.value;
    let activation = file.activation().ok_or_else(|| broken("no activation"))?;
    let control = middle();
    let times_ms = [0_u64, 100, 200, 300, 400, 500];
    let of_wire = |wire: f32| {
        times_ms.map(|ms| activation.probability(Duration::from_millis(ms), wire, &control))
    };
    let found = [0.0, 1.0, 2.0].map(of_wire);
    let most = found.iter().flatten().copied().fold(0.0, f64::max);
    Ok(Answer::new(
        Mark::Agrees,
        format!(
            "{most:.3} at most for three wires at six times; alpha + beta is {:.3}.",
            file.alpha + file.beta
        ),
        json!({
            "alpha": file.alpha, "beta": file.beta, "lead_ms": file.lead_ms, "delta_mu_ms": 120.0,
            "sigma_ms": 90.0, "times_ms": times_ms, "probabilities": found,
        }),
    ))
}

fn control() -> Result<Answer, Failure> {
    let file = load_activation("assumed")?.value;
    let driver = LatentDriver {
        coordinate: 0,
        falls: false,
        low: -0.75,
        high: 0.75,
    };
    let map = file.map(Drivers::from(driver)).map_err(broken)?;
    let latents = [-1.0_f32, -0.75, -0.25, 0.0, 0.5, 0.75];
    let found = latents.map(|z| {
        let control = map.control(&[z, 0.0, 0.0]);
        [
            control.delta_mu.as_micros() as f64 * 1e-3,
            control.sigma.as_micros() as f64 * 1e-3,
            f64::from(control.rate_mhz) * 1e-3,
        ]
    });
    let [low, high] = [found[1], found[5]];
    Ok(Answer::new(
        Mark::Agrees,
        format!(
            "delta mu {:.0} to {:.0} ms, sigma {:.0} to {:.0} ms, f_PWM {:.0} to {:.0} Hz; beyond the limits of z the ends hold.",
            low[0], high[0], low[1], high[1], low[2], high[2]
        ),
        json!({
            "z_limits": [-0.75, 0.75], "z": latents, "found": found,
            "delta_mu_ms": [file.delta_mu_ms.smooth, file.delta_mu_ms.rough],
            "sigma_ms": [file.sigma_ms.smooth, file.sigma_ms.rough],
            "rate_hz": [file.rate_hz.smooth, file.rate_hz.rough],
        }),
    ))
}
