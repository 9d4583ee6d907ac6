//! Breaks a network up as an imperfect extraction would: gaps, lost ends, noise, spurious fragments, points in random order. Or with gaps as
//! the only damage: the middle of some vessels is missing, everything else is complete and exact.

use rand::seq::{SliceRandom, index};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::damage::{Breaks, SampledVessel, damage, spurious};
use super::truth::{Break, BreakKind, Truth};
use super::{add_node, check_positions};
use willis_core::error::{Error, Result};
use willis_core::network::{Centerlines, Fragments, Frame, Network, Origin, PathPoint, Role, Vessel, fragments};
use willis_core::support::{Point, grouped, random, random::stream};
use willis_models::candidates::search::join_nearest;

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
/// A node without position.
pub fn break_up(network: &Network, params: &Breaks) -> Result<(Centerlines, Truth)> {
    check_positions(network)?;
    let mut rng = stream(params.seed, random::DAMAGE);
    let vessels = damage(network, params, &mut rng);
    Ok(extract(network, &vessels, params, &mut rng))
}

/// The shuffled, noisy centerlines of damaged vessels with spurious fragments, and the true answer.
fn extract(network: &Network, vessels: &[SampledVessel], params: &Breaks, rng: &mut impl Rng) -> (Centerlines, Truth) {
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

/// How many vessels are interrupted, and the distance of centerline points.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaps {
    /// The share of the vessels that lose about their middle third, 0 to 1. Their number is exact, to rounding.
    pub share: f64,
    /// The seed; it may equal that of the anatomy.
    pub seed: u64,
    /// Distance between centerline points, m, positive; `None` gives a vessel two points, an interrupted one four.
    pub spacing: Option<f64>,
}

impl Gaps {
    /// The rows of the interrupted vessels, in order.
    ///
    /// # Errors
    ///
    /// A share out of its range, a node without position.
    fn choose(&self, network: &Network) -> Result<Vec<usize>> {
        check_positions(network)?;
        let count = (self.share * network.vessel_count() as f64).round() as usize;
        let mut rows = index::sample(&mut stream(self.seed, random::GAPS), network.vessel_count(), count).into_vec();
        rows.sort_unstable();
        Ok(rows)
    }

    /// A vessel at equal steps, without its middle third where it is interrupted.
    fn sampled(&self, network: &Network, row: usize, interrupted: bool) -> SampledVessel {
        let steps = |length: f64| self.spacing.map_or(1.0, |spacing| (length / spacing).round()).max(1.0) as usize;
        let mut vessel = SampledVessel::at(network, row, |length| steps(length).max(if interrupted { 3 } else { 1 }));
        if interrupted {
            let (last, third) = (vessel.last(), (vessel.last() as f64 / 3.0).round() as usize);
            vessel.pieces = vec![[0, third], [last - third, last]];
        }
        vessel
    }
}

/// The centerlines of a network with gaps, and the true answer. Points are numbered as by [`super::extraction::break_up`].
///
/// # Errors
///
/// A share out of its range, a node without position.
pub fn with_gaps(network: &Network, gaps: &Gaps) -> Result<(Centerlines, Truth)> {
    let mut interrupted = gaps.choose(network)?.into_iter().peekable();
    let sampled = |row: usize| gaps.sampled(network, row, interrupted.next_if_eq(&row).is_some());
    let vessels: Vec<SampledVessel> = (0..network.vessel_count()).map(sampled).collect();
    let params = Breaks { jitter: 0.0, radius_noise: 0.0, radius_bias: 0.0, spurious: 0.0, ..Breaks::default() };
    // The random order of fragments and points uses a later part of the stream than the gaps.
    let mut rng = stream(gaps.seed, random::GAPS);
    rng.set_word_pos(1 << 40);
    Ok(extract(network, &vessels, &params, &mut rng))
}

/// The same gaps in a graph that is over-connected: candidates join both loose ends of every gap to their `k` nearest nodes.
///
/// The nodes keep their rows, ids and conditions. The loose ends follow, two per gap, with the next numbers as ids. Two vessels replace
/// an interrupted one. Candidates come last ([`join_nearest`]). The ids in the answer are those of the nodes, which must be the numbers
/// from 1 in order, as in the large phantoms.
///
/// # Errors
///
/// A share out of its range, a node without position or with another id.
pub fn over_connected(network: Network, gaps: &Gaps, k: usize) -> Result<(Network, Truth)> {
    let chosen = gaps.choose(&network)?;
    if let Some((row, node)) = network.nodes().enumerate().find(|(row, node)| node.id.parse() != Ok(row + 1)) {
        return Err(Error::parameter("node", &node.id, format!("expected {} as its id", row + 1)));
    }
    let mut truth = Truth {
        vessels: network.vessels().map(|(_, vessel)| vessel.label.clone()).collect(),
        inlets: (1..).zip(network.nodes()).filter(|(_, n)| n.role == Some(Role::Inlet)).map(|(id, _)| id).collect(),
        points: widest_vessels(&network),
        ..Truth::default()
    };
    let complete = network.node_count();
    let sampled: Vec<SampledVessel> = chosen.iter().map(|row| gaps.sampled(&network, *row, true)).collect();
    let (nodes, vessels) = network.into_parts();
    let mut graph = Network::of(Frame::Unknown, nodes.collect(), Vec::new());
    let mut interrupted = chosen.into_iter().zip(sampled).peekable();
    for (row, (ends, vessel)) in vessels.enumerate() {
        let Some((_, sampled)) = interrupted.next_if(|(next, _)| *next == row) else {
            graph.add_vessel(ends, vessel);
            continue;
        };
        let [near, far] = [sampled.pieces[0], sampled.pieces[1]];
        let loose = [near[1], far[0]].map(|at| {
            let (position, radius) = sampled.points[at];
            truth.points.push(Some(row));
            add_node(&mut graph, position, Some(radius))
        });
        let label = vessel.label;
        for (ends, piece) in [([ends[0], loose[0]], near), ([loose[1], ends[1]], far)] {
            let points = || sampled.points[piece[0]..=piece[1]].iter();
            let path = points().map(|(position, radius)| PathPoint { position: *position, radius: *radius, id: None });
            let path = if vessel.path.is_empty() { Vec::new() } else { path.collect() };
            let length = sampled.step * (piece[1] - piece[0]) as f64;
            graph.add_vessel(ends, Vessel { label: label.clone(), path, ..Vessel::new(length, vessel.radius, Origin::Observed) });
        }
        let stretch = [near[1], far[0]].map(|at| at as f64 * sampled.step);
        let ids = loose.map(|node| node as u64 + 1);
        truth.breaks.push(Break { ids, kind: BreakKind::Vessel, vessel: row, label, stretch });
    }
    truth.spurious = vec![false; fragments(&graph, |_, _| true).count];
    let ends: Vec<usize> = (complete..graph.node_count()).collect();
    join_nearest(&mut graph, &ends, k);
    Ok((graph, truth))
}

/// For each node the row of its widest vessel.
fn widest_vessels(network: &Network) -> Vec<Option<usize>> {
    let mut widest: Vec<Option<usize>> = vec![None; network.node_count()];
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        for end in ends {
            if widest[end].is_none_or(|widest| vessel.radius > network.vessel(widest).radius) {
                widest[end] = Some(row);
            }
        }
    }
    widest
}
