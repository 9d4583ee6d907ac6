//! failed.json: why an input gave no run, in the place of its run, for `willis merge` to make a row of it.

use std::path::Path;

use serde::{Deserialize, Serialize};
use willis::error::{Error, Result};
use willis::internals::io::checksum_of_file;
use willis::internals::output::names::FAILURE;
use willis::internals::output::{StagedFolder, read_json, write_json};

/// Why an input gave no run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// The version.
    pub willis: String,
    /// The command of the whole run.
    pub command: String,
    pub input: Input,
    /// The first sample and the first after the last, where it stands for a shard.
    pub range: Option<[u64; 2]>,
    /// The one line that says why.
    pub error: String,
}

/// The file that was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Input {
    pub path: String,
    /// None where it cannot be read.
    pub sha256: Option<String>,
}

impl Failure {
    /// Of an input and its run, or a range of its samples.
    pub fn of(input: &Path, command: String, range: Option<[u64; 2]>, error: &Error) -> Self {
        let input = Input { path: input.display().to_string(), sha256: checksum_of_file(input).ok() };
        Self { willis: env!("CARGO_PKG_VERSION").to_owned(), command, input, range, error: error.to_string() }
    }

    /// Whether an error is one of the input, which comes again, and not of the machine.
    pub fn is_of_input(error: &Error) -> bool {
        error.is_usage() || matches!(error, Error::Breakdown)
    }

    /// Whether a folder holds one.
    pub fn stands_in(folder: &Path) -> bool {
        folder.join(FAILURE).is_file()
    }

    /// The failure in a folder.
    ///
    /// # Errors
    ///
    /// A file that is none.
    pub fn read(folder: &Path) -> Result<Self> {
        read_json(&folder.join(FAILURE), "expected it as willis infer --record-failure wrote it")
    }

    /// Writes its folder.
    pub fn write(&self, output: &Path, force: bool) -> Result<()> {
        let folder = StagedFolder::new(output, force)?;
        write_json(&folder.path().join(FAILURE), self)?;
        folder.commit()
    }
}
