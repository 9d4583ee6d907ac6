//! A panel of small inputs, the answers to them, and a digest of each kind of answer: what an experiment depends on, by name.

use std::fs::File;
use std::path::{Path, PathBuf};

use serde_json::Value;
use willis::internals::flow::poiseuille::BLOOD_VISCOSITY;
use willis::internals::formats::{Column, Values, checksum, write_nifti, write_nifti_image};
use willis::internals::modulation::Reading;
use willis::internals::naming::{NamingModel, name_arteries};
use willis::internals::network::{Frame, Origin};
use willis::internals::phantom::{Anatomy, Breaks, Recipe, break_up, draw_scan};
use willis::{
    ArterySource, BoundaryOptions, Change, Cut, FlowOptions, InferOptions, Inference, Input, ModulationOptions, Network,
    PhenotypeOptions, Prior, ReadOptions, SamplingOptions, Stenosis, Uncertain, candidates, infer, modulate, read, read_bytes,
    simulate,
};

/// What the panel returns: every error is a fault of the program, for its inputs ship with it.
pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// What the answers of the panel are made with. The default is what ships.
#[derive(Debug, Clone)]
pub struct Made {
    /// The weights of joins of tracings.
    pub joins: Prior,
    /// Those of tubes.
    pub tubes: Prior,
    /// The model of joins of skeletons.
    pub skeletons: Prior,
    /// The model of contacts.
    pub contacts: Cut,
    /// The model of names, where it is not those that ship.
    pub names: Option<PathBuf>,
    /// Blood viscosity, Pa s.
    pub viscosity: f64,
}

impl Default for Made {
    fn default() -> Self {
        Self {
            joins: Prior::Tracing,
            tubes: Prior::Tubes,
            skeletons: Prior::Skeleton,
            contacts: Cut::Always,
            names: None,
            viscosity: BLOOD_VISCOSITY,
        }
    }
}

/// The name of each fingerprint with its digest, in a fixed order; of those that `which` wants.
///
/// # Errors
///
/// An input of the panel that the program refuses.
pub fn fingerprints(made: &Made, which: impl Fn(&str) -> bool) -> Result<Vec<(String, String)>> {
    type Answer = fn(&Made, &Path, &mut Digest) -> Result<()>;
    let scratch = tempfile::tempdir()?;
    let panel: [(&'static str, Answer); 16] = [
        ("phantoms", phantoms),
        ("network", network),
        ("masks", masks),
        ("search", search),
        ("joins", joins),
        ("tubes", tubes),
        ("skeletons", skeletons),
        ("images", images),
        ("contacts", contacts),
        ("kept", kept),
        ("repaired", repaired),
        ("sampling", sampling),
        ("paper", paper),
        ("flow", flow),
        ("modulation", modulation),
        ("variants", variants),
    ];
    let one = |(name, answer): (&'static str, Answer)| {
        let mut digest = Digest::default();
        answer(made, scratch.path(), &mut digest)?;
        Ok((name.to_owned(), digest.end()))
    };
    panel.into_iter().filter(|(name, _)| which(name)).map(one).collect()
}

/// What is hashed: words and counts as they are, numbers to six digits.
#[derive(Default)]
struct Digest(String);

impl Digest {
    fn word(&mut self, word: &str) {
        self.0 += word;
        self.0.push(';');
    }

    /// Six significant digits of each, so that no processor differs; what is below 1e-9 of the largest is rounding, and counts as zero.
    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        let numbers: Vec<f64> = numbers.into_iter().collect();
        let largest = numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for x in numbers {
            let is_zero = x.abs() <= 1e-9 * largest;
            self.word(&if is_zero { "0".to_owned() } else { format!("{x:.5e}") });
        }
    }

    /// Columns of a table by their names.
    fn columns(&mut self, table: &[Column], names: &[&str]) {
        for name in names {
            self.word(name);
            match table.iter().find(|column| column.name == *name).map(|column| &column.values) {
                Some(Values::Real(values)) => self.numbers(values.iter().copied()),
                Some(Values::Integer(values)) => values.iter().for_each(|x| self.word(&x.to_string())),
                Some(Values::Text(values)) => values.iter().for_each(|x| self.word(x)),
                None => panic!("no column {name}"),
            }
        }
    }

    fn vessels(&mut self, network: &Network, which: impl Fn(Origin) -> bool) {
        let vessels = || network.vessels().filter(|(_, vessel)| which(vessel.origin));
        vessels().for_each(|(ends, _)| self.word(&format!("{ends:?}")));
        self.numbers(vessels().map(|(_, vessel)| vessel.length));
        self.numbers(vessels().map(|(_, vessel)| vessel.radius));
    }

    fn json(&mut self, value: &Value) {
        match value {
            Value::Number(x) => self.numbers(x.as_f64()),
            Value::Array(values) => values.iter().for_each(|value| self.json(value)),
            Value::Object(fields) => fields.iter().for_each(|(name, value)| {
                self.word(name);
                self.json(value);
            }),
            other => self.word(&other.to_string()),
        }
    }

    fn end(self) -> String {
        checksum(self.0.as_bytes())[..12].to_owned()
    }
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn shipped(name: &str) -> Result<Input> {
    Ok(read(&data(name), &ReadOptions::default())?)
}

fn broken_circle() -> Result<Input> {
    shipped("broken-circle-of-willis.swc")
}

fn scan() -> Result<Input> {
    shipped("scan.nii.gz")
}

/// Of every vessel, what the model of the evidence says.
fn probabilities(input: &Input, prior: &Prior, digest: &mut Digest) -> Result<()> {
    let options = InferOptions { prior: Some(prior.clone()), cut: Cut::Never, ..InferOptions::default() };
    let graph = candidates(input, &options)?;
    digest.numbers(graph.vessels().filter_map(|(_, vessel)| Some(vessel.evidence()?.probability)));
    Ok(())
}

/// A run whose samples do not matter.
fn decided(input: &Input, options: InferOptions) -> Result<Inference> {
    let sampling = SamplingOptions { samples: 1, ..options.sampling };
    Ok(infer(input, &InferOptions { sampling, ..options })?)
}

/// Broken tracings and scans of drawn anatomy.
fn phantoms(_: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let whole = Anatomy::Cerebral.network(&Recipe::default())?;
    digest.vessels(&whole, |_| true);
    for seed in 1..3 {
        let (lines, truth) = break_up(&whole, &Breaks { seed, ..Breaks::default() })?;
        digest.numbers(lines.points.into_iter().flatten());
        digest.numbers(lines.radii);
        digest.numbers(truth.breaks.iter().map(|gap| gap.stretch[1] - gap.stretch[0]));
    }
    let recipe = Recipe { seed: 1, ..Recipe::default() };
    let (mask, _, image) = draw_scan(&whole, 0.002, Some(&Anatomy::Cerebral.scan(&recipe)))?;
    digest.word(&checksum(&mask.classes));
    digest.numbers([image.values.iter().map(|x| f64::from(*x)).sum::<f64>()]);
    Ok(())
}

/// Vessels from centerlines.
fn network(_: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    digest.vessels(&broken_circle()?.network, |_| true);
    Ok(())
}

/// Vessels from a mask.
fn masks(_: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    digest.vessels(&scan()?.network, |_| true);
    Ok(())
}

/// Which candidates there are.
fn search(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    for prior in [&made.joins, &Prior::Uniform] {
        let options = InferOptions { prior: Some(prior.clone()), ..InferOptions::default() };
        digest.vessels(&candidates(&broken_circle()?, &options)?, |origin| origin == Origin::Candidate);
    }
    Ok(())
}

fn joins(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    probabilities(&broken_circle()?, &made.joins, digest)
}

fn tubes(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    probabilities(&broken_circle()?, &made.tubes, digest)
}

fn skeletons(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    probabilities(&scan()?, &made.skeletons, digest)
}

/// Joins of a skeleton whose image is there.
fn images(made: &Made, scratch: &Path, digest: &mut Digest) -> Result<()> {
    let [mask, image] = ["mask.nii", "image.nii"].map(|name| scratch.join(name));
    let recipe = Recipe { seed: 3, ..Recipe::default() };
    let drawn = draw_scan(&Anatomy::Cerebral.network(&recipe)?, 0.0012, Some(&Anatomy::Cerebral.scan(&recipe)))?;
    write_nifti(File::create(&mask)?, &drawn.0, false)?;
    write_nifti_image(File::create(&image)?, &drawn.2, false)?;
    let options =
        InferOptions { prior: Some(made.skeletons.clone()), cut: Cut::Never, image: Some(image), ..InferOptions::default() };
    let graph = candidates(&read(&mask, &ReadOptions::default())?, &options)?;
    digest.numbers(graph.vessels().filter_map(|(_, vessel)| Some(vessel.evidence()?.probability)));
    Ok(())
}

/// What is one vessel where vessels meet in a mask.
fn contacts(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let options = InferOptions { prior: Some(Prior::Uniform), cut: made.contacts.clone(), ..InferOptions::default() };
    let graph = candidates(&scan()?, &options)?;
    let contacts = graph.vessels().filter(|(_, vessel)| vessel.origin == Origin::Contact);
    digest.numbers(contacts.filter_map(|(_, vessel)| Some(vessel.evidence()?.probability)));
    Ok(())
}

/// Candidates that close loops within one fragment, and that another fragment hangs on, with probabilities around all that the rule asks.
const LOOPS: &str = "node_a,node_b,length_mm,radius_mm,origin,probability
1,2,20,1,observed,
2,3,20,1,observed,
2,4,20,1,observed,
5,6,20,1,observed,
1,3,3,1,candidate,0.25
1,4,3,1,candidate,0.35
3,4,3,1,candidate,0.55
4,5,3,1,candidate,0.7
3,6,3,1,candidate,0.2
";

/// What stays, of a tracing and of candidates that close loops; what these need, and which a person should look at.
fn kept(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let run = decided(&broken_circle()?, InferOptions { prior: Some(made.joins.clone()), ..InferOptions::default() })?;
    run.kept().iter().for_each(|kept| digest.word(&kept.to_string()));
    let boundary = BoundaryOptions { inlet: vec!["1".to_owned()], ..BoundaryOptions::default() };
    let loops = read_bytes("loops.csv".as_ref(), LOOPS.as_bytes(), &ReadOptions::default())?;
    let run = decided(&loops, InferOptions { keep: Some("probable".parse()?), boundary, ..InferOptions::default() })?;
    digest.columns(&run.tables()?[1], &["needed", "kept"]);
    run.decision().undecided.iter().for_each(|row| digest.word(&row.to_string()));
    Ok(())
}

/// What is kept and cut of a mask.
fn repaired(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let options = InferOptions { prior: Some(made.skeletons.clone()), cut: made.contacts.clone(), ..InferOptions::default() };
    decided(&scan()?, options)?.kept().iter().for_each(|kept| digest.word(&kept.to_string()));
    Ok(())
}

/// L, its error and the forests of a ready graph.
fn sampling(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let sampling =
        SamplingOptions { samples: 256, uncertain: Uncertain::All, viscosity: made.viscosity, ..SamplingOptions::default() };
    for conditions in [None, Some(data("outlets-at-ground.csv"))] {
        let boundary = BoundaryOptions { conditions, ..BoundaryOptions::default() };
        let options = InferOptions { sampling: sampling.clone(), boundary, ..InferOptions::default() };
        let run = infer(&shipped("circle-of-willis/complete.graphml")?, &options)?;
        digest.columns(&run.tables()?[1], &["likelihood", "std_error", "frequency", "above_median"]);
    }
    Ok(())
}

/// The paper's preset on a tracing, with conditions that were found.
fn paper(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let mut options = InferOptions::paper();
    (options.sampling.samples, options.sampling.epsilon, options.sampling.viscosity) = (256, 0.2, made.viscosity);
    let run = infer(&broken_circle()?, &options)?;
    digest.columns(&run.tables()?[1], &["likelihood", "frequency", "above_median", "kept"]);
    digest.columns(&run.tables()?[0], &["role", "pressure_mmHg"]);
    Ok(())
}

/// Pressures and flows, before and after a stenosis and an occlusion.
fn flow(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let input = shipped("circle-of-willis/complete.graphml")?;
    let changes = [("L-ICA I", Change::Stenosis(Stenosis::of_diameter(0.5))), ("L-PComm", Change::Occlusion)];
    for conditions in [None, Some(data("outlets-at-ground.csv"))] {
        let boundary = BoundaryOptions { conditions, ..BoundaryOptions::default() };
        let options = FlowOptions { boundary, viscosity: made.viscosity, ..FlowOptions::default() };
        let run = simulate(&input, &changes, &options)?;
        for state in [Some(&run.result.unperturbed), run.result.perturbed.as_ref()].into_iter().flatten() {
            digest.numbers(state.pressure.iter().flatten().copied());
            digest.numbers(state.vessels.iter().map(|vessel| vessel.flow));
            digest.numbers([state.network_resilience, state.inflow]);
        }
    }
    Ok(())
}

/// Resistances that vary at random, by every reading.
fn modulation(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let input = shipped("circle-of-willis/complete.graphml")?;
    for reading in [Reading::Increment, Reading::Conductance, Reading::Literal, Reading::Geometry] {
        let options = ModulationOptions { samples: 64, reading, viscosity: made.viscosity, ..ModulationOptions::default() };
        let run = modulate(&input, &BoundaryOptions::default(), &options, None)?;
        let record = run.record();
        digest.json(&record["classes"]);
    }
    Ok(())
}

/// The variants of a broken circle with landmarks, and the names of its nodes by geometry, which take longer than all the rest.
fn variants(made: &Made, _: &Path, digest: &mut Digest) -> Result<()> {
    let options = InferOptions {
        arteries: Some(ArterySource::Landmarks(data("broken-circle-of-willis.landmarks.csv"))),
        prior: Some(made.joins.clone()),
        phenotypes: PhenotypeOptions { arteries: made.names.clone(), ..PhenotypeOptions::default() },
        ..InferOptions::default()
    };
    // No frame, so that both are tried.
    let mut circle = broken_circle()?;
    circle.network.frame = Frame::Unknown;
    let run = decided(&circle, options)?;
    let (posterior, _) = run.posterior().ok_or("no posterior of the circle")?;
    digest.numbers(posterior.segments);
    posterior.variants.iter().for_each(|(variant, p)| digest.word(&format!("{variant:?} {p:.4}")));
    // The model of patients finds no circle in a drawn one: that it does not is no answer, but what it says of each node is.
    let text = made.names.as_ref().map(std::fs::read_to_string).transpose()?;
    let model = NamingModel::read(text.as_deref().unwrap_or(include_str!("../../crates/models/src/naming/arteries.toml")))
        .map_err(|fault| fault.in_file("arteries.toml".as_ref()))?;
    let names = name_arteries(run.graph(), &model).ok_or("no names")?;
    digest.numbers(names.labels.into_iter().flatten().map(|p| (1e6 * p).round()));
    Ok(())
}
