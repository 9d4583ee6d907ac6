//! The kinds of phantoms by name, and the network of each.

use std::{fmt, str::FromStr};

use super::circle::{cerebral, circle_of_willis};
use super::tree::{BranchingTree, arterial, branching_tree};
use super::{EDGES, Large, capillary::capillary, extraction::Gaps, mask::Scan};
use willis_core::error::{Error, Result, require};
use willis_core::network::{Network, metres, millimetres};
use willis_core::support::suggestions::did_you_mean;

/// The default distance between centerline points, m.
const SPACING: f64 = 0.0005;

/// Which test anatomy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anatomy {
    /// The 33 vessels from the heart to the cerebral arteries ([`circle_of_willis`]).
    CircleOfWillis,
    /// The 20 of them that an angiogram of the head shows ([`cerebral`]).
    Cerebral,
    /// A bifurcating tree with the default parameters ([`branching_tree`]).
    Tree,
    /// Twelve trees of any size that fill a volume ([`arterial()`]).
    Arterial,
    /// A mesh of capillaries of any size ([`capillary()`]).
    Capillary,
}

/// The options of a phantom.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recipe {
    /// Distance between centerline points, m, from 0.01 to 10 mm. The default is 0.5 mm; kinds of any size then have no points between
    /// their nodes.
    pub spacing: Option<f64>,
    /// How many vessels, 100 to 10 000 000. Kinds of any size require it, the others refuse it.
    pub edges: Option<usize>,
    /// The seed of the anatomy of kinds of any size. The others are always the same.
    pub seed: u64,
}

impl Anatomy {
    /// Every kind.
    pub const ALL: [Self; 5] = [Self::CircleOfWillis, Self::Cerebral, Self::Tree, Self::Arterial, Self::Capillary];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["circle-of-willis", "cerebral", "tree", "arterial", "capillary"][self as usize]
    }

    /// Whether the caller chooses the number of vessels. The anatomy is random then.
    pub fn has_any_size(self) -> bool {
        matches!(self, Self::Arterial | Self::Capillary)
    }

    /// The gaps that break a kind of any size: in 2.5 % of the arteries, 2 % of the capillaries. `None` for the other kinds, which
    /// [`super::extraction::break_up`] breaks.
    pub fn gaps(self, recipe: &Recipe) -> Option<Gaps> {
        let share = match self {
            Self::Arterial => 0.025,
            Self::Capillary => 0.02,
            _ => return None,
        };
        Some(Gaps { share, seed: recipe.seed, spacing: recipe.spacing })
    }

    /// The scan that breaks the mask of this kind. Kinds of any size get no veins.
    pub fn scan(self, recipe: &Recipe) -> Scan {
        let defaults = Scan { seed: recipe.seed, ..Scan::default() };
        if self.has_any_size() { Scan { veins: 0.0, ..defaults } } else { defaults }
    }

    /// The complete network.
    ///
    /// # Errors
    ///
    /// A field of the recipe out of its range; a number of vessels missing or refused.
    pub fn network(self, recipe: &Recipe) -> Result<Network> {
        let spacing = recipe.spacing.unwrap_or(SPACING);
        let is_usual = (metres(0.01)..=metres(10.0)).contains(&spacing);
        require(is_usual, "spacing", millimetres(spacing), "expected 0.01 to 10 mm")?;
        let [least, most] = EDGES;
        let large = |edges| {
            require((least..=most).contains(&edges), "edges", edges, format!("expected {least} to {most}"))?;
            Ok::<Large, Error>(Large { edges, seed: recipe.seed, spacing: recipe.spacing })
        };
        match (self, recipe.edges) {
            (Self::CircleOfWillis, None) => Ok(circle_of_willis(spacing)),
            (Self::Cerebral, None) => Ok(cerebral(&circle_of_willis(spacing))),
            (Self::Tree, None) => Ok(branching_tree(&BranchingTree { spacing, ..BranchingTree::default() })),
            (Self::Arterial, Some(edges)) => Ok(arterial(&large(edges)?)),
            (Self::Capillary, Some(edges)) => capillary(&large(edges)?),
            (_, None) => {
                let accepted = format!("expected a number of vessels, {least} to {most}: {self} may have any size");
                Err(Error::parameter("edges", "missing", accepted))
            }
            (_, Some(edges)) => {
                let accepted = format!("{self} has a size of its own; expected with arterial or capillary");
                Err(Error::parameter("edges", edges, accepted))
            }
        }
    }
}

impl fmt::Display for Anatomy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Anatomy {
    type Err = Error;

    fn from_str(word: &str) -> Result<Self> {
        (Self::ALL.into_iter().find(|kind| kind.name() == word)).ok_or_else(|| {
            let (names, meant) = (Self::ALL.map(Self::name), did_you_mean(word, Self::ALL.map(Self::name)));
            Error::parameter("phantom", word, format!("{meant}expected {}", names.join(", ")))
        })
    }
}
