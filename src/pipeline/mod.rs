//! The method, from top to bottom: read, boundary conditions, candidates, samples, decision.

mod arteries;
mod boundary_options;
mod classify;
pub mod decisions;
mod inference;
mod input;
mod label;
mod measure;
mod models;
mod options;
mod picture;
mod prepare;
mod prepared;
mod progress;
mod pulse;
mod simulate;
mod source_file;
mod write;

pub use self::{inference::Inference, models::Cut, models::Prior, prepared::Prepared};
pub use boundary_options::{BoundaryOptions, parse_found_outlets};
pub use classify::{Phenotype, classify};
pub use decisions::{ConnectionDecision, GraphEdit, twice_read};
pub use input::{Contents, Input, read, read_bytes, read_run};
pub use label::{Labelled, label};
pub use measure::{ComparisonOptions, MeasureOptions, Measurement, compare_groups, measure, two_groups};
pub use options::{ArterySource, FlowOptions, InferOptions, PhenotypeOptions, Preset, PulseMean, PulseOptions, RunOptions};
pub use prepare::prepare;
pub use progress::{Follow, Silent, Step};
pub use simulate::{modulate, modulate_with, simulate, simulate_with, solver_model};
pub use source_file::{ModelSource, SourceFile, of_word, require, require_in};
pub use write::{WrittenFiles, stage_target, write, write_target};

use willis_core::error::Result;

/// Finds the plausible topology of an input: exactly what `willis infer` does.
///
/// # Errors
///
/// An option out of its range, a file beside the input that cannot be read, no inlet or outlet, points that are crowded, a vessel whose
/// conductance no double can hold, a breakdown of the solver.
pub fn infer(input: &Input, options: &InferOptions) -> Result<Inference> {
    infer_with(input, options, &mut Silent)
}

/// As [`infer`], followed by `progress`, which may stop it.
///
/// # Errors
///
/// As [`infer`], or [`Error::Stopped`](crate::Error::Stopped).
pub fn infer_with(input: &Input, options: &InferOptions, progress: &mut dyn Follow) -> Result<Inference> {
    prepare(input.clone(), options, progress)?.sample(&options.sampling, progress)
}

/// The over-connected graph of an input: its vessels and the candidates around them, with their priors and boundary conditions.
///
/// # Errors
///
/// As [`infer`].
pub fn candidates(input: &Input, options: &InferOptions) -> Result<crate::Network> {
    let prepared = prepare(input.clone(), options, &mut Silent)?;
    Ok(prepared.boundary.stated_in(prepared.graph.clone()))
}
