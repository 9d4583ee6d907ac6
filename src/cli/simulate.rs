//! `willis simulate`: the flow in a network as it is, and beside it with vessels narrowed, occluded or lengthened.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use willis::error::Result;
use willis::internals::output::StagedFolder;
use willis::internals::report::figures::{DEFAULT_DPI, check_dpi};
use willis::internals::report::{FlowRecord, Simulated, write_simulated};
use willis::internals::simulation::simulate;

use super::boundary::{BoundaryArgs, say_boundary};
use super::perturbation::PerturbationArgs;
use super::reading::InputArgs;
use super::shell::print_json;
use super::tell_flow::say_simulated;
use super::terminal::Terminal;
use super::typed::{viscosity, whole};

/// Simulate the flow in a network, with stenoses, occlusions and tortuosity beside it
#[derive(Debug, Args)]
pub struct SimulateArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP")]
    viscosity: String,
    /// Resolution of the picture
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DPI, value_parser = whole::<u32>, allow_negative_numbers = true, help_heading = "Answer")]
    dpi: u32,
    /// Print run.json on standard output too
    #[arg(long, help_heading = "Answer")]
    json: bool,
    #[command(flatten)]
    perturbation: PerturbationArgs,
    #[command(flatten)]
    boundary: BoundaryArgs,
}

impl SimulateArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let start = Instant::now();
        let viscosity = viscosity(&self.viscosity)?;
        let outlets = self.boundary.found_outlets(false)?;
        self.perturbation.check()?;
        check_dpi(self.dpi)?;
        self.input.refuse_candidates("simulate")?;
        StagedFolder::check(&self.output, force)?;

        let loaded = self.input.load(terminal)?;
        let network = &loaded.network;
        let perturbations = self.perturbation.resolve(network)?;
        let boundary = self.boundary.resolve(&self.input.input, network, outlets, terminal)?;
        say_boundary(terminal, network, &boundary);
        let result = simulate(network, &boundary, viscosity, &perturbations)?;
        let simulated = Simulated { network, boundary: &boundary, perturbations: &perturbations, result: &result, viscosity };
        let record = FlowRecord::new(&simulated, &loaded.provenance, loaded.radius_rule, outlets);
        say_simulated(terminal, &simulated);

        let folder = StagedFolder::new(&self.output, force)?;
        for note in write_simulated(&folder.path(), &simulated, &record, self.dpi)? {
            terminal.say("note", note);
        }
        folder.commit()?;
        if self.json {
            print_json(&record)?;
        }
        terminal.say("written", format!("{} in {:.1} s", self.output.display(), start.elapsed().as_secs_f64()));
        Ok(())
    }
}
