//! Breaks a network up as an imperfect extraction would: gaps, lost ends, noise, spurious fragments, points in random order.

use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::check_positions;
use super::damage::{Breaks, SampledVessel, damage, spurious};
use super::truth::{Break, BreakKind, Truth};
use willis_core::error::Result;
use willis_core::network::centerlines::Centerlines;
use willis_core::network::{Fragments, Frame, Network, Role};
use willis_core::support::geometry::Point;
use willis_core::support::numbered::grouped;
use willis_core::support::random::{self, stream};

/// The extraction before its points are shuffled and get noise.
#[derive(Default)]
struct OrderedExtraction {
    /// The points; those of the vessels first.
    points: Vec<TruePoint>,
    /// Pairs of linked points.
    links: Vec<[usize; 2]>,
    /// The missing stretches, with the rows of points as their ids.
    gaps: Vec<Break>,
    /// Per node the row of its point, where a vessel reaches it.
    at_node: Vec<Option<usize>>,
}

/// A point at its true place.
struct TruePoint {
    /// m.
    position: Point,
    /// m.
    radius: f64,
    /// The row of its vessel; `None` where it is spurious.
    vessel: Option<usize>,
}

impl OrderedExtraction {
    /// Adds the pieces of a vessel and returns the first and last point of each. Vessels that meet at a node share its point.
    fn add_vessel(&mut self, row: usize, vessel: &SampledVessel, ends: [usize; 2]) -> Vec<[usize; 2]> {
        let mut pieces = Vec::new();
        for [first, last] in &vessel.pieces {
            let mut rows = Vec::new();
            for at in *first..=*last {
                let (position, radius) = vessel.points[at];
                let node = (0..2).find(|end| at == [0, vessel.last()][*end]).map(|end| ends[end]);
                let point = node.and_then(|node| self.at_node[node]).unwrap_or_else(|| {
                    self.points.push(TruePoint { position, radius, vessel: Some(row) });
                    self.points.len() - 1
                });
                if let Some(node) = node {
                    self.at_node[node] = Some(point);
                }
                if radius > self.points[point].radius {
                    (self.points[point].radius, self.points[point].vessel) = (radius, Some(row));
                }
                rows.push(point);
            }
            self.links.extend(rows.windows(2).map(|pair| [pair[0], pair[1]]));
            pieces.push([rows[0], rows[rows.len() - 1]]);
        }
        pieces
    }

    /// Adds the missing stretches of a vessel that have a point at both ends. `pieces` are the first and last points of its pieces.
    fn add_gaps(&mut self, (row, label): (usize, &String), vessel: &SampledVessel, pieces: &[[usize; 2]], ends: [usize; 2]) {
        let nodes = ends.map(|node| self.at_node[node]);
        let (Some(first), Some(last)) = (vessel.pieces.first(), vessel.pieces.last()) else { return };
        let mut add = |kind, ends: [usize; 2], stretch: [usize; 2]| {
            let stretch = stretch.map(|at| at as f64 * vessel.step);
            self.gaps.push(Break { ids: ends.map(|point| point as u64), kind, vessel: row, label: label.clone(), stretch });
        };
        if let (Some(node), true) = (nodes[0], first[0] > 0) {
            add(BreakKind::Junction, [node, pieces[0][0]], [0, first[0]]);
        }
        for (steps, points) in vessel.pieces.windows(2).zip(pieces.windows(2)) {
            add(BreakKind::Vessel, [points[0][1], points[1][0]], [steps[0][1], steps[1][0]]);
        }
        if let (Some(node), true) = (nodes[1], last[1] < vessel.last()) {
            add(BreakKind::Junction, [node, pieces[pieces.len() - 1][1]], [last[1], vessel.last()]);
        }
    }

    /// The connected points as lists, in the order of their first points.
    fn fragments(&self) -> Vec<Vec<usize>> {
        let Fragments { of_node, count } = Fragments::over(self.points.len(), self.links.iter().copied());
        grouped(count, of_node.into_iter().zip(0..))
    }

    /// The shuffled, noisy centerlines, and for each point its row in them.
    fn centerlines(&self, frame: Frame, params: &Breaks, rng: &mut impl Rng) -> (Centerlines, Vec<usize>) {
        let mut neighbours = grouped(self.points.len(), self.links.iter().flat_map(|[a, b]| [(*a, *b), (*b, *a)]));
        let mut fragments = self.fragments();
        fragments.shuffle(rng);
        let mut lines = Centerlines { frame, ..Centerlines::default() };
        let mut number = vec![usize::MAX; self.points.len()];
        let mut parent = vec![usize::MAX; self.points.len()];
        for (strand, fragment) in fragments.iter().enumerate() {
            let loose: Vec<usize> = fragment.iter().copied().filter(|point| neighbours[*point].len() < 2).collect();
            let roots = if loose.is_empty() { fragment } else { &loose };
            let mut stack = vec![(roots[rng.random_range(0..roots.len())], usize::MAX)];
            let bias = params.radius_bias * rng.sample::<f64, _>(StandardNormal);
            while let Some((point, before)) = stack.pop() {
                if number[point] != usize::MAX {
                    continue;
                }
                (number[point], parent[point]) = (lines.points.len(), before);
                if before != usize::MAX {
                    lines.links.push([number[before] as u32, number[point] as u32]);
                }
                let TruePoint { position, radius, .. } = &self.points[point];
                let mut noise = || rng.sample::<f64, _>(StandardNormal);
                let jitter = params.jitter * params.spacing / 3.0_f64.sqrt();
                let place = [0, 1, 2].map(|axis| position[axis] + jitter * noise());
                let radius = radius * (bias + params.radius_noise * noise()).exp();
                lines.add_point(place, radius, lines.points.len() as u64 + 1, strand as u32);
                neighbours[point].shuffle(rng);
                stack.extend(neighbours[point].iter().map(|next| (*next, point)));
            }
        }
        let closing = self.links.iter().filter(|[a, b]| parent[*a] != *b && parent[*b] != *a);
        lines.links.extend(closing.map(|link| link.map(|point| number[point] as u32)));
        (lines, number)
    }
}

/// Breaks a network up as an extraction from an image would: missing stretches, lost ends, displaced points, noisy radii, spurious
/// fragments.
///
/// Points are numbered from 1, fragment by fragment in random order, each from a random loose end. Every point except the first of a
/// fragment is linked to an earlier one; the links that close a loop come last. The seed alone decides: two calls give the same bits.
///
/// # Errors
///
/// `params` that do not validate, a node without position.
pub fn break_up(network: &Network, params: &Breaks) -> Result<(Centerlines, Truth)> {
    params.validate()?;
    check_positions(network)?;
    let mut rng = stream(params.seed, random::DAMAGE);
    let vessels = damage(network, params, &mut rng);
    Ok(extract(network, &vessels, params, &mut rng))
}

/// The shuffled, noisy centerlines of damaged vessels with spurious fragments, and the true answer.
pub(crate) fn extract(network: &Network, vessels: &[SampledVessel], params: &Breaks, rng: &mut impl Rng) -> (Centerlines, Truth) {
    let mut ordered = OrderedExtraction { at_node: vec![None; network.node_count()], ..OrderedExtraction::default() };
    let mut pieces = Vec::new();
    for (row, vessel) in vessels.iter().enumerate() {
        pieces.push(ordered.add_vessel(row, vessel, network.ends(row)));
    }
    for (row, vessel) in vessels.iter().enumerate() {
        ordered.add_gaps((row, &network.vessel(row).label), vessel, &pieces[row], network.ends(row));
    }
    let true_fragments = ordered.fragments().len();
    let wanted = (params.spurious * true_fragments as f64).round() as usize;
    let avoided = if wanted > 0 { vessels } else { &[] };
    let lumens: Vec<_> = avoided.iter().flat_map(|vessel| vessel.points.iter().copied()).collect();
    for fragment in spurious(&lumens, wanted, params, rng) {
        let first = ordered.points.len();
        ordered.points.extend(fragment.into_iter().map(|(position, radius)| TruePoint { position, radius, vessel: None }));
        ordered.links.extend((first + 1..ordered.points.len()).map(|point| [point - 1, point]));
    }
    let inlets = (0..network.node_count()).filter(|row| network.node(*row).role == Some(Role::Inlet));
    let inlets: Vec<usize> = inlets.filter_map(|row| ordered.at_node[row]).collect();
    let (lines, number) = ordered.centerlines(network.frame, params, rng);

    let mut truth = Truth {
        vessels: network.vessels().map(|(_, vessel)| vessel.label.clone()).collect(),
        lost: (0..vessels.len()).filter(|row| vessels[*row].pieces.is_empty()).collect(),
        inlets: inlets.into_iter().map(|point| lines.ids[number[point]]).collect(),
        spurious: vec![false; lines.strand.iter().max().map_or(0, |last| *last as usize + 1)],
        points: vec![None; lines.points.len()],
        breaks: ordered.gaps,
    };
    for gap in &mut truth.breaks {
        gap.ids = gap.ids.map(|point| lines.ids[number[point as usize]]);
    }
    for (point, true_point) in ordered.points.iter().enumerate() {
        truth.points[number[point]] = true_point.vessel;
        truth.spurious[lines.strand[number[point]] as usize] = true_point.vessel.is_none();
    }
    (lines, truth)
}
