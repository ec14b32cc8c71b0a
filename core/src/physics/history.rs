//! The history of a wire before its first pulse.

/// A state that a wire is brought into by temperature alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireState {
    /// All martensite: cooled far below its martensite finish.
    Cold,
    /// Austenite and R: heated until all of it was austenite, then cooled to rest.
    Passed,
}

/// Heat and cold that a wire went through, and the state in which its bow was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct History {
    /// State in which the wire begins.
    pub state: WireState,
    /// State in which [`super::Mount::sag_m`] was measured.
    pub sag_state: WireState,
    /// Lowest temperature since a pass, degrees C; `None`: that of rest.
    pub coldest_c: Option<f64>,
}

impl History {
    /// A wire that is cold, its bow measured so.
    pub const COLD: Self = Self {
        state: WireState::Cold,
        sag_state: WireState::Cold,
        coldest_c: None,
    };
}
