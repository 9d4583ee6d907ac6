//! The pulse of a simulation: its options, the waveforms that inlets get, and the pulse of both states of the network.

use std::path::Path;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::options::{FlowOptions, SourceFile};
use super::progress::{Follow, Step};
use willis_core::error::{Error, Result};
use willis_core::flow::state::{BLOOD_DENSITY, State};
use willis_core::flow::{Boundary, Tube, WallLaw};
use willis_core::network::units::{ml_per_min, mmhg};
use willis_core::network::waveform::{Quantity, Waveform};
use willis_core::network::{Condition, Network, Role, Windkessel, locate};
use willis_core::simulation::pulse::fourier::{beyond, coefficients};
use willis_core::simulation::pulse::typical::{self, Typical};
use willis_core::simulation::pulse::womersley::Fluid;
use willis_core::simulation::pulse::{Drive, Friction, Pulse, Pulses, Setting, terminals, walled};
use willis_core::simulation::{Perturbation, Simulation, perturbed};
use willis_io::formats::read_waveform;
use willis_report::end_name;

/// How the flow pulsates. The default is what `willis simulate --pulse` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PulseOptions {
    /// What drives the inlets: a table of one period for all of them (`FILE`) or for one (`NODE=FILE`), or in the place of a file
    /// `carotid`, `vertebral` or `typical`, shapes of the flow whose mean is the steady flow there. Without any: `typical`.
    pub waveforms: Vec<String>,
    /// The period T, s, positive; by default what the tables mean.
    #[serde(rename = "period_s")]
    pub period: Option<f64>,
    /// The mean of every waveform that is a table: a pressure is shifted to it, a flow scaled to it.
    pub mean: Option<PulseMean>,
    /// How many harmonics are solved, 1 to 1000.
    pub harmonics: usize,
    /// The law of the walls; by default what the vessels state, or Olufsen's law where none does.
    pub wall: Option<WallLaw>,
    /// φ of a Kelvin-Voigt wall, s; 0 of an elastic one.
    #[serde(rename = "wall_viscosity_s")]
    pub wall_viscosity: f64,
    /// RC of outlets with a terminal resistance that state no compliance, s, positive; `None` leaves them resistances.
    #[serde(rename = "time_constant_s")]
    pub time_constant: Option<f64>,
    /// The profile by which the flow meets friction.
    pub friction: Friction,
    /// Density of blood ρ, kg/m³, positive.
    #[serde(rename = "density_kg_per_m3")]
    pub density: f64,
    /// At how many even times of the period waveforms are written, 10 to 10000.
    pub times: usize,
}

/// What the mean of a waveform becomes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum PulseMean {
    /// Pa.
    #[serde(rename = "pressure_Pa")]
    Pressure(f64),
    /// m³/s.
    #[serde(rename = "flow_m3_per_s")]
    Flow(f64),
}

impl Default for PulseOptions {
    fn default() -> Self {
        Self {
            waveforms: Vec::new(),
            period: None,
            mean: None,
            harmonics: 40,
            wall: None,
            wall_viscosity: 0.0,
            time_constant: Some(Windkessel::TIME_CONSTANT),
            friction: Friction::default(),
            density: BLOOD_DENSITY,
            times: 100,
        }
    }
}

impl PulseOptions {
    /// Checks every field that can be checked without an input.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let positive = |name: &'static str, value: Option<f64>, unit: &str| match value {
            Some(x) if !(x.is_finite() && x > 0.0) => {
                Err(Error::parameter(name, x, format!("expected a positive number of {unit}")))
            }
            _ => Ok(()),
        };
        positive("period", self.period, "s")?;
        positive("windkessel", self.time_constant, "s")?;
        positive("density", Some(self.density), "kg/m3")?;
        if !(self.wall_viscosity.is_finite() && self.wall_viscosity >= 0.0) {
            return Err(Error::parameter("wall_viscosity", self.wall_viscosity, "expected zero or a positive number of s"));
        }
        if !(1..=1000).contains(&self.harmonics) {
            return Err(Error::parameter("harmonics", self.harmonics, "expected a number from 1 to 1000"));
        }
        if !(10..=10_000).contains(&self.times) {
            return Err(Error::parameter("times", self.times, "expected a number from 10 to 10000"));
        }
        Ok(())
    }
}

/// What one inlet is driven by.
#[derive(Debug, Clone)]
enum Source {
    Table { waveform: Waveform, file: SourceFile },
    Shape(Typical),
}

/// The waveforms of the inlets, which change the steady conditions too.
#[derive(Debug)]
pub struct Waves {
    sources: Vec<(usize, Source)>,
    period: f64,
    coefficients: Vec<Vec<Complex64>>,
}

impl Waves {
    /// Reads the waveforms and finds their inlets.
    pub fn load(network: &Network, boundary: &Boundary, options: &PulseOptions, progress: &mut dyn Follow) -> Result<Self> {
        let inlets: Vec<usize> = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Inlet).collect();
        let usual = ["typical".to_owned()];
        let texts = if options.waveforms.is_empty() { &usual[..] } else { &options.waveforms };
        let mut by_inlet: Vec<Option<(bool, Source)>> = vec![None; network.node_count()];
        for text in texts {
            let refused = |why: String| Error::parameter("pulse", format!("\"{text}\""), why);
            let whole = is_word(text) || Path::new(text).is_file();
            let (nodes, name, is_own) = match text.split_once('=').filter(|_| !whole) {
                None => (inlets.clone(), text.as_str(), false),
                Some((name, file)) => {
                    let found = locate(network, name).map_err(refused)?;
                    if !inlets.contains(&found.node) {
                        return Err(refused(format!("{name} is no inlet; expected one, or `inlet={name}` beside it")));
                    }
                    (vec![found.node], file, true)
                }
            };
            let table = if is_word(name) { None } else { Some(table(name, progress)?) };
            for node in nodes {
                let source = match &table {
                    Some((waveform, file)) => Source::Table { waveform: waveform.clone(), file: file.clone() },
                    None => Source::Shape(shape(name, &end_name(network, node))),
                };
                match &by_inlet[node] {
                    Some((true, _)) if !is_own => {}
                    Some((own, _)) if *own == is_own => {
                        let which = end_name(network, node);
                        return Err(refused(format!(
                            "is the second waveform of inlet {which}; expected a pressure or a flow, once"
                        )));
                    }
                    _ => by_inlet[node] = Some((is_own, source)),
                }
            }
        }
        let sources: Vec<(usize, Source)> = by_inlet.into_iter().enumerate().filter_map(|(node, s)| Some((node, s?.1))).collect();
        if sources.is_empty() {
            return Err(Error::parameter("pulse", "has no inlet", "expected one that a waveform can drive"));
        }
        let period = period(&sources, options)?;
        let mut all = Vec::new();
        for (_, source) in &sources {
            all.push(source.coefficients(period, options)?);
            if let (Source::Table { waveform, file }, Some(c)) = (source, all.last()) {
                let left = beyond(waveform, period, c);
                if left > LEFT_OUT {
                    let percent = 100.0 * left;
                    let note = format!(
                        "{}: {percent:.2} % of its variance lies above {} harmonics",
                        file.path.display(),
                        options.harmonics
                    );
                    progress.step(Step::Note(&note));
                }
            }
        }
        Ok(Self { sources, period, coefficients: all })
    }

    /// The steady conditions: the mean of a table in the place of what was stated at its inlet.
    pub fn steady(&self, boundary: &Boundary) -> Result<Boundary> {
        let mut steady = boundary.clone();
        for ((node, source), c) in self.sources.iter().zip(&self.coefficients) {
            let Some(quantity) = source.prescribes_the_mean() else { continue };
            let condition = match quantity {
                Quantity::Pressure => Condition::Pressure(c[0].re),
                Quantity::Flow => Condition::Flow(c[0].re),
            };
            if let Some((_, stated)) = steady.conditions.iter_mut().find(|(stated, _)| stated == node) {
                *stated = condition;
            }
        }
        if steady.conditions.iter().all(|(_, c)| matches!(c, Condition::Flow(_))) {
            let accepted = "expected a pressure or a resistance at one node at least";
            return Err(Error::parameter("conditions", "are flows only", accepted));
        }
        Ok(steady)
    }

    /// What drives the inlets on top of a steady flow.
    fn drives(&self, network: &Network, state: &State) -> Vec<Drive> {
        let inflow = |node: usize| -> f64 {
            let at = network.vessels().zip(&state.vessels);
            at.map(|((ends, _), v)| {
                if ends[0] == ends[1] { 0.0 } else { f64::from(i8::from(ends[0] == node) - i8::from(ends[1] == node)) * v.flow }
            })
            .sum()
        };
        let drive = |((node, source), c): (&(usize, Source), &Vec<Complex64>)| match source {
            Source::Table { waveform, .. } => Drive { node: *node, quantity: waveform.quantity, coefficients: c.clone() },
            Source::Shape(_) => {
                let mean = inflow(*node);
                Drive { node: *node, quantity: Quantity::Flow, coefficients: c.iter().map(|c| c * mean).collect() }
            }
        };
        self.sources.iter().zip(&self.coefficients).map(drive).collect()
    }
}

/// The share of a waveform's variance above the harmonics that goes without saying.
const LEFT_OUT: f64 = 1e-3;

fn is_word(text: &str) -> bool {
    ["carotid", "vertebral", "typical"].contains(&text)
}

/// The shape that a word means at an inlet of a name.
fn shape(word: &str, inlet: &str) -> Typical {
    let of_neck = |name: &str| name.split(|c: char| !c.is_ascii_alphanumeric()).any(|part| ["VA", "BA"].contains(&part));
    match word {
        "vertebral" => Typical::Vertebral,
        "typical" if of_neck(inlet) => Typical::Vertebral,
        _ => Typical::Carotid,
    }
}

fn table(name: &str, progress: &mut dyn Follow) -> Result<(Waveform, SourceFile)> {
    let path = Path::new(name);
    let (bytes, source) = SourceFile::read(path)?;
    let (waveform, note) = read_waveform(&bytes).map_err(|fault| fault.in_file(path))?;
    if let Some(note) = note {
        progress.step(Step::Note(&format!("{}: {note}", path.display())));
    }
    Ok((waveform, source))
}

/// The one period of all waveforms, s.
fn period(sources: &[(usize, Source)], options: &PulseOptions) -> Result<f64> {
    let tables = || {
        sources.iter().filter_map(|(_, s)| if let Source::Table { waveform, file } = s { Some((waveform, file)) } else { None })
    };
    let first = tables().next().map(|(waveform, file)| (waveform.own_period(), file));
    let period = options.period.or(first.map(|(period, _)| period)).unwrap_or(typical::PERIOD);
    for (waveform, file) in tables() {
        let own = waveform.own_period();
        if let (None, Some((_, other))) = (options.period, first)
            && (own - period).abs() > 1e-6 * period
        {
            let found = format!("has a period of {own} s, {} one of {period} s", other.path.display());
            return Err(Error::parameter("pulse", file.path.display(), format!("{found}; expected one period, or `period`")));
        }
        let wrong = |(found, accepted)| willis_core::error::Fault::file(found, accepted).in_file(&file.path);
        waveform.check(period).map_err(wrong)?;
    }
    Ok(period)
}

impl Source {
    /// What its mean prescribes; nothing where only the shape is known.
    fn prescribes_the_mean(&self) -> Option<Quantity> {
        match self {
            Self::Table { waveform, .. } => Some(waveform.quantity),
            Self::Shape(_) => None,
        }
    }

    fn coefficients(&self, period: f64, options: &PulseOptions) -> Result<Vec<Complex64>> {
        let Self::Table { waveform, file } = self else {
            let Self::Shape(typical) = self else { return Ok(Vec::new()) };
            return Ok(typical.shape(options.harmonics));
        };
        let mut c = coefficients(waveform, period, options.harmonics);
        let refused = |what: &str, value: f64| {
            let found = format!("{value} for {}", file.path.display());
            Err(Error::parameter("pulse_mean", found, format!("expected {what}")))
        };
        match (options.mean, waveform.quantity) {
            (None, _) => {}
            (Some(PulseMean::Pressure(mean)), Quantity::Pressure) => c[0] = Complex64::new(mean, 0.0),
            (Some(PulseMean::Flow(mean)), Quantity::Flow) if c[0].re != 0.0 => {
                let factor = mean / c[0].re;
                for c in &mut c {
                    *c *= factor;
                }
            }
            (Some(PulseMean::Flow(mean)), Quantity::Flow) => {
                return refused("a flow whose own mean is not zero, which cannot be scaled", ml_per_min(mean));
            }
            (Some(PulseMean::Pressure(mean)), Quantity::Flow) => return refused("a flow, as the waveform is one", mmhg(mean)),
            (Some(PulseMean::Flow(mean)), Quantity::Pressure) => {
                return refused("a pressure, as the waveform is one", ml_per_min(mean));
            }
        }
        Ok(c)
    }
}

impl Waves {
    /// Solves the pulse on both states of a simulation.
    ///
    /// # Errors
    ///
    /// A wall that is not positive or not stated; a network with too many loops.
    pub fn solve(
        &self,
        network: &Network,
        boundary: &Boundary,
        (options, flow): (&PulseOptions, &FlowOptions),
        perturbations: &[Perturbation],
        simulation: &Simulation,
    ) -> Result<(Pulses, Value)> {
        let viscosity = flow.viscosity;
        let fluid =
            Fluid { viscosity, density: options.density, friction: options.friction, wall_viscosity: options.wall_viscosity };
        let usual = if network.vessels().any(|(_, v)| v.wall.is_some()) { WallLaw::Stated } else { WallLaw::OLUFSEN };
        let law = options.wall.unwrap_or(usual);
        let windkessels = flow.boundary.windkessels(network)?;
        let at_rest = Tube::at_rest(network, viscosity);
        let vessels = walled(network, &at_rest, &[], &law, &fluid)?;
        let terminals = terminals(network, boundary, &windkessels, &vessels, &fluid, options.time_constant);
        let solve = |state: &State, vessels: &[_]| {
            let drives = self.drives(network, state);
            let setting = Setting {
                fluid: &fluid,
                period: self.period,
                harmonics: options.harmonics,
                vessels,
                drives: &drives,
                terminals: &terminals,
            };
            Pulse::of(network, boundary, state, &setting)
        };
        let perturbed = match &simulation.perturbed {
            None => None,
            Some(state) => {
                let tubes = perturbed(network, &at_rest, perturbations)?;
                Some(solve(state, &walled(network, &tubes, perturbations, &law, &fluid)?)?)
            }
        };
        let inlets = self.sources.iter().map(|(node, source)| {
            let mut value = json!({ "node": node, "id": network.node(*node).id });
            match source {
                Source::Table { waveform, file } => {
                    value["quantity"] = json!(if waveform.quantity == Quantity::Pressure { "pressure" } else { "flow" });
                    value["file"] = json!(file);
                }
                Source::Shape(typical) => {
                    value["quantity"] = json!("flow");
                    value["shape"] = json!(if *typical == Typical::Carotid { "carotid" } else { "vertebral" });
                }
            }
            value
        });
        let record = json!({
            "period_s": self.period,
            "harmonics": options.harmonics,
            "wall": law,
            "wall_viscosity_s": options.wall_viscosity,
            "friction": options.friction,
            "density_kg_per_m3": options.density,
            "outlet_time_constant_s": options.time_constant,
            "inlets": inlets.collect::<Vec<_>>(),
        });
        let unperturbed = solve(&simulation.unperturbed, &vessels)?;
        let first = self.drives(network, &simulation.unperturbed).swap_remove(0);
        Ok((Pulses { unperturbed, perturbed, fluid, first, times: options.times }, record))
    }
}
