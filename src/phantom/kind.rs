//! The phantoms by name.

use std::fmt;
use std::str::FromStr;

use super::{Tree, branching_tree, cerebral, circle_of_willis};
use crate::error::{Error, Result};
use crate::network::Network;
use crate::suggestion::did_you_mean;
use crate::units::{metres, millimetres};

/// Which test anatomy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The 33 vessels from the heart to the cerebral arteries ([`circle_of_willis`]).
    CircleOfWillis,
    /// The 20 of them that an angiogram of the head shows ([`cerebral`]).
    Cerebral,
    /// A bifurcating tree with the default parameters ([`branching_tree`]).
    Tree,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::CircleOfWillis, Self::Cerebral, Self::Tree];

    /// The word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::CircleOfWillis => "circle-of-willis",
            Self::Cerebral => "cerebral",
            Self::Tree => "tree",
        }
    }

    /// The complete network, sampled at about `spacing`, in m, from 0.01 to 10 mm.
    ///
    /// # Errors
    ///
    /// A spacing out of that range.
    pub fn network(self, spacing: f64) -> Result<Network> {
        if !(metres(0.01)..=metres(10.0)).contains(&spacing) {
            return Err(Error::parameter("spacing", millimetres(spacing), "expected 0.01 to 10 mm"));
        }
        match self {
            Self::CircleOfWillis => Ok(circle_of_willis(spacing)),
            Self::Cerebral => Ok(cerebral(&circle_of_willis(spacing))),
            Self::Tree => branching_tree(&Tree { spacing, ..Tree::default() }),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = Error;

    fn from_str(word: &str) -> Result<Self> {
        (Self::ALL.into_iter().find(|kind| kind.name() == word)).ok_or_else(|| {
            let (names, meant) = (Self::ALL.map(Self::name), did_you_mean(word, Self::ALL.map(Self::name)));
            Error::parameter("phantom", word, format!("{meant}expected {}", names.join(", ")))
        })
    }
}
