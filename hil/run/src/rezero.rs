//! The reference of the skin anew, because a person asks for it.

use palpate_core::units::Instant;

use crate::display_end::DisplayEnd;
use crate::session::Session;
use crate::skin_end::SkinEnd;

/// Takes the reference of the skin anew at `now`, with everything off first; not while anything is in contact, unless
/// `forced`. The trace says what became of it.
pub fn rezero<S: SkinEnd, D: DisplayEnd>(session: &mut Session<S, D>, now: Instant, forced: bool) {
    let (display, projector, recorder) = session.all();
    let (banks, _) = display.parts();
    let text = match projector.rezero(now, forced, banks, recorder) {
        Ok(()) => "rezero: the reference of the skin is taken anew".to_owned(),
        Err(refused) => format!("rezero: {refused}"),
    };
    recorder.note(now, text);
}
