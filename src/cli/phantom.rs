//! `willis phantom`: test anatomy with a known answer.

use std::path::{Path, PathBuf, absolute};

use serde_json::{Value, json};

use super::print::{TextTerminal, count, plural};
use super::{args::length, args::whole, convert::put, shell::print_json};
use crate::internals::formats::{
    Format, LandmarkFormat, write_centerlines_swc, write_landmarks, write_loops, write_nifti, write_nifti_image,
};
use crate::internals::phantom::{
    Anatomy, Breaks, Gaps, Recipe, Truth, break_up, draw_mask, draw_scan, landmarks, over_connected, with_gaps, without,
};
use crate::{
    Network, Result, internals::candidates::NEAREST, internals::flow::Boundary, internals::flow::FoundOutlets,
    internals::flow::boundary_conditions::stated, internals::formats::convert::Target, internals::network::Origin,
    internals::network::centerlines::Centerlines, internals::network::fragments, internals::output::StagedFiles,
    internals::pipeline::require,
};

/// Make test anatomy with a known answer
///
/// `circle-of-willis` has the 33 arteries of Alastruey et al. 2007 from the heart to the brain, `cerebral` the 20 of them
/// that an angiogram of the head shows, `tree` bifurcates by Murray's law. --break makes an uncertain extraction of it:
/// gaps at junctions and midway, jitter, noisy radii, spurious bits; the truth is written beside it as FILE.truth.json, and of
/// `cerebral` the in- and outlets that it shows as FILE.landmarks.csv, for willis classify.
///
/// An output .nii.gz or .nii is a segmentation mask, with its truth beside it. It is clean, or with --break what a threshold makes of a
/// blurred and noisy scan: thin vessels break, near ones touch, and veins lie beside the arteries.
///
/// `arterial` and `capillary` have any size, --edges: twelve trees that fill a brain, and a block of capillaries. --break cuts gaps
/// into 2.5 and 2 % of their vessels, nothing else; as .graphml or .csv it writes the broken graph with its candidates, the 6
/// nearest nodes of every loose end.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis phantom circle-of-willis --without L-PComm -o circle.swc
  willis phantom cerebral --break --seed 7 -o scan.swc")]
pub struct PhantomArgs {
    /// circle-of-willis, cerebral, tree, arterial or capillary
    kind: String,
    /// The file to write; its ending says the format, as for willis convert, or .nii.gz or .nii for a mask
    #[arg(short, long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    output: PathBuf,
    /// Leave out vessels, by label: --without AComm, --without L-PComm,R-P1; of the circle these are L-A1, R-A1, AComm, L-P1, R-P1,
    /// L-PComm, R-PComm and the arteries around them, all named where a label is not known
    #[arg(long, value_name = "LABEL[,LABEL]", value_delimiter = ',')]
    without: Vec<String>,
    /// How many vessels, 100 to 10000000; for arterial and capillary
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_negative_numbers = true)]
    edges: Option<usize>,
    /// Break it up as an extraction would (.swc; arterial and capillary also .graphml and .csv), or a scan (.nii.gz, .nii)
    #[arg(long = "break")]
    broken: bool,
    /// The seed of the damage, of arterial and capillary also of the anatomy: a broken one is the whole one of its seed [default: 0]
    #[arg(long, value_name = "SEED", value_parser = whole::<u64>, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Distance of centerline points, or length of a voxel, in mm unless it says otherwise [default: 0.5mm; centerlines of arterial and
    /// capillary: straight from node to node]
    #[arg(long, value_name = "LENGTH", value_parser = length("spacing"))]
    spacing: Option<f64>,
    /// Write the image in which the threshold of a mask was drawn too, .nii.gz or .nii: 0 is background, 1 a wide vessel
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    image: Option<PathBuf>,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
}

impl PhantomArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let kind: Anatomy = self.kind.parse()?;
        let recipe = self.recipe(kind)?;
        if let Some(image) = &self.image {
            let need = |holds: bool, accepted: &str| require(holds, "image", image.display(), accepted);
            need(is_mask(&self.output) && is_mask(image), "expected .nii.gz or .nii, with an output .nii.gz or .nii")?;
            let other = absolute(image).ok() != absolute(&self.output).ok();
            need(other, "is `output`, which is the mask; expected another file")?;
        }
        if is_mask(&self.output) {
            return self.write_mask(kind, &recipe, terminal, force);
        }
        let accepted = format!("expected an ending .nii.gz or .nii for a mask, or one of {}", Format::written_endings());
        require(Format::of_ending(&self.output).is_some(), "output", self.output.display(), accepted)?;
        let target = Target::new(&self.output, None)?;
        StagedFiles::check(&target.path, target.nodes.iter().chain(&self.beside(kind)), force)?;
        let graph = matches!(target.format, Format::GraphMl | Format::Csv) && kind.has_any_size();
        let or = if kind.has_any_size() { ", .graphml or .csv" } else { "" };
        let accepted = format!("expected an ending .swc{or} for a broken extraction");
        require(!self.broken || target.format == Format::Swc || graph, "output", self.output.display(), accepted)?;
        let network = self.anatomy(kind, &recipe, terminal)?;
        match (self.broken, kind.gaps(&recipe)) {
            (false, _) => self.write_whole(kind, network, &target, terminal, force),
            (true, Some(gaps)) if graph => self.write_graph(network, &gaps, &target, terminal, force),
            (true, Some(gaps)) => {
                let (lines, truth) = with_gaps(&network, &gaps)?;
                drop(network);
                self.write_broken(&lines, &truth, StagedFiles::new(&self.output, force)?, terminal)
            }
            (true, None) => {
                let defaults = Breaks { seed: recipe.seed, ..Breaks::default() };
                let params = Breaks { spacing: recipe.spacing.unwrap_or(defaults.spacing), ..defaults };
                let (lines, truth) = break_up(&network, &params)?;
                let mut staged = StagedFiles::new(&self.output, force)?;
                self.stage_landmarks(kind, &network, &truth.lost, &mut staged)?;
                self.write_broken(&lines, &truth, staged, terminal)
            }
        }
    }

    /// The whole anatomy, with its conditions.
    pub(super) fn whole(&self) -> Result<Network> {
        let kind: Anatomy = self.kind.parse()?;
        require(!self.broken && self.image.is_none(), "break", "", "makes files; give `output`")?;
        with_conditions(self.anatomy(kind, &self.recipe(kind)?, TextTerminal::new(true, false))?)
    }

    /// What the options ask for, where they go with the kind.
    fn recipe(&self, kind: Anatomy) -> Result<Recipe> {
        let (seed, any_size) = (self.seed.unwrap_or_default(), kind.has_any_size());
        let accepted = format!("{kind} is always the same; expected with --break, arterial or capillary");
        require(self.seed.is_none() || self.broken || any_size, "seed", seed, accepted)?;
        let accepted = format!("the vessels of {kind} have no labels; expected with another phantom");
        require(!any_size || self.without.is_empty(), "without", self.without.join(","), accepted)?;
        Ok(Recipe { spacing: self.spacing, edges: self.edges, seed })
    }

    /// The complete network, or what --without leaves of it.
    fn anatomy(&self, kind: Anatomy, recipe: &Recipe, terminal: TextTerminal) -> Result<Network> {
        let network = kind.network(recipe)?;
        if self.without.is_empty() {
            return Ok(network);
        }
        let network = without(&network, &self.without)?;
        let parts = fragments(&network, |_, _| true).count;
        if parts > 1 {
            let missing = self.without.join(", ");
            terminal.say("note", format!("without {missing} the network falls into {parts} parts"));
        }
        Ok(network)
    }

    fn write_whole(&self, kind: Anatomy, network: Network, target: &Target, terminal: TextTerminal, force: bool) -> Result<()> {
        let network = with_conditions(network)?;
        let files = put(StagedFiles::new(&target.path, force)?, &network, target, terminal)?.files;
        let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        terminal.say("written", format!("{}: {kind}, {}", names.join(", "), plural(network.vessel_count(), "vessel")));
        let counts = json!({ "nodes": network.node_count(), "vessels": network.vessel_count() });
        self.print(json!({ "counts": counts }))
    }

    /// The file that goes with the output: `circle.swc` -> `circle.truth.json`, `scan.nii.gz` -> `scan.truth.json`.
    fn sibling(&self, ending: &str) -> PathBuf {
        let path = &self.output;
        if has_ending(path, ".nii.gz") { path.with_extension("").with_extension(ending) } else { path.with_extension(ending) }
    }

    /// Whether there are landmarks beside the output.
    fn has_landmarks(&self, kind: Anatomy) -> bool {
        self.broken && kind == Anatomy::Cerebral
    }

    fn stage_landmarks(&self, kind: Anatomy, network: &Network, lost: &[usize], staged: &mut StagedFiles) -> Result<()> {
        if !self.has_landmarks(kind) {
            return Ok(());
        }
        let marks = landmarks(network, lost);
        staged.write(&self.sibling("landmarks.csv"), |out| write_landmarks(out, LandmarkFormat::Csv, network.frame, &marks))
    }

    /// The files beside broken centerlines that are known before the work.
    fn beside(&self, kind: Anatomy) -> Vec<PathBuf> {
        let endings = [("truth.json", self.broken), ("landmarks.csv", self.has_landmarks(kind))];
        endings.iter().filter(|(_, is_made)| *is_made).map(|(ending, _)| self.sibling(ending)).collect()
    }

    /// The mask and its truth; of a broken `cerebral` the landmarks too.
    fn write_mask(&self, kind: Anatomy, recipe: &Recipe, terminal: TextTerminal, force: bool) -> Result<()> {
        let (answer, marks) = (self.sibling("truth.json"), self.sibling("landmarks.csv"));
        let others = [&answer].into_iter().chain(self.has_landmarks(kind).then_some(&marks)).chain(&self.image);
        StagedFiles::check(&self.output, others, force)?;
        let network = self.anatomy(kind, &Recipe { spacing: None, ..recipe.clone() }, terminal)?;
        let scan = self.broken.then(|| kind.scan(recipe));
        let spacing = recipe.spacing.unwrap_or(VOXEL);
        let (mask, truth, image) = match self.image {
            Some(_) => draw_scan(&network, spacing, scan.as_ref()).map(|(mask, truth, image)| (mask, truth, Some(image)))?,
            None => draw_mask(&network, spacing, scan.as_ref()).map(|(mask, truth)| (mask, truth, None))?,
        };
        let mut staged = StagedFiles::new(&self.output, force)?;
        staged.write_main(|out| write_nifti(out, &mask, has_ending(&self.output, ".gz")))?;
        staged.write(&answer, |out| truth.write_json(out))?;
        self.stage_landmarks(kind, &network, &truth.lost, &mut staged)?;
        if let Some((path, image)) = self.image.as_ref().zip(image) {
            staged.write(path, |out| write_nifti_image(out, &image, has_ending(path, ".gz")))?;
        }
        staged.commit()?;
        let ([x, y, z], mm) = (mask.shape, mask.spacing()[0]);
        let voxels = mask.classes.iter().filter(|class| **class > 0).count();
        let made = format!("{}, {}", plural(truth.breaks.len(), "break"), plural(truth.contacts.len(), "contact"));
        let size = format!("{x} x {y} x {z} voxels of {mm:.4} mm, {} of vessels", count(voxels as u64));
        let counts = json!({
            "voxels": mask.classes.len(),
            "foreground": voxels,
            "vessels": truth.tubes.len(),
            "spurious": truth.spurious().count(),
            "lost": truth.lost.len(),
            "gaps": truth.breaks.len(),
            "contacts": truth.contacts.len(),
        });
        let written = format!("{}: {size}, {made}", self.output.display());
        self.say_truth(terminal, written, json!({ "counts": counts }))
    }

    /// The broken graph with its candidates, and the truth.
    fn write_graph(&self, network: Network, gaps: &Gaps, target: &Target, terminal: TextTerminal, force: bool) -> Result<()> {
        let (graph, truth) = over_connected(network, gaps, NEAREST)?;
        let mut staged = StagedFiles::new(&self.output, force)?;
        staged.write(&self.sibling("truth.json"), |out| truth.write_json(out))?;
        let files = put(staged, &graph, target, terminal)?.files.into_iter().map(|path| path.display().to_string());
        let names: Vec<String> = files.filter(|name| !name.ends_with(".truth.json")).collect();
        let candidates = graph.vessels().filter(|(_, vessel)| vessel.origin == Origin::Candidate).count();
        let (nodes, vessels) = (graph.node_count(), graph.vessel_count());
        let size = format!("{}, {}", plural(nodes, "node"), plural(vessels, "vessel"));
        let made = format!("{} of them candidates, {}", count(candidates as u64), plural(truth.breaks.len(), "gap"));
        let written = format!("{}: {size}, {made}", names.join(", "));
        let counts = json!({ "nodes": nodes, "vessels": vessels, "candidates": candidates, "gaps": truth.breaks.len() });
        self.say_truth(terminal, written, json!({ "counts": counts }))
    }

    /// The broken centerlines, and the truth beside what else is staged; and the links that SWC cannot hold, where there are any.
    fn write_broken(&self, lines: &Centerlines, truth: &Truth, mut staged: StagedFiles, terminal: TextTerminal) -> Result<()> {
        staged.write(&self.sibling("truth.json"), |out| truth.write_json(out))?;
        let mut links = Vec::new();
        staged.write_main(|out| write_centerlines_swc(out, lines).map(|found| links = found))?;
        let loops = Some(self.sibling("loops.csv")).filter(|_| !links.is_empty());
        if let Some(path) = &loops {
            staged.write(path, |out| write_loops(out, &links))?;
            let links = plural(links.len(), "link");
            terminal.say("note", format!("SWC cannot hold {links}: give them with --loops {}", path.display()));
        }
        staged.commit()?;
        let spurious = truth.spurious.iter().filter(|s| **s).count();
        let (points, fragments) = (count(lines.points.len() as u64), plural(truth.spurious.len(), "fragment"));
        let made = format!("{points} points in {fragments}, {spurious} of them spurious, {}", plural(truth.breaks.len(), "gap"));
        let counts = json!({
            "points": lines.points.len(),
            "fragments": truth.spurious.len(),
            "spurious": spurious,
            "gaps": truth.breaks.len(),
        });
        let written = format!("{}: {made}", self.output.display());
        self.say_truth(terminal, written, json!({ "loops": loops.map(|path| path.display().to_string()), "counts": counts }))
    }

    /// Says what was written and where the truth is; the summary with it.
    fn say_truth(&self, terminal: TextTerminal, written: String, mut summary: Value) -> Result<()> {
        let truth = self.sibling("truth.json").display().to_string();
        terminal.say("written", written);
        terminal.say("truth", &truth);
        summary["truth"] = truth.into();
        self.print(summary)
    }

    /// The summary, where it is asked for.
    fn print(&self, mut summary: Value) -> Result<()> {
        if !self.json {
            return Ok(());
        }
        summary["willis"] = env!("CARGO_PKG_VERSION").into();
        summary["output"] = self.output.display().to_string().into();
        summary["phantom"] = self.kind.as_str().into();
        summary["without"] = self.without.as_slice().into();
        print_json(&summary)
    }
}

/// The length of a voxel unless the user says otherwise, m.
const VOXEL: f64 = 0.0005;

/// Whether a file name ends in these letters, small or capital, after something else.
fn has_ending(path: &Path, ending: &str) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_ascii_lowercase();
    name.len() > ending.len() && name.ends_with(ending)
}

/// Whether the ending of a file name means a mask.
fn is_mask(path: &Path) -> bool {
    has_ending(path, ".nii") || has_ending(path, ".nii.gz")
}

/// A network with its conditions.
fn with_conditions(network: Network) -> Result<Network> {
    let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground)?;
    Ok(boundary.stated_in(network))
}
