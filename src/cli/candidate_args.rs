//! `-k`, `--max-gap` and the other options of candidates.

use clap::{Args, ValueEnum};
use serde::Serialize;
use willis::error::Result;
use willis::internals::candidates;
use willis::internals::candidates::search::SearchOptions;
use willis::internals::candidates::{Attach, CandidateRadius};
use willis::internals::network::RadiusRule;

use super::typed::{length, whole};

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
    #[arg(short, value_name = "K", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub k: Option<usize>,
    /// The longest gap to bridge, in mm unless it says otherwise (5mm, 800um); never beyond 20 point spacings + 5 end diameters
    #[arg(long, value_name = "LENGTH")]
    pub max_gap: Option<String>,
    /// What a candidate may meet [default: centerline]
    #[arg(long, value_enum)]
    pub attach: Option<AttachTo>,
    /// A candidate's radius from the radii at its two ends [default: min]
    #[arg(long, value_enum)]
    pub candidate_radius: Option<RadiusOfCandidate>,
    /// The largest radius of a candidate, in mm unless it says otherwise
    #[arg(long, value_name = "LENGTH")]
    pub max_candidate_radius: Option<String>,
}

impl CandidateArgs {
    /// The parameters of the library; `paper` and `evidence` change what is used where no option is given.
    pub fn params(&self, radius_rule: RadiusRule, paper: bool, evidence: bool) -> Result<candidates::CandidateOptions> {
        let (attach, radius) =
            if paper { (AttachTo::Ends, RadiusOfCandidate::Mean) } else { (AttachTo::Centerline, RadiusOfCandidate::Min) };
        let params = candidates::CandidateOptions {
            k: self.k.unwrap_or(if evidence {
                SearchOptions::default().branches
            } else {
                candidates::CandidateOptions::default().k
            }),
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
