//! What a caller may hear of a run while it is at work, and how it may stop it or resume an earlier one.

use crate::{CandidateOptions, Network, Progress, SamplingOptions};
use willis_core::{flow::Boundary, network::find_by_name::Located, sampling::PartialRun};

/// Follows a run: what its samples come to, as [`Progress`] has it, and the steps around them. Every method does nothing by default.
pub trait Follow: Progress {
    /// A step of the method is done.
    fn step(&mut self, _step: Step<'_>) {}

    /// Sampling is about to begin: the part of the run that an earlier one finished, where it was kept. `key` stands for everything that
    /// the samples depend on; `fits` says whether a part may be of this run.
    fn resume(&mut self, _key: &str, _fits: &dyn Fn(&PartialRun) -> bool) -> Option<PartialRun> {
        None
    }

    /// The samples are complete, or the run has failed: the part that is finished.
    fn sampled(&mut self, _part: &PartialRun, _is_complete: bool) {}
}

/// Nobody follows.
pub struct Silent;

impl Progress for Silent {}

impl Follow for Silent {}

/// What a person should know of a run: each note is said and kept for its record in one act.
pub(super) struct Notes<'a> {
    pub(super) kept: Vec<String>,
    pub(super) follow: &'a mut dyn Follow,
}

impl Notes<'_> {
    pub(super) fn say(&mut self, note: String) {
        self.follow.step(Step::Note(&note));
        self.kept.push(note);
    }
}

/// A step of the method.
#[derive(Debug)]
#[non_exhaustive]
pub enum Step<'a> {
    /// A boundary condition's node was found by the `name` given for it.
    Located {
        /// As given.
        name: &'a str,
        /// The id of the node.
        node: &'a str,
        /// How it was found.
        found: Located,
        /// Whether a file of conditions names it.
        is_in_file: bool,
    },
    /// What found outlets should be was said, and all outlets are stated.
    OutletsAllStated,
    /// Candidates were built around the fragments.
    Built {
        /// The over-connected graph.
        graph: &'a Network,
        /// How.
        options: &'a CandidateOptions,
        /// Whether evidence says how probable they are.
        by_evidence: bool,
    },
    /// Observed vessels that may only touch were cut apart.
    Cut {
        /// The over-connected graph with its contacts.
        graph: &'a Network,
        /// Whether the mask was looked at, ...
        with_mask: bool,
        /// ... and the image beside it.
        with_image: bool,
    },
    /// Cuts were found and not made, there being no mask.
    CutsSuggested {
        /// How many.
        suggested: usize,
    },
    /// The boundary conditions are known.
    Boundary {
        /// The over-connected graph.
        graph: &'a Network,
        /// Its conditions.
        boundary: &'a Boundary,
    },
    /// Something that a person should know.
    Note(&'a str),
    /// Sampling begins.
    Sampling {
        /// The over-connected graph.
        graph: &'a Network,
        /// How.
        options: &'a SamplingOptions,
        /// Whether it goes on until every decision on L is clear.
        until_stable: bool,
    },
}
