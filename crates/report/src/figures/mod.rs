//! The pictures of a run as PNG and SVG: the likelihood matrix and its convergence, flows, whose blood it is, responses to modulation, hypertension.
//!
//! The pictures need no installed font, and the same input gives the same bytes.

pub mod axis;
mod figure;
mod likelihood;
mod modulation;
mod sheet;
mod simulation;
mod summary;

pub(crate) use figure::units;
pub use figure::{DEFAULT_DPI, Figure, SaveOptions};
pub use likelihood::{CutLine, LikelihoodMatrix, NodeBlock, convergence, heat_map, node_blocks, orders};
pub use modulation::{Boxes, Histogram, Histograms, Panel, hypertension, modulation};
pub use simulation::{ArteryWaveform, OutletSupply, VesselFlow, flow_bars, supply_bars, waveform_panels};
pub(crate) use summary::FRONT;
pub use summary::{CoursePoint, DrawnVessel, MOST_RINGS, Projection, Ring, smoothed, summary};

/// Red, green and blue, 0 to 255 (sRGB).
pub type Rgb = [u8; 3];

/// The colour of a zero in the heat map.
pub const ZERO: Rgb = [0xf4, 0xf4, 0xf4];

/// Kept vessels (Okabe & Ito's blue).
pub const KEPT: Rgb = [0x00, 0x72, 0xb2];
/// Pruned vessels (Okabe & Ito's vermilion).
pub const PRUNED: Rgb = [0xd5, 0x5e, 0x00];
/// Flow in the unperturbed network (Okabe & Ito's blue).
pub const UNPERTURBED: Rgb = KEPT;
/// Flow in the perturbed network (Okabe & Ito's orange, lighter than the blue in grey print).
pub const PERTURBED: Rgb = [0xe6, 0x9f, 0x00];
/// Figures of every vessel or node (Okabe & Ito's sky blue).
pub const EACH: Rgb = [0x56, 0xb4, 0xe9];
/// Figures of the whole network (Okabe & Ito's orange).
pub const WHOLE: Rgb = [0xe6, 0x9f, 0x00];
/// Further kinds of one thing: Okabe & Ito's bluish green, reddish purple and yellow, ...
pub const GREEN: Rgb = [0x00, 0x9e, 0x73];
/// ... each other than the colours above, ...
pub const PURPLE: Rgb = [0xcc, 0x79, 0xa7];
/// ... in this order.
pub const YELLOW: Rgb = [0xf0, 0xe4, 0x42];
/// What has no colour of its own.
pub const GREY: Rgb = [0xa9, 0xad, 0xb3];
/// Vessels that are certain, from far to near.
pub const DEPTHS: [Rgb; 2] = [[0xd0, 0xd3, 0xd8], [0x8a, 0x8e, 0x95]];
/// Text, axes and the threshold.
pub const INK: Rgb = [0x1a, 0x1a, 0x1a];
/// Grid lines.
pub const GRID: Rgb = [0xe4, 0xe4, 0xe4];
/// The page.
pub const PAPER: Rgb = [0xff, 0xff, 0xff];

/// The colour map viridis without its lightest ninth, from light to dark in equal steps.
pub const MAP: [Rgb; 9] = [
    [0xb4, 0xde, 0x2c],
    [0x6d, 0xcd, 0x59],
    [0x35, 0xb7, 0x79],
    [0x1f, 0x9e, 0x89],
    [0x26, 0x82, 0x8e],
    [0x31, 0x68, 0x8e],
    [0x3e, 0x4a, 0x89],
    [0x48, 0x28, 0x78],
    [0x44, 0x01, 0x54],
];

/// The colour of the share `t` in [0, 1] of the scale: light green is the lowest, dark violet the highest.
///
/// The map is viridis (Smith & van der Walt 2015), which is perceptually uniform. It is reversed, so that the largest values are the most
/// visible on a light page, and has no lightest ninth, which would be invisible there. Values outside [0, 1] take the nearer end; NaN
/// takes the lowest colour.
pub fn colour(t: f64) -> Rgb {
    let steps = MAP.len() - 1;
    let place = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) * steps as f64 };
    let low = (place as usize).min(steps - 1);
    let share = place - low as f64;
    mixed(MAP[low], MAP[low + 1], share)
}

/// A mixture of two colours: `share` in [0, 1] of the second.
pub fn mixed(a: Rgb, b: Rgb, share: f64) -> Rgb {
    std::array::from_fn(|c| (f64::from(a[c]) + share * (f64::from(b[c]) - f64::from(a[c]))).round() as u8)
}
