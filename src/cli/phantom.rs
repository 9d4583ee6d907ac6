//! `willis phantom`: test anatomy with a known answer.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};
use willis::centerline::Centerlines;
use willis::error::{Error, Result};
use willis::formats::convert::Target;
use willis::formats::{Format, write_centerlines_swc, write_loops};
use willis::hemodynamics::{Boundary, FoundOutlets, boundary::stated};
use willis::network::fragments;
use willis::phantom::{Breaks, Kind, Truth, break_up, landmarks, without, write_landmarks};
use willis::report::{StagedFile, staged::write_file};

use super::convert::{check, put};
use super::input::length;
use super::shell::print_json;
use super::terminal::{Terminal, count, plural};

/// Make test anatomy with a known answer
///
/// `circle-of-willis` has the 33 arteries of Alastruey et al. 2007 from the heart to the brain, `cerebral` the 20 of them
/// that an angiogram of the head shows, `tree` bifurcates by Murray's law. --break makes an uncertain extraction of it:
/// gaps at junctions and midway, jitter, noisy radii, spurious bits; the truth is written beside it as FILE.truth.json, and of
/// `cerebral` the in- and outlets that it shows as FILE.landmarks.csv, for willis classify.
#[derive(Debug, Args)]
pub struct PhantomArgs {
    /// circle-of-willis, cerebral or tree
    kind: String,
    /// The file to write; its ending says the format, as for willis convert
    #[arg(short, long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    output: PathBuf,
    /// Leave out vessels, by label: --without AComm, --without L-PComm,R-P1
    #[arg(long, value_name = "LABEL[,LABEL]", value_delimiter = ',')]
    without: Vec<String>,
    /// Break it up as an extraction would (.swc only)
    #[arg(long = "break")]
    broken: bool,
    /// The seed of the damage
    #[arg(long, value_name = "SEED", default_value_t = 0, requires = "broken")]
    seed: u64,
    /// Distance of centerline points
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm")]
    spacing: String,
    /// Print a summary on standard output, as JSON
    #[arg(long)]
    json: bool,
}

impl PhantomArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let kind: Kind = self.kind.parse()?;
        let spacing = length("--spacing", Some(&self.spacing))?.unwrap_or_default();
        let network = without(&kind.network(spacing)?, &self.without)?;
        let parts = fragments(&network, |_, _| true).count;
        if parts > 1 {
            let missing = self.without.join(", ");
            terminal.say("note", format!("without {missing} the network falls into {parts} parts"));
        }
        let target = Target::new(&self.output, None)?;
        check(&target, force)?;
        if !self.broken {
            let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground)?;
            let (names, _) = put(&boundary.stated_in(network.clone()), &target, terminal, force)?;
            terminal.say("written", format!("{}: {kind}, {}", names.join(", "), plural(network.vessel_count(), "vessel")));
            let counts = json!({ "nodes": network.node_count(), "vessels": network.vessel_count() });
            return self.print(json!({ "counts": counts }));
        }
        if target.format != Format::Swc {
            return Err(Error::parameter("--output", self.output.display(), "expected an ending .swc for a broken extraction"));
        }
        let params = Breaks { seed: self.seed, spacing, ..Breaks::default() };
        let (lines, truth) = break_up(&network, &params)?;
        let loops = write_extraction(&self.output, &lines, &truth, force, terminal)?;
        if kind == Kind::Cerebral {
            let file = StagedFile::new(&beside(&self.output, "landmarks.csv"), force)?;
            write_file(&file.path(), |out| write_landmarks(out, &landmarks(&network, &truth)))?;
            file.commit()?;
        }
        let spurious = truth.spurious.iter().filter(|s| **s).count();
        self.print(json!({
            "truth": beside(&self.output, "truth.json").display().to_string(),
            "loops": loops.map(|path| path.display().to_string()),
            "counts": {
                "points": lines.points.len(),
                "fragments": truth.spurious.len(),
                "spurious": spurious,
                "gaps": truth.breaks.len(),
            },
        }))
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

/// `circle.swc` -> `circle.truth.json`.
fn beside(path: &Path, ending: &str) -> PathBuf {
    path.with_extension(ending)
}

/// Writes the damaged centerlines and the truth; the path of the table of links that SWC cannot hold, where there are any.
fn write_extraction(path: &Path, lines: &Centerlines, truth: &Truth, force: bool, terminal: Terminal) -> Result<Option<PathBuf>> {
    let answer = StagedFile::new(&beside(path, "truth.json"), force)?;
    write_file(&answer.path(), |out| truth.write_json(out))?;
    let file = StagedFile::new(path, force)?;
    let mut loops = Vec::new();
    write_file(&file.path(), |out| {
        loops = write_centerlines_swc(out, lines)?;
        Ok(())
    })?;
    if !loops.is_empty() {
        let table = StagedFile::new(&beside(path, "loops.csv"), force)?;
        write_file(&table.path(), |out| write_loops(out, &loops))?;
        table.commit()?;
        terminal.say(
            "note",
            format!(
                "SWC cannot hold {}: give them with --loops {}",
                plural(loops.len(), "link"),
                beside(path, "loops.csv").display()
            ),
        );
    }
    answer.commit()?;
    file.commit()?;
    let (points, fragments) = (count(lines.points.len() as u64), plural(truth.spurious.len(), "fragment"));
    let spurious = truth.spurious.iter().filter(|s| **s).count();
    terminal.say(
        "written",
        format!(
            "{}: {points} points in {fragments}, {spurious} of them spurious, {}",
            path.display(),
            plural(truth.breaks.len(), "gap")
        ),
    );
    terminal.say("truth", beside(path, "truth.json").display().to_string());
    Ok((!loops.is_empty()).then(|| beside(path, "loops.csv")))
}
