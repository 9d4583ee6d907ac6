//! `willis modulate`: how pressures, flows and resilience respond to resistances that vary at random.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use willis::error::{Error, Result};
use willis::internals::modulation::{Class, HypertensionByClass, ModulationOptions, Reading, modulate};
use willis::internals::network::units::pascals_per_square_metre;
use willis::internals::network::{Network, vessels_called};
use willis::internals::output::StagedFolder;
use willis::internals::report::figures::{DEFAULT_DPI, check_dpi};
use willis::internals::report::{ModulationOutcome, write_modulation};

use super::boundary::{BoundaryArgs, say_boundary};
use super::reading::InputArgs;
use super::shell::print_json;
use super::terminal::{Terminal, brief, is_stopped, plural};
use super::typed::{viscosity, whole};

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Meaning {
    /// The resistance grows: R(1 + u)
    Increment,
    /// The conductance shrinks: R/(1 - u)
    Conductance,
    /// The resistance shrinks: R(1 - u)
    Literal,
    /// The radius shrinks, r(1 - u1), and the length grows, l(1 + u2); the volume follows
    Geometry,
}

/// Modulate the resistances of a network at random, and see what pressures, flows, resilience and hypertension become
#[derive(Debug, Args)]
pub struct ModulateArgs {
    #[command(flatten)]
    input: InputArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// The classes of u, each drawn uniformly in [LOW, HIGH)
    #[arg(
        long,
        value_name = "LOW:HIGH,...",
        value_delimiter = ',',
        default_value = "0:0.2,0.2:0.3,0.3:0.5",
        help_heading = "Modulation",
        allow_hyphen_values = true
    )]
    classes: Vec<String>,
    /// How many instances of each class to draw
    #[arg(short = 'n', long, value_name = "N", default_value_t = 1000, value_parser = whole::<u64>, allow_negative_numbers = true, help_heading = "Modulation")]
    samples: u64,
    /// The seed; the same command with the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = whole::<u64>, allow_negative_numbers = true, help_heading = "Modulation")]
    seed: u64,
    /// What a modulation by u means
    #[arg(long, value_enum, default_value = "increment", help_heading = "Modulation")]
    reading: Meaning,
    /// Modulate only these vessels, by label or edge:ROW [default: all vessels]
    #[arg(long, value_name = "VESSEL,...", value_delimiter = ',', help_heading = "Modulation")]
    vessels: Option<Vec<String>>,
    /// Blood viscosity
    #[arg(long, value_name = "VISCOSITY", default_value = "3.5cP", help_heading = "Modulation")]
    viscosity: String,
    /// Hypertension above this is a risk, mmHg/mm2 [default: the 95th percentile over the unperturbed vessels]
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
    #[command(flatten)]
    boundary: BoundaryArgs,
}

impl ModulateArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let mut params = self.params()?;
        let threshold = self.threshold()?;
        let outlets = self.boundary.found_outlets(false)?;
        check_dpi(self.dpi)?;
        self.input.refuse_candidates("modulate")?;
        StagedFolder::check(&self.output, force)?;

        let loaded = self.input.load(terminal)?;
        let network = loaded.network;
        params.vessels = self.vessels.as_ref().map(|names| called(&network, names)).transpose()?;
        let boundary = self.boundary.resolve(&self.input.input, &network, outlets, terminal)?;
        say_boundary(terminal, &network, &boundary);
        let folder = StagedFolder::new(&self.output, force)?;

        let modulated = params.vessels.as_ref().map_or(network.vessel_count(), |v| v.iter().filter(|v| **v).count());
        let how = format!("{} each, seed {}", plural(params.samples as usize, "instance"), params.seed);
        let classes = if params.classes.len() == 1 { "1 class".to_owned() } else { format!("{} classes", params.classes.len()) };
        let reading = params.reading.name();
        terminal.say("modulating", format!("{} in {classes}, {how}, reading {reading}", plural(modulated, "vessel")));
        let start = Instant::now();
        let mut progress = terminal.progress("solving", "instances", params.samples * params.classes.len() as u64);
        let result = modulate(&network, &boundary, &params, &mut progress);
        progress.finish();
        let (result, seconds) = (result?, start.elapsed().as_secs_f64());
        let hypertension = HypertensionByClass::of(&result, threshold);
        let outcome = ModulationOutcome {
            network: &network,
            boundary: &boundary,
            outlets,
            provenance: &loaded.provenance,
            params: &params,
            result: &result,
            hypertension: &hypertension,
            seconds,
        };
        say_outcome(terminal, &outcome);
        write_modulation(&folder.path(), &outcome, self.save_samples, self.dpi)?;
        if is_stopped() {
            let total = params.samples * params.classes.len() as u64;
            return Err(Error::Stopped { done: total, total });
        }
        folder.commit()?;
        if self.json {
            print_json(&outcome.record())?;
        }
        terminal.say("written", self.output.display().to_string());
        Ok(())
    }

    fn params(&self) -> Result<ModulationOptions> {
        let params = ModulationOptions {
            classes: self.classes.iter().map(|text| parse_class(text)).collect::<Result<_>>()?,
            samples: self.samples,
            seed: self.seed,
            reading: match self.reading {
                Meaning::Increment => Reading::Increment,
                Meaning::Conductance => Reading::Conductance,
                Meaning::Literal => Reading::Literal,
                Meaning::Geometry => Reading::Geometry,
            },
            vessels: None,
            viscosity: viscosity(&self.viscosity)?,
        };
        params.validate()?;
        Ok(params)
    }

    /// The threshold, Pa/m².
    fn threshold(&self) -> Result<Option<f64>> {
        match self.threshold {
            Some(x) if !(x.is_finite() && x > 0.0) => {
                Err(Error::parameter("--threshold", x, "expected a positive number of mmHg/mm2"))
            }
            given => Ok(given.map(pascals_per_square_metre)),
        }
    }
}

/// `LOW:HIGH`.
fn parse_class(text: &str) -> Result<Class> {
    let number = |text: &str| text.trim().parse().ok();
    let class = text.split_once(':').and_then(|(low, high)| Some(Class { low: number(low)?, high: number(high)? }));
    class.ok_or_else(|| Error::parameter("--classes", format!("\"{text}\""), "expected LOW:HIGH with 0 <= low < high < 1"))
}

/// Per vessel whether it is called by one of the `names`.
fn called(network: &Network, names: &[String]) -> Result<Vec<bool>> {
    let mut called = vec![false; network.vessel_count()];
    for name in names {
        let rows = vessels_called(network, name).map_err(|why| Error::parameter("--vessels", format!("\"{name}\""), why))?;
        for row in rows {
            called[row] = true;
        }
    }
    Ok(called)
}

/// What became of the network in each class.
fn say_outcome(terminal: Terminal, outcome: &ModulationOutcome<'_>) {
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
        let risk = brief(100.0 * hypertension.above);
        terminal.say(
            &class.to_string(),
            format!("resilience x {resilience}, inflow x {inflow}, {risk} % of vessels above the threshold of hypertension"),
        );
    }
}
