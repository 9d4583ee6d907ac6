//! `-k`, `--max-gap`, `--prior` and the other options of candidates.

use std::path::PathBuf;

use crate::internals::formats::{Format, FormatTrait};
use crate::{Appearance, Attach, CandidateRadius, Cut, InferOptions, Prior};
use clap::Args;

use super::figures::{length, whole};
use super::words;

#[derive(Debug, Args)]
#[command(next_help_heading = "Candidates")]
pub struct CandidateArgs {
    /// How probable a candidate is before any flow: evidence (the shipped model of real arteries), WEIGHTS.toml (one of your own,
    /// from willis train), none (what the file states), uniform (1 everywhere), or A.npy or A.csv, numbers from 0 to 1 for pairs
    /// of nodes or for vessels of the graph [default: evidence on centerlines, none on a ready graph]
    #[arg(long, value_name = "evidence|none|uniform|FILE")]
    prior: Option<Prior>,
    /// Cut observed vessels apart where they may only touch: auto (automatic skeletons with their mask), always, never, or MODEL.toml
    /// (one of your own, from willis train --model contacts) [default: auto]
    #[arg(long, value_name = "auto|always|never|FILE")]
    cut: Option<Cut>,
    /// The mask that the centerlines were made of; where a mask is the input, it is that one
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
