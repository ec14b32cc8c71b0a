//! `hil emulate`.

use crate::cli::EmulateArgs;
use palpate_files::{Setup, load_bench, load_scene};
use palpate_live::emulate::{self, Options};
use palpate_live::telling::Telling;
use palpate_run::Failure;

use super::run::DEFAULT_SCENE;

/// Serves a scene's boards and a bench's display until stopped.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn emulate(args: &EmulateArgs) -> Result<(), Failure> {
    let scene = load_scene(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    let bench = args.bench.as_deref();
    let bench = load_bench(bench.unwrap_or(scene.value.own_bench()))?;
    let setup = Setup::join(scene, bench)?;
    emulate::serve(
        &setup,
        &Options {
            can: args.can.clone(),
            await_start: args.await_start,
            oe: args.oe,
            seed: args.seed,
            telling: Telling::new(args.json, args.quiet),
        },
    )
}
