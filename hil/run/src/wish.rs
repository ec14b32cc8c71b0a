//! Wishes of a person while a run goes on.

use palpate_core::units::Instant;

use crate::display_end::DisplayEnd;
use crate::session::Session;
use crate::skin_end::SkinEnd;

/// A wish by a key, a page or a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// The reference of the skin is to be taken anew; `forced` also while anything is in contact.
    Rezero {
        /// `true` where contacts do not matter.
        forced: bool,
    },
    /// The display was put on anew: its wires count as cold and are to be passed.
    HotPass,
}

impl<S: SkinEnd, D: DisplayEnd> Session<S, D> {
    /// Grants a wish at `now`, or refuses it. The trace says what became of it.
    pub fn grant(&mut self, wish: Wish, now: Instant) {
        let text = match wish {
            Wish::Rezero { forced } => self.rezero(now, forced),
            Wish::HotPass => self.pass_again(now),
        };
        self.recorder().note(now, text);
    }

    /// Takes the reference of the skin anew, with everything off first.
    fn rezero(&mut self, now: Instant, forced: bool) -> String {
        let (display, projector, recorder) = self.all();
        let (banks, _) = display.parts();
        match projector.rezero(now, forced, banks, recorder) {
            Ok(()) => "rezero: the reference of the skin is taken anew".to_owned(),
            Err(refused) => format!("rezero: {refused}"),
        }
    }
}
