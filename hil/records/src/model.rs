//! The ends of the model of wire and tissue. A temperature beyond them is no number, and is told so.

pub use palpate_core::physics::TIGHTEST;

/// Hottest wire that the model knows, degrees C. Nickel-titanium is annealed above: it loses the shape that it was set to.
pub const WIRE_C: f64 = 400.0;
/// Hottest tissue that the model knows, degrees C. Water boils above.
pub const TISSUE_C: f64 = 100.0;

/// A temperature that lies within the model; `None` beyond it and for what is no number.
pub fn known(celsius: f64, most: f64) -> Option<f64> {
    (celsius <= most).then_some(celsius)
}

/// A temperature in words: `34.9 C`, `beyond the model (over 100 C)`, or `-` where nothing measured it.
pub fn words(celsius: Option<f64>, most: f64) -> String {
    match celsius.map(|c| known(c, most)) {
        None => "-".to_owned(),
        Some(Some(c)) => format!("{c:.1} C"),
        Some(None) => format!("beyond the model (over {most:.0} C)"),
    }
}

/// A temperature on a page: `34.9 °C`, or `> 100 °C` beyond the model.
pub fn on_page(celsius: f64, most: f64) -> String {
    match known(celsius, most) {
        Some(celsius) => format!("{celsius:.1} \u{b0}C"),
        None => format!("> {most:.0} \u{b0}C"),
    }
}

#[cfg(test)]
#[path = "model_tests.rs"]
mod tests;
