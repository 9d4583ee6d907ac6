//! `--prior`: how probable each candidate is before any flow, and the graph that follows from it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use willis::error::{Error, Fault, Result};
use willis::internals::candidates;
use willis::internals::candidates::model::Weights;
use willis::internals::candidates::{build, build_with_evidence};
use willis::internals::flow::Boundary;
use willis::internals::io::{bytes_of, checksum, read_prior_csv, read_prior_npy};
use willis::internals::network::{Network, Role};
use willis::internals::support::suggestions::did_you_mean;

use super::loaded::Loaded;

#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Candidates")]
pub struct PriorArgs {
    /// How probable a candidate is before any flow: evidence (the shipped model of real arteries), WEIGHTS.toml (one of your own,
    /// from willis train), none (what the file states), uniform (1 everywhere), or A.npy or A.csv, numbers from 0 to 1 for pairs
    /// of nodes or for vessels of the graph [default: evidence on centerlines, none on a ready graph]
    #[arg(long, value_name = "evidence|none|uniform|FILE")]
    prior: Option<String>,
}

/// Where the priors come from.
#[derive(Debug)]
pub enum Prior {
    /// A model of the evidence, with its file where it is not the shipped one.
    Evidence { weights: Box<Weights>, source: Option<Source> },
    /// What the file states.
    None,
    /// One everywhere.
    Uniform,
    /// A matrix or table.
    File { bytes: Vec<u8>, source: Source },
}

/// A file that was read.
#[derive(Debug)]
pub struct Source {
    path: PathBuf,
    sha256: String,
}

impl PriorArgs {
    /// The prior for an input; `paper` changes what is used where no option is given.
    ///
    /// # Errors
    ///
    /// A word that is none, a file that cannot be read, evidence for a ready graph.
    pub fn resolve(&self, loaded: &Loaded, paper: bool) -> Result<Prior> {
        let default = match (paper, loaded.fragments) {
            (true, _) => "uniform",
            (false, true) => "evidence",
            (false, false) => "none",
        };
        let text = self.prior.as_deref().unwrap_or(default);
        let prior = prior_of(text)?;
        if prior.is_evidence() && !loaded.fragments {
            let accepted =
                "needs centerlines; this is a ready graph, whose candidates state their own probability (see --observed)";
            return Err(Error::parameter("--prior", text, accepted));
        }
        Ok(prior)
    }

    /// Refuses what is wrong whatever the input.
    pub fn check(&self) -> Result<()> {
        self.prior.as_deref().map(prior_of).transpose().map(drop)
    }

    /// The file of priors or weights.
    pub fn file(&self) -> Option<PathBuf> {
        self.prior.as_ref().filter(|text| !["evidence", "none", "uniform"].contains(&text.as_str())).map(PathBuf::from)
    }
}

/// The prior that a word or file means.
fn prior_of(text: &str) -> Result<Prior> {
    let path = Path::new(text);
    let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let read = || -> Result<(Vec<u8>, Source)> {
        let bytes = bytes_of(path)?;
        let sha256 = checksum(&bytes);
        Ok((bytes, Source { path: path.to_owned(), sha256 }))
    };
    let (weights, source) = match (text, ending.as_ref().and_then(|e| e.to_str())) {
        ("none", _) => return Ok(Prior::None),
        ("uniform", _) => return Ok(Prior::Uniform),
        ("evidence", _) => (Weights::shipped()?, None),
        (_, Some("toml")) => {
            let (bytes, source) = read()?;
            let fault = |_| Fault::file("not UTF-8", "expected weights as `willis train` writes them").in_file(path);
            let text = std::str::from_utf8(&bytes).map_err(fault)?;
            (Weights::read(text).map_err(|fault| fault.in_file(path))?, Some(source))
        }
        (_, Some("npy" | "csv")) => {
            let (bytes, source) = read()?;
            return Ok(Prior::File { bytes, source });
        }
        _ => {
            let meant = did_you_mean(text, ["evidence", "none", "uniform"]);
            let accepted = format!("{meant}expected evidence, none, uniform, or a file .toml, .npy or .csv");
            return Err(Error::parameter("--prior", format!("\"{text}\""), accepted));
        }
    };
    Ok(Prior::Evidence { weights: Box::new(weights), source })
}

impl Prior {
    /// Whether candidates come with evidence.
    pub fn is_evidence(&self) -> bool {
        matches!(self, Self::Evidence { .. })
    }

    /// The record in run.json: the word, or the file with its checksum.
    pub fn record(&self) -> Value {
        match self {
            Self::Evidence { source: None, .. } => json!("evidence"),
            Self::None => json!("none"),
            Self::Uniform => json!("uniform"),
            Self::Evidence { source: Some(source), .. } | Self::File { source, .. } => {
                json!({ "path": source.path.display().to_string(), "sha256": source.sha256 })
            }
        }
    }

    /// The graph to sample: candidates built where the input asks for them, with their priors.
    pub fn graph(&self, loaded: &mut Loaded, boundary: &Boundary, params: &candidates::CandidateOptions) -> Result<Network> {
        let network = std::mem::take(&mut loaded.network);
        let mut graph = match self {
            _ if !loaded.fragments => network,
            Self::Evidence { weights, .. } => {
                let found: BTreeSet<usize> = boundary.found_inlets.iter().copied().collect();
                let given = |node: &usize| boundary.roles[*node] == Role::Inlet && !found.contains(node);
                let inlets: Vec<usize> = (0..network.node_count()).filter(given).collect();
                build_with_evidence(&network, &inlets, params, weights)?
            }
            _ => build(&network, params)?,
        };
        if let Self::File { bytes, source } = self {
            let is_table = source.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
            let read = if is_table { read_prior_csv } else { read_prior_npy };
            read(bytes, &mut graph).map_err(|fault| fault.in_file(&source.path))?;
        }
        Ok(graph)
    }
}
