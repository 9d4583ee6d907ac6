//! From likelihoods and probabilities to an answer: the rule, the most probable forest, whole topologies.

pub mod decide;
pub mod most_probable_forest;
pub mod rules;
pub mod whole_topologies;

pub use decide::{Decision, Topology, UNDECIDED_BAND, UNDECIDED_Z, all_decided, decide};
pub use most_probable_forest::{
    BESIDE_ACCEPTED, BEST_FIRST, DOUBTFUL, ExpectedErrors, PRICE, RECONNECT, WITHOUT_PIECE, best_first, best_first_of,
    expected_errors, has_evidence, knows_fragments, probabilities, probable, reconnected,
};
pub use rules::{DecidingFigure, FollowedRule, Keep, threshold};
pub use whole_topologies::{KnownEnds, Topologies, TopologySource};
