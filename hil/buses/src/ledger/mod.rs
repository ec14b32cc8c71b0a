//! The ledger: heat and dose that outlive every process. Heat of the tissue by the hardware that is on it, and dose by
//! wearer, over all hardware.
//!
//! A run reads its accounts before anything is opened. Once the hardware is its own it holds them: a thread reserves
//! the worst heat of the next seconds ahead, and without a reserve nothing may be driven. A clean end replaces the
//! reserve by true heat, and a death leaves it booked.

mod account;
mod keeper;
mod layout;
mod passed;
mod uptime;

use std::io;
use std::path::{Path, PathBuf};

use palpate_core::guard::{Doses, Guard, Memory, Spent};
use palpate_core::units::{Duration, Instant};

pub use keeper::Keeper;
pub use layout::Output;
pub use passed::{keep_passed, passed};

use crate::guardian::{remedy, state_folder};
use account::{Account, Held};
use layout::Kept;
use uptime::Uptime;

/// Reason for which an account that is whole is not believed.
const ODD: &str = "no guard has such heat or dose";

/// Errors of the ledger, for which nothing may be driven.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// The account cannot be read: its heat or dose is unknown.
    #[error("{}: {why}", .file.display())]
    Unreadable {
        /// The account's file.
        file: PathBuf,
        /// Reason why the account cannot be read.
        why: String,
    },
    /// Accounts cannot be kept in the folder.
    #[error("{}: heat cannot be kept there: {error}; a folder for all users is made with `{}`", .folder.display(), remedy(.folder.parent().unwrap_or(.folder)))]
    Folder {
        /// The folder of all accounts.
        folder: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// Another run books on the same account: the hardware is another's, or its wearer is.
    #[error("{}: another run keeps its account there: end that one, or say in the scene's or bench's `wearer` who wears which", .0.display())]
    Held(PathBuf),
    /// Another run has ended between two looks.
    #[error("{}: another run has just booked there: start again", .0.display())]
    Changed(PathBuf),
    /// No reserve could be written.
    #[error("heat cannot be kept: {0}")]
    Reserve(String),
}

/// A fingertip of a run.
#[derive(Clone, Debug)]
pub struct Fingertip {
    /// Wires in the display's order: the number of their hardware, and their output on it.
    pub wires: Vec<(usize, Output)>,
    /// Number of the wearer; `None` where the dose is kept elsewhere.
    pub wearer: Option<usize>,
}

/// The accounts of a run as they were read.
#[derive(Debug)]
pub struct Ledger {
    hardware: Vec<(Account, Vec<Kept>)>,
    wearers: Vec<(Account, Doses)>,
    fingertips: Vec<Fingertip>,
}

/// Folder of all accounts: the sticky folder of stops does not allow to rename over another user's file.
pub fn folder() -> PathBuf {
    state_folder().join("heat")
}

fn heat_of(hardware: &str) -> String {
    format!("{hardware}.heat")
}

fn dose_of(wearer: &str) -> String {
    format!("{wearer}.dose")
}

/// Forgets heat and dose in a folder of accounts: a person's decision. Returns whether there was any.
///
/// # Errors
/// [`LedgerError::Held`] while a run books there, and the system's error.
pub fn forget(folder: &Path, hardware: &[String], wearers: &[String]) -> Result<bool, LedgerError> {
    let heat = hardware.iter().map(|name| heat_of(name));
    let states = hardware.iter().map(|name| passed::name_of(name));
    let names = heat
        .chain(states)
        .chain(wearers.iter().map(|name| dose_of(name)));
    let mut is_any = false;
    for name in names {
        is_any |= Account::forget(folder, &name)?;
    }
    Ok(is_any)
}

impl Ledger {
    /// Reads the accounts of hardware and wearers in a folder, by their names, for these fingertips.
    ///
    /// # Errors
    /// [`LedgerError::Unreadable`].
    pub fn open(
        folder: &Path,
        (hardware, wearers): (&[String], &[String]),
        fingertips: Vec<Fingertip>,
    ) -> Result<Self, LedgerError> {
        let heat = |name: &String| {
            let account = Account::open(folder, &heat_of(name))?;
            let kept = match account.payload()? {
                Some(bytes) => layout::wires(bytes).ok_or_else(|| account.unreadable(ODD))?,
                None => Vec::new(),
            };
            Ok::<_, LedgerError>((account, kept))
        };
        let dose = |name: &String| {
            let account = Account::open(folder, &dose_of(name))?;
            let doses = match account.payload()? {
                Some(bytes) => layout::doses(bytes).ok_or_else(|| account.unreadable(ODD))?,
                None => Doses::default(),
            };
            Ok::<_, LedgerError>((account, doses))
        };
        Ok(Self {
            hardware: hardware.iter().map(heat).collect::<Result<_, _>>()?,
            wearers: wearers.iter().map(dose).collect::<Result<_, _>>()?,
            fingertips,
        })
    }

    /// Heat and dose of a fingertip as of now. A wire that was never driven is cold. Heat of unknown age has not
    /// cooled.
    pub fn memory(&self, fingertip: usize) -> Memory {
        self.memory_at(fingertip, Uptime::now())
    }

    fn memory_at(&self, fingertip: usize, now: Uptime) -> Memory {
        let fingertip = self.fingertips.get(fingertip);
        let wires = fingertip.map_or(&[][..], |own| own.wires.as_slice());
        let wearer = fingertip.and_then(|own| self.wearers.get(own.wearer?));
        let find = |(hardware, output): &(usize, Output)| {
            let (_, kept) = self.hardware.get(*hardware)?;
            kept.iter().find(|kept| kept.output == *output)
        };
        let remembered = |place| {
            let kept = find(place).map(|kept| kept.wire.after(now.since(kept.uptime)));
            let mut wire = kept.unwrap_or_default();
            if let Some((_, doses)) = wearer {
                wire.doses = *doses;
            }
            wire
        };
        // Wires of one fingertip share its power; the powers of several fingertips add up.
        let mut tips: Vec<(Uptime, Spent)> = Vec::new();
        let mut face_k = 0.0_f64;
        for kept in wires.iter().filter_map(find) {
            let tip = (kept.uptime, kept.tip);
            if !tips.contains(&tip) {
                tips.push(tip);
            }
            face_k = face_k.max(kept.face_k);
        }
        let ago = tips.iter().map(|(uptime, tip)| {
            let elapsed = now.since(*uptime).unwrap_or(Duration::ZERO);
            tip.ago + elapsed
        });
        let tip = Spent {
            ago: ago.min().unwrap_or_default(),
            pj: tips
                .iter()
                .fold(0_u64, |sum, (_, tip)| sum.saturating_add(tip.pj)),
        };
        Memory {
            wires: wires.iter().map(remembered).collect(),
            tip,
            face_k,
        }
    }

    /// Holds the accounts and reserves ahead, from these guards at their times: those of all fingertips, in their order.
    ///
    /// # Errors
    /// [`LedgerError`]: nothing may be driven.
    pub fn keep(self, states: &[(Instant, &Guard)]) -> Result<Keeper, LedgerError> {
        let Self {
            hardware,
            wearers,
            fingertips,
        } = self;
        let is_own = |number: usize, kept: &Kept| {
            let mut places = fingertips.iter().flat_map(|own| &own.wires);
            places.any(|own| *own == (number, kept.output))
        };
        let mut others = Vec::new();
        for (number, (account, mut kept)) in hardware.into_iter().enumerate() {
            kept.retain(|kept| !is_own(number, kept));
            others.push((account.hold()?, kept));
        }
        let mut worn = Vec::new();
        for (account, doses) in wearers {
            worn.push((account.hold()?, doses));
        }
        let books = Books {
            others,
            wearers: worn,
            fingertips,
        };
        Keeper::start(books, states)
    }
}

/// Accounts that are held.
#[derive(Debug)]
struct Books {
    /// Accounts by hardware, with the wires that are none of this run's.
    others: Vec<(Held, Vec<Kept>)>,
    /// Accounts by wearer, with the dose before the run.
    wearers: Vec<(Held, Doses)>,
    fingertips: Vec<Fingertip>,
}

impl Books {
    /// Writes the memory that outlives the run, by fingertip, with its time.
    fn write(&self, states: &[(Uptime, Memory)]) -> io::Result<()> {
        for (number, (account, before)) in self.wearers.iter().enumerate() {
            let own = self.fingertips.iter().zip(states);
            let own = own.filter(|(fingertip, _)| fingertip.wearer == Some(number));
            let doses = own.fold(*before, |most, (_, (_, memory))| most.max(memory.doses()));
            account.write(&layout::of_doses(&doses))?;
        }
        for (number, (account, others)) in self.others.iter().enumerate() {
            let mut kept = others.clone();
            for (fingertip, (uptime, memory)) in self.fingertips.iter().zip(states) {
                let wires = fingertip.wires.iter().zip(&memory.wires);
                let here = wires.filter(|((hardware, _), _)| *hardware == number);
                kept.extend(here.map(|((_, output), wire)| Kept {
                    output: *output,
                    uptime: *uptime,
                    wire: wire.clone(),
                    tip: memory.tip,
                    face_k: memory.face_k,
                }));
            }
            account.write(&layout::of_wires(&kept))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
