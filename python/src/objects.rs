//! What Python holds on to: an input, a run, a simulation, a modulation, a phenotype. Each is one call of the library.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use willis::cli::words;
use willis::internals::formats::ANSWERS;
use willis::internals::network::Edit;
use willis::internals::output::StagedFolder;
use willis::{
    BoundaryOptions, Change, ConnectionDecision, Error, GraphEdit, Inference, Input, ModulationOptions, Network, Result,
    SamplingOptions, SaveOptions, Silent, SimulationRun,
};

use crate::errors::raised;
use crate::interrupt::{Follower, Watch, computed, detached, interruptible};
use crate::tables;

type Said = Vec<(String, String)>;

/// A network that was read, or made of arrays.
#[pyclass(frozen, module = "willis._willis")]
pub struct Scan {
    pub input: Arc<Input>,
}

impl Scan {
    fn of(network: Network) -> Self {
        Self { input: Arc::new(Input::from_network(network)) }
    }

    /// The name of the file; one that was handed over has none, and is called a network.
    fn path(&self) -> &Path {
        let name = &self.input.provenance.input;
        Path::new(if name.is_empty() { "network" } else { name })
    }
}

#[pymethods]
impl Scan {
    /// The name of the file.
    #[getter]
    fn name(&self) -> &str {
        &self.input.provenance.input
    }

    #[getter]
    fn node_count(&self) -> usize {
        self.input.network.node_count()
    }

    #[getter]
    fn vessel_count(&self) -> usize {
        self.input.network.vessel_count()
    }

    /// What the command says of it: facts under headings.
    fn said(&self) -> Said {
        words::said_of_input(&self.input)
    }

    /// The columns of its nodes and of its vessels.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyDict>; 2]> {
        tables::of_network(py, &self.input.network)
    }

    /// The two nodes of each vessel (M, 2), the points of all vessels (P, 3) and their radii (P), mm, and where each vessel begins (M + 1).
    fn lines<'py>(&self, py: Python<'py>) -> PyResult<tables::Lines<'py>> {
        tables::lines(py, &self.input.network)
    }
}

/// Reads a file, or of the folder of a run its topology; `run` reads the run itself.
#[pyfunction]
#[pyo3(signature = (path, words, run=false))]
pub fn read(py: Python<'_>, path: PathBuf, words: Vec<String>, run: bool) -> PyResult<Scan> {
    let read = || {
        let options = words::reading(&path, &words)?;
        if run { willis::read_run(&path, &options) } else { willis::read(&path, &options) }
    };
    interruptible(py, &Watch::default(), None, None, None, |_| read())?.map(|input| Scan { input: Arc::new(input) })
}

/// Reads the bytes of a file that would be called `name`.
#[pyfunction]
pub fn read_bytes(py: Python<'_>, name: &str, bytes: Vec<u8>, words: Vec<String>) -> PyResult<Scan> {
    let name = Path::new(name);
    let read = || willis::read_bytes(name, &bytes, &words::reading(name, &words)?);
    interruptible(py, &Watch::default(), None, None, None, |_| read())?.map(|input| Scan { input: Arc::new(input) })
}

/// The whole anatomy of a phantom.
#[pyfunction]
pub fn phantom(py: Python<'_>, kind: String, words: Vec<String>) -> PyResult<Scan> {
    interruptible(py, &Watch::default(), None, None, None, |_| words::phantom(&kind, &words))?.map(Scan::of)
}

/// A run of infer.
#[pyclass(frozen, module = "willis._willis")]
pub struct Run {
    run: Inference,
}

/// The over-connected graph of a scan, before it is sampled, by the words of infer.
#[pyclass(frozen, module = "willis._willis")]
pub struct Prepared {
    prepared: Arc<willis::Prepared>,
    sampling: SamplingOptions,
}

/// Builds the over-connected graph of a scan, by the words of infer.
#[pyfunction]
#[pyo3(signature = (scan, words, watch, threads=None, say=None))]
pub fn prepare(
    py: Python<'_>,
    scan: &Scan,
    words: Vec<String>,
    watch: &Watch,
    threads: Option<usize>,
    say: Option<&Bound<'_, PyAny>>,
) -> PyResult<Prepared> {
    let input = &scan.input;
    interruptible(py, watch, threads, None, say, |follower| {
        let (options, line) = words::infer(scan.path(), &words)?;
        let prepared = willis::prepare(input.as_ref().clone().with_command(line), &options, follower)?;
        Ok(Prepared { prepared, sampling: options.sampling })
    })?
}

#[pymethods]
impl Prepared {
    /// The graph, with its conditions.
    fn graph(&self, py: Python<'_>) -> Scan {
        detached(py, || Scan::of(self.prepared.boundary.stated_in(self.prepared.graph.clone())))
    }

    /// Samples it, and decides.
    #[pyo3(signature = (watch, threads=None, progress=None, say=None))]
    fn sample(
        &self,
        py: Python<'_>,
        watch: &Watch,
        threads: Option<usize>,
        progress: Option<&Bound<'_, PyAny>>,
        say: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Run> {
        let work = |follower: &mut Follower<'_>| self.prepared.sample(&self.sampling, follower);
        interruptible(py, watch, threads, progress, say, work)?.map(|run| Run { run })
    }

    /// What the samples say that are finished by now; `None` where there are none.
    fn so_far(&self, py: Python<'_>, watch: &Watch) -> PyResult<Option<Run>> {
        let so_far = detached(py, || {
            let (part, seconds) = watch.part(PATIENCE).filter(|(part, _)| part.done() > 0)?;
            Some(self.prepared.so_far(&self.sampling, &part, seconds))
        });
        so_far.transpose().map_err(|e| raised(py, &e)).map(|found| found.map(|run| Run { run }))
    }
}

/// How long to wait for the next step of a run that is looked at.
const PATIENCE: Duration = Duration::from_secs(5);

/// A run from its bytes.
#[pyfunction]
pub fn run_from_bytes(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Run> {
    interruptible(py, &Watch::default(), None, None, None, |_| Inference::from_bytes(&bytes))?.map(|run| Run { run })
}

#[pymethods]
impl Run {
    /// The graph that was sampled, with its conditions.
    fn graph(&self, py: Python<'_>) -> Scan {
        detached(py, || Scan::of(self.run.boundary().stated_in(self.run.graph().clone())))
    }

    /// The plausible topology.
    fn topology(&self, py: Python<'_>) -> Scan {
        detached(py, || Scan::of(self.run.topology()))
    }

    /// The columns of nodes.csv and of edges.csv.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyDict>; 2]> {
        tables::pair(py, computed(py, || self.run.tables())?)
    }

    /// The upper triangle of the likelihood matrix: rows, columns, values.
    #[allow(clippy::type_complexity, reason = "it is what Python gets")]
    fn matrix<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>) {
        let cells = detached(py, || self.run.likelihood().matrix(self.run.graph()));
        let (rows, columns, values): (Vec<u32>, Vec<u32>, Vec<f64>) = cells.into_iter().collect();
        (rows.into_pyarray(py), columns.into_pyarray(py), values.into_pyarray(py))
    }

    /// Per vessel whether it is kept.
    fn kept<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.run.kept().to_vec().into_pyarray(py)
    }

    /// The rows of the vessels whose decision is not certain.
    fn undecided<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.run.decision().undecided.iter().map(|row| *row as i64).collect::<Vec<i64>>().into_pyarray(py)
    }

    /// The columns of review.csv, where that is written.
    fn review<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        detached(py, || self.run.review()).map(|columns| tables::dict(py, columns)).transpose()
    }

    /// SHA-256 of the input.
    fn input_sha256(&self) -> &str {
        self.run.input_sha256()
    }

    /// What a list of decisions has for this run: rows, words, places of edits, who, when and what was said.
    #[allow(clippy::type_complexity, reason = "it is what Python gets")]
    fn listed(
        &self,
        py: Python<'_>,
        path: PathBuf,
        input_sha256: &str,
    ) -> PyResult<Vec<(Option<usize>, String, String, [String; 3])>> {
        let (made, edits) = computed(py, || self.run.listed_decisions(&path, input_sha256))?;
        let word = |accepted| ANSWERS.iter().find(|(answer, _)| *answer == accepted).map_or("", |(_, word)| *word);
        let made = made
            .into_iter()
            .map(|one| (Some(one.edge), word(one.accepted).to_owned(), String::new(), [one.who, one.when, one.comment]));
        let edits =
            edits.into_iter().map(|one| (None, one.edit.word().to_owned(), one.edit.places(), [one.who, one.when, one.comment]));
        Ok(made.chain(edits).collect())
    }

    /// How many of the kept connections are expected to be wrong, and how many are missed; where there is evidence.
    fn expected(&self) -> Option<(f64, f64)> {
        self.run.outcome().expected.map(|expected| (expected.wrong, expected.missed))
    }

    /// What the command says of it: facts under headings.
    fn said(&self) -> Said {
        words::said_of_run(&self.run)
    }

    /// The same samples decided on by another rule.
    fn decided_by(&self, py: Python<'_>, rule: &str) -> PyResult<Self> {
        computed(py, || self.run.decided_by(rule.parse()?)).map(|run| Self { run })
    }

    /// The run again with decisions of a person: the rows that were accepted and rejected, the edits as text, by whom, and when.
    fn decide(
        &self,
        py: Python<'_>,
        accept: Vec<usize>,
        reject: Vec<usize>,
        edits: Vec<String>,
        who: &str,
        when: &str,
    ) -> PyResult<Self> {
        let each = accept.into_iter().map(|edge| (edge, true)).chain(reject.into_iter().map(|edge| (edge, false)));
        let made: Vec<ConnectionDecision> = each
            .map(|(edge, accepted)| ConnectionDecision {
                edge,
                accepted: Some(accepted),
                who: who.into(),
                when: when.into(),
                ..Default::default()
            })
            .collect();
        let edit = |text: String| {
            let edit = Edit::try_from(text.clone()).map_err(|expected| Error::parameter("decisions", text, expected))?;
            Ok(GraphEdit { edit, who: who.into(), when: when.into(), comment: String::new(), line: 0 })
        };
        let edits = edits.into_iter().map(edit).collect::<Result<Vec<GraphEdit>>>().map_err(|e| raised(py, &e))?;
        computed(py, || self.run.with_decisions(&made, &edits, &mut Silent)).map(|run| Self { run })
    }

    /// Writes the folder of the command; what a person should know.
    fn save(&self, py: Python<'_>, folder: PathBuf, force: bool, dpi: u32) -> PyResult<Vec<String>> {
        let written = |staged: &StagedFolder| self.run.write(&staged.path(), &SaveOptions { dpi });
        computed(py, || Ok(StagedFolder::fill(&folder, force, written)?.1))
    }

    /// All that it takes to make it again.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &computed(py, || self.run.to_bytes())?))
    }
}

/// The flow in a network as it is, and with its changes.
#[pyclass(frozen, module = "willis._willis")]
pub struct Simulation {
    run: SimulationRun<'static>,
}

/// A simulation that stands without its input.
fn owned(run: SimulationRun<'_>) -> SimulationRun<'static> {
    SimulationRun {
        network: Cow::Owned(run.network.into_owned()),
        boundary: run.boundary,
        outlets: run.outlets,
        provenance: Cow::Owned(run.provenance.into_owned()),
        radius_rule: run.radius_rule,
        perturbations: run.perturbations,
        result: run.result,
        viscosity: run.viscosity,
        transports: run.transports,
        closures: run.closures,
        pulses: run.pulses,
    }
}

/// Solves the flow in a network by the words of the command.
#[pyfunction]
pub fn simulate(py: Python<'_>, scan: &Scan, words: Vec<String>) -> PyResult<Simulation> {
    let made = computed(py, || {
        let (options, changes) = words::simulate(scan.path(), &words)?;
        let changes: Vec<(&str, Change)> = changes.iter().map(|(name, change)| (name.as_str(), *change)).collect();
        willis::simulate(&scan.input, &changes, &options).map(owned)
    });
    made.map(|run| Simulation { run })
}

#[pymethods]
impl Simulation {
    /// The columns of nodes.csv and of edges.csv.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyDict>; 2]> {
        tables::pair(py, detached(py, || self.run.tables()))
    }

    /// The columns of territories.csv and of transit.csv, if the blood was followed.
    fn transport<'py>(&self, py: Python<'py>) -> PyResult<Option<[Bound<'py, PyDict>; 2]>> {
        detached(py, || self.run.transport_tables()).map(|columns| tables::pair(py, columns)).transpose()
    }

    /// The columns of occlusions.csv, if each vessel was closed in turn.
    fn occlusions<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        detached(py, || self.run.occlusion_table()).map(|columns| tables::dict(py, columns)).transpose()
    }

    /// The arrays of waveforms.npz, if the flow pulsates.
    fn waveforms<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        detached(py, || self.run.waveforms()).map(|arrays| tables::arrays(py, arrays)).transpose()
    }

    /// What the command says of it: facts under headings.
    fn said(&self) -> Said {
        words::said_of_simulation(&self.run)
    }

    /// Writes the folder of the command; what a person should know.
    fn save(&self, py: Python<'_>, folder: PathBuf, force: bool, dpi: u32) -> PyResult<Vec<String>> {
        computed(py, || self.run.save(&folder, force, &SaveOptions { dpi }))
    }
}

/// How a network responds to resistances that vary at random.
#[pyclass(frozen, module = "willis._willis")]
pub struct Modulation {
    input: Arc<Input>,
    boundary: BoundaryOptions,
    options: ModulationOptions,
    threshold: Option<f64>,
    /// run.json.
    #[pyo3(get)]
    record: String,
}

/// Modulates the resistances of a network by the words of the command.
#[pyfunction]
#[pyo3(signature = (scan, words, watch, threads=None, progress=None, say=None))]
pub fn modulate(
    py: Python<'_>,
    scan: &Scan,
    words: Vec<String>,
    watch: &Watch,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    say: Option<&Bound<'_, PyAny>>,
) -> PyResult<Modulation> {
    interruptible(py, watch, threads, progress, say, |follower| {
        let input = scan.input.clone();
        let (boundary, options, threshold) = words::modulate(scan.path(), &input.network, &words)?;
        let record = willis::modulate_with(&input, &boundary, &options, threshold, follower)?.record().to_string();
        Ok(Modulation { input, boundary, options, threshold, record })
    })?
}

#[pymethods]
impl Modulation {
    /// Writes the folder of the command.
    fn save(&self, py: Python<'_>, folder: PathBuf, instances: bool, force: bool, dpi: u32) -> PyResult<()> {
        let Self { input, boundary, options, threshold, .. } = self;
        interruptible(py, &Watch::default(), None, None, None, |follower| {
            StagedFolder::fill(&folder, force, |staged| {
                let run = willis::modulate_with(input, boundary, options, *threshold, follower)?;
                run.write(&staged.path(), instances, &SaveOptions { dpi })
            })
        })?
    }
}

/// The phenotype of a Circle of Willis.
#[pyclass(frozen, module = "willis._willis")]
pub struct Phenotype {
    phenotype: willis::Phenotype,
}

/// Classifies the Circle of Willis of a scan, or of the folder of a run, by the words of the command.
#[pyfunction]
pub fn classify(py: Python<'_>, scan: &Scan, words: Vec<String>) -> PyResult<Phenotype> {
    let found = interruptible(py, &Watch::default(), None, None, None, |follower| {
        let (source, phenotypes) = words::classify(scan.path(), &words)?;
        willis::classify(&scan.input, source.as_ref(), &phenotypes, follower)
    })?;
    found.map(|phenotype| Phenotype { phenotype })
}

#[pymethods]
impl Phenotype {
    /// phenotype.json.
    #[getter]
    fn json(&self) -> String {
        self.phenotype.json.to_string()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.phenotype.notes.clone()
    }
}
