//! What a page asks for.

use serde::Deserialize;

/// A request. `do` says which.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// What there is to choose from.
    Shelves,
    /// Begins a session.
    Open(Chosen),
    /// Lets the session go on, under fingers.
    Step(Step),
    /// The session so far as a scene.
    Save,
    /// Ends the session, as a run of it ends, and says what it came to.
    End,
    /// A whole run, without looking on.
    Run(Chosen),
}

/// What a session or run is of.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Chosen {
    /// A built-in scene.
    pub scene: String,
    /// A scene's text in its place.
    pub text: Option<String>,
    /// A built-in bench.
    pub bench: String,
    /// `KEY=VALUE` in place of the files' own, as `hil run --set` takes them.
    pub set: Vec<String>,
    /// Whether the guard only looks on.
    pub observe: bool,
    /// Seed of every random stream; left out: 1.
    pub seed: Option<u64>,
}

/// How far to go, and what the fingers do from now on.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Until this time, microseconds.
    pub until_us: u64,
    /// Of each finger that does something else from now on: its number, the module, x and y (um), force (mN), diameter (um).
    #[serde(default)]
    pub fingers: Vec<(usize, usize, i64, i64, i64, i64)>,
}
