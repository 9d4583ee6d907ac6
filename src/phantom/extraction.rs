//! The uncertain extraction of a complete network, and its answer.

use rand::Rng;

use super::damage::{Sampled, damage};
use super::draft::{Draft, Drawn};
use super::spurious::spurious;
use super::{Break, Breaks, Truth};
use crate::centerline::Centerlines;
use crate::error::{Error, Result};
use crate::network::{Network, Role};
use crate::rng::{stream, streams};

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
    let mut rng = stream(params.seed, streams::DAMAGE);
    let vessels = damage(network, params, &mut rng);
    Ok(extract(network, &vessels, params, &mut rng))
}

/// The centerlines of what is left of the vessels, in random order, noisy and with spurious bits, and the answer.
pub(super) fn extract(network: &Network, vessels: &[Sampled], params: &Breaks, rng: &mut impl Rng) -> (Centerlines, Truth) {
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
