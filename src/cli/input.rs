//! Reading the input of a command: centerlines become a network, a ready graph is taken as it stands.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use willis::candidates::evidence::Search;
use willis::candidates::{self, Attach, CandidateRadius};
use willis::centerline::{Centerlines, WELD_TOLERANCE};
use willis::error::{Error, Result};
use willis::formats::{Content, ReadOptions, byte_count, read};
use willis::network::{Network, Origin, RadiusRule, contract, fragments};
use willis::phenotype::divide;
use willis::quantity::Dimension;
use willis::report::Provenance;
use willis::units::{LengthUnit, Scale, millimetres};

use super::provenance::command_line;
use super::terminal::{Terminal, brief, count, plural};

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Unit {
    Mm,
    Um,
    Cm,
    M,
    Voxel,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Radius {
    /// The mean over arc length
    Mean,
    /// The one with the vessel's own Poiseuille resistance
    Effective,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    /// Centerlines (SWC, VTP, VTK, TRE, Slicer markups, iCafe, Voreen, VesselVio, NPZ, MAT, CSV of points) or a candidate graph
    /// (GraphML, CSV of edges)
    #[arg(value_name = "INPUT", value_hint = clap::ValueHint::FilePath)]
    pub input: PathBuf,
    #[command(flatten)]
    reading: ReadingArgs,
}

/// How an input is read.
#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Input")]
pub struct ReadingArgs {
    /// The unit of coordinates and radii in INPUT [default: mm]
    #[arg(long, value_enum)]
    units: Option<Unit>,
    /// Voxel spacing in mm, with --units voxel: one number, or three
    #[arg(long, value_name = "S|SX,SY,SZ", value_delimiter = ',')]
    spacing: Option<Vec<f64>>,
    /// The VTP point array that holds the radius, when it has an unusual name
    #[arg(long, value_name = "NAME")]
    radius_array: Option<String>,
    /// Which radius stands for a vessel
    #[arg(long, value_enum, default_value = "mean")]
    radius: Radius,
    /// The radius of vessels that have none
    #[arg(long, value_name = "LENGTH")]
    default_radius: Option<String>,
    /// Links between points that SWC cannot hold: a CSV file of id_a,id_b; in its name {} is INPUT without its ending and {dir}
    /// the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    loops: Option<PathBuf>,
    /// Take the vessels of a graph file as observed and build candidates around them
    #[arg(long)]
    observed: bool,
    /// The largest file to read, on the disk and unpacked
    #[arg(long, value_name = "SIZE", default_value = "2GiB", value_parser = byte_count)]
    max_input: u64,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AttachTo {
    /// Any vessel, split where the candidate meets it, or a free end
    Centerline,
    /// Free ends only
    Ends,
}

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadiusOfCandidate {
    Min,
    Mean,
}

#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Candidates")]
pub struct CandidateArgs {
    /// Nearest branches and free ends that every free end is joined to; by evidence: nearest branches, and four free ends beside
    /// [default: 5 by evidence, else 6]
    #[arg(short, value_name = "K")]
    pub k: Option<usize>,
    /// The longest gap to bridge; never beyond 20 point spacings + 5 end diameters
    #[arg(long, value_name = "LENGTH")]
    pub max_gap: Option<String>,
    /// What a candidate may meet [default: centerline]
    #[arg(long, value_enum)]
    pub attach: Option<AttachTo>,
    /// A candidate's radius from the radii at its two ends [default: min]
    #[arg(long, value_enum)]
    pub candidate_radius: Option<RadiusOfCandidate>,
    /// The largest radius of a candidate
    #[arg(long, value_name = "LENGTH")]
    pub max_candidate_radius: Option<String>,
}

/// An input that has been read.
pub struct Loaded {
    pub network: Network,
    /// The centerlines that it was made of.
    lines: Option<Centerlines>,
    pub provenance: Provenance,
    /// Whether candidates are to be built around its vessels.
    pub fragments: bool,
    pub radius_rule: RadiusRule,
}

impl Loaded {
    /// Divides the vessels where their labels change along the centerlines.
    pub fn divide_by_labels(&mut self) {
        if let Some(lines) = &self.lines {
            self.network = divide(&self.network, lines, self.radius_rule);
        }
    }
}

/// A length given as an option, m.
pub fn length(option: &str, text: Option<&String>) -> Result<Option<f64>> {
    let parse = |text: &String| {
        let length =
            Dimension::Length.parse(text).map_err(|accepted| Error::parameter(option, format!("\"{text}\""), accepted))?;
        if length > 0.0 { Ok(length) } else { Err(Error::parameter(option, format!("\"{text}\""), "expected a positive length")) }
    };
    text.map(parse).transpose()
}

impl InputArgs {
    /// Refuses what only commands that build candidates know.
    pub fn refuse_candidates(&self, command: &str) -> Result<()> {
        self.reading.refuse_candidates(command)
    }

    /// Reads the input and says what was found in it.
    pub fn load(&self, terminal: Terminal) -> Result<Loaded> {
        self.reading.load(&self.input, command_line(), terminal)
    }
}

/// A file named for every input: `{}` in its name is the input without its ending, `{dir}` the folder of the input.
pub fn beside(name: &Path, input: &Path) -> PathBuf {
    let Some(text) = name.to_str().filter(|text| text.contains('{')) else { return name.to_owned() };
    let folder = input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Split first, so that braces in the name of a folder stay as they are.
    let mut path = String::new();
    for (at, part) in text.split("{dir}").enumerate() {
        if at > 0 {
            path += &folder.to_string_lossy();
        }
        let whole = if input.is_dir() { input.to_owned() } else { input.with_extension("") };
        path += &part.replace("{}", &whole.to_string_lossy());
    }
    path.into()
}

impl ReadingArgs {
    /// Refuses what only commands that build candidates know.
    pub fn refuse_candidates(&self, command: &str) -> Result<()> {
        if self.observed {
            let why = format!("goes with infer and candidates; {command} uses every vessel as it is");
            return Err(Error::parameter("--observed", "", why));
        }
        Ok(())
    }

    /// Refuses what is wrong whatever the input.
    pub fn check(&self) -> Result<()> {
        self.scale()?;
        length("--default-radius", self.default_radius.as_ref()).map(drop)
    }

    /// The file of links that goes with an input.
    pub fn loops(&self, input: &Path) -> Option<PathBuf> {
        self.loops.as_ref().map(|name| beside(name, input))
    }

    /// The unit of INPUT, which files of positions beside it share.
    pub fn scale(&self) -> Result<Scale> {
        let unit = match self.units.unwrap_or(Unit::Mm) {
            Unit::Mm => LengthUnit::Millimetre,
            Unit::Um => LengthUnit::Micrometre,
            Unit::Cm => LengthUnit::Centimetre,
            Unit::M => LengthUnit::Metre,
            Unit::Voxel => LengthUnit::Voxel,
        };
        let spacing = match self.spacing.as_deref() {
            None => None,
            Some([s]) => Some([*s; 3]),
            Some([x, y, z]) => Some([*x, *y, *z]),
            Some(other) => {
                return Err(Error::parameter(
                    "--spacing",
                    format!("of {} numbers", other.len()),
                    "expected one or three positive numbers, in mm",
                ));
            }
        };
        let scale = Scale { unit, spacing };
        scale.validate()?;
        Ok(scale)
    }

    /// Reads an input and says what was found in it; `command` is the line that repeats the run.
    pub fn load(&self, input: &Path, command: String, terminal: Terminal) -> Result<Loaded> {
        let scale = self.scale()?;
        let default_radius = length("--default-radius", self.default_radius.as_ref())?;
        let radius_rule = match self.radius {
            Radius::Mean => RadiusRule::Mean,
            Radius::Effective => RadiusRule::Effective,
        };
        let options = ReadOptions {
            scale,
            radius_array: self.radius_array.clone(),
            radius_optional: default_radius.is_some(),
            loops: self.loops(input),
            max_input: self.max_input,
        };
        let document = read(input, &options)?;
        let given = [
            ("--radius-array", self.radius_array.as_ref(), matches!(document.content, Content::Centerlines(_))),
            ("--default-radius", self.default_radius.as_ref(), !matches!(document.content, Content::Graph(_))),
        ];
        if let Some((option, value, _)) = given.into_iter().find(|(_, value, fits)| value.is_some() && !fits) {
            let why = "goes with centerlines; the vessels of this input state their radii";
            return Err(Error::parameter(option, value.map_or("", String::as_str), why));
        }
        if self.observed && !matches!(document.content, Content::Graph(_)) {
            return Err(Error::parameter("--observed", "", "goes with a candidate graph; these vessels are observed anyway"));
        }
        let mut notes = document.notes;
        if let Some([x, y, z]) = scale.spacing.filter(|[x, y, z]| x != y || y != z) {
            notes.push(format!("unequal spacing {x}, {y}, {z} mm: radii are scaled by the smallest"));
        }
        let assumed = if self.units.is_none() { " assumed" } else { "" };
        let heading = format!("{}, {}{assumed}", document.format.name(), scale.unit.symbol());
        let ready = matches!(document.content, Content::Graph(_));
        let (network, lines) = network(input, document.content, &heading, (radius_rule, default_radius), terminal, &mut notes)?;
        if network.vessel_count() == 0 {
            return Err(willis::error::Fault::file(
                "no vessel",
                "expected centerlines with at least two linked points, or edges",
            )
            .in_file(input));
        }
        for note in &notes {
            terminal.say("note", note);
        }
        let network = if self.observed && ready { observed(network) } else { network };
        let provenance = Provenance {
            command,
            input: input.display().to_string(),
            format: document.format.name().to_owned(),
            sha256: document.sha256,
            units: scale.unit.symbol().to_owned(),
            notes,
        };
        Ok(Loaded { network, lines, provenance, fragments: !ready || self.observed, radius_rule })
    }
}

/// Makes a network of what was read and says how large it is.
fn network(
    input: &Path,
    content: Content,
    heading: &str,
    (radius_rule, default_radius): (RadiusRule, Option<f64>),
    terminal: Terminal,
    notes: &mut Vec<String>,
) -> Result<(Network, Option<Centerlines>)> {
    match content {
        Content::Centerlines(mut lines) => {
            let points = lines.points.len();
            let welded = lines.weld(WELD_TOLERANCE);
            let made = contract(&lines, radius_rule, default_radius).map_err(|fault| fault.in_file(input))?;
            let parts = fragments(&made.network, |_, _| true).count;
            let vessels = plural(made.network.vessel_count(), "vessel");
            terminal.say(
                "read",
                format!(
                    "{}: {heading}: {}, {vessels}, {} points{}",
                    input.display(),
                    plural(parts, "fragment"),
                    count(points as u64),
                    radii(&made.network)
                ),
            );
            if welded > 0 {
                notes.push(format!("{} coinciding with another: made one with it", plural(welded, "point")));
            }
            if made.repaired_radii > 0 {
                notes.push(format!(
                    "{} without a positive finite radius: interpolated along the vessel",
                    plural(made.repaired_radii, "point")
                ));
            }
            if made.mixed_labels > 0 {
                let vessels = plural(made.mixed_labels, "vessel");
                notes.push(format!("{vessels} with more than one label along them: took that of the longest part"));
            }
            if made.default_radii > 0 {
                notes.push(format!("{} without any radius: took --default-radius", plural(made.default_radii, "vessel")));
            }
            Ok((made.network, Some(lines)))
        }
        Content::Vessels(mut network) => {
            let without: Vec<usize> = (0..network.vessel_count()).filter(|v| network.vessel(*v).radius.is_nan()).collect();
            if let Some(radius) = default_radius.filter(|_| !without.is_empty()) {
                for row in &without {
                    network.vessel_mut(*row).radius = radius;
                }
                notes.push(format!("{} without any radius: took --default-radius", plural(without.len(), "vessel")));
            }
            let (nodes, vessels) = (plural(network.node_count(), "node"), plural(network.vessel_count(), "vessel"));
            let size = format!("{nodes}, {vessels}{}", radii(&network));
            terminal.say("read", format!("{}: {heading}: {size}", input.display()));
            Ok((network, None))
        }
        Content::Graph(network) => {
            let observed = network.vessels().filter(|(_, v)| v.origin == Origin::Observed).count();
            let candidates = network.vessel_count() - observed;
            terminal.say(
                "read",
                format!(
                    "{}: {heading}: {}, {} observed and {} candidate vessels{}",
                    input.display(),
                    plural(network.node_count(), "node"),
                    count(observed as u64),
                    count(candidates as u64),
                    radii(&network)
                ),
            );
            Ok((network, None))
        }
    }
}

impl CandidateArgs {
    /// The parameters of the library; `paper` and `evidence` change what is used where no option is given.
    pub fn params(&self, radius_rule: RadiusRule, paper: bool, evidence: bool) -> Result<candidates::Params> {
        let (attach, radius) =
            if paper { (AttachTo::Ends, RadiusOfCandidate::Mean) } else { (AttachTo::Centerline, RadiusOfCandidate::Min) };
        let params = candidates::Params {
            k: self.k.unwrap_or(if evidence { Search::default().branches } else { candidates::Params::default().k }),
            max_gap: length("--max-gap", self.max_gap.as_ref())?,
            attach: match self.attach.unwrap_or(attach) {
                AttachTo::Centerline => Attach::Centerline,
                AttachTo::Ends => Attach::Ends,
            },
            radius: match self.candidate_radius.unwrap_or(radius) {
                RadiusOfCandidate::Min => CandidateRadius::Min,
                RadiusOfCandidate::Mean => CandidateRadius::Mean,
            },
            max_radius: length("--max-candidate-radius", self.max_candidate_radius.as_ref())?,
            radius_rule,
        };
        params.validate()?;
        Ok(params)
    }
}

/// The same network with every vessel observed.
fn observed(mut network: Network) -> Network {
    for row in 0..network.vessel_count() {
        network.vessel_mut(row).origin = Origin::Observed;
    }
    network
}

fn radii(network: &Network) -> String {
    let radii = || network.vessels().map(|(_, v)| millimetres(v.radius));
    let (low, high) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
    if low <= high { format!(", radius {} - {} mm", brief(low), brief(high)) } else { String::new() }
}

/// Viscosity, Pa s, from `--viscosity`.
pub fn viscosity(text: &str) -> Result<f64> {
    Dimension::Viscosity.parse(text).map_err(|accepted| Error::parameter("--viscosity", format!("\"{text}\""), accepted))
}
