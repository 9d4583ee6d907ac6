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

use interrupt::{Watch, computed, interruptible};

/// The command line: its words, the first being the name of the program; the exit status.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| cli::main(words))
}

/// Runs a command by its words, the first being the subcommand, and raises what goes wrong; `say` hears what it says.
#[pyfunction]
fn call(py: Python<'_>, words: Vec<String>, say: &Bound<'_, PyAny>) -> PyResult<()> {
    interruptible(py, &Watch::default(), None, None, Some(say), |follower| {
        let (said, result) = cli::words::called(words);
        follower.say(said);
        result
    })?
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
    let written = computed(py, || {
        let unfed = unfed.map(|word| word.parse::<Unfed>()).transpose()?;
        write_target(network, &Target::new(&path, to.as_deref())?.with_unfed(unfed), force)
    })?;
    let notes = written.notes.iter().map(|note| arguments_in(note));
    Ok(notes.chain(written.lost.into_iter().map(|lost| format!("lost: {lost}"))).collect())
}

#[pymodule(gil_used = true)]
mod _willis {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::interrupt::{Watch, set_num_threads};
    #[pymodule_export]
    use super::objects::{Modulation, Phenotype, Prepared, Run, Scan, Simulation};
    #[pymodule_export]
    use super::objects::{classify, modulate, phantom, prepare, read, read_bytes, run_from_bytes, simulate};
    #[pymodule_export]
    use super::{byte_count, call, main, write};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::interrupt::remember_process();
        // A command line without a command: from now on notes name arguments as Python has them.
        let _ = super::cli::check(["willis".into()]);
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
