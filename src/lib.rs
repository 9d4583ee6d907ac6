//! Finds the plausible topology of vascular centerlines, with a probability for every connection.
//!
//! Image pipelines extract centerlines that are broken, or joined in too many places. This crate builds the over-connected
//! graph of all connections that may exist, and gives each one a probability by its geometry, which decides. Beside it stands the
//! likelihood of Moriconi et al. 2019, *Towards Quantifying Neurovascular Resilience* ("the paper"): vessels are occluded at random, the
//! blood flow of every sample is solved, and the spanning forests of highest resilience add up.
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let out = folder.path().join("out");
//! use willis::{InferOptions, ReadOptions, SaveOptions};
//!
//! let input = willis::read("data/broken-circle-of-willis.swc".as_ref(), &ReadOptions::default())?;
//! let run = willis::infer(&input, &InferOptions::default())?;
//! println!("{} vessels are kept", run.kept().iter().filter(|kept| **kept).count());
//! run.save(&out, &SaveOptions::default())?;
//! # assert!(out.join("topology.vtp").is_file());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A program may make the network itself, in SI units; this one is a tube, whose flow is Q = πr⁴ΔP/(8µl):
//!
//! ```
//! use willis::{Condition, FlowOptions, Input, Network, Node, Origin, Vessel};
//!
//! let mut network = Network::new();
//! for (id, pressure) in [("in", 13_332.0), ("out", 0.0)] {
//!     network.add_node(Node { id: id.into(), condition: Some(Condition::Pressure(pressure)), ..Node::default() });
//! }
//! network.add_vessel([0, 1], Vessel::new(1e-2, 1e-3, Origin::Observed));
//! let input = Input::from_network(network);
//! let flow = willis::simulate(&input, &[], &FlowOptions::default())?.result.unperturbed.vessels[0].flow;
//! assert!((flow / (std::f64::consts::PI * 1e-12 * 13_332.0 / (8.0 * 3.5e-3 * 1e-2)) - 1.0).abs() < 1e-12);
//! # Ok::<(), willis::Error>(())
//! ```
//!
//! These functions do exactly what the commands of the same names do, with the same defaults. Everything behind them is in
//! [`internals`], which promises nothing. Inside, everything is in SI units; lengths in files are in mm, pressures in mmHg.
//!
//! | the paper | here |
//! |---|---|
//! | the whole method, one sample after another, slow and obvious | `crates/core/src/sampling/reference.rs` |
//! | the steps of a run | [`internals::pipeline`] |
//! | eq. 1: r = (1/l) ∫ sqrt(a/π) dz | `crates/core/src/network/centerlines.rs`: [`RadiusRule::Mean`] |
//! | R = 8µl/(πr⁴) | [`internals::flow::poiseuille`] |
//! | algorithm 1: Kirchhoff's current law with source and ground | [`internals::flow::Circuit`]; solved in `crates/core/src/flow/batch/` |
//! | ρ = ΔP·Q/(πr²l), ρ_G | [`internals::flow::resilience`](mod@internals::flow::resilience), [`internals::flow::state`] |
//! | Ẽ = 𝓔 ∘ (E ∘ A), ε-occlusion | [`internals::perturbation::Occlusion`] |
//! | MST(1/ρ) | `crates/core/src/sampling/forest.rs` |
//! | L(j1, j2) = Σ_n ρ_n·MST(1/ρ_n) | [`Likelihood`] |
//! | median threshold | [`Keep::Median`] |
//! | forward simulation under stenosis and occlusion | [`simulate`], [`internals::simulation`] |
//! | resistance modulation, hypertension | [`modulate`], [`internals::modulation`] |
//!
//! | the evidence | here |
//! |---|---|
//! | w = exp(β·x), v = exp(γ·z) | [`internals::candidates::features`], [`internals::candidates::model`] |
//! | P(c → p by e) = w_e (G_cc - G_pc), P(root c) = v_c G_cc | [`internals::forest_posterior::marginals()`] |
//! | maximum conditional likelihood | `crates/training/src/fit.rs` |
//! | the most probable forest | `crates/core/src/decision/most_probable_forest.rs` |
//! | whole topologies with their weights | `crates/core/src/decision/whole_topologies.rs` |
//! | the variant of a circle, and its probability | [`internals::circle_of_willis`] |

#[cfg(feature = "cli")]
pub mod cli;
pub mod internals;

mod pipeline;

pub use pipeline::{
    ArterySource, BoundaryOptions, ComparisonOptions, ConnectionDecision, Contents, Cut, FlowOptions, Follow, GraphEdit,
    InferOptions, Inference, Input, Labelled, MeasureOptions, Measurement, Phenotype, PhenotypeOptions, Prepared, Preset, Prior,
    PulseMean, PulseOptions, Silent, Step, WrittenFiles, candidates, classify, compare_groups, infer, infer_with, label, measure,
    modulate, modulate_with, prepare, read, read_bytes, read_run, simulate, simulate_with, solver_model, twice_read, two_groups,
    write,
};
pub use willis_core::decision::{Decision, Keep};
pub use willis_core::error::{self, Error, Result};
pub use willis_core::flow::{FoundOutlets, Thickness, Unfed, WallLaw, boundary_conditions::Total};
pub use willis_core::modulation::{Class, ModulationOptions, Reading};
pub use willis_core::network::units::{LengthUnit, Scale};
pub use willis_core::network::{
    Condition, ConditionFrom, Edit, Evidence, Frame, Network, Node, Origin, PathPoint, RadiusRule, Role, Vessel, Wall, Windkessel,
};
pub use willis_core::perturbation::{Stenosis, StretchPlace};
pub use willis_core::sampling::{FoundConditions, Likelihood, Progress, SamplingOptions, Solver, Uncertain, Weight};
pub use willis_core::{simulation::Change, simulation::pulse::Friction};
pub use willis_io::formats::ReadOptions;
pub use willis_io::masks::{Appearance, Cavities, RadiusFrom};
pub use willis_models::candidates::{Attach, CandidateOptions, CandidateRadius};
pub use willis_models::circle_of_willis::LabelScheme;
pub use willis_report::figures::SaveOptions;
pub use willis_report::{ModulationRun, SimulationRun};
