//! Choice of a bench by a command line: a built-in one, or a file, whose addresses the command line may replace.

use std::path::{Path, PathBuf};

use palpate_files::{
    Bench, BenchKind, DEFAULT_BENCH, Loaded, Overrides, Real, load_bench, repeated_bus,
};
use palpate_run::Failure;

use crate::cli::UnitOn;
use palpate_live::link::UnitPlace;

/// A bench by name on its own buses or on these.
///
/// # Errors
/// The errors of [`bench_with`].
pub(super) fn bench(
    name: Option<&str>,
    can: &[String],
    i2c: &[PathBuf],
) -> Result<Loaded<Bench>, Failure> {
    bench_with(name, &Overrides::default(), can, i2c)
}

/// A bench by name, with these changes, and these interfaces and adapters in place of its own where there are any.
///
/// # Errors
/// An unknown name, a bad file, or devices that are too few.
pub(super) fn bench_with(
    name: Option<&str>,
    overrides: &Overrides,
    can: &[String],
    i2c: &[PathBuf],
) -> Result<Loaded<Bench>, Failure> {
    let bench = bench_on(name, overrides, can, i2c)?;
    if !(can.is_empty() && i2c.is_empty()) {
        enough_adapters(&bench.value)?;
    }
    Ok(bench)
}

/// A bench by name, with changes and devices as in `bench_with`, without a check of the number of adapters.
///
/// # Errors
/// An unknown name, a bad file, devices that are named twice, or more of them than the bench has.
pub fn bench_on(
    name: Option<&str>,
    overrides: &Overrides,
    can: &[String],
    i2c: &[PathBuf],
) -> Result<Loaded<Bench>, Failure> {
    let bench = load_bench(name.unwrap_or(DEFAULT_BENCH))?.with(overrides)?;
    if can.is_empty() && i2c.is_empty() {
        return Ok(bench);
    }
    let Some(real) = &bench.value.real else {
        let option = if can.is_empty() { "--i2c" } else { "--can" };
        return Err(Failure::Input(format!(
            "{option}: expected a bench of kind \"real\", whose addresses it replaces; `{}` names no buses, and says nothing of the wires and current on them. Make one with `{}`, make it true, and name it with --bench",
            bench.value.name,
            new_line(can, i2c)
        )));
    };
    for (option, given, own) in [
        ("--can", can.len(), real.can.len()),
        ("--i2c", i2c.len(), real.i2c.len()),
    ] {
        if given > own {
            return Err(Failure::Input(format!(
                "{option}: expected at most {own}, the addresses that bench `{}` has for it to replace, found {given}; name more in the bench's own file",
                bench.value.name
            )));
        }
    }
    on_devices(bench, can, i2c)
}

/// The line that makes a bench of hardware on these devices.
fn new_line(can: &[String], i2c: &[PathBuf]) -> String {
    let or = |given: Vec<String>, other: &str| match given.is_empty() {
        true => vec![other.to_owned()],
        false => given,
    };
    let can = or(can.to_vec(), "can0").into_iter();
    let i2c = i2c.iter().map(|path| path.display().to_string());
    let i2c = or(i2c.collect(), "/dev/i2c-1").into_iter();
    let can = can.map(|name| format!(" --can {name}"));
    let i2c = i2c.map(|path| format!(" --i2c {path}"));
    format!(
        "hil new bench my-bench{}",
        can.chain(i2c).collect::<String>()
    )
}

/// The skin of a bench on these interfaces, or the default one's: it drives nothing, so nothing of it must be true of hardware.
///
/// # Errors
/// An unknown name, a bad file, or devices that are named twice.
pub fn skin_on(
    name: Option<&str>,
    overrides: &Overrides,
    can: &[String],
) -> Result<Loaded<Bench>, Failure> {
    let bench = load_bench(name.unwrap_or(DEFAULT_BENCH))?.with(overrides)?;
    on_devices(bench, can, &[])
}

/// Adapters alone, with a board where the default bench has one: to switch off what is on them.
///
/// # Errors
/// Devices that are named twice.
pub(super) fn adapters_alone(i2c: &[PathBuf]) -> Result<Loaded<Bench>, Failure> {
    on_devices(load_bench(DEFAULT_BENCH)?, &[], i2c)
}

fn on_devices(
    mut bench: Loaded<Bench>,
    can: &[String],
    i2c: &[PathBuf],
) -> Result<Loaded<Bench>, Failure> {
    if can.is_empty() && i2c.is_empty() {
        return Ok(bench);
    }
    let file = &mut bench.value;
    file.kind = BenchKind::Real;
    let real = file.real.get_or_insert_with(|| Real::new(vec![], vec![]));
    if !can.is_empty() {
        real.can = can.to_vec();
    }
    if !i2c.is_empty() {
        real.i2c = i2c.to_vec();
    }
    once("--can", real.can.iter().map(Path::new))?;
    once("--i2c", real.i2c.iter().map(PathBuf::as_path))?;
    Ok(bench)
}

/// Refuses a bench of hardware whose outputs have fewer adapters than they name.
///
/// # Errors
/// [`Failure::Input`] with how many it needs.
pub fn enough_adapters(bench: &Bench) -> Result<(), Failure> {
    let Some(real) = bench
        .real
        .as_ref()
        .filter(|_| bench.unit_address().is_none())
    else {
        return Ok(());
    };
    let needed = bench.outputs.iter().map(|o| usize::from(o.bus) + 1).max();
    if needed > Some(real.i2c.len()) {
        return Err(Failure::Input(format!(
            "--i2c: bench `{}` needs {} adapters, found {}",
            bench.name,
            needed.unwrap_or(0),
            real.i2c.len()
        )));
    }
    Ok(())
}

/// The driver unit that a command names, by option or by its bench.
///
/// # Errors
/// A bad bench, address or key file.
pub(super) fn unit_of(name: Option<&str>, on: &UnitOn) -> Result<Option<UnitPlace>, Failure> {
    UnitPlace::find(&bench_of(name, on)?)
}

/// The bench that a command names, with the driver unit that it names.
///
/// # Errors
/// A bad bench or address.
pub(super) fn bench_of(name: Option<&str>, on: &UnitOn) -> Result<Loaded<Bench>, Failure> {
    let mut overrides = Overrides::default();
    on.change(&mut overrides);
    bench_with(name, &overrides, &[], &[])
}

/// Every device must be named once.
fn once<'a>(option: &str, names: impl Iterator<Item = &'a Path> + Clone) -> Result<(), Failure> {
    let Some((first, again)) = repeated_bus(names.clone()) else {
        return Ok(());
    };
    let name = names.map(Path::display).nth(again);
    let found = name.map_or_else(String::new, |name| name.to_string());
    Err(Failure::Input(format!(
        "{option}: expected a bus of its own for number {again}: number {first} is the same, and so are its addresses, found {found}"
    )))
}
