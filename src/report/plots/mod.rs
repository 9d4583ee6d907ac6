//! The pictures of a run, as PNG and as SVG: the likelihood matrix and its convergence, the flows of a simulation.
//!
//! The pictures need no font of the system, and the same input gives the same bytes.

mod axis;
mod colour;
mod convergence;
mod dots;
mod drawing;
mod figure;
mod flow_bars;
mod font;
mod heat_map;
mod hypertension;
mod linear;
mod modulation;
mod sheet;

pub use colour::{ZERO, colour};
pub use convergence::convergence;
pub use figure::{DEFAULT_DPI, Figure, check_dpi};
pub use flow_bars::{VesselFlow, flow_bars};
pub use heat_map::{Matrix, heat_map};
pub use hypertension::{Histogram, Histograms, hypertension};
pub use modulation::{Boxes, Panel, modulation};
