//! Compression: clustering and levels beside other people's, whole frames of skins of every size, what noise and
//! settings do to the path, and the thesis's figures over again.

mod accuracy;
mod clouds;
mod figures;
mod frames;
mod kernels;
mod peers;
pub(super) mod presses;
mod textbook;

use crate::bench::Findings;
use crate::failure::Failure;

/// Measures the family.
///
/// # Errors
/// Fixtures that do not fit together, or peers that are asked for and do not answer.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::default();
    kernels::measure(&mut findings)?;
    frames::measure(&mut findings)?;
    accuracy::measure(&mut findings)?;
    figures::measure(&mut findings)?;
    Ok(findings)
}
