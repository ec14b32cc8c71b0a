//! Wire and finger: the exact solver against other methods and other people's solvers.

mod anchors;
mod hidden;
mod long;
mod methods;
mod peers;
mod precision;
mod speed;
mod train;

use crate::bench::Findings;
use crate::failure::Failure;

/// Measures the family.
///
/// # Errors
/// A method that cannot compute a case at all.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::default();
    for part in [
        precision::measure,
        hidden::measure,
        anchors::measure,
        long::measure,
        speed::measure,
    ] {
        part(&mut findings).map_err(Failure::Input)?;
    }
    Ok(findings)
}
