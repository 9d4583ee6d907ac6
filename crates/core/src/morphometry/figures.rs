//! What is measured of a network as a whole, and of its arteries and territories.

use std::collections::{BTreeMap, BTreeSet};

use super::vessel_lines::{Stretch, cones};
use super::{MeasuredBifurcation, VesselLine, orders::InletWays};
use crate::network::Fragments;
use crate::support::{Point, bounds, distance, lerp, median};

/// Boxes that are counted: the box around the network is cut in 2^k along its longest side, for these k.
const HALVINGS: [i32; 5] = [2, 3, 4, 5, 6];

/// What is known of a network besides its vessels.
#[derive(Clone, Copy, Default)]
pub struct MeasureContext<'a> {
    /// Per vessel the territory to which its artery leads; none, and none for all by default, elsewhere.
    pub territory: &'a [Option<usize>],
    /// The region to which densities refer, such as the brain.
    pub region: Option<&'a Region>,
}

/// A part of space.
pub struct Region {
    /// Its volume, m³.
    pub volume: f64,
    /// Lines are looked at in steps of this length, m.
    pub step: f64,
    /// Whether a place (m) lies inside.
    pub holds: Box<dyn Fn(Point) -> bool + Send + Sync>,
}

/// Sums and means over vessels, in SI units; no number where there is nothing to measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselTotals {
    /// The length, m.
    pub length: f64,
    /// The volume, m³.
    pub volume: f64,
    /// The lateral surface, m².
    pub surface: f64,
    /// The mean radius over the length, m.
    pub radius: f64,
    /// The mean way from the nearest inlet over the length of those that one leads to, m.
    pub mean_from_inlet: f64,
    /// The longest such way, to any place of a vessel, m.
    pub most_from_inlet: f64,
}

/// Figures of a whole network, in SI units; no number where there is nothing to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkFigures {
    /// Vessels between junctions and ends.
    pub vessels: usize,
    /// Nodes where at least three vessels meet.
    pub bifurcations: usize,
    /// Ends of vessels where no other begins.
    pub ends: usize,
    /// Connected parts.
    pub parts: usize,
    /// Independent loops.
    pub loops: usize,
    /// Of all vessels.
    pub whole: VesselTotals,
    /// The share of the length in the longest part.
    pub longest_part: f64,
    /// The volume of the box around all points, along the axes, m³.
    pub boxed: f64,
    /// The dimension by counting boxes that hold a point of a centerline.
    pub box_dimension: f64,
    /// The median of Murray's exponents, of the bifurcations that have one.
    pub murray: f64,
    /// The length and the volume of vessels per volume of the region, m⁻² and 1, with that volume, m³.
    pub in_region: Option<[f64; 3]>,
    /// By label.
    pub arteries: BTreeMap<String, VesselTotals>,
    /// By territory.
    pub territories: BTreeMap<usize, VesselTotals>,
}

/// Measures the lines of a network; `territory` is that of each line.
pub fn figures_of(
    ways: &InletWays,
    bifurcations: &[MeasuredBifurcation],
    territory: &[Option<usize>],
    region: Option<&Region>,
) -> NetworkFigures {
    let InletWays { lines, degree, .. } = ways;
    let parts = Fragments::over(degree.len(), lines.iter().map(|line| line.ends));
    let mut of_part = BTreeMap::<usize, f64>::new();
    let (mut arteries, mut territories) = (BTreeMap::new(), BTreeMap::new());
    for (line, territory) in lines.iter().zip(territory) {
        *of_part.entry(parts.of_node[line.ends[0]]).or_default() += line.length;
        if !line.label.is_empty() {
            arteries.entry(line.label.clone()).or_insert_with(Vec::new).push(line);
        }
        if let Some(territory) = territory {
            territories.entry(*territory).or_insert_with(Vec::new).push(line);
        }
    }
    let whole = VesselTotals::of(lines, ways);
    let nodes = degree.iter().filter(|degree| **degree > 0).count();
    let exponents: Vec<f64> = bifurcations.iter().filter_map(|b| b.murray).collect();
    NetworkFigures {
        vessels: lines.len(),
        bifurcations: degree.iter().filter(|degree| **degree > 2).count(),
        ends: degree.iter().filter(|degree| **degree == 1).count(),
        parts: of_part.len(),
        loops: lines.len() + of_part.len() - nodes,
        whole,
        longest_part: of_part.values().copied().fold(0.0, f64::max) / whole.length,
        boxed: box_of(lines).map_or(f64::NAN, |[low, high]| (0..3).map(|k| high[k] - low[k]).product()),
        box_dimension: box_dimension(lines),
        murray: median(&exponents).unwrap_or(f64::NAN),
        in_region: region.map(|region| densities(lines, region)),
        arteries: arteries.into_iter().map(|(label, lines)| (label, VesselTotals::of(lines, ways))).collect(),
        territories: territories.into_iter().map(|(row, lines)| (row, VesselTotals::of(lines, ways))).collect(),
    }
}

impl VesselTotals {
    fn of<'a>(lines: impl IntoIterator<Item = &'a VesselLine>, ways: &InletWays) -> Self {
        let (mut sums, mut way, mut most) = ([0.0; 4], [0.0; 2], f64::NAN);
        for line in lines {
            let [volume, surface] = cones(line);
            for (sum, x) in sums.iter_mut().zip([line.length, volume, surface, line.length * line.radius()]) {
                *sum += x;
            }
            let [a, b] = line.ends.map(|node| ways.from_inlet[node]);
            if a.is_finite() {
                // Where two ways meet within a line, each of its points has the shorter one.
                let met = 0.5 * (b - a + line.length);
                way[0] += met * (a + 0.5 * met) + (line.length - met) * (b + 0.5 * (line.length - met));
                way[1] += line.length;
                most = most.max(a + met);
            }
        }
        let [length, volume, surface, weighted] = sums;
        let (radius, mean_from_inlet) = (weighted / length, way[0] / way[1]);
        Self { length, volume, surface, radius, mean_from_inlet, most_from_inlet: most }
    }
}

/// The length and the volume of lines in a region by its volume, and that volume.
fn densities(lines: &[VesselLine], region: &Region) -> [f64; 3] {
    let mut sums = [0.0; 2];
    for line in lines {
        for (points, Stretch { at, radii }) in line.points.windows(2).zip(line.stretches()) {
            let length = at[1] - at[0];
            let steps = (length / region.step).ceil().max(1.0) as usize;
            for step in 0..steps {
                let share = (step as f64 + 0.5) / steps as f64;
                if (region.holds)(lerp(points[0], points[1], share)) {
                    let radius = radii[0] + share * (radii[1] - radii[0]);
                    sums[0] += length / steps as f64;
                    sums[1] += std::f64::consts::PI * radius * radius * length / steps as f64;
                }
            }
        }
    }
    [sums[0] / region.volume, sums[1] / region.volume, region.volume]
}

/// The lowest and the highest corner of the box around all points; none without one.
fn box_of(lines: &[VesselLine]) -> Option<[Point; 2]> {
    Some(bounds(lines.iter().flat_map(|line| line.points.iter().copied()))).filter(|[low, high]| low[0] <= high[0])
}

/// Minus the slope of ln N over ln of the side of a box, where N boxes hold a part of a line.
fn box_dimension(lines: &[VesselLine]) -> f64 {
    let Some([low, high]) = box_of(lines) else { return f64::NAN };
    let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    if side <= 0.0 {
        return f64::NAN;
    }
    let finest = side / 2.0_f64.powi(HALVINGS[HALVINGS.len() - 1]);
    // Boxes of the finest size, along every line in steps that leave none out but at corners.
    let mut held: BTreeSet<[i64; 3]> = BTreeSet::new();
    for line in lines {
        for pair in line.points.windows(2) {
            let steps = (4.0 * distance(pair[0], pair[1]) / finest).ceil().max(1.0) as usize;
            held.extend((0..=steps).map(|i| {
                let p = lerp(pair[0], pair[1], i as f64 / steps as f64);
                // The far face belongs to the last box.
                std::array::from_fn(|k| (((p[k] - low[k]) / finest) as i64).min((1 << HALVINGS[HALVINGS.len() - 1]) - 1))
            }));
        }
    }
    let mut points = Vec::new();
    for k in HALVINGS.into_iter().rev() {
        points.push([f64::from(k) * 2.0_f64.ln(), (held.len() as f64).ln()]);
        held = held.into_iter().map(|cell| cell.map(|x| x / 2)).collect();
    }
    let n = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / n;
    let [x, y] = [mean(0), mean(1)];
    let both: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    both / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}
