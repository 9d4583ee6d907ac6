//! Contacts: places where observed vessels meet, and whether they are one vessel there or two that touch.
//!
//! Thinning makes one skeleton of vessels that touch in the mask. Junctions within each other's lumen are a cluster ([`branches`]), and the
//! branch ends at a cluster fall into blocks, each a vessel or a true junction ([`partition`]). Boosted trees score every pair of ends
//! ([`features`], or [`evidence`] where there is a mask, and perhaps an image beside it), and a log-linear model makes of the scores a probability for every set
//! partition. In the most probable one each block gets junctions of its own, and the blocks of a cluster are joined by contacts
//! ([`split()`]), vessels of origin contact whose probability a decision goes by.

pub mod branches;
pub mod evidence;
pub mod features;
pub mod model;
pub mod partition;
pub mod sections;
pub mod split;

pub use model::Basis;

use ndarray::Array2;

use branches::{Branches, Cluster};
use features::{PairTable, pairs_among, skeleton_features};
use model::{ContactModel, Crowding};
use partition::{most_probable_blocks, without_narrow_loops};
use split::{Opened, split};
use willis_core::network::Network;
use willis_core::support::boosted_trees::stored;
use willis_io::masks::{Field, Scene};

/// What is measured of the pairs of ends of each cluster, cluster by cluster: a row a pair, a column one of [`Basis::feature_names`]. Where there is
/// a mask the skeleton's own features are left out: on manual masks they mislead.
pub fn pair_features(branches: &Branches, mask: Option<&Field>, scene: Option<&Scene>) -> Array2<f32> {
    let rows = match mask {
        Some(field) => evidence::mask_features(field, scene, branches),
        None => skeleton_features(branches),
    };
    let columns = Basis::of(mask, scene).feature_names().len();
    Array2::from_shape_fn((rows.len(), columns), |(row, column)| stored(rows[row][column]))
}

/// Per cluster the scores of its pairs, given those of all pairs.
pub fn scores_by_cluster(branches: &Branches, scores: &[f64]) -> Vec<PairTable> {
    let mut scores = scores.iter().copied();
    let of = |cluster: &Cluster| {
        let ends = cluster.ends.len();
        PairTable::over(ends, 0.0, scores.by_ref().take(pairs_among(ends).count()))
    };
    branches.clusters.iter().map(of).collect()
}

/// The network with the contacts of its observed vessels opened, as far as a model finds them: a vessel of origin contact joins what
/// was one junction. The image is left out where the model does not know images. Beside it, where
/// the vessels are unlike those that the model was calibrated on, what to tell a person.
pub fn with_contacts(
    network: &Network,
    mask: Option<&Field>,
    scene: Option<&Scene>,
    model: &ContactModel,
) -> (Opened, Option<String>) {
    let branches = Branches::new(network);
    let scene = scene.filter(|_| model.image.is_some());
    let part = model.part(Basis::of(mask, scene));
    let scores = scores_by_cluster(&branches, &part.trees.scores(&pair_features(&branches, mask, scene)));
    let blocks = match mask {
        Some(field) => without_narrow_loops(&branches, &scores, &part.weights, field),
        None => most_probable_blocks(&scores, &part.weights),
    };
    let opened = split(network, &branches, &blocks, |joined| part.probability(joined));
    let here = Crowding::new(network, &branches, opened.junctions.len());
    (opened, part.crowding.and_then(|most| here.unlike(most)))
}
