//! Centerlines of a mask: smooth lines along the skeleton's branches, with the radius of the lumen around them; which voxel of the skeleton each voxel of
//! the lumen belongs to, and with what volume.

use std::{cmp::Reverse, collections::BinaryHeap, f64::consts::PI};

use super::skeleton::{Branch, Skeleton, skeleton};
use super::{Cavities, Foreground, Mask, distances, indices_of, neighbours, row_at, steps_of, thin};
use willis_core::network::{Centerlines, Fragments, metres, walks::other};
use willis_core::support::arc_lengths::{arc_lengths, in_direction};
use willis_core::support::geometry::{Point, distance, dot, lerp, norm_squared, sub, unit};
use willis_core::support::{numbered::grouped, ties::in_steps};

/// How far lines are smoothed: the standard deviation of the weights along them, in voxels.
const SMOOTH: f64 = 2.5;
/// How far smoothing moves a point: half the diagonal of a voxel, in voxels. The vessel passes through the voxel.
const FARTHEST: f64 = 0.866;
/// A radius by area is at most so many distances to the background. On a stretch that is shorter than wide, at a junction, length says
/// little.
const WIDEST: f64 = 1.5;
/// Shares of lengths are compared in steps of 1/2 to this power: an oblique frame has the voxels of a NIfTI file to seven digits.
const ROUNDING: u32 = 20;
/// The weights reach this many standard deviations.
const REACH: f64 = 3.0;

/// What the radius of a centerline point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RadiusFrom {
    /// That of the circle with the area of the lumen's cross-section: the volume of the voxels nearest to a stretch over its length, those
    /// at the wall by the part of them that is inside where that is known.
    #[default]
    Area,
    /// The distance from the skeleton to the nearest voxel outside.
    Distance,
    /// The radius of the largest sphere inside: that distance, less half a voxel.
    Inscribed,
}

impl RadiusFrom {
    /// The word for it.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["area", "distance", "inscribed"][self as usize]
    }
}

/// Centerlines made of a mask.
#[derive(Debug, Clone)]
pub struct Traced {
    /// The centerlines, m, in the scanner's frame. Labels are the names or numbers of the classes where the mask has several.
    pub lines: Centerlines,
    /// The voxels that they were traced in.
    pub lumen: Foreground,
    /// Spurs that were removed.
    pub spurs: usize,
    /// Specks: parts of the mask too small for a line, or with one that is shorter than they are wide.
    pub specks: usize,
    /// The length of the lines of specks, m.
    pub speck_length: f64,
}

/// The centerlines of a mask; `None` for a mask without vessels, or one too large to index. Unless cavities are kept, specks are
/// left out; to fill cavities is a step before ([`Mask::fill_cavities`]).
pub fn trace(mask: &Mask, radius_from: RadiusFrom, cavities: Cavities) -> Option<Traced> {
    let vessels = Foreground::of(mask)?;
    let thinned = thin(&vessels);
    // The distances of the skeleton's voxels alone; the others are as many as the mask is large.
    let all = distances(&vessels, mask.spacing());
    let depths = thinned.iter().map(|row| all[*row as usize]).collect();
    drop(all);
    let mut graph = skeleton(&vessels, &thinned);
    let tracer = Tracer { mask, vessels: &vessels, thinned: &thinned, depths };
    let spurs = graph.prune(|graph, branch, junction| tracer.reach(graph, branch, junction));
    let (specks, speck_length) = if cavities == Cavities::Fill { tracer.leave_out_specks(&mut graph) } else { (0, 0.0) };
    let lines = tracer.lines(&graph, radius_from);
    Some(Traced { lines, lumen: vessels, spurs, specks: graph.specks + specks, speck_length })
}

struct Tracer<'a> {
    mask: &'a Mask,
    vessels: &'a Foreground,
    /// The skeleton's voxels, rising, and the distance of each to the background.
    thinned: &'a [u32],
    depths: Vec<f64>,
}

/// A branch in space: one point for each voxel, the nodes first and last. Lengths in mm.
struct TracedLine {
    points: Vec<Point>,
    /// The length of the stretch that each point stands for.
    lengths: Vec<f64>,
    /// The volume of the lumen nearest to it, mm³.
    volumes: Vec<f64>,
    /// The distance to the background.
    depths: Vec<f64>,
}

/// Where a voxel of the graph is.
#[derive(Debug, Clone, Copy)]
enum LumenPlace {
    Node(usize),
    /// A branch and one of its points.
    Point(usize, usize),
}

impl Tracer<'_> {
    /// The side of a cube as large as a voxel, mm.
    fn step(&self) -> f64 {
        self.mask.voxel_volume().cbrt()
    }

    fn at(&self, voxel: u32) -> Point {
        self.mask.position(self.vessels.voxel(voxel as usize).map(|index| index as f64))
    }

    fn class(&self, voxel: u32) -> u8 {
        self.mask.classes[row_at(self.mask.shape, self.vessels.voxel(voxel as usize))]
    }

    fn depth(&self, voxel: u32) -> f64 {
        let depth = self.thinned.binary_search(&voxel).map_or(0.0, |at| self.depths[at]);
        // A mask without any background says nothing about widths.
        if depth.is_finite() { depth } else { 0.0 }
    }

    /// The middle of a node.
    fn middle(&self, node: &[u32]) -> Point {
        let sum = node
            .iter()
            .map(|voxel| self.vessels.voxel(*voxel as usize))
            .fold([0; 3], |sum, at| [0, 1, 2].map(|k| sum[k] + at[k]));
        self.mask.position(sum.map(|total| total as f64 / node.len() as f64))
    }

    fn widest(&self, node: &[u32]) -> f64 {
        node.iter().map(|voxel| self.depth(*voxel)).fold(0.0, f64::max)
    }

    /// Leaves out parts whose lines are together shorter than the part is wide; how many, and their length, m.
    fn leave_out_specks(&self, graph: &mut Skeleton) -> (usize, f64) {
        let parts = Fragments::over(graph.nodes.len(), graph.branches.iter().map(|branch| branch.ends));
        let mut measured = vec![(0.0, 0.0_f64); parts.count];
        for branch in &graph.branches {
            let line = self.line(graph, branch);
            let (length, width) = &mut measured[parts.of_node[branch.ends[0]]];
            *length += line.points.windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
            *width = line.depths.iter().fold(*width, |width, depth| width.max(2.0 * depth));
        }
        // On a lattice both are often equal, but for rounding.
        let is_speck = |(length, width): &(f64, f64)| in_steps(length / width, ROUNDING) < 1.0;
        let specks: Vec<f64> = measured.iter().filter(|part| is_speck(part)).map(|(length, _)| *length).collect();
        let gone: Vec<bool> = graph.branches.iter().map(|branch| is_speck(&measured[parts.of_node[branch.ends[0]]])).collect();
        graph.remove(&gone);
        // The sum of no lengths at all is -0, which would be printed so.
        (specks.len(), metres(specks.iter().sum::<f64>().abs()))
    }

    /// How far the tip of a branch reaches beyond the wall of the vessel that it leaves at a junction, in diameters of its tip.
    fn reach(&self, graph: &Skeleton, branch: &Branch, junction: usize) -> f64 {
        let tip = other(branch.ends, junction);
        let line = in_direction(self.points(graph, branch), branch.ends[0] == junction);
        let length: f64 = line.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
        let own = self.widest(&graph.nodes[tip]);
        in_steps((length + own - self.widest(&graph.nodes[junction])) / (2.0 * own), ROUNDING)
    }

    fn lines(&self, graph: &Skeleton, radius_from: RadiusFrom) -> Centerlines {
        let mut lines: Vec<TracedLine> = graph.branches.iter().map(|branch| self.line(graph, branch)).collect();
        let step = self.step();
        for line in &mut lines {
            let smoothed = smooth(&line.points);
            line.points = line.points.iter().zip(smoothed).map(|(from, to)| self.held(*from, to)).collect();
        }
        let degrees = graph.degrees();
        let at_border = self.fill(graph, &degrees, &mut lines);
        let mut out = Centerlines { frame: self.mask.frame, ..Centerlines::default() };
        let mut classes = self.mask.classes.iter().filter(|class| **class > 0);
        let first = classes.next();
        let several = classes.any(|class| Some(class) != first);
        let mut row_of = vec![u32::MAX; graph.nodes.len()];
        for (strand, (branch, line)) in graph.branches.iter().zip(&lines).enumerate() {
            let radii = match radius_from {
                RadiusFrom::Area => line.radii(step),
                RadiusFrom::Distance => line.depths.clone(),
                RadiusFrom::Inscribed => line.depths.iter().map(|depth| depth - step / 2.0).collect(),
            };
            let mut before: Option<u32> = None;
            let last = line.points.len() - 1;
            for (n, (point, radius)) in line.points.iter().zip(radii).enumerate() {
                let node = if n == 0 { Some(branch.ends[0]) } else { (n == last).then_some(branch.ends[1]) };
                let known = node.map(|node| row_of[node]).filter(|row| *row != u32::MAX);
                let row = known.unwrap_or_else(|| {
                    let id = out.points.len() as u64;
                    out.add_point(point.map(metres), metres(radius), id, strand as u32)
                });
                if let Some(node) = node {
                    row_of[node] = row;
                    out.at_border.extend(at_border[node].then_some(out.ids[row as usize]));
                    out.radii[row as usize] = out.radii[row as usize].max(metres(radius));
                }
                if let Some(before) = before {
                    let voxel = branch.voxels.get((n - 1).min(branch.voxels.len().saturating_sub(1)));
                    let voxel = voxel.copied().unwrap_or(graph.nodes[branch.ends[1]][0]);
                    let class = self.class(voxel);
                    let class = self.mask.names.get(&class).cloned().unwrap_or_else(|| class.to_string());
                    out.add_link([before, row], if several { &class } else { "" });
                }
                before = Some(row);
            }
        }
        out
    }

    /// A smoothed point, no further from where it was than [`FARTHEST`].
    fn held(&self, from: Point, to: Point) -> Point {
        let by = sub(to, from);
        let along = |axis: usize| {
            let column = steps_of(&self.mask.affine)[axis];
            dot(by, column) / dot(column, column)
        };
        let voxels = (0..3).map(|axis| along(axis).powi(2)).sum::<f64>().sqrt();
        if voxels > FARTHEST { lerp(from, to, FARTHEST / voxels) } else { to }
    }

    fn points(&self, graph: &Skeleton, branch: &Branch) -> Vec<Point> {
        let [first, last] = branch.ends.map(|end| self.middle(&graph.nodes[end]));
        std::iter::once(first).chain(branch.voxels.iter().map(|v| self.at(*v))).chain([last]).collect()
    }

    fn line(&self, graph: &Skeleton, branch: &Branch) -> TracedLine {
        let [first, last] = branch.ends.map(|end| self.widest(&graph.nodes[end]));
        let depths = std::iter::once(first).chain(branch.voxels.iter().map(|v| self.depth(*v))).chain([last]);
        let count = branch.voxels.len() + 2;
        TracedLine {
            points: self.points(graph, branch),
            lengths: vec![0.0; count],
            volumes: vec![0.0; count],
            depths: depths.collect(),
        }
    }

    /// Gives each point the volume of the lumen around it and the length of its stretch, at a free end to the tip of the lumen. Draws ends
    /// at the border of the image out to it.
    /// Returns whether each node is a free end whose lumen reaches the border of the image.
    fn fill(&self, graph: &Skeleton, degrees: &[usize], lines: &mut [TracedLine]) -> Vec<bool> {
        let mut at_border = vec![false; graph.nodes.len()];
        // Every voxel of the graph with where it is: a node, or a point of a branch.
        let mut seeds: Vec<(u32, LumenPlace)> = Vec::new();
        for (node, voxels) in graph.nodes.iter().enumerate().filter(|(node, _)| degrees[*node] > 0) {
            seeds.extend(voxels.iter().map(|voxel| (*voxel, LumenPlace::Node(node))));
        }
        for (row, branch) in graph.branches.iter().enumerate() {
            seeds.extend(branch.voxels.iter().enumerate().map(|(n, voxel)| (*voxel, LumenPlace::Point(row, n + 1))));
        }
        seeds.sort_unstable_by_key(|(voxel, _)| *voxel);
        seeds.dedup_by_key(|(voxel, _)| *voxel);
        let voxels: Vec<u32> = seeds.iter().map(|(voxel, _)| *voxel).collect();
        let nearest = nearest_seeds(self.mask, self.vessels, &voxels);
        let mut of_node = vec![0.0; graph.nodes.len()];
        // The lumen around a free end, beyond it along the line.
        let mut beyond = vec![0.0; graph.nodes.len()];
        let mut direction: Vec<Option<(Point, Point)>> = vec![None; graph.nodes.len()];
        for (branch, line) in graph.branches.iter().zip(&*lines) {
            let n = line.points.len();
            let far = |at: usize| line.points[at.min(n - 1)];
            let span = (2.0 * SMOOTH) as usize + 1;
            let ends = [(far(0), far(span)), (far(n - 1), far((n - 1).saturating_sub(span)))];
            for (end, (tip, inside)) in branch.ends.into_iter().zip(ends) {
                if degrees[end] == 1 {
                    direction[end] = Some((tip, unit(sub(tip, inside))));
                }
            }
        }
        for (place, seed, volume) in volumes(self.mask, self.vessels, &voxels, &nearest) {
            match seeds[seed as usize].1 {
                LumenPlace::Point(row, point) => lines[row].volumes[point] += volume,
                LumenPlace::Node(node) => {
                    // A voxel that the end divides lies in part beyond it.
                    let voxel = self.vessels.voxel_at(place);
                    let at = self.mask.position(voxel.map(|index| index as f64));
                    let share = direction[node].map_or(0.0, |(tip, to)| {
                        let width: f64 = steps_of(&self.mask.affine).map(|step| dot(to, step).abs()).iter().sum();
                        (dot(sub(at, tip), to) / width + 0.5).clamp(0.0, 1.0)
                    });
                    let is_border =
                        (0..3).any(|axis| [false, true].iter().any(|forward| self.vessels.is_last(voxel, axis, *forward)));
                    at_border[node] |= is_border && self.vessels.contains(place) && direction[node].is_some();
                    beyond[node] += volume * share;
                    of_node[node] += volume * (1.0 - share);
                }
            }
        }
        lines.iter_mut().for_each(TracedLine::measure);
        // The lumen at a junction belongs to the vessels that meet there, in the shares of their cross-sections.
        let share = |row: usize, is_last: bool| {
            let depths = &lines[row].depths;
            let at = (depths.len() / 2).min(4);
            let depth = depths[if is_last { depths.len() - 1 - at } else { at }];
            (graph.branches[row].ends[usize::from(is_last)], (row, is_last, (depth * depth).max(f64::MIN_POSITIVE)))
        };
        let ends = (0..lines.len()).flat_map(|row| [share(row, false), share(row, true)]);
        for (node, shares) in grouped(graph.nodes.len(), ends).iter().enumerate() {
            let all: f64 = shares.iter().map(|(.., share)| share).sum();
            for (row, is_last, share) in shares {
                let line = &mut lines[*row];
                let end = if *is_last { line.volumes.len() - 1 } else { 0 };
                line.volumes[end] += (of_node[node] + beyond[node]) * share / all;
            }
        }
        let step = self.step();
        for (branch, line) in graph.branches.iter().zip(lines) {
            for (is_last, end) in [(false, branch.ends[0]), (true, branch.ends[1])] {
                let Some((tip, to)) = direction[end] else { continue };
                let n = line.points.len();
                // As far as the volume beyond the end goes in a lumen as wide as behind it.
                let behind: Vec<usize> = if is_last { (0..n - 1).rev().collect() } else { (1..n).collect() };
                let near = &behind[..behind.len().min((2.0 * SMOOTH) as usize + 1)];
                let (volume, length) = near.iter().fold((0.0, 0.0), |(v, l), at| (v + line.volumes[*at], l + line.lengths[*at]));
                let area = if volume > 0.0 { volume / length } else { PI * step * step / 4.0 };
                let at = if is_last { n - 1 } else { 0 };
                let out = beyond[end] / area;
                line.lengths[at] += out;
                if at_border[end] {
                    // Where the vessel goes on outside the image, so does its line up to there.
                    line.points[at] = [0, 1, 2].map(|axis| tip[axis] + out * to[axis]);
                }
            }
        }
        at_border
    }
}

impl TracedLine {
    /// The length that each point stands for: half of the way to its neighbours.
    fn measure(&mut self) {
        for n in 1..self.points.len() {
            let half = distance(self.points[n - 1], self.points[n]) / 2.0;
            self.lengths[n - 1] += half;
            self.lengths[n] += half;
        }
    }

    /// The radius of a circle with the area of the lumen: weighted volume over weighted length, the weights as wide as the lumen.
    fn radii(&self, step: f64) -> Vec<f64> {
        let at = arc_lengths(self.points.iter().copied());
        let n = self.points.len();
        (0..n)
            .map(|here| {
                let wide = self.depths[here].max(2.0 * step);
                let (mut volume, mut length) = (0.0, 0.0);
                let mut add = |other: usize| {
                    let apart = (at[other] - at[here]) / wide;
                    let weight = (-0.5 * apart * apart).exp();
                    volume += weight * self.volumes[other];
                    length += weight * self.lengths[other];
                    apart.abs() < REACH
                };
                let _ = (here..n).all(&mut add);
                let _ = (0..here).rev().all(&mut add);
                let most = if self.depths[here] > 0.0 { WIDEST * self.depths[here] } else { f64::INFINITY };
                (volume / length / PI).sqrt().min(most)
            })
            .collect()
    }
}

/// The line with each point moved to the weighted mean of those around it; beyond an end the line is turned about it, so that ends stay.
///
/// The weights are twice a Gaussian less the Gaussian of two such smoothings, so that curves up to the third order stay where they are: a
/// mean alone cuts bends short.
fn smooth(points: &[Point]) -> Vec<Point> {
    let n = points.len() as isize;
    // On a short line no further than it is long, so that the turned line is as long as the weights reach.
    let once = SMOOTH.min((n - 1).max(1) as f64 / (REACH * std::f64::consts::SQRT_2));
    let twice = once * std::f64::consts::SQRT_2;
    let reach = (REACH * twice) as isize;
    let gaussian = |k: isize, spread: f64| (-0.5 * (k as f64 / spread).powi(2)).exp() / spread;
    let weights: Vec<f64> = (-reach..=reach).map(|k| 2.0 * gaussian(k, once) - gaussian(k, twice)).collect();
    let total: f64 = weights.iter().sum();
    let at = |k: isize| {
        let about = k.clamp(0, n - 1);
        let (end, other) = (points[about as usize], points[(2 * about - k).clamp(0, n - 1) as usize]);
        if k == about { end } else { [0, 1, 2].map(|axis| 2.0 * end[axis] - other[axis]) }
    };
    (0..n)
        .map(|here| {
            if here == 0 || here == n - 1 {
                return points[here as usize];
            }
            let mut sum = [0.0; 3];
            for (k, weight) in (here - reach..).zip(&weights) {
                let point = at(k);
                (0..3).for_each(|axis| sum[axis] += weight * point[axis]);
            }
            sum.map(|x| x / total)
        })
        .collect()
}

/// A voxel that belongs to no seed.
const NONE: u32 = u32::MAX;
/// The bit of a voxel whose seed is settled.
const SETTLED: u32 = 1 << 31;

/// Between voxels given by their indices, mm².
fn squared_distance(steps: [Point; 3], at: [f64; 3], from: [f64; 3]) -> f64 {
    let by = [0, 1, 2].map(|axis| at[axis] - from[axis]);
    norm_squared([0, 1, 2].map(|row| (0..3).map(|axis| steps[axis][row] * by[axis]).sum()))
}

/// For each voxel of the vessels the seed that is nearest, among those that its neighbours belong to: the row in `seeds`; [`NONE`] where
/// no seed is in the same component. Ties go to the earlier seed.
fn nearest_seeds(mask: &Mask, vessels: &Foreground, seeds: &[u32]) -> Vec<u32> {
    let steps = steps_of(&mask.affine);
    let around = neighbours(vessels.strides());
    let indices = |place: usize| vessels.voxel_at(place).map(|index| index as f64);
    let seeds: Vec<(usize, [f64; 3])> =
        seeds.iter().map(|row| vessels.place(*row as usize)).map(|place| (place, indices(place))).collect();
    let apart = |at: [f64; 3], seed: u32| squared_distance(steps, at, seeds[seed as usize].1);
    // The nearest seed so far of each voxel, or the settled one.
    let mut best = vec![NONE; vessels.count()];
    // Lengths are not negative, so that their bits are in their order.
    let mut open: BinaryHeap<Reverse<(u64, u32, u32)>> =
        (0_u32..).zip(&seeds).map(|(seed, (place, _))| Reverse((0, seed, *place as u32))).collect();
    while let Some(Reverse((_, seed, place))) = open.pop() {
        let place = place as usize;
        let Some(voxel) = vessels.row(place).filter(|row| best[*row] == NONE || best[*row] & SETTLED == 0) else { continue };
        best[voxel] = seed | SETTLED;
        let here = indices(place);
        for (step, by) in around {
            let next = (place as isize + step) as usize;
            let Some(row) = vessels.row(next) else { continue };
            let known = best[row];
            if known == seed || (known != NONE && known & SETTLED != 0) {
                continue;
            }
            let at = [0, 1, 2].map(|axis| here[axis] + f64::from(by[axis]));
            let nearer = (apart(at, seed).to_bits(), seed);
            if known == NONE || nearer < (apart(at, known).to_bits(), known) {
                best[row] = seed;
                open.push(Reverse((nearer.0, seed, next as u32)));
            }
        }
    }
    best.iter_mut().filter(|seed| **seed != NONE).for_each(|seed| *seed &= !SETTLED);
    best
}

/// The volume of the lumen in pieces: the place of each voxel, the seed it belongs to, and how much of it is inside, mm³. A piece may
/// take away from one before it: a voxel of a vessel counts as a whole first, then less what its wall leaves outside. A voxel beside a
/// vessel belongs to the nearest of the seeds that its neighbours belong to.
fn volumes(mask: &Mask, vessels: &Foreground, seeds: &[u32], nearest: &[u32]) -> impl Iterator<Item = (usize, u32, f64)> {
    let (cell, steps, around) = (mask.voxel_volume(), steps_of(&mask.affine), neighbours(vessels.strides()));
    let indices = |place: usize| vessels.voxel_at(place).map(|index| index as f64);
    let at: Vec<[f64; 3]> = seeds.iter().map(|row| indices(vessels.place(*row as usize))).collect();
    let nearest_beside = move |place: usize| {
        let touched = around.iter().filter_map(|(step, _)| vessels.row((place as isize + step) as usize)).map(|row| nearest[row]);
        let apart = |seed: u32| squared_distance(steps, indices(place), at[seed as usize]);
        touched.filter(|seed| *seed != NONE).map(|seed| (apart(seed).to_bits(), seed)).min().map(|(_, seed)| seed)
    };
    let of_wall = move |(voxel, part): &(u32, f32)| {
        let place = vessels.place_of(indices_of(mask.shape, *voxel as usize))?;
        let part = f64::from(*part);
        match vessels.row(place) {
            Some(row) => Some((place, nearest[row], cell * (part - 1.0))),
            None => nearest_beside(place).map(|seed| (place, seed, cell * part)),
        }
    };
    let walls = mask.walls.iter().flat_map(|walls| &walls.voxels).filter_map(of_wall);
    let whole = vessels.places().zip(nearest).map(move |(place, seed)| (place, *seed, cell));
    whole.chain(walls).filter(|(_, seed, _)| *seed != NONE)
}
