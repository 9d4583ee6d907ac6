//! `willis convert`: a network from one format into another.

use std::path::{Path, PathBuf};

use super::args::{boundary_for, unfed, viscosity};
use super::print::{TextTerminal, plural};
use super::{
    args::pulse::PulseArgs, args::reading::InputArgs, args::reading::ReadingArgs, checkpoint::Follower,
    command_line::command_line, shell::print_json,
};
use crate::internals::formats::convert::Target;
use crate::internals::formats::{Format, FormatTrait, unread_columns};
use crate::internals::output::StagedFiles;
use crate::internals::pipeline::{require, require_in, stage_target};
use crate::{BoundaryOptions, FlowOptions, Network, Result, Unfed, WrittenFiles, read, solver_model};

/// Convert centerlines or a graph into another format, saying what is lost
#[derive(Debug, clap::Args)]
#[command(long_about = format!("Convert centerlines or a graph into another format, saying what is lost\n\n\
    The ending of OUT says the format: {}. --to says it where the ending does not.", Format::explained_endings()))]
#[command(after_help = "Examples:
  willis convert extraction.vtp extraction.swc
  willis convert circle.graphml model.json --to svzerod --pulse")]
pub struct ConvertArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The file to write
    #[arg(value_name = "OUT", value_hint = clap::ValueHint::FilePath, help_heading = None::<&str>)]
    output: PathBuf,
    /// The format to write
    #[arg(long, value_name = "FORMAT", value_parser = clap::builder::PossibleValuesParser::new(Format::words()))]
    to: Option<String>,
    /// Vessels that no inlet feeds [default: drop for svzerod and openbf, which cannot do with them, else keep]
    #[arg(long, value_parser = unfed())]
    unfed: Option<Unfed>,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    model: ModelArgs,
}

/// Conditions as simulate has them, for a model of svZeroDSolver or openBF.
#[derive(Debug, Default, clap::Args)]
struct ModelArgs {
    /// Blood viscosity in a model for svzerod or openbf [default: 3.5cP]
    #[arg(long, value_name = "VISCOSITY", value_parser = viscosity, hide_short_help = true)]
    viscosity: Option<f64>,
    #[command(flatten)]
    pulse: PulseArgs,
    #[command(flatten)]
    boundary: BoundaryOptions,
}

impl ModelArgs {
    /// The options of the simulation; none where none is given.
    fn options(&self, input: &Path) -> Result<Option<FlowOptions>> {
        let (boundary, pulse) = (boundary_for(&self.boundary, input), self.pulse.of_a_model()?);
        if pulse.is_none() && self.viscosity.is_none() && boundary == BoundaryOptions::default() {
            return Ok(None);
        }
        let usual = FlowOptions::default();
        Ok(Some(FlowOptions { boundary, pulse, viscosity: self.viscosity.unwrap_or(usual.viscosity), ..usual }))
    }
}

/// Make centerlines of a segmentation mask
///
/// The vessels of the mask are thinned to lines of the same topology, in the scanner's frame, with radii; nothing is inferred. The
/// ending of FILE says the format, as for convert.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis skeleton vessels.nii.gz -o lines.vtp
  willis skeleton probabilities.nii.gz --level 0.5 -o lines.swc")]
pub struct SkeletonArgs {
    #[arg(value_name = "INPUT", help = format!("A mask ({})", Format::short(FormatTrait::Mask)), value_hint = clap::ValueHint::FilePath)]
    input: PathBuf,
    #[command(flatten)]
    reading: ReadingArgs,
    /// The file to write
    #[arg(short, long, value_name = "FILE", value_hint = clap::ValueHint::FilePath, help_heading = "Input")]
    output: PathBuf,
    /// The format to write
    #[arg(long, value_name = "FORMAT", value_parser = clap::builder::PossibleValuesParser::new(Format::words()))]
    to: Option<String>,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
}

impl SkeletonArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let Self { input, reading, output, to, json } = self;
        let input = InputArgs { input, reading };
        ConvertArgs { input, output, to, unfed: None, json, model: ModelArgs::default() }.run("skeleton", terminal, force)
    }
}

impl ConvertArgs {
    pub fn run(self, command: &str, terminal: TextTerminal, force: bool) -> Result<()> {
        self.input.reading.refuse_candidates(command)?;
        let mut target = Target::new(&self.output, self.to.as_deref())?.with_unfed(self.unfed);
        let path = &self.input.input;
        let model = self.model.options(path)?;
        let (found, accepted) = (target.format.name(), "conditions, viscosity and pulse go with `to=svzerod` or `to=openbf`");
        require(model.is_none() || target.format.is(FormatTrait::Model), "to", format!("for {found}"), accepted)?;
        StagedFiles::check(&target.path, &target.nodes, force)?;
        // The output of convert is among its words.
        let again = if command == "skeleton" { "again" } else { "" };
        let again = Path::new(again).with_extension(target.path.extension().unwrap_or_default()).display().to_string();
        let input = read(path, &self.input.reading.options(path)?)?.with_command(command_line(&again));
        let is_meant = command != "skeleton" || input.format.is_some_and(Format::is_mask);
        let accepted = format!("expected a mask: {}; convert rewrites centerlines", Format::short(FormatTrait::Mask));
        require_in(path, is_meant, format!("a file of {}", input.provenance.format), accepted)?;
        let mut input = self.input.reading.said(input, terminal);
        if let Some(options) = &model {
            (input.network, target.setting) = solver_model(&input, options, &mut Follower::new(terminal))?;
        }
        let staged = StagedFiles::new(&target.path, force)?;
        let WrittenFiles { files, mut lost, counts: [nodes, vessels], .. } = put(staged, &input.network, &target, terminal)?;
        let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        let unread = input.format.map(|format| unread_columns(path, format, &input.options)).unwrap_or_default();
        if !unread.is_empty() {
            lost.push(format!("the columns {}", unread.join(", ")));
            terminal.say("lost", lost.last().map_or("", String::as_str));
        }
        let size = format!("{}, {}", plural(nodes, "node"), plural(vessels, "vessel"));
        terminal.say("written", format!("{}: {}: {size}", names.join(", "), target.format.name()));
        if !self.json {
            return Ok(());
        }
        print_json(&serde_json::json!({
            "willis": env!("CARGO_PKG_VERSION"),
            "command": input.provenance.command,
            "input": input.provenance.of_input(),
            "notes": input.provenance.notes,
            "output": names,
            "format": target.format.name(),
            "counts": { "nodes": nodes, "vessels": vessels },
            "lost": lost,
        }))
    }
}

/// Writes the files of a target into a set that was begun for it, says what is lost, and returns what came of it.
pub fn put(mut staged: StagedFiles, network: &Network, target: &Target, terminal: TextTerminal) -> Result<WrittenFiles> {
    let written = stage_target(network, target, &mut staged)?;
    let files = staged.commit()?;
    terminal.notes(&written.notes);
    written.lost.iter().for_each(|what| terminal.say("lost", what));
    Ok(WrittenFiles { files, ..written })
}
