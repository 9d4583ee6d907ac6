//! The exact posterior over forests of fragments: which fragment hangs on which, and by which bridge.
//!
//! Each of n fragments hangs on one other by one directed bridge e of weight w_e, or is a root of weight v_c. An explanation is
//! a choice for every fragment without a cycle; its probability is the product of its weights over the sum Z of all such
//! products. By the matrix-tree theorem (Chaiken and Kleitman 1978) Z = det L with L_cc = v_c + Σ w, L_cp = -Σ w, and
//! marginals come from G = L⁻¹: P(c → p by e) = w_e (G_cc - G_pc), P(root c) = v_c G_cc.
//!
//! The difference loses every digit of an improbable bridge, so it is never formed. L belongs to a random walk that steps
//! from c along e with odds w_e and dies at c with odds v_c. With q_pc the probability that the walk from p dies before it
//! meets c, G_cc - G_pc = G_cc q_pc and 1/G_cc = v_c + Σ w_e q_pc. Eliminating a fragment from the walk needs no subtraction
//! (Grassmann, Taksar and Heyman 1985), so every marginal is accurate in its own digits, however small.

pub(crate) mod arborescence;
mod cliques;
mod escape;
pub(crate) mod log_likelihood;
pub(crate) mod marginals;
mod messages;
mod random_walk;
mod rooted;

pub use arborescence::arborescence;
pub use log_likelihood::log_likelihood;
pub use marginals::{Marginals, check_tangle, marginals};
pub use rooted::rooted_in;

use crate::error::{Error, Result};

/// The largest absolute log weight: e^±100 stays apart from 0 and infinity through all products.
pub const MOST_LOG_WEIGHT: f64 = 100.0;

/// A way for one fragment to hang on another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge {
    /// The fragment that hangs.
    pub child: usize,
    /// The fragment it hangs on.
    pub parent: usize,
    /// ln w; -∞ for a bridge that cannot be.
    pub log_weight: f64,
}

/// What every fragment may do: the weights of all explanations.
#[derive(Debug, Clone, PartialEq)]
pub struct Forests {
    log_roots: Vec<f64>,
    bridges: Vec<Bridge>,
}

impl Forests {
    /// Fragments with the log weights ln v of being a root, shape (n), and the bridges between them, parallel ones among them.
    ///
    /// # Errors
    ///
    /// A bridge from a fragment to itself or to one that is not there; a log weight beyond ±[`MOST_LOG_WEIGHT`], except -∞ for
    /// a bridge; more than 2³¹ fragments or bridges.
    pub fn new(log_roots: Vec<f64>, bridges: Vec<Bridge>) -> Result<Self> {
        let fragments = log_roots.len();
        let size = fragments.max(bridges.len());
        if size >= 1 << 31 {
            return Err(Error::parameter("fragments or bridges", size, "fewer than 2147483648"));
        }
        let wild = |log_weight: f64| log_weight.is_nan() || log_weight.abs() > MOST_LOG_WEIGHT;
        if let Some((fragment, log_weight)) = log_roots.iter().enumerate().find(|(_, w)| wild(**w)) {
            let accepted = format!("a number from -{MOST_LOG_WEIGHT} to {MOST_LOG_WEIGHT}");
            return Err(Error::parameter(format!("log weight of root {fragment}"), log_weight, accepted));
        }
        for (row, Bridge { child, parent, log_weight }) in bridges.iter().enumerate() {
            if *child >= fragments || *parent >= fragments || child == parent {
                let accepted = format!("two different fragments below {fragments}");
                return Err(Error::parameter(format!("ends of bridge {row}"), format!("{child}, {parent}"), accepted));
            }
            if *log_weight != f64::NEG_INFINITY && wild(*log_weight) {
                let accepted = format!("a number from -{MOST_LOG_WEIGHT} to {MOST_LOG_WEIGHT}, or -inf");
                return Err(Error::parameter(format!("log weight of bridge {row}"), log_weight, accepted));
            }
        }
        Ok(Self { log_roots, bridges })
    }

    /// ln v per fragment.
    pub fn log_roots(&self) -> &[f64] {
        &self.log_roots
    }

    /// The bridges.
    pub fn bridges(&self) -> &[Bridge] {
        &self.bridges
    }

    /// How many fragments there are.
    pub fn fragments(&self) -> usize {
        self.log_roots.len()
    }
}
