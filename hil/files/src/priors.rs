//! Priors of what has not been measured: a distribution for each quantity of wire, finger and person.

use serde::Deserialize;

use super::error::FileError;
use super::quantity::{Quantity, QuantityTable};
use super::source::Source;

/// The distribution of a quantity; exactly one key is stated.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct PriorEntry {
    /// Equal everywhere between both ends.
    pub uniform: Option<[f64; 2]>,
    /// Equal everywhere between both ends of the logarithm.
    pub log_uniform: Option<[f64; 2]>,
    /// Mean and standard deviation.
    pub normal: Option<[f64; 2]>,
    /// Median, and the standard deviation of the natural logarithm.
    pub log_normal: Option<[f64; 2]>,
    /// A value that is known.
    pub known: Option<f64>,
}

/// A distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// Between both ends.
    Uniform(f64, f64),
    /// Between both ends, by the logarithm.
    LogUniform(f64, f64),
    /// Mean and standard deviation.
    Normal(f64, f64),
    /// Median, and the standard deviation of the logarithm.
    LogNormal(f64, f64),
    /// A value.
    Known(f64),
}

impl PriorEntry {
    /// The stated distribution; `None` where none or several are.
    #[must_use]
    pub fn prior(&self) -> Option<Prior> {
        let of =
            |pair: Option<[f64; 2]>, make: fn(f64, f64) -> Prior| pair.map(|[a, b]| make(a, b));
        let all = [
            of(self.uniform, Prior::Uniform),
            of(self.log_uniform, Prior::LogUniform),
            of(self.normal, Prior::Normal),
            of(self.log_normal, Prior::LogNormal),
            self.known.map(Prior::Known),
        ];
        let mut stated = all.into_iter().flatten();
        let first = stated.next();
        first.filter(|_| stated.next().is_none())
    }

    fn check(&self, source: &Source, quantity: Quantity) -> Result<(), FileError> {
        let key = format!("prior.{}", quantity.key());
        let Some(prior) = self.prior() else {
            let expected = "one of uniform, log_uniform, normal, log_normal and known, such as { uniform = [35, 55] }";
            return Err(source.bad(&key, expected));
        };
        let (low, high) = quantity.bounds();
        let ends = |name: &str, (a, b): (f64, f64), least: f64| {
            let key = format!("{key}.{name}");
            if a >= b {
                let expected = format!("the lower end first: more than {a} behind it");
                return Err(source.bad(&key, expected));
            }
            source.range(&key, &[a, b], low.max(least)..=high, quantity.unit())
        };
        let spread = |name: &str, (middle, spread): (f64, f64), least: f64, most: f64| {
            let key = format!("{key}.{name}");
            source.range(
                &format!("{key}[0]"),
                &middle,
                low.max(least)..=high,
                quantity.unit(),
            )?;
            source.range(&format!("{key}[1]"), &spread, 1e-6..=most, "")
        };
        match prior {
            Prior::Uniform(a, b) => ends("uniform", (a, b), low),
            Prior::LogUniform(a, b) => ends("log_uniform", (a, b), 1e-9),
            Prior::Normal(m, s) => spread("normal", (m, s), low, high - low),
            Prior::LogNormal(m, s) => spread("log_normal", (m, s), 1e-9, 3.0),
            Prior::Known(v) => {
                source.range(&format!("{key}.known"), &v, low..=high, quantity.unit())
            }
        }
    }
}

/// Priors of what has not been measured.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PriorsFile {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The priors, in a sentence.
    pub description: String,
    /// Probability that wires are taut.
    pub taut: f64,
    /// Two-way strain that a taut wire has at least, % per MPa of its stress.
    pub taut_strain: f64,
    /// Distributions of the quantities.
    pub prior: QuantityTable<PriorEntry>,
}

impl PriorsFile {
    /// Reads and checks priors.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        source.range("taut", &file.taut, 0.0..=1.0, "")?;
        source.range("taut_strain", &file.taut_strain, 0.0..=0.05, "% per MPa")?;
        for quantity in Quantity::ALL {
            match file.prior.entry(quantity) {
                Some(entry) => entry.check(source, quantity)?,
                None if quantity.is_of_bench() => {}
                None => {
                    let expected = format!("a prior of `{}`", quantity.key());
                    return Err(source.bad_found("prior", expected, "none"));
                }
            }
        }
        Ok(file)
    }

    /// The distribution of a quantity; `None` where the bench's value counts.
    #[must_use]
    pub fn prior(&self, quantity: Quantity) -> Option<Prior> {
        self.prior.entry(quantity).and_then(PriorEntry::prior)
    }
}
