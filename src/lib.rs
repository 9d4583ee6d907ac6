//! Finds the plausible topology of vascular centerlines by neurovascular resilience.
//!
//! Image pipelines extract centerlines that are broken, or joined in too many ways. This crate builds the over-connected
//! graph of all connections that might be there, occludes its vessels at random, solves the blood flow of every sample,
//! takes the spanning forest of highest resilience and adds up a likelihood for every vessel. Source: Moriconi et al. 2019,
//! *Towards Quantifying Neurovascular Resilience* ("the paper").
//!
//! | the paper | here |
//! |---|---|
//! | eq. 1: r = (1/l) ∫ sqrt(a/π) dz | [`network::RadiusRule::Mean`] |
//! | R = 8µl/(πr⁴) | [`hemodynamics::poiseuille::resistance`] |
//! | algorithm 1: Kirchhoff's current law with source and ground | [`hemodynamics::Circuit`], solved by [`hemodynamics::StarMesh`], [`hemodynamics::conjugate_gradients`] or [`hemodynamics::cholesky`] |
//! | ρ = ΔP·Q/(πr²l), ρ_G | [`resilience::resilience`]; ρ_G in [`inference::Sampler`] |
//! | Ẽ = 𝓔 ∘ (E ∘ A), ε-occlusion | [`perturbation::Occlusion`] |
//! | MST(1/ρ) | [`inference::Forest`] |
//! | L(j1, j2) = Σ_n ρ_n·MST(1/ρ_n) | [`inference::Likelihood`] |
//! | forward simulation under stenosis and occlusion | [`simulation::simulate`], [`state::State`] |
//! | resistance modulation, hypertension | [`modulation::modulate`], [`modulation::Hypertension`] |
//! | median threshold | [`inference::Keep::Median`] |
//!
//! | the evidence | here |
//! |---|---|
//! | w = exp(β·x), v = exp(γ·z) | [`candidates::evidence::FEATURES`], [`candidates::prior::Weights`] |
//! | P(c → p by e) = w_e (G_cc - G_pc), P(root c) = v_c G_cc | [`posterior::marginals`] |
//! | maximum conditional likelihood | [`candidates::prior::fit`] |
//! | the most probable forest | [`inference::probable()`], [`posterior::arborescence`] |
//! | whole topologies with their weights | [`inference::Topologies`] |
//! | the variant of a circle, and its probability | [`phenotype::Circle`], [`phenotype::Posterior`] |
//!
//! ```
//! use willis::hemodynamics::{Boundary, FoundOutlets};
//! use willis::inference::{Keep, Params, decide, infer};
//!
//! let whole = willis::phantom::cerebral(&willis::phantom::circle_of_willis(1e-3));
//! let boundary = Boundary::resolve(&whole, &willis::hemodynamics::boundary::stated(&whole), FoundOutlets::Ground)?;
//! let params = Params { uncertain: willis::inference::Uncertain::All, ..Params::default() };
//! let (likelihood, _) = infer(&whole, &boundary, &params, &mut |_done: u64, _total: u64| true)?;
//! let answer = decide(Keep::Median, &whole, &likelihood)?;
//! assert_eq!(answer.kept.len(), whole.vessel_count());
//! # Ok::<(), willis::error::Error>(())
//! ```
//!
//! Everything inside is in SI units; lengths in files are in mm, pressures in mmHg. The modules below stand in the order of
//! their layers: each uses only those above it.

pub mod error;

pub mod simd;
pub mod stats;
pub mod suggestion;
pub mod units;

pub mod rng;

pub mod quantity;

pub mod elimination;
pub mod geometry;

pub mod centerline;
pub mod posterior;

pub mod network;

pub mod candidates;
pub mod formats;
pub mod hemodynamics;
pub mod perturbation;

pub mod resilience;

pub mod state;

pub mod inference;
pub mod simulation;

pub mod modulation;

pub mod phantom;
pub mod phenotype;

pub mod training;

pub mod report;
