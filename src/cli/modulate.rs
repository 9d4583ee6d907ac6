//! `willis modulate`: how pressures, flows and resilience respond to resistances that vary at random.

use std::path::{Path, PathBuf};

use super::args::{boundary_for, for_option, unfed, viscosity, whole, words};
use super::print::{TextTerminal, brief, plural};
use super::{
    args::reading::InputArgs, checkpoint::Follower, command_line::command_line, shell::print_json, signals::is_stopped,
    subjects::check_output,
};
use crate::{
    BoundaryOptions, Error, ModulationOptions, ModulationRun, Network, Result, SaveOptions, Unfed, internals::modulation::Class,
    internals::modulation::Reading, internals::network::units::pascals_per_square_metre, internals::network::vessels_called,
    internals::output::StagedFolder, internals::pipeline::require, internals::report::figures::DEFAULT_DPI, modulate_with,
};

/// Modulate the resistances of a network at random, and see what pressures, flows, resilience and hypertension become
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis modulate circle.graphml -o modulated
  willis modulate circle.graphml -o modulated --classes 0:0.2,0.2:0.5 -n 10000 --save-samples")]
pub struct ModulateArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// The classes of u, each drawn uniformly in [LOW, HIGH)
    #[arg(long, value_name = "LOW:HIGH,...", value_delimiter = ',', default_value = "0:0.2,0.2:0.3,0.3:0.5",
        help_heading = "Modulation", value_parser = for_option("classes", parse_class), allow_hyphen_values = true)]
    classes: Vec<Class>,
    /// How many instances of each class to draw
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1000, value_parser = whole::<u64>, allow_negative_numbers = true, help_heading = "Modulation")]
    samples: u64,
    /// The seed; the same command with the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = whole::<u64>, allow_negative_numbers = true, help_heading = "Modulation")]
    seed: u64,
    /// What a modulation by u means
    #[arg(long, default_value = "increment", help_heading = "Modulation", value_parser = words::<Reading>(&[("increment", "The resistance grows: R(1 + u)"),
        ("conductance", "The conductance shrinks: R/(1 - u)"), ("literal", "The resistance shrinks: R(1 - u)"),
        ("geometry", "The radius shrinks, r(1 - u1), and the length grows, l(1 + u2); the volume follows")]))]
    reading: Reading,
    /// Modulate only these vessels, by label or edge:ROW [default: all vessels]
    #[arg(long, value_name = "VESSEL,...", value_delimiter = ',', help_heading = "Modulation")]
    vessels: Option<Vec<String>>,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP", value_parser = viscosity, help_heading = "Modulation")]
    viscosity: f64,
    /// Hypertension above this is a risk, mmHg/mm2 [default: what the topmost twentieth of the unperturbed vessels exceed]
    #[arg(long, value_name = "X", help_heading = "Answer", allow_hyphen_values = true)]
    threshold: Option<f64>,
    /// Write every instance into samples.npz too
    #[arg(long, help_heading = "Answer")]
    save_samples: bool,
    /// Resolution of the pictures
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DPI, value_parser = whole::<u32>, allow_negative_numbers = true, help_heading = "Answer")]
    dpi: u32,
    /// Print run.json on standard output too
    #[arg(long, help_heading = "Answer")]
    json: bool,
    /// Vessels that no inlet feeds
    #[arg(long, default_value = "keep", value_parser = unfed(), help_heading = "Modulation")]
    unfed: Unfed,
    #[command(flatten)]
    boundary: BoundaryOptions,
}

impl ModulateArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let path = &self.input.input;
        // Before the input is read.
        self.options().and_then(|_| self.threshold())?;
        let save = SaveOptions { dpi: self.dpi };
        save.validate()?;
        self.input.reading.refuse_candidates("modulate")?;
        check_output(&self.output, force, [&**path])?;

        let input = self.input.reading.read(path, command_line("again"), terminal)?;
        let network = &input.network;
        let (boundary, options, threshold) = self.meaning(path, network)?;
        let folder = StagedFolder::new(&self.output, force)?;

        let modulated = options.vessels.as_ref().map_or(network.vessel_count(), |v| v.iter().filter(|v| **v).count());
        let how = format!("{} each, seed {}", plural(options.samples as usize, "instance"), options.seed);
        let (count, reading) = (options.classes.len(), options.reading.name());
        let classes = if count == 1 { "1 class".to_owned() } else { format!("{count} classes") };
        terminal.say("modulating", format!("{} in {classes}, {how}, reading {reading}", plural(modulated, "vessel")));
        let total = options.samples * options.classes.len() as u64;
        let mut follower = Follower::counting(terminal, "solving", "instances", total);
        let run = modulate_with(&input, &boundary, &options, threshold, &mut follower);
        follower.finish();
        let run = run?;
        say_outcome(terminal, &run);
        run.write(&folder.path(), self.save_samples, &save).map_err(|error| terminal.stopped(error, total, total))?;
        if is_stopped() {
            return Err(Error::Stopped { done: total, total });
        }
        folder.commit()?;
        if self.json {
            print_json(&run.record())?;
        }
        terminal.say("written", self.output.display().to_string());
        Ok(())
    }

    /// The options of the library for an input and its network.
    pub(super) fn meaning(&self, input: &Path, network: &Network) -> Result<(BoundaryOptions, ModulationOptions, Option<f64>)> {
        let vessels = self.vessels.as_ref().map(|names| called(network, names)).transpose()?;
        let options = ModulationOptions { vessels, ..self.options()? };
        Ok((boundary_for(&self.boundary, input), options, self.threshold()?))
    }

    fn options(&self) -> Result<ModulationOptions> {
        let Self { samples, seed, reading, viscosity, unfed, .. } = *self;
        let classes = self.classes.clone();
        let options = ModulationOptions { classes, samples, seed, reading, vessels: None, viscosity, unfed };
        options.validate()?;
        Ok(options)
    }

    /// The threshold, Pa/m².
    fn threshold(&self) -> Result<Option<f64>> {
        let (x, accepted) = (self.threshold.unwrap_or(1.0), "expected a positive number of mmHg/mm2, from 1e-30 to 1e30");
        require((1e-30..=1e30).contains(&x), "threshold", x, accepted)?;
        Ok(self.threshold.map(pascals_per_square_metre))
    }
}

/// `LOW:HIGH`.
fn parse_class(text: &str) -> Result<Class, String> {
    let number = |text: &str| text.trim().parse().ok();
    let class = text.split_once(':').and_then(|(low, high)| Some(Class { low: number(low)?, high: number(high)? }));
    class.ok_or_else(|| "expected LOW:HIGH with 0 <= low < high < 1".into())
}

/// Per vessel whether it is called by one of the `names`.
fn called(network: &Network, names: &[String]) -> Result<Vec<bool>> {
    let mut called = vec![false; network.vessel_count()];
    for name in names {
        let rows = vessels_called(network, name).map_err(|why| Error::parameter("vessels", format!("\"{name}\""), why))?;
        for row in rows {
            called[row] = true;
        }
    }
    Ok(called)
}

/// What became of the network in each class.
fn say_outcome(terminal: TextTerminal, outcome: &ModulationRun<'_>) {
    let rest = &outcome.result.unperturbed;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let instances = outcome.result.classes.iter().map(|(_, i)| i.count()).sum::<usize>();
    let took = format!("{} in {:.2} s, {} solver", plural(instances, "instance"), outcome.seconds, outcome.result.solver);
    terminal.say("solved", took);
    let change = |values: &[f64], rest: &[f64]| {
        let ratio = mean(values) / rest[0];
        if ratio.is_finite() { brief(ratio) } else { "-".to_owned() }
    };
    for ((class, instances), hypertension) in outcome.result.classes.iter().zip(&outcome.hypertension.classes) {
        let resilience = change(&instances.network_resilience, &rest.network_resilience);
        let inflow = change(&instances.inflow, &rest.inflow);
        let risk = format!("{} % of vessels above the threshold of hypertension", brief(100.0 * hypertension.above));
        terminal.say(&class.to_string(), format!("resilience x {resilience}, inflow x {inflow}, {risk}"));
    }
}
