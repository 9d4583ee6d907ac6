//! Groups of options that several commands share, each with the options of the library that it means.

pub mod pulse;
pub mod reading;

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::{
    Appearance, ArterySource, Attach, BoundaryOptions, CandidateRadius, Cut, Error, InferOptions, LabelScheme, PhenotypeOptions,
    Prior, Result, Unfed, internals::formats::Format, internals::formats::FormatTrait, internals::network::quantity::Dimension,
    internals::network::units::millimetres, internals::pipeline::of_word, internals::support::endings::without_ending,
};

/// A parser for an enum of the library by the words that serde writes, each with its help.
pub fn words<T: serde::de::DeserializeOwned + Clone + Send + Sync + 'static>(
    words: &[(&'static str, &'static str)],
) -> impl TypedValueParser<Value = T> {
    let value = |(word, help): &(&'static str, &'static str)| match *help {
        "" => PossibleValue::new(*word),
        help => PossibleValue::new(*word).help(help),
    };
    PossibleValuesParser::new(words.iter().map(value)).try_map(|word| of_word(&word).ok_or("expected one of the words"))
}

/// The words for what becomes of vessels that no inlet feeds.
pub fn unfed() -> impl TypedValueParser<Value = Unfed> {
    words(&[("drop", "They are left out"), ("keep", "They stay, without flow")])
}

/// Options with the files that are named for every input being those of this one.
pub fn options_for(mut options: InferOptions, input: &Path) -> InferOptions {
    options.boundary = boundary_for(&options.boundary, input);
    options.arteries = options.arteries.map(|source| source_for(&source, input));
    for name in [&mut options.decisions, &mut options.mask, &mut options.image, &mut options.probability].into_iter().flatten() {
        *name = file_of(name, input);
    }
    options
}

/// Conditions with the file of them that goes with an input.
pub fn boundary_for(options: &BoundaryOptions, input: &Path) -> BoundaryOptions {
    BoundaryOptions { conditions: options.conditions.as_ref().map(|name| file_of(name, input)), ..options.clone() }
}

/// A file named for every input: `{}` in its name is the input without its ending, `{dir}` the folder of the input.
pub fn file_of(name: &Path, input: &Path) -> PathBuf {
    let Some(text) = name.to_str().filter(|text| text.contains('{')) else { return name.to_owned() };
    let folder = input.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let whole = if input.is_dir() { input.to_owned() } else { without_ending(input) };
    // Split first, so that braces in the name of a folder stay as they are.
    let mut file = OsString::new();
    for (at, part) in text.split("{dir}").enumerate() {
        file.push(if at > 0 { folder.as_os_str() } else { OsStr::new("") });
        for (at, rest) in part.split("{}").enumerate() {
            file.push(if at > 0 { whole.as_os_str() } else { OsStr::new("") });
            file.push(rest);
        }
    }
    file.into()
}

/// The largest number up to which a figure with an exponent stands for every whole number.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// A whole number, which may be typed as 1e6.
pub fn whole<T: TryFrom<u64>>(text: &str) -> Result<T, String> {
    let is_whole = |x: &f64| x.fract() == 0.0 && *x >= 0.0;
    let by_exponent = || text.parse().ok().filter(is_whole).map(|x| (x <= WHOLE).then_some(x as u64));
    let number = text.parse().map(Some).ok().or_else(by_exponent).ok_or("expected a whole number, such as 1000 or 1e6")?;
    number.and_then(|number| number.try_into().ok()).ok_or_else(|| "is too large".to_owned())
}

/// A probability, as a number from 0 to 1.
pub fn probability(text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').and_then(|digits| digits.trim().parse::<f64>().ok());
    let example = percent.map_or(0.5, |percent| percent / 100.0);
    text.parse().map_err(|_| format!("expected a number from 0 to 1, such as {example}"))
}

/// A voxel spacing, mm; none where it is that which is stated for the input.
pub type Spacing = Option<f64>;

/// A spacing in mm, as a number or a length, or `auto`.
pub fn spacing(text: &str) -> Result<Spacing, String> {
    if text == "auto" {
        return Ok(None);
    }
    text.parse().or_else(|_| Dimension::Length.parse(text).map(millimetres)).map(Some)
}

/// A parser whose errors name the option that a text was given to.
pub fn for_option<T>(
    option: &'static str,
    parse: impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<T> + Clone + Send + Sync + 'static {
    move |text| parse(text).map_err(|accepted| Error::parameter(option, format!("\"{text}\""), accepted))
}

/// A parser of a figure with its unit, SI, for an option of this name.
pub fn figure(option: &'static str, dimension: Dimension) -> impl Fn(&str) -> Result<f64> + Clone + Send + Sync + 'static {
    for_option(option, move |text| dimension.parse(text))
}

/// A parser of a positive length, m, for an option of this name.
pub fn length(option: &'static str) -> impl Fn(&str) -> Result<f64> + Clone + Send + Sync + 'static {
    for_option(option, |text| {
        let length = Dimension::Length.parse(text)?;
        if length > 0.0 { Ok(length) } else { Err("expected a positive length".into()) }
    })
}

/// Viscosity, Pa s, from `--viscosity`.
pub fn viscosity(text: &str) -> Result<f64> {
    figure("viscosity", Dimension::Viscosity)(text)
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Circle of Willis")]
pub struct ArteryArgs {
    /// Where arteries enter and leave, in the place of labels: auto, to name them by their geometry, a point list of 3D Slicer, or a CSV file of label,x_mm,y_mm,z_mm, or
    /// x,y,z in the unit of INPUT; in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    landmarks: Option<PathBuf>,
    /// What the labels are [default: names; numbers where only one list has them]
    #[arg(long, conflicts_with = "landmarks", hide_short_help = true, value_parser = words::<LabelScheme>(&[("names", "Names of arteries, as L-A1, \"A1 left\", ACoA"),
        ("icafe", "The numbers of iCafe's VesselType"), ("topcow", "The numbers of the TopCoW challenge")]))]
    labels: Option<LabelScheme>,
    #[command(flatten)]
    pub phenotypes: PhenotypeOptions,
}

impl ArteryArgs {
    /// How the arteries are known, where a person said it.
    pub fn source(&self) -> Option<ArterySource> {
        let is_auto = |path: &PathBuf| path.as_os_str() == "auto";
        let source = |path| if is_auto(&path) { ArterySource::Geometry } else { ArterySource::Landmarks(path) };
        self.landmarks.clone().map(source).or(self.labels.map(ArterySource::Labels))
    }
}

/// The same with the file of landmarks that goes with an input.
pub fn source_for(source: &ArterySource, input: &Path) -> ArterySource {
    if let ArterySource::Landmarks(name) = source { ArterySource::Landmarks(file_of(name, input)) } else { source.clone() }
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Candidates")]
pub struct CandidateArgs {
    /// How probable a candidate is before any flow: evidence (the shipped model of real arteries for such an input; weights:tracing,
    /// weights:tubes or weights:skeleton is one of them), WEIGHTS.toml (one of your own,
    /// from willis train), none (what the file states), uniform (1 everywhere), or A.npy or A.csv, numbers from 0 to 1 for pairs
    /// of nodes or for vessels of the graph [default: evidence on centerlines, none on a ready graph]
    #[arg(long, value_name = "evidence|none|uniform|FILE")]
    prior: Option<Prior>,
    /// Cut observed vessels apart where they may only touch: auto (automatic skeletons with their mask), always, never, or MODEL.toml
    /// (one of your own, from willis train --model contacts) [default: auto]
    #[arg(long, value_name = "auto|always|never|FILE")]
    cut: Option<Cut>,
    /// The mask that the centerlines were made of [default: INPUT where it is one]; in its name, as in those of images, {} is INPUT
    /// without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    mask: Option<PathBuf>,
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath, help = format!(
        "The image that shows the vessels ({}): gaps of a mask or of an automatic skeleton are looked at in it", Format::short(FormatTrait::OwnSpacing)))]
    image: Option<PathBuf>,
    #[arg(long, value_name = "FILE", conflicts_with_all = ["image", "vessels"], value_hint = clap::ValueHint::FilePath, help = format!(
        "The probabilities of vessels from a segmenter ({}), looked at in place of an image; it may be the input itself", Format::short(FormatTrait::OwnSpacing)))]
    probability: Option<PathBuf>,
    /// How vessels look in the image [default: auto]
    #[arg(long, requires = "image", value_parser = words::<Appearance>(&[("auto", "As most of them do"), ("bright", "TOF, CTA, contrast-enhanced MRA"),
        ("dark", "Black-blood MRI")]))]
    vessels: Option<Appearance>,
    /// Nearest branches and free ends that every free end is joined to; by evidence: nearest branches, and four free ends beside
    /// [default: 5 by evidence, else 6]
    #[arg(short, value_name = "K", value_parser = whole::<usize>, allow_negative_numbers = true, hide_short_help = true)]
    k: Option<usize>,
    /// The longest gap to bridge, in mm unless it says otherwise (5mm, 800um); never beyond 20 point spacings + 5 end diameters,
    /// twice as far straight ahead of an end on masks and skeletons
    #[arg(long, value_name = "LENGTH", value_parser = length("max_gap"))]
    max_gap: Option<f64>,
    /// What a candidate may meet [default: centerline]
    #[arg(long, hide_short_help = true, value_parser = words::<Attach>(&[("centerline", "Any vessel, split where the candidate meets it, or a free end"),
        ("ends", "Free ends only")]))]
    attach: Option<Attach>,
    /// A candidate's radius from the radii at its two ends [default: min]
    #[arg(long, hide_short_help = true, value_parser = words::<CandidateRadius>(&[("min", ""), ("mean", "")]))]
    candidate_radius: Option<CandidateRadius>,
    /// The largest radius of a candidate, in mm unless it says otherwise
    #[arg(long, value_name = "LENGTH", value_parser = length("max_candidate_radius"), hide_short_help = true)]
    max_candidate_radius: Option<f64>,
}

impl CandidateArgs {
    /// Puts what was given in the place of the `usual` options.
    pub fn put(&self, options: &mut InferOptions) {
        let usual = &mut options.candidates;
        (usual.max_gap, usual.max_radius) = (self.max_gap, self.max_candidate_radius);
        usual.k = self.k.or(usual.k);
        usual.attach = self.attach.unwrap_or(usual.attach);
        usual.radius = self.candidate_radius.unwrap_or(usual.radius);
        options.prior = self.prior.clone().or(options.prior.take());
        options.cut = self.cut.clone().unwrap_or(options.cut.clone());
        options.mask.clone_from(&self.mask);
        options.image.clone_from(&self.image);
        options.probability.clone_from(&self.probability);
        options.vessels = self.vessels.unwrap_or(options.vessels);
    }
}
