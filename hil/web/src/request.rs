//! Requests of a page.

use serde::Deserialize;

/// A request. `do` names its kind.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// Asks for the shelves: the built-in files to choose from.
    Shelves,
    /// Begins a session.
    Open(Chosen),
    /// Lets the session go on, under fingers.
    Step(Step),
    /// Asks for the session so far as a scene.
    Save,
    /// Ends the session, as a run of it ends, and asks for its digest.
    End,
    /// Runs a whole scene at once.
    Run(Chosen),
}

/// Files, values and seed of a session or run.
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
    /// `true` where the guard only observes.
    pub observe: bool,
    /// Seed of every random stream; left out: 1.
    pub seed: Option<u64>,
}

/// Time to go on to, and the touches from now on.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Time to go on to, microseconds.
    pub until_us: u64,
    /// Changed touches from now on, one per finger: number, module, x and y (um), force (mN), diameter (um).
    #[serde(default)]
    pub fingers: Vec<(usize, usize, i64, i64, i64, i64)>,
}
