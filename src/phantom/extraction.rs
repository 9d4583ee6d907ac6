//! An extraction in the making: what is left of the vessels, then shuffled and noisy.

use std::collections::HashMap;

use petgraph::unionfind::UnionFind;
use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::breaks::Breaks;
use super::damage::{Sampled, damage, spurious};
use super::truth::{Break, BreakKind, Truth};
use crate::error::{Error, Result};
use crate::network::centerlines::Centerlines;
use crate::network::{Network, Role};
use crate::support::geometry::Point;
use crate::support::random;
use crate::support::random::stream;

/// The extraction before its points are shuffled.
#[derive(Default)]
pub(crate) struct Draft {
    /// The points; those of the vessels first.
    pub points: Vec<Drawn>,
    /// Pairs of linked points.
    pub links: Vec<[usize; 2]>,
    /// The missing stretches.
    pub gaps: Vec<Gap>,
}

/// A point where the true vessel has it.
pub(crate) struct Drawn {
    /// m.
    pub position: Point,
    /// m.
    pub radius: f64,
    /// The row of its vessel; none where it is spurious.
    pub vessel: Option<usize>,
}

/// A break whose sides are still rows of the draft.
pub(crate) struct Gap {
    /// The points of the draft on its two sides.
    pub sides: [usize; 2],
    /// All but the ids.
    pub truth: Break,
}

impl Draft {
    /// Adds what is left of a vessel; its nodes' points are shared with the vessels that meet there. Returns the first
    /// and last point of each piece.
    pub fn add_vessel(
        &mut self,
        row: usize,
        vessel: &Sampled,
        ends: [usize; 2],
        node_point: &mut [Option<usize>],
    ) -> Vec<[usize; 2]> {
        let mut sides = Vec::new();
        for [first, last] in &vessel.pieces {
            let mut drawn = Vec::new();
            for at in *first..=*last {
                let (position, radius) = vessel.points[at];
                let node = (0..2).find(|end| at == [0, vessel.last()][*end]).map(|end| ends[end]);
                let point = node.and_then(|node| node_point[node]).unwrap_or_else(|| {
                    self.points.push(Drawn { position, radius, vessel: Some(row) });
                    self.points.len() - 1
                });
                if let Some(node) = node {
                    node_point[node] = Some(point);
                }
                if radius > self.points[point].radius {
                    (self.points[point].radius, self.points[point].vessel) = (radius, Some(row));
                }
                drawn.push(point);
            }
            self.links.extend(drawn.windows(2).map(|pair| [pair[0], pair[1]]));
            sides.push([drawn[0], drawn[drawn.len() - 1]]);
        }
        sides
    }

    /// Notes the missing stretches of a vessel that have a point on both sides.
    pub fn add_gaps(&mut self, row: usize, vessel: &Sampled, sides: &[[usize; 2]], nodes: [Option<usize>; 2]) {
        let (Some(first), Some(last)) = (vessel.pieces.first(), vessel.pieces.last()) else { return };
        let mut add = |kind, sides: [usize; 2], stretch: [usize; 2]| {
            let stretch = stretch.map(|at| at as f64 * vessel.step);
            self.gaps.push(Gap { sides, truth: Break { ids: [0; 2], kind, vessel: row, stretch } });
        };
        if let (Some(node), true) = (nodes[0], first[0] > 0) {
            add(BreakKind::Junction, [node, sides[0][0]], [0, first[0]]);
        }
        for (pieces, sides) in vessel.pieces.windows(2).zip(sides.windows(2)) {
            add(BreakKind::Vessel, [sides[0][1], sides[1][0]], [pieces[0][1], pieces[1][0]]);
        }
        if let (Some(node), true) = (nodes[1], last[1] < vessel.last()) {
            add(BreakKind::Junction, [node, sides[sides.len() - 1][1]], [last[1], vessel.last()]);
        }
    }

    /// The connected points as lists, in order of their first.
    pub fn fragments(&self) -> Vec<Vec<usize>> {
        let mut parts = UnionFind::<usize>::new(self.points.len());
        for [a, b] in &self.links {
            parts.union(*a, *b);
        }
        let mut fragments: Vec<Vec<usize>> = Vec::new();
        let mut row_of = HashMap::new();
        for point in 0..self.points.len() {
            let row = *row_of.entry(parts.find(point)).or_insert(fragments.len());
            if row == fragments.len() {
                fragments.push(Vec::new());
            }
            fragments[row].push(point);
        }
        fragments
    }

    /// The shuffled, noisy centerlines, and per point of the draft its row there.
    pub fn centerlines(&self, params: &Breaks, rng: &mut impl Rng) -> (Centerlines, Vec<usize>) {
        let mut neighbours = vec![Vec::new(); self.points.len()];
        for [a, b] in &self.links {
            neighbours[*a].push(*b);
            neighbours[*b].push(*a);
        }
        let mut fragments = self.fragments();
        fragments.shuffle(rng);
        let mut lines = Centerlines::default();
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
                let Drawn { position, radius, .. } = &self.points[point];
                let mut noise = || rng.sample::<f64, _>(StandardNormal);
                let jitter = params.jitter * params.spacing / 3.0_f64.sqrt();
                lines.points.push([0, 1, 2].map(|axis| position[axis] + jitter * noise()));
                lines.radii.push(radius * (bias + params.radius_noise * noise()).exp());
                lines.ids.push(lines.points.len() as u64);
                lines.strand.push(strand as u32);
                neighbours[point].shuffle(rng);
                stack.extend(neighbours[point].iter().map(|next| (*next, point)));
            }
        }
        let closing = self.links.iter().filter(|[a, b]| parent[*a] != *b && parent[*b] != *a);
        lines.links.extend(closing.map(|link| link.map(|point| number[point] as u32)));
        (lines, number)
    }
}

/// Breaks a network up as an image would: missing stretches, lost ends, displaced points, noisy radii, spurious bits.
///
/// Points are numbered from 1, fragment by fragment in random order, each from a random loose end outwards, so that
/// every point but a fragment's first is linked to one before it; the links that close a loop come last. The seed alone
/// decides: two calls give the same bits.
///
/// # Errors
///
/// `params` that do not validate, a node without position.
pub fn break_up(network: &Network, params: &Breaks) -> Result<(Centerlines, Truth)> {
    params.validate()?;
    if let Some(node) = network.nodes().find(|node| node.position.is_none()) {
        return Err(Error::parameter("node", &node.id, "has no position; expected one for every node"));
    }
    let mut rng = stream(params.seed, random::DAMAGE);
    let vessels = damage(network, params, &mut rng);
    Ok(extract(network, &vessels, params, &mut rng))
}

/// The centerlines of what is left of the vessels, in random order, noisy and with spurious bits, and the answer.
pub(crate) fn extract(network: &Network, vessels: &[Sampled], params: &Breaks, rng: &mut impl Rng) -> (Centerlines, Truth) {
    let mut draft = Draft::default();
    let mut node_point = vec![None; network.node_count()];
    let mut sides = Vec::new();
    for (row, vessel) in vessels.iter().enumerate() {
        sides.push(draft.add_vessel(row, vessel, network.ends(row), &mut node_point));
    }
    for (row, vessel) in vessels.iter().enumerate() {
        draft.add_gaps(row, vessel, &sides[row], network.ends(row).map(|node| node_point[node]));
    }
    let true_fragments = draft.fragments().len();
    let wanted = (params.spurious * true_fragments as f64).round() as usize;
    let seen = if wanted > 0 { vessels } else { &[] };
    let lumens: Vec<_> = seen.iter().flat_map(|vessel| vessel.points.iter().copied()).collect();
    for bit in spurious(&lumens, wanted, params, rng) {
        let first = draft.points.len();
        draft.points.extend(bit.into_iter().map(|(position, radius)| Drawn { position, radius, vessel: None }));
        draft.links.extend((first + 1..draft.points.len()).map(|point| [point - 1, point]));
    }
    let inlets = (0..network.node_count()).filter(|row| network.node(*row).role == Some(Role::Inlet));
    let inlets: Vec<usize> = inlets.filter_map(|row| node_point[row]).collect();
    let (lines, number) = draft.centerlines(params, rng);

    let mut truth = Truth {
        vessels: network.vessels().map(|(_, vessel)| vessel.label.clone()).collect(),
        lost: (0..vessels.len()).filter(|row| vessels[*row].pieces.is_empty()).collect(),
        inlets: inlets.into_iter().map(|point| lines.ids[number[point]]).collect(),
        spurious: vec![false; lines.strand.iter().max().map_or(0, |last| *last as usize + 1)],
        points: vec![None; lines.points.len()],
        breaks: draft
            .gaps
            .iter()
            .map(|gap| Break { ids: gap.sides.map(|p| lines.ids[number[p]]), ..gap.truth.clone() })
            .collect(),
    };
    for (point, drawn) in draft.points.iter().enumerate() {
        truth.points[number[point]] = drawn.vessel;
        truth.spurious[lines.strand[number[point]] as usize] = drawn.vessel.is_none();
    }
    (lines, truth)
}
