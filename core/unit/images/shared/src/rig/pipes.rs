//! The pipes, by semihosting.

use semihosting::fd::{AsFd, OwnedFd};
use semihosting::sys::arm_compat::{OpenMode, sys_open, sys_read_orig, sys_write_orig};

use super::{ANSWERS, QUESTIONS, Wires};

/// Both pipes; closed for good after the first failure.
#[derive(Debug)]
pub struct Pipes(Option<(OwnedFd, OwnedFd)>);

impl Pipes {
    /// Opens both pipes.
    pub fn open() -> Self {
        let questions = sys_open(QUESTIONS, OpenMode::WRONLY_TRUNC_BINARY);
        let answers = sys_open(ANSWERS, OpenMode::RDONLY_BINARY);
        Self(questions.ok().zip(answers.ok()))
    }
}

impl Wires for Pipes {
    fn send(&mut self, bytes: &[u8]) -> Option<()> {
        let (questions, _) = self.0.as_ref()?;
        let left = sys_write_orig(questions.as_fd(), bytes);
        left.is_ok_and(|left| left == 0).then_some(())
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Option<()> {
        let (_, answers) = self.0.as_ref()?;
        let mut done = 0;
        while let Some(room) = bytes.get_mut(done..).filter(|room| !room.is_empty()) {
            let wanted = room.len();
            let left = sys_read_orig(answers.as_fd(), room).ok()?;
            // All of it left: the other end is gone.
            if left >= wanted {
                self.0 = None;
                return None;
            }
            done += wanted - left;
        }
        Some(())
    }
}
