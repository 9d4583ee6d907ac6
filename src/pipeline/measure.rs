//! What is measured of an input: its vessels, bifurcations, ends, and the whole, with the doubt about its topology where there is a run.

use serde::{Deserialize, Serialize};

use super::{BoundaryOptions, Follow, Input};
use willis_core::decision::{KnownEnds, Topologies, TopologySource, has_evidence};
use willis_core::error::{Error, Result};
use willis_core::flow::boundary_conditions::stated;
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::morphometry::{Morphometry, NetworkFigures, SMOOTHING, Smoothing, network_figures};
use willis_core::network::units::millimetres;
use willis_core::network::{Network, Role};
use willis_core::sampling::SamplingOptions;
use willis_io::formats::Column;
use willis_models::circle_of_willis::present_vessels;
use willis_report::MeasuredSubject;
use willis_report::cohort::Figures;

/// So many topologies of a run are drawn.
const DRAWN: u64 = 200;

/// How vessels are measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeasureOptions {
    /// Where blood enters, from which orders and ways are counted.
    pub boundary: BoundaryOptions,
    /// The length over which courses are smoothed before bends are measured, m; six radii of each vessel without it.
    pub smoothing: Option<f64>,
}

impl MeasureOptions {
    /// Checks the length.
    ///
    /// # Errors
    ///
    /// A length that is not positive.
    pub fn validate(&self) -> Result<()> {
        match self.smoothing {
            Some(length) if !(length.is_finite() && length > 0.0) => {
                Err(Error::parameter("smoothing", millimetres(length), "expected a positive length, in mm"))
            }
            _ => Ok(()),
        }
    }

    fn smoothing(&self) -> Smoothing {
        self.smoothing.map_or(Smoothing::Radii(SMOOTHING), Smoothing::Length)
    }
}

/// What was measured of an input.
#[derive(Debug)]
pub struct Measurement {
    name: String,
    /// The SHA-256 of the file that was read.
    pub sha256: String,
    network: Network,
    roles: Vec<Role>,
    /// Vessel by vessel, and the whole.
    pub measured: Morphometry,
    /// The whole of each plausible topology of a run, with its weight.
    plausible: Vec<(NetworkFigures, f64)>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Measures the vessels of an input, as subject `name`; beside the plausible topology of a run also those that `run`, the same run as
/// [`read_run`](crate::read_run) has it, finds plausible.
///
/// # Errors
///
/// An option out of its range, a condition at a node that is not there.
pub fn measure(
    name: &str,
    input: &Input,
    run: Option<&Input>,
    options: &MeasureOptions,
    progress: &mut dyn Follow,
) -> Result<Measurement> {
    options.validate()?;
    let (present, note) = present_vessels(&input.network);
    let mut notes: Vec<String> = note.map(str::to_owned).into_iter().collect();
    let network = input.network.subgraph(|row| present[row]).0;
    let outlets = options.boundary.found_outlets.unwrap_or_else(|| input.usual_outlets());
    let roles = match options.boundary.resolve(&network, outlets, &input.inlets_by_labels(), progress) {
        Ok(boundary) => boundary.held(&network, |_| true).roles,
        // A ring has no end to enter by: it has no orders, but a length.
        Err(why) if !options.boundary.states_an_inlet() => {
            notes.push(format!("no orders and no ways from inlets: {why}"));
            vec![Role::Inner; network.node_count()]
        }
        Err(why) => return Err(why),
    };
    if !network.has_positions() {
        notes.push("nodes without positions: no chords, bends, angles and boxes".to_owned());
    }
    let measured = Morphometry::of(&network, |node| roles[node], options.smoothing());
    let plausible = run.map(plausible_figures).transpose()?.unwrap_or_default();
    Ok(Measurement { name: name.to_owned(), sha256: input.provenance.sha256.clone(), network, roles, measured, plausible, notes })
}

/// The figures of the plausible topologies of a run, with their weights; none where it has no evidence, by which they are drawn.
fn plausible_figures(run: &Input) -> Result<Vec<(NetworkFigures, f64)>> {
    let (network, Some(stored)) = (&run.network, &run.run) else { return Ok(Vec::new()) };
    if !has_evidence(network) {
        return Ok(Vec::new());
    }
    let options = SamplingOptions { samples: DRAWN, ..stored.options.infer.sampling.clone() };
    let boundary = Boundary::resolve(network, &stated(network), FoundOutlets::Ground)?;
    let mut known = vec![false; network.node_count()];
    for node in stored.given.iter().filter(|node| **node < network.node_count()) {
        known[*node] = true;
    }
    let source = TopologySource::FreeEnds(KnownEnds { ends: &known, inlets: &[] });
    let drawn = Topologies::draw(network, &boundary, &options, source)?;
    let figures = |(kept, weight): (Vec<bool>, f64)| {
        let roles = boundary.held(network, |row| kept[row]).roles;
        (network_figures(&network.subgraph(|row| kept[row]).0, |node| roles[node]), weight)
    };
    Ok(drawn.weighted.into_iter().map(figures).collect())
}

impl Measurement {
    fn subject(&self) -> MeasuredSubject<'_> {
        MeasuredSubject { name: &self.name, network: &self.network, measured: &self.measured }
    }

    /// The columns of vessels.csv, bifurcations.csv, ends.csv and intervals.csv; the last has no row without a run.
    pub fn tables(&self) -> [Vec<Column>; 4] {
        let subject = self.subject();
        let ends = subject.ends(|node| self.roles[node]);
        [subject.vessels(), subject.bifurcations(), ends, subject.intervals(&self.plausible)]
    }

    /// The figures of its row in subjects.csv.
    pub fn figures(&self) -> Figures {
        self.subject().figures()
    }
}
