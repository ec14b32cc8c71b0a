//! Wire and finger: the exact solver against other methods and other people's solvers.

mod methods;
mod peers;
mod precision;
mod train;

use crate::bench::Findings;
use crate::failure::Failure;

/// Measures the family.
///
/// # Errors
/// A method that cannot compute a case at all.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::default();
    precision::measure(&mut findings).map_err(Failure::Input)?;
    Ok(findings)
}
