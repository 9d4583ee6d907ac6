//! The columns of tables of what is measured, in the units in which files have it: vessels.csv, bifurcations.csv, ends.csv and subjects.csv.

use super::{MeasuredBifurcation, MeasuredEnd, MeasuredVessel, NetworkFigures, VesselTotals};
use crate::network::millimetres;

/// A column: its name, and the figure of a row; what is not finite leaves its cell empty.
pub type MeasuredColumn<T> = (&'static str, fn(&T) -> f64);

const MM2: f64 = 1e6;
const MM3: f64 = 1e9;

/// Of a vessel.
pub const OF_VESSEL: [MeasuredColumn<MeasuredVessel>; 17] = [
    ("length_mm", |of| millimetres(of.line.length)),
    ("chord_mm", |of| millimetres(of.shape.chord)),
    ("radius_mm", |of| millimetres(of.shape.radius)),
    ("radius_min_mm", |of| millimetres(of.shape.least_radius)),
    ("taper", |of| of.shape.taper),
    ("volume_mm3", |of| MM3 * of.shape.volume),
    ("surface_mm2", |of| MM2 * of.shape.surface),
    ("distance_metric", |of| of.shape.distance_metric),
    ("inflection_count_metric", |of| of.shape.inflection_count_metric),
    ("sum_of_angles_rad_per_mm", |of| 1e-3 * of.shape.sum_of_angles_metric),
    ("curvature_per_mm", |of| 1e-3 * of.shape.curvature),
    ("torsion_per_mm", |of| 1e-3 * of.shape.torsion),
    ("generation", |of| of.generation.map_or(f64::NAN, |n| n as f64)),
    ("strahler", |of| of.strahler.map_or(f64::NAN, |n| n as f64)),
    ("strahler_by_diameter", |of| of.diameter_strahler.map_or(f64::NAN, |n| n as f64)),
    ("from_inlet_mm", |of| millimetres(of.from_inlet)),
    ("probability", |of| of.probability),
];

/// Of a bifurcation.
pub const OF_BIFURCATION: [MeasuredColumn<MeasuredBifurcation>; 10] = [
    ("radius_parent_mm", |of| millimetres(of.radii[0])),
    ("radius_child_1_mm", |of| millimetres(of.radii[1])),
    ("radius_child_2_mm", |of| millimetres(of.radii[2])),
    ("angle_deg", |of| of.angle.to_degrees()),
    ("bend_child_1_deg", |of| of.bends[0].to_degrees()),
    ("bend_child_2_deg", |of| of.bends[1].to_degrees()),
    ("elevation_deg", |of| of.elevation.to_degrees()),
    ("asymmetry", |of| of.asymmetry),
    ("area_ratio", |of| of.area_ratio),
    ("murray_exponent", |of| of.murray.unwrap_or(f64::NAN)),
];

/// Of an end.
pub const OF_END: [MeasuredColumn<MeasuredEnd>; 2] =
    [("radius_mm", |of| millimetres(of.radius)), ("from_inlet_mm", |of| millimetres(of.from_inlet))];

/// Of a whole network.
pub const OF_NETWORK: [MeasuredColumn<NetworkFigures>; 17] = [
    ("vessels", |of| of.vessels as f64),
    ("bifurcations", |of| of.bifurcations as f64),
    ("ends", |of| of.ends as f64),
    ("parts", |of| of.parts as f64),
    ("loops", |of| of.loops as f64),
    ("length_mm", |of| millimetres(of.whole.length)),
    ("longest_part", |of| of.longest_part),
    ("volume_mm3", |of| MM3 * of.whole.volume),
    ("surface_mm2", |of| MM2 * of.whole.surface),
    ("radius_mm", |of| millimetres(of.whole.radius)),
    ("box_mm3", |of| MM3 * of.boxed),
    ("length_density_per_mm2", |of| of.whole.length / of.boxed / MM2),
    ("volume_density", |of| of.whole.volume / of.boxed),
    ("box_dimension", |of| of.box_dimension),
    ("from_inlet_mean_mm", |of| millimetres(of.whole.mean_from_inlet)),
    ("from_inlet_max_mm", |of| millimetres(of.whole.most_from_inlet)),
    ("murray_exponent_median", |of| of.murray),
];

/// Of a network in a region ([`NetworkFigures::in_region`]).
pub const IN_REGION: [MeasuredColumn<[f64; 3]>; 3] = [
    ("brain_mm3", |[_, _, region]| MM3 * region),
    ("length_density_in_brain_per_mm2", |[length, _, _]| length / MM2),
    ("volume_density_in_brain", |[_, volume, _]| *volume),
];

/// Of an artery or a territory, with its name before.
pub const OF_TOTALS: [MeasuredColumn<VesselTotals>; 4] = [
    ("length_mm", |of| millimetres(of.length)),
    ("volume_mm3", |of| MM3 * of.volume),
    ("diameter_mm", |of| 2.0 * millimetres(of.radius)),
    ("from_inlet_mean_mm", |of| millimetres(of.mean_from_inlet)),
];
