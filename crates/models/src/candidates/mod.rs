//! Candidate connections: from fragments to the over-connected graph.

pub mod features;
pub mod joins;
pub mod model;
pub mod over_connected;
pub mod resample;
pub mod search;

pub use features::NetworkPoint;
pub use search::{Attach, CandidateOptions, CandidateRadius, NEAREST};

use model::{ForestPosterior, Usual, Weights, posterior};
use over_connected::{FragmentCluster, NewVessel, clusters, over_connected};
use resample::{CenterlineKind, Resampled};
use search::{EndCandidate, search, search_nearest};
use willis_core::error::Result;
use willis_core::network::{Evidence, Network};
use willis_core::support::ties::steady;
use willis_io::masks::{Scene, Unseen, View};

/// Connections between fragments that are less probable than this are left out ...
const LEAST_PROBABLE: f64 = 1e-3;
/// ... and loops less probable than this.
const LEAST_PROBABLE_LOOP: f64 = 1e-2;

/// An image as it was measured, or why it says nothing of the vessels.
pub type Looked = Result<Scene, Unseen>;

/// Joins every free end of the observed vessels to its nearest branches and free ends by candidate vessels.
///
/// The nodes of `network` keep their rows; nodes where a vessel is split follow. The parts of the observed vessels come
/// first, in order, then the candidates by free end and distance. Every length is one that a file in millimetres holds
/// exactly.
///
/// # Errors
///
/// A parameter out of its range, a node without position or with more than 1000 vessels, or points that are crowded.
pub fn build(network: &Network, options: &CandidateOptions) -> Result<Network> {
    options.validate()?;
    let mut found = Vec::new();
    for cluster in clusters(network, &[]) {
        let resampled = Resampled::new(&cluster.network, CenterlineKind::Tracing);
        let e = resampled.extraction(&[])?;
        found.extend(search_nearest(&e, options)?.into_iter().map(|candidate| {
            let there = e.end_at[candidate.point].map_or(e.radius[candidate.point], |end| e.ends[end].mean_radius);
            let radii = [e.ends[candidate.end].mean_radius, there];
            NewVessel { radii, ..NewVessel::of(candidate, &e, &resampled, &cluster) }
        }));
    }
    Ok(over_connected(network, found, options).0)
}

/// Joins the fragments of the observed vessels by the candidates that the evidence allows.
///
/// Every candidate has its [`Evidence`], its probability is its prior, and every node knows how probably its fragment is a root.
/// `inlets` are nodes where blood is known to enter. Rows and lengths are as [`build`] makes them. Beside the graph, where the largest cluster of
/// fragments is unlike all that the weights were fitted to, what to tell a person.
///
/// # Errors
///
/// A parameter out of its range, a node without position or with more than 1000 vessels, or points that are crowded.
pub fn build_with_evidence(
    network: &Network,
    inlets: &[usize],
    options: &CandidateOptions,
    weights: &Weights,
) -> Result<(Network, Option<String>)> {
    options.validate()?;
    let (mut found, mut roots, mut largest) = (Vec::new(), Vec::new(), None);
    for cluster in clusters(network, inlets) {
        let resampled = Resampled::new(&cluster.network, CenterlineKind::Tracing);
        let e = resampled.extraction(&cluster.inlets)?;
        let mut candidates = search(&e, &options.search())?;
        candidates.retain(|c| options.allows(c, &e));
        let posterior = posterior(&e, &candidates, weights)?;
        let loops = posterior.closures.iter().filter(|(_, p)| *p > LEAST_PROBABLE_LOOP).map(|(candidate, p)| {
            (*candidate, Evidence { probability: *p, attached: [0.0; 2], continuation_odds: [Evidence::odds(*p), 0.0] })
        });
        found.extend(probable(&posterior).into_iter().chain(loops).map(|(candidate, evidence)| NewVessel {
            evidence: Some(evidence),
            ..NewVessel::of(candidate, &e, &resampled, &cluster)
        }));
        let root = |(place, fragment): (&NetworkPoint, &usize)| (cluster.in_whole(*place), posterior.root_scores[*fragment]);
        roots.extend(e.place.iter().zip(&e.fragment).map(root));
        largest = [largest, Usual::new(&e)].into_iter().flatten().max_by(|a: &Usual, b| a.0[0][0].total_cmp(&b.0[0][0]));
    }
    let (mut graph, node_at) = over_connected(network, found, options);
    for (place, score) in roots {
        let node = match place {
            NetworkPoint::Node(node) => Some(node),
            NetworkPoint::Along { .. } => node_at.get(&place).copied(),
        };
        if let Some(node) = node {
            graph.node_mut(node).root_score = Some(score);
        }
    }
    Ok((graph, largest.and_then(|usual| usual.unlike(weights.usual?))))
}

/// Joins the loose ends of an automatic skeleton by the candidates that the join model allows, within fragments too.
///
/// Every candidate has its [`Evidence`], and its probability is its prior. Rows and lengths are as [`build`] makes them; where an image
/// shows what lies between two ends, the vessel follows the cheapest path through it. The image as it was measured is told too, or why it says
/// nothing.
///
/// # Errors
///
/// A parameter out of its range, a node without position or with more than 1000 vessels, or points that are crowded.
pub fn build_joins(
    network: &Network,
    options: &CandidateOptions,
    model: &joins::model::JoinModel,
    view: Option<View>,
) -> Result<(Network, Option<Looked>)> {
    options.validate()?;
    // An image shows all of them alike.
    let whole = FragmentCluster::whole(network, &[]);
    let parts = if view.is_some() { vec![whole] } else { clusters(network, &[]) };
    let (mut vessels, mut looked, mut view) = (Vec::new(), None, view);
    for cluster in parts {
        let table = joins::JoinTable::new(&cluster.network, options.search().branches)?;
        let e = &table.extraction;
        let scores = table.scores(model);
        looked = view.take().map(|view| Scene::new(&e.centerlines(), view));
        let scene = looked.as_ref().and_then(|looked| looked.as_ref().ok());
        let image = scene.map(|scene| joins::image::InImage::new(&table, scene, Some(&scores.second)));
        let (candidates, pairs, probabilities) = match &image {
            Some(image) => (&image.candidates, &image.pairs, image.probabilities(&table, model, &scores)),
            None => (&table.candidates, &table.pairs, table.probabilities(model, &scores)),
        };
        vessels.extend(pairs.first.iter().zip(probabilities).enumerate().filter_map(|(pair, (row, probability))| {
            let candidate = candidates[*row];
            let gap = steady(candidate.gap(e));
            let within = candidate.fragments(e).iter().all(|row| gap <= steady(e.fragments[*row].reach()));
            let stays = probability > LEAST_PROBABLE && options.allows(&candidate, e) && within;
            let course = image.as_ref().filter(|_| model.image.is_some());
            stays.then(|| NewVessel {
                evidence: Some(Evidence::undirected(probability)),
                course: course.map(|image| image.course(pair, e.ends[candidate.end].point)).unwrap_or_default(),
                ..NewVessel::of(candidate, e, &table.resampled, &cluster)
            })
        }));
    }
    Ok((over_connected(network, vessels, options).0, looked))
}

/// The candidates between fragments that are probable enough. Of the two directions between a pair of points the first found
/// represents both.
fn probable(posterior: &ForestPosterior) -> Vec<(EndCandidate, Evidence)> {
    let table = &posterior.table;
    let mut found: Vec<(EndCandidate, f64, Evidence)> = Vec::new();
    for (row, (candidate, pair)) in table.candidates.iter().zip(&table.pairs.of).enumerate() {
        let p = posterior.marginals.edges[row];
        let odds = Evidence::odds_of_weight(posterior.forests.edges()[row].log_weight.exp());
        if let Some((_, sum, evidence)) = found.get_mut(*pair) {
            *sum += p;
            (evidence.attached[1], evidence.continuation_odds[1]) = (p, odds);
        } else {
            let probability = posterior.probability[row];
            found.push((*candidate, p, Evidence { probability, attached: [p, 0.0], continuation_odds: [odds, 0.0] }));
        }
    }
    let likely = found.into_iter().filter(|(_, sum, _)| *sum > LEAST_PROBABLE);
    likely.map(|(candidate, _, evidence)| (candidate, evidence.divided(evidence.attached))).collect()
}
