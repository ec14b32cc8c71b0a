//! `hil unit`.

use palpate_files::{Setup, load_scene};
use palpate_run::Failure;

use super::devices::bench;
use super::run::DEFAULT_SCENE;
use crate::cli::UnitArgs;
use palpate_live::link::key;
use palpate_live::output::print;
use palpate_live::telling::Telling;
use palpate_live::unit::{self, Options};

/// Serves a driver unit until stopped, or makes a key for one.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn unit(args: &UnitArgs) -> Result<(), Failure> {
    if let Some(path) = &args.new_key {
        key::make(path)?;
        return print(|out| {
            writeln!(
                out,
                "{}: a new key; give the same file to the unit and to its host",
                path.display()
            )
        });
    }
    let Some(path) = &args.key else {
        return Err(Failure::Input(
            "--key: expected the file of a key; `hil unit --new-key FILE` makes one".into(),
        ));
    };
    let key = key::read(path)?;
    // A unit projects no scene; what a scene states of the boards (PRE_SCALE) a host finds in the unit's hello.
    let scene = load_scene(DEFAULT_SCENE)?;
    let bench = bench(args.bench.as_deref(), &[], args.i2c.as_slice())?;
    let setup = Setup::join(scene, bench)?;
    unit::serve(
        &setup,
        &Options {
            listen: args.at,
            key,
            telling: Telling::new(args.json, args.quiet),
        },
    )
}
