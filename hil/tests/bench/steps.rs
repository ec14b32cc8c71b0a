//! The steps that a sequence of runs is drawn from.

use std::time::Duration;

use nix::libc;
use palpate_tests::fake_bench::{GUARDIAN, RUN};

use crate::campaign::Draws;
use crate::damage::Damage;

/// The processes that are killed.
#[derive(Clone, Copy, Debug)]
pub enum Killed {
    /// The run.
    Run,
    /// The guardian.
    Guardian,
    /// Both at once.
    Both,
}

/// How the state folder fails, for [`RUN`], [`GUARDIAN`] or both.
#[derive(Clone, Copy, Debug)]
pub enum Disk {
    /// Each call fails with this error number.
    Fails(i32),
    /// No call returns.
    Hangs,
}

/// A step of a sequence. Each begins at least one run.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// A run that nothing disturbs.
    Clean,
    /// A run of which processes are killed at a random moment.
    Kill(Killed, Duration),
    /// Another name for this start of the machine, and whether its clocks begin anew.
    Reboot(bool, bool),
    /// A file of the ledger is damaged.
    Ledger(Damage),
    /// The record of a stop is damaged.
    Record(Damage),
    /// The file of the lock is of a newer version.
    Lock,
    /// The disk fails from the run's begin, or this long after it, for so long.
    Disk(Disk, u32, Option<Duration>, Duration),
    /// The state folder cannot be made.
    NoFolder,
    /// The state folder is another user's.
    OthersFolder,
    /// Two programs run, the second so much later.
    Two(Duration),
    /// The adapter comes back under another number.
    Port,
    /// `hil off` clears nothing, and forgets nothing for another name.
    Off,
}

impl Step {
    /// Draws one.
    pub fn draw(draws: &mut Draws) -> Self {
        match draws.below(30) {
            0..14 => Self::Clean,
            14..18 => {
                let killed = draws.pick(&[Killed::Run, Killed::Guardian, Killed::Both]);
                Self::Kill(killed, draws.ms(20, 1950))
            }
            18 | 19 => {
                let (is_named, is_anew) = draws.pick(&[(true, true), (true, false), (false, true)]);
                Self::Reboot(is_named, is_anew)
            }
            20 | 21 => Self::Ledger(Damage::draw(draws)),
            22 => Self::Record(Damage::draw(draws)),
            23 => Self::Lock,
            24 | 25 => {
                let disk = draws.pick(&[
                    Disk::Fails(libc::ENOSPC),
                    Disk::Fails(libc::EROFS),
                    Disk::Fails(libc::EIO),
                    Disk::Hangs,
                ]);
                let from = draws.ms(100, 1100);
                let from = (draws.below(2) == 0).then_some(from);
                let whose = draws.pick(&[RUN, GUARDIAN, RUN | GUARDIAN]);
                Self::Disk(disk, whose, from, draws.ms(100, 3000))
            }
            26 => draws.pick(&[Self::NoFolder, Self::OthersFolder]),
            27 => Self::Two(draws.ms(0, 1400)),
            28 => Self::Port,
            _ => Self::Off,
        }
    }

    /// The kind of a step, in words.
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Clean => "clean run",
            Self::Kill(Killed::Run, _) => "run killed",
            Self::Kill(Killed::Guardian, _) => "guardian killed",
            Self::Kill(Killed::Both, _) => "both killed",
            Self::Reboot(..) => "reboot",
            Self::Ledger(_) => "ledger damaged",
            Self::Record(_) => "record damaged",
            Self::Lock => "newer lock",
            Self::Disk(Disk::Fails(_), ..) => "disk fails",
            Self::Disk(Disk::Hangs, ..) => "disk hangs",
            Self::NoFolder => "no folder",
            Self::OthersFolder => "folder of another user",
            Self::Two(_) => "two programs",
            Self::Port => "another number",
            Self::Off => "hil off",
        }
    }
}
