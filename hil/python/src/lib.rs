//! The module `palpate._palpate`: what Python needs of Palpate, as columns and plain values. The package `palpate`
//! around it makes numpy's arrays of them and checks arguments; nothing is computed there.

mod chip;
mod contacts;
mod errors;
mod guard;
mod happened;
mod load;
mod places;
mod program;
mod run;
mod session;
mod setup;
mod shown;
mod sweep;
mod table;
mod tables;
mod texture;

use pyo3::prelude::pymodule;

#[pymodule]
mod _palpate {
    #[pymodule_export]
    use crate::chip::I2cBus;
    #[pymodule_export]
    use crate::contacts::Finder;
    #[pymodule_export]
    use crate::guard::guard;
    #[pymodule_export]
    use crate::happened::Happened;
    #[pymodule_export]
    use crate::load::{kind, load_buses, load_schedule, load_taxels};
    #[pymodule_export]
    use crate::program::main;
    #[pymodule_export]
    use crate::run::{Run, run};
    #[pymodule_export]
    use crate::session::Loop;
    #[pymodule_export]
    use crate::setup::Setup;
    #[pymodule_export]
    use crate::shown::notebook;
    #[pymodule_export]
    use crate::sweep::{Sweep, sweep_rows};
    #[pymodule_export]
    use crate::table::arrow_stream;
    #[pymodule_export]
    use crate::texture::Texture;

    /// Version of the rust crates: what a row of a sweep is keyed by.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
