//! The pictures of a run as PNG and SVG: the likelihood matrix and its convergence, flows, whose blood it is, responses to modulation, hypertension.
//!
//! The pictures need no installed font, and the same input gives the same bytes.

pub mod axis;
mod bitmap;
pub(crate) mod colour;
mod colour_bar;
pub(crate) mod convergence;
pub mod course;
pub(crate) mod figure;
pub(crate) mod flow_bars;
mod font;
pub(crate) mod heat_map;
pub(crate) mod hypertension;
mod legend;
pub(crate) mod modulation;
mod sheet;
mod style;
pub(crate) mod summary;
pub(crate) mod supply_bars;
mod svg;
pub(crate) mod waveforms;

pub use colour::{ZERO, colour};
pub use convergence::{CutLine, convergence};
pub use figure::{DEFAULT_DPI, Figure, SaveOptions};
pub use flow_bars::{VesselFlow, flow_bars};
pub use heat_map::{LikelihoodMatrix, NodeBlock, heat_map};
pub use hypertension::{Histogram, Histograms, hypertension};
pub use modulation::{Boxes, Panel, modulation};
pub(crate) use summary::FRONT;
pub use summary::{DrawnVessel, Projection, Ring, summary};
pub use supply_bars::{OutletSupply, supply_bars};
pub(crate) use svg::units;
pub use waveforms::{ArteryWaveform, waveform_panels};
