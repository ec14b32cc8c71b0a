//! Compression: clustering and levels beside peers, whole frames of skins of every size, and the thesis's figures 4.5 to
//! 4.7.

mod clouds;
mod figures;
mod frames;
mod kernels;
mod panels;
mod peers;
mod side_by_side;
mod textbook;

use crate::findings::Findings;
use palpate_run::Failure;

/// Measures the family.
///
/// # Errors
/// Fixtures that do not fit together, or peers that are named and do not answer.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::new("compression");
    kernels::measure(&mut findings)?;
    frames::measure(&mut findings)?;
    side_by_side::measure(&mut findings)?;
    figures::measure(&mut findings)?;
    Ok(findings)
}
