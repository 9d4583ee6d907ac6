//! The pulse of a simulation: the waveforms that inlets get, and the pulse of both states of the network.

use std::{collections::BTreeMap, path::Path};

use num_complex::Complex64;
use serde_json::{Value, json};

use super::{FlowOptions, Follow, PulseMean, PulseOptions, SourceFile, Step, require};
use crate::{Error, Network, Result, WallLaw};
use willis_core::flow::{Boundary, Tube};
use willis_core::network::units::{ml_per_min, mmhg};
use willis_core::network::waveform::{Quantity, Waveform};
use willis_core::network::{Condition, Role, locate};
use willis_core::simulation::pulse::fourier::{Indices, beyond, coefficients, samples};
use willis_core::simulation::pulse::{Drive, Pulse, Pulses, Setting, terminals, typical, walled};
use willis_core::simulation::{BothStates, Perturbation, Simulation, perturbed};
use willis_core::{error::ensure, flow::state::State, simulation::pulse::typical::Typical, simulation::pulse::womersley::Fluid};
use willis_report::end_name;

/// What one inlet is driven by.
#[derive(Debug, Clone)]
enum WaveSource {
    Table { waveform: Waveform, file: SourceFile },
    Shape(Typical),
}

/// The waveforms of the inlets, which change the steady conditions too.
#[derive(Debug)]
pub struct Waves {
    sources: Vec<(usize, WaveSource)>,
    pub(super) period: f64,
    coefficients: Vec<Vec<Complex64>>,
}

impl Waves {
    /// Reads the waveforms and finds their inlets.
    pub fn load(network: &Network, boundary: &Boundary, options: &PulseOptions, progress: &mut dyn Follow) -> Result<Self> {
        let inlets: Vec<usize> = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Inlet).collect();
        let usual = ["typical".to_owned()];
        let texts = if options.waveforms.is_empty() { &usual[..] } else { &options.waveforms };
        let mut by_inlet: Vec<Option<(bool, WaveSource)>> = vec![None; network.node_count()];
        for text in texts {
            let refused = |why: String| Error::parameter("pulse", format!("\"{text}\""), why);
            let whole = is_word(text) || Path::new(text).is_file();
            let (nodes, name, is_own) = match text.split_once('=').filter(|_| !whole) {
                None => (inlets.clone(), text.as_str(), false),
                Some((name, file)) => {
                    let found = locate(network, name).map_err(refused)?;
                    let why = || refused(format!("{name} is no inlet; expected one, or `inlet={name}` beside it"));
                    ensure(inlets.contains(&found.node), why)?;
                    (vec![found.node], file, true)
                }
            };
            let table = if is_word(name) { None } else { Some(table(name, progress)?) };
            for node in nodes {
                let shaped = || WaveSource::Shape(shape(name, &end_name(network, node)));
                let source = table.clone().map_or_else(shaped, |(waveform, file)| WaveSource::Table { waveform, file });
                match &by_inlet[node] {
                    Some((true, _)) if !is_own => {}
                    Some((own, _)) if *own == is_own => {
                        let which = format!("is the second waveform of inlet {}", end_name(network, node));
                        return Err(refused(format!("{which}; expected a pressure or a flow, once")));
                    }
                    _ => by_inlet[node] = Some((is_own, source)),
                }
            }
        }
        let sources: Vec<_> = by_inlet.into_iter().enumerate().filter_map(|(node, s)| Some((node, s?.1))).collect();
        require(!sources.is_empty(), "pulse", "has no inlet", "expected one that a waveform can drive")?;
        let has_mean = options.mean.is_none() || sources.iter().any(|(_, source)| source.table().is_some());
        require(has_mean, "pulse_mean", "of a shape", "goes with a table; the mean of a shape is the steady flow")?;
        let period = period(&sources, options)?;
        let mut all = Vec::new();
        for (_, source) in &sources {
            all.push(source.coefficients(period, options)?);
            if let (WaveSource::Table { waveform, file }, Some(c)) = (source, all.last()) {
                let left = beyond(waveform, period, c);
                if left > LEFT_OUT {
                    let (path, percent, harmonics) = (file.path.display(), 100.0 * left, options.harmonics);
                    let note = format!("{path}: {percent:.2} % of its variance lies above {harmonics} harmonics");
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
            // Of a shape the mean is not known.
            let Some((waveform, _)) = source.table() else { continue };
            let condition = match waveform.quantity {
                Quantity::Pressure => Condition::Pressure(c[0].re),
                Quantity::Flow => Condition::Flow(c[0].re),
            };
            if let Some((_, stated)) = steady.conditions.iter_mut().find(|(stated, _)| stated == node) {
                *stated = condition;
            }
        }
        let is_stated = !steady.conditions.iter().all(|(_, c)| matches!(c, Condition::Flow(_)));
        require(is_stated, "conditions", "are flows only", "expected a pressure or a resistance at one node at least")?;
        Ok(steady)
    }

    /// One period at each inlet that is driven, by the id of its node.
    pub(super) fn courses(&self, network: &Network, state: &State) -> BTreeMap<String, Waveform> {
        let course = |drive: Drive| {
            let mut values = samples(&drive.coefficients, COURSE_STEPS);
            values.push(values[0]);
            let times = (0..=COURSE_STEPS).map(|k| self.period * k as f64 / COURSE_STEPS as f64).collect();
            (network.node(drive.node).id.clone(), Waveform { quantity: drive.quantity, times, values })
        };
        self.drives(network, state).into_iter().map(course).collect()
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
        let drive = |((node, source), c): (&(usize, WaveSource), &Vec<Complex64>)| match source {
            WaveSource::Table { waveform, .. } => Drive { node: *node, quantity: waveform.quantity, coefficients: c.clone() },
            WaveSource::Shape(_) => {
                let mean = inflow(*node);
                Drive { node: *node, quantity: Quantity::Flow, coefficients: c.iter().map(|c| c * mean).collect() }
            }
        };
        self.sources.iter().zip(&self.coefficients).map(drive).collect()
    }

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
        let (fluid, law) = (fluid(options, viscosity), law(options, network));
        let windkessels = flow.boundary.windkessels(network)?;
        let at_rest = Tube::at_rest(network, viscosity);
        let vessels = walled(network, &at_rest, &[], &law, &fluid)?;
        let terminals = terminals(network, boundary, &windkessels, &vessels, &fluid, options.time_constant);
        let solve = |state: &State, vessels: &[_]| {
            let drives = self.drives(network, state);
            let (period, harmonics) = (self.period, options.harmonics);
            let setting = Setting { fluid: &fluid, period, harmonics, vessels, drives: &drives, terminals: &terminals };
            Pulse::of(network, boundary, state, &setting)
        };
        let after = |state: &State| {
            let tubes = perturbed(network, &at_rest, perturbations)?;
            solve(state, &walled(network, &tubes, perturbations, &law, &fluid)?)
        };
        let perturbed = simulation.perturbed.as_ref().map(after).transpose()?;
        let inlets = self.sources.iter().map(|(node, source)| {
            let mut value = json!({ "node": node, "id": network.node(*node).id });
            match source {
                WaveSource::Table { waveform, file } => {
                    value["quantity"] = json!(if waveform.quantity == Quantity::Pressure { "pressure" } else { "flow" });
                    value["file"] = json!(file);
                }
                WaveSource::Shape(typical) => {
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
        let both = BothStates { unperturbed: solve(&simulation.unperturbed, &vessels)?, perturbed };
        let first = &self.drives(network, &simulation.unperturbed)[0];
        let first_phase = Indices::of(&first.coefficients, self.period, 0.0).phase;
        Ok((Pulses { both, fluid, first_phase, times: options.times }, record))
    }
}

/// The blood of a pulse, of a viscosity in Pa s.
pub(super) fn fluid(options: &PulseOptions, viscosity: f64) -> Fluid {
    Fluid { viscosity, density: options.density, friction: options.friction, wall_viscosity: options.wall_viscosity }
}

/// The law of the walls of a network in a pulse.
pub(super) fn law(options: &PulseOptions, network: &Network) -> WallLaw {
    let usual = if network.vessels().any(|(_, v)| v.wall.is_some()) { WallLaw::Stated } else { WallLaw::OLUFSEN };
    options.wall.unwrap_or(usual)
}

/// The share of a waveform's variance above the harmonics that goes without saying.
const LEFT_OUT: f64 = 1e-3;
/// So many even steps of a period are written for solvers in time.
const COURSE_STEPS: usize = 1000;

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
    let (waveform, note) = willis_io::formats::read_waveform(&bytes).map_err(|fault| fault.in_file(path))?;
    if let Some(note) = note {
        progress.step(Step::Note(&format!("{}: {note}", path.display())));
    }
    Ok((waveform, source))
}

/// The one period of all waveforms, s.
fn period(sources: &[(usize, WaveSource)], options: &PulseOptions) -> Result<f64> {
    let tables = || sources.iter().filter_map(|(_, source)| source.table());
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

impl WaveSource {
    /// Its table and the file of that, where it is one.
    fn table(&self) -> Option<(&Waveform, &SourceFile)> {
        if let Self::Table { waveform, file } = self { Some((waveform, file)) } else { None }
    }

    fn coefficients(&self, period: f64, options: &PulseOptions) -> Result<Vec<Complex64>> {
        let (waveform, file) = match self {
            Self::Shape(typical) => return Ok(typical.shape(options.harmonics)),
            Self::Table { waveform, file } => (waveform, file),
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
