//! Wire and finger: the exact solver beside the solvers of other projects.

mod bow;
mod methods;
mod peers;
mod precision;
mod speed;
mod train;

use crate::findings::Findings;
use palpate_run::Failure;

/// Measures the family.
///
/// # Errors
/// A method that cannot compute a case at all, or a peer that does not agree.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::new("physics");
    for part in [precision::measure, speed::measure] {
        part(&mut findings).map_err(Failure::Input)?;
    }
    bow::measure(&mut findings)?;
    Ok(findings)
}

#[cfg(test)]
mod tests;
