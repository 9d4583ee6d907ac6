//! `willis simulate`: the flow in a network as it is, and beside it with vessels narrowed, occluded or lengthened.

use std::{path::Path, path::PathBuf, time::Instant};

use super::args::{boundary_for, for_option, unfed, viscosity, whole};
use super::{
    args::pulse::PulseArgs, args::reading::InputArgs, checkpoint::Follower, command_line::command_line, print::TextTerminal,
    print::flow::say_simulated, shell::print_json, subjects::check_output,
};
use crate::internals::network::quantity::Dimension;
use crate::internals::report::figures::DEFAULT_DPI;
use crate::{
    BoundaryOptions, Change, FlowOptions, Result, SaveOptions, Stenosis, StretchPlace, Unfed, error::ensure, simulate_with,
};

const SEVERITY: &str =
    "expected VESSEL=70% (of the diameter), VESSEL=area:70%, or either with @mid:10mm, @start:10mm or @end:10mm";

/// Simulate the flow in a network, with stenoses, occlusions and tortuosity beside it
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis simulate circle.graphml -o flow
  willis simulate circle.graphml -o stenosis --stenosis \"L-ICA I=70%\" --occlude L-PComm")]
pub struct SimulateArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP", value_parser = viscosity, hide_short_help = true)]
    viscosity: f64,
    /// Resolution of the picture
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DPI, value_parser = whole::<u32>, allow_negative_numbers = true,
        help_heading = "Answer", hide_short_help = true)]
    dpi: u32,
    /// Print run.json on standard output too
    #[arg(long, help_heading = "Answer", hide_short_help = true)]
    json: bool,
    /// Vessels that no inlet feeds
    #[arg(long, default_value = "keep", value_parser = unfed())]
    unfed: Unfed,
    /// Follow the blood: territories.csv, who feeds what; transit.csv, when it arrives
    #[arg(long)]
    transport: bool,
    /// Close each vessel in turn: occlusions.csv, what its loss means
    #[arg(long)]
    occlude_each: bool,
    #[command(flatten)]
    pulse: PulseArgs,
    #[command(flatten)]
    changes: ChangeArgs,
    #[command(flatten)]
    boundary: BoundaryOptions,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Perturbations (VESSEL is a label, or edge:ROW; several with commas)")]
struct ChangeArgs {
    /// Narrow a vessel by a share of its diameter, or of its area; @ narrows a stretch of it only
    #[arg(long, value_name = "VESSEL=[area:]PERCENT%[@mid:LENGTH]", value_delimiter = ',', value_parser = for_option("stenosis", parse_stenosis), allow_hyphen_values = true)]
    stenosis: Vec<(String, Change)>,
    /// Close a vessel
    #[arg(long, value_name = "VESSEL", value_delimiter = ',', allow_hyphen_values = true)]
    occlude: Vec<String>,
    /// Lengthen a vessel by a factor of at least 1
    #[arg(long, value_name = "VESSEL=FACTOR", value_delimiter = ',', value_parser = for_option("tortuosity", parse_tortuosity), allow_hyphen_values = true)]
    tortuosity: Vec<(String, Change)>,
}

impl SimulateArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let start = Instant::now();
        let path = &self.input.input;
        let (options, changes) = self.meaning(path)?;
        let changes: Vec<(&str, Change)> = changes.iter().map(|(name, change)| (name.as_str(), *change)).collect();
        let save = SaveOptions { dpi: self.dpi };
        save.validate()?;
        self.input.reading.refuse_candidates("simulate")?;
        check_output(&self.output, force, [&**path])?;

        let input = self.input.reading.read(path, command_line("again"), terminal)?;
        let run = simulate_with(&input, &changes, &options, &mut Follower::new(terminal))?;
        say_simulated(terminal, &run);
        terminal.notes(&run.save(&self.output, force, &save)?);
        if self.json {
            print_json(&run.record())?;
        }
        terminal.say("written", format!("{} in {:.1} s", self.output.display(), start.elapsed().as_secs_f64()));
        Ok(())
    }

    /// The options of the library for an input, and what is to be done to which vessels.
    pub(super) fn meaning(&self, input: &Path) -> Result<(FlowOptions, Vec<(String, Change)>)> {
        let ChangeArgs { stenosis, occlude, tortuosity } = &self.changes;
        let occlusions = occlude.iter().map(|name| (name.clone(), Change::Occlusion));
        let changes = stenosis.iter().cloned().chain(occlusions).chain(tortuosity.iter().cloned()).collect();
        let (boundary, pulse) = (boundary_for(&self.boundary, input), self.pulse.options()?);
        let Self { viscosity, transport, occlude_each, unfed, .. } = *self;
        Ok((FlowOptions { boundary, viscosity, transport, occlude_each, pulse, unfed }, changes))
    }
}

/// `VESSEL=[area:]PERCENT%[@mid:LENGTH]`.
fn parse_stenosis(text: &str) -> Result<(String, Change), String> {
    let (name, value) = text.rsplit_once('=').ok_or(SEVERITY)?;
    let (severity, place) = value.split_once('@').map_or((value, None), |(severity, place)| (severity, Some(place)));
    let stretch = place.map(stretch).transpose()?;
    let (of_area, percent) = severity.trim().strip_prefix("area:").map_or((false, severity.trim()), |rest| (true, rest));
    let percent: f64 = percent.strip_suffix('%').and_then(|digits| digits.trim().parse().ok()).ok_or(SEVERITY)?;
    ensure(percent >= 0.0, || "expected a reduction from 0% to below 100%")?;
    ensure(percent < 100.0, || "leaves nothing open; expected a reduction below 100%, or `occlude` to close the vessel")?;
    let reduction = percent / 100.0;
    let narrowed = if of_area { Stenosis::of_area(reduction) } else { Stenosis::of_diameter(reduction) };
    let over = |(place, length)| Stenosis { stretch: Some(length), place, ..narrowed };
    Ok((name.to_owned(), Change::Stenosis(stretch.map_or(narrowed, over))))
}

/// The place and the length (m) in `mid:10mm`, `start:10mm` or `end:10mm`: only a pulse notices where the stretch lies.
fn stretch(place: &str) -> Result<(StretchPlace, f64), String> {
    let words = [("mid:", StretchPlace::Middle), ("start:", StretchPlace::Start), ("end:", StretchPlace::End)];
    let found = words.iter().find_map(|(word, at)| Some((*at, place.trim().strip_prefix(word)?)));
    let (at, length) = found.ok_or(SEVERITY)?;
    let length = Dimension::Length.parse(length)?;
    let accepted = "expected a positive length of the narrowed stretch, such as @mid:10mm";
    if length > 0.0 { Ok((at, length)) } else { Err(accepted.into()) }
}

/// `VESSEL=FACTOR`.
fn parse_tortuosity(text: &str) -> Result<(String, Change), String> {
    const ACCEPTED: &str = "expected VESSEL=FACTOR with a factor of length of at least 1, such as 1.3";
    let (name, factor) = text.rsplit_once('=').ok_or(ACCEPTED)?;
    let factor: f64 = factor.trim().parse().map_err(|_| ACCEPTED)?;
    let is_longer = factor.is_finite() && factor >= 1.0;
    if is_longer { Ok((name.to_owned(), Change::Tortuosity(factor))) } else { Err(ACCEPTED.into()) }
}
