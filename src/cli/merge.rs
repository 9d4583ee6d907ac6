//! `willis merge`: runs that were made separately become a cohort.

use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::internals::formats::is_there;
use crate::internals::output::StagedFolder;
use crate::internals::output::names::RECORD;
use clap::Args;
use serde_json::Value;

use super::cohort::{Cohort, Failure, gather};
use super::print::TextTerminal;
use super::subjects::{named, paths};

/// Make a cohort of runs of many subjects that were made separately
///
/// Runs are the folders of willis infer: they make cohort.csv and cohort.html, with the rows that willis infer writes for all inputs
/// in one command, and links to the reports where they are. They must have the same options and seed. A folder that
/// willis infer --record-failure wrote is a row that failed. The inputs need not be there.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  willis merge 'runs/*' -o merged")]
pub struct MergeArgs {
    /// The folders of the runs; a pattern in quotes ('runs/*') is all that fit it
    #[arg(value_name = "FOLDER", required = true, value_hint = clap::ValueHint::DirPath)]
    folders: Vec<PathBuf>,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Print the row of each subject on standard output too, in JSON
    #[arg(long)]
    json: bool,
}

impl MergeArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        StagedFolder::check(&self.output, force)?;
        let is_run = |path: &Path| is_there(&path.join(RECORD)) || Failure::is_in(path);
        let folders = paths(&self.folders, "folder of a run", is_run)?;
        let cohort = Cohort { command: "merge", parameters: Value::Null, output: &self.output, force, json: self.json };
        gather(&folders, &cohort, named, |_| Vec::new(), terminal).map(drop)
    }
}
