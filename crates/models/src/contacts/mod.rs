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
use features::{Pair, PairTable, pairs_among, pairs_of, skeleton_features};
use model::{ContactModel, Crowding};
use partition::{Blocks, PartitionWeights, most_probable, without_narrow_loops};
use split::{Opened, split};
use willis_core::network::Network;
use willis_core::support::boosted_trees::stored;
use willis_io::masks::{Field, Scene};

/// The contacts of a network.
pub struct ContactTable {
    /// Branches and clusters.
    pub branches: Branches,
    /// Pairs of ends, cluster by cluster.
    pub pairs: Vec<Pair>,
}

impl ContactTable {
    /// The contacts of the observed vessels of a network, whose nodes have positions.
    pub fn new(network: &Network) -> Self {
        let branches = Branches::new(network);
        Self { pairs: pairs_of(&branches), branches }
    }

    /// What is measured of the pairs, a row each, a column one of [`Basis::feature_names`]. Where there is a mask the skeleton's own features
    /// are left out: on manual masks they mislead.
    pub fn features(&self, mask: Option<&Field>, scene: Option<&Scene>) -> Array2<f32> {
        let rows = match mask {
            Some(field) => evidence::mask_features(field, scene, &self.branches, &self.pairs),
            None => skeleton_features(&self.branches, &self.pairs),
        };
        let columns = Basis::of(mask, scene).feature_names().len();
        Array2::from_shape_fn((rows.len(), columns), |(row, column)| stored(rows[row][column]))
    }

    /// Per cluster the scores of its pairs, given those of all pairs.
    pub fn by_cluster(&self, scores: &[f64]) -> Vec<PairTable> {
        let mut scores = scores.iter().copied();
        let of = |cluster: &Cluster| {
            let ends = cluster.ends.len();
            PairTable::over(ends, 0.0, scores.by_ref().take(pairs_among(ends).count()))
        };
        self.branches.clusters.iter().map(of).collect()
    }

    /// The most probable blocks of each cluster, given the scores of its pairs.
    pub fn blocks(&self, tables: &[PairTable], weights: &PartitionWeights) -> Vec<Blocks> {
        let clusters = tables.iter().zip(&self.branches.clusters);
        clusters.map(|(table, c)| most_probable(table, c.ends.len(), weights, &std::collections::BTreeSet::new())).collect()
    }
}

/// The network with the contacts of its observed vessels opened, as far as a model finds them: a vessel of origin contact joins what
/// was one junction. The nodes of `network` keep their rows. The image is left out where the model does not know images. Beside it, where
/// the vessels are unlike those that the model was calibrated on, what to tell a person.
pub fn with_contacts(
    network: &Network,
    mask: Option<&Field>,
    scene: Option<&Scene>,
    model: &ContactModel,
) -> (Opened, Option<String>) {
    let table = ContactTable::new(network);
    let scene = scene.filter(|_| model.image.is_some());
    let part = model.part(Basis::of(mask, scene));
    let tables = table.by_cluster(&part.trees.scores(&table.features(mask, scene)));
    let mut blocks = table.blocks(&tables, &part.weights);
    if let Some(field) = mask {
        blocks = without_narrow_loops(&table.branches, &tables, blocks, &part.weights, field);
    }
    let opened = split(network, &table.branches, &blocks, |joined| part.probability(joined));
    let here = Crowding::new(network, &table.branches, opened.junctions.len());
    (opened, part.crowding.and_then(|most| here.unlike(most)))
}
