//! The exact posterior over forests of fragments: which fragment is attached to which, and by which edge.
//!
//! Each of n fragments is attached to one other by one directed edge e of weight w_e, or is a root of weight v_c. A forest is
//! a choice for every fragment without a cycle; its probability is the product of its weights over the sum Z of all such
//! products. By the matrix-tree theorem (Chaiken and Kleitman 1978) Z = det L with L_cc = v_c + Σ w, L_cp = -Σ w, and
//! marginals come from G = L⁻¹: P(c → p by e) = w_e (G_cc - G_pc), P(root c) = v_c G_cc.
//!
//! The difference loses every digit of an improbable edge, so it is never formed. L belongs to a random walk that steps
//! from c along e with odds w_e and dies at c with odds v_c. With q_pc the probability that the walk from p dies before it
//! meets c, G_cc - G_pc = G_cc q_pc and 1/G_cc = v_c + Σ w_e q_pc. Eliminating a fragment from the walk needs no subtraction
//! (Grassmann, Taksar and Heyman 1985), so every marginal is accurate in its own digits, however small.

pub mod absorbing_walk;
pub(crate) mod arborescence;
pub mod clique_tree;
pub(crate) mod marginals;

pub use arborescence::arborescence;
pub use marginals::{MOST_PAIRS, Marginals, is_tangle, log_likelihood, marginals, rooted_in};

use crate::error::{Error, Result, require};

/// The largest absolute log weight: products of e^±100 neither vanish nor overflow.
pub const MOST_LOG_WEIGHT: f64 = 100.0;

/// A directed edge by which one fragment may be attached to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The fragment that is attached.
    pub child: usize,
    /// The fragment that it is attached to.
    pub parent: usize,
    /// ln w; -∞ for an edge that cannot be.
    pub log_weight: f64,
}

/// The weights of all forests: of every root and every edge.
#[derive(Debug, Clone, PartialEq)]
pub struct Forests {
    log_roots: Vec<f64>,
    edges: Vec<Edge>,
}

impl Forests {
    /// Fragments with the log weights ln v of being a root, shape (n), and the edges between them, parallel ones among them.
    ///
    /// # Errors
    ///
    /// An edge from a fragment to itself or to one that is not there; a log weight beyond ±[`MOST_LOG_WEIGHT`], except -∞ for
    /// an edge; more than 2³¹ fragments or edges.
    pub fn new(log_roots: Vec<f64>, edges: Vec<Edge>) -> Result<Self> {
        let fragments = log_roots.len();
        let size = fragments.max(edges.len());
        require(size < 1 << 31, "fragments or edges", size, "fewer than 2147483648")?;
        let wild = |log_weight: f64| log_weight.is_nan() || log_weight.abs() > MOST_LOG_WEIGHT;
        if let Some((fragment, log_weight)) = log_roots.iter().enumerate().find(|(_, w)| wild(**w)) {
            let accepted = format!("a number from -{MOST_LOG_WEIGHT} to {MOST_LOG_WEIGHT}");
            return Err(Error::parameter(format!("log weight of root {fragment}"), log_weight, accepted));
        }
        for (row, Edge { child, parent, log_weight }) in edges.iter().enumerate() {
            if *child >= fragments || *parent >= fragments || child == parent {
                let accepted = format!("two different fragments below {fragments}");
                return Err(Error::parameter(format!("ends of edge {row}"), format!("{child}, {parent}"), accepted));
            }
            if *log_weight != f64::NEG_INFINITY && wild(*log_weight) {
                let accepted = format!("a number from -{MOST_LOG_WEIGHT} to {MOST_LOG_WEIGHT}, or -inf");
                return Err(Error::parameter(format!("log weight of edge {row}"), log_weight, accepted));
            }
        }
        Ok(Self { log_roots, edges })
    }

    /// ln v per fragment.
    pub fn log_roots(&self) -> &[f64] {
        &self.log_roots
    }

    /// The edges.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// How many fragments there are.
    pub fn fragments(&self) -> usize {
        self.log_roots.len()
    }
}
