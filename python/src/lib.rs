//! `willis._willis`: conversions between Python and the front door of the library, nothing else. The package around it, in Python,
//! gives them names, defaults and documentation.

mod errors;
mod interrupt;
mod objects;
mod tables;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use willis::Unfed;
use willis::cli;
use willis::cli::words::arguments_in;
use willis::internals::formats::convert::Target;
use willis::internals::pipeline::write_target;

use errors::raised;
use interrupt::{Watch, detached, interruptible};

/// The command line: its words, the first being the name of the program; the exit status.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| cli::main(words))
}

/// Runs a command by its words, the first being the subcommand, and raises what goes wrong.
#[pyfunction]
fn call(py: Python<'_>, words: Vec<String>) -> PyResult<()> {
    let watch = Watch::default();
    interruptible(py, &watch, None, None, None, |_| cli::call(words))?
}

/// So many threads from now on, where a call does not say otherwise.
#[pyfunction]
fn set_num_threads(py: Python<'_>, threads: usize) -> PyResult<()> {
    interrupt::set_num_threads(py, threads)
}

/// The bytes that a size such as `2GiB` is; none where it is no size.
#[pyfunction]
fn byte_count(text: &str) -> Option<u64> {
    willis::internals::formats::byte_count(text).ok()
}

/// Writes a network as a file of any format; what a person should know.
#[pyfunction]
#[pyo3(signature = (scan, path, to, unfed, force))]
fn write(
    py: Python<'_>,
    scan: &objects::Scan,
    path: PathBuf,
    to: Option<String>,
    unfed: Option<String>,
    force: bool,
) -> PyResult<Vec<String>> {
    let network = &scan.input.network;
    let written = detached(py, || {
        let unfed = unfed.map(|word| word.parse::<Unfed>()).transpose()?;
        write_target(network, &Target::new(&path, to.as_deref())?.with_unfed(unfed), force)
    });
    let written = written.map_err(|e| raised(py, &e))?;
    let notes = written.notes.iter().map(|note| arguments_in(note));
    Ok(notes.chain(written.lost.into_iter().map(|lost| format!("lost: {lost}"))).collect())
}

#[pymodule(gil_used = true)]
fn _willis(m: &Bound<'_, PyModule>) -> PyResult<()> {
    interrupt::remember_process();
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add_class::<objects::Scan>()?;
    m.add_class::<objects::Prepared>()?;
    m.add_class::<objects::Run>()?;
    m.add_class::<objects::Simulation>()?;
    m.add_class::<objects::Modulation>()?;
    m.add_class::<objects::Phenotype>()?;
    m.add_class::<Watch>()?;
    for function in [
        wrap_pyfunction!(main, m)?,
        wrap_pyfunction!(call, m)?,
        wrap_pyfunction!(set_num_threads, m)?,
        wrap_pyfunction!(byte_count, m)?,
        wrap_pyfunction!(write, m)?,
        wrap_pyfunction!(objects::read, m)?,
        wrap_pyfunction!(objects::read_bytes, m)?,
        wrap_pyfunction!(objects::phantom, m)?,
        wrap_pyfunction!(objects::prepare, m)?,
        wrap_pyfunction!(objects::simulate, m)?,
        wrap_pyfunction!(objects::modulate, m)?,
        wrap_pyfunction!(objects::classify, m)?,
        wrap_pyfunction!(objects::run_from_bytes, m)?,
    ] {
        m.add_function(function)?;
    }
    Ok(())
}
