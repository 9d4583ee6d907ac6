//! What the plausible topologies of a network say of its Circle of Willis, and the flow in the one that is kept.

use willis::error::Result;
use willis::internals::circle_of_willis::{Circle, Collateral, Posterior, collaterals};
use willis::internals::decision::{KnownEnds, Topologies, TopologySource};
use willis::internals::flow::boundary::stated;
use willis::internals::flow::poiseuille::BLOOD_VISCOSITY;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::network::{Condition, Network, Role};
use willis::internals::sampling::SamplingOptions;

/// What plausible topologies say of a circle: those of the evidence, or without any those that the samples vote for, by the vessels
/// `above` the median.
pub fn posterior(
    network: &Network,
    boundary: &Boundary,
    params: &SamplingOptions,
    circle: &Circle,
    given: &[usize],
    above: Option<&[bool]>,
) -> Result<(Posterior, String)> {
    let mut known = vec![false; network.node_count()];
    let rows = circle.ends(network).into_iter().chain(given.iter().copied());
    for node in rows.filter(|node| *node < network.node_count()) {
        known[node] = true;
    }
    let mut inlets = circle.inlets();
    if !inlets.is_empty() {
        inlets.extend(given.iter().filter(|node| boundary.roles.get(**node) == Some(&Role::Inlet)));
    }
    let (draw, how) = match above {
        None => {
            (TopologySource::FreeEnds(KnownEnds { ends: &known, inlets: &inlets }), "whose free ends continue by the evidence")
        }
        Some(above) => (TopologySource::Samples(above), "that samples vote for by their resilience"),
    };
    let topologies = Topologies::draw(network, boundary, params, draw)?;
    let how = format!("{} plausible topologies, {how}", topologies.samples);
    Ok((Posterior::of(circle, network, &topologies), how))
}

/// With what blood flows: what the network states, else what is found.
pub struct Flow {
    pub viscosity: f64,
    pub outlets: FoundOutlets,
}

impl Flow {
    /// Blood as infer takes it; outlets found are those of centerlines, or of a ready graph.
    pub fn of_blood(centerlines: bool) -> Self {
        Self { viscosity: BLOOD_VISCOSITY, outlets: if centerlines { FoundOutlets::CEREBRAL } else { FoundOutlets::Ground } }
    }

    /// What the loss of each feeder means to the topology of the vessels `kept`.
    pub fn collaterals(&self, network: &Network, circle: &Circle, kept: &[bool]) -> Result<Vec<Collateral>> {
        let mut network = network.clone();
        state_inlets(&mut network, circle);
        let boundary = Boundary::resolve(&network, &stated(&network), self.outlets)?;
        collaterals(circle, &network, |row| kept[row], &boundary, self.viscosity)
    }
}

/// Makes inlets of the landmarks where blood comes in, unless the input states what they are.
pub fn state_inlets(network: &mut Network, circle: &Circle) {
    for node in circle.inlets() {
        let node = network.node_mut(node);
        if node.condition.is_none() {
            (node.role, node.condition) = (Some(Role::Inlet), Some(Condition::INLET));
        }
    }
}
