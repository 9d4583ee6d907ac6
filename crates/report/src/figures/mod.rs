//! The pictures of a run as PNG and SVG: the likelihood matrix and its convergence, flows, whose blood it is, responses to modulation, hypertension.
//!
//! The pictures need no installed font, and the same input gives the same bytes.

pub mod axis;
pub(crate) mod colour;
mod figure;
mod likelihood;
mod modulation;
mod sheet;
mod simulation;
mod summary;

pub use colour::{ZERO, colour};
pub(crate) use figure::units;
pub use figure::{DEFAULT_DPI, Figure, SaveOptions};
pub use likelihood::{CutLine, LikelihoodMatrix, NodeBlock, convergence, heat_map, node_blocks, orders};
pub use modulation::{Boxes, Histogram, Histograms, Panel, hypertension, modulation};
pub use simulation::{ArteryWaveform, OutletSupply, VesselFlow, flow_bars, supply_bars, waveform_panels};
pub(crate) use summary::FRONT;
pub use summary::{CoursePoint, DrawnVessel, MOST_RINGS, Projection, Ring, smoothed, summary};
