//! The arteries of the Circle of Willis and those that feed and leave it.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A side of the body: the patient's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// An artery. What lies further out counts as what it continues: M2 to M4 as M1, A3 to A5 as A2, P3 and P4 as P2, every segment of
/// the internal carotid (C1 to C7, ICA I and II, ICA-T) as the internal carotid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Artery {
    /// Internal carotid artery.
    Ica(Side),
    /// First segment of the middle cerebral artery, and what continues it.
    M1(Side),
    /// Anterior cerebral artery up to the anterior communicating artery.
    A1(Side),
    /// Anterior cerebral artery beyond it.
    A2(Side),
    /// Posterior cerebral artery up to the posterior communicating artery.
    P1(Side),
    /// Posterior cerebral artery beyond it.
    P2(Side),
    /// Posterior communicating artery.
    PComm(Side),
    /// Vertebral artery.
    Va(Side),
    /// Anterior communicating artery.
    AComm,
    /// Basilar artery.
    Ba,
    /// A third A2, which leaves the anterior communicating artery between the two.
    ThirdA2,
    /// The middle cerebral artery, undivided.
    Mca(Side),
    /// The anterior cerebral artery, undivided: A1 and A2 under one name.
    Aca(Side),
    /// The posterior cerebral artery, undivided: P1 and P2 under one name.
    Pca(Side),
}

/// The seven segments that close the circle.
pub const RING: [Artery; 7] = [
    Artery::A1(Side::Left),
    Artery::A1(Side::Right),
    Artery::AComm,
    Artery::P1(Side::Left),
    Artery::P1(Side::Right),
    Artery::PComm(Side::Left),
    Artery::PComm(Side::Right),
];

/// The segments whose fenestrations are told, in the order of [`super::variant::Variant::fenestration`].
pub const FENESTRATED: [Artery; 5] =
    [Artery::A1(Side::Left), Artery::AComm, Artery::A1(Side::Right), Artery::P1(Side::Left), Artery::P1(Side::Right)];

impl Side {
    /// Left, then right.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// 0 for left, 1 for right.
    pub fn row(self) -> usize {
        self as usize
    }

    /// The word in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

impl Artery {
    /// Those that come in pairs.
    pub(crate) const PAIRED: [fn(Side) -> Self; 11] =
        [Self::Ica, Self::M1, Self::Mca, Self::A1, Self::A2, Self::Aca, Self::P1, Self::P2, Self::Pca, Self::PComm, Self::Va];

    /// Every artery.
    pub fn all() -> impl Iterator<Item = Self> {
        let sided = Self::PAIRED.into_iter().flat_map(|artery| Side::BOTH.map(artery));
        sided.chain([Self::AComm, Self::Ba, Self::ThirdA2])
    }

    /// Its side; none in the midline.
    pub fn side(self) -> Option<Side> {
        match self {
            Self::AComm | Self::Ba | Self::ThirdA2 => None,
            Self::Ica(s)
            | Self::M1(s)
            | Self::A1(s)
            | Self::A2(s)
            | Self::P1(s)
            | Self::P2(s)
            | Self::PComm(s)
            | Self::Va(s)
            | Self::Mca(s)
            | Self::Aca(s)
            | Self::Pca(s) => Some(s),
        }
    }

    /// The undivided artery that it is a segment of; itself where it is none.
    #[must_use]
    pub fn whole(self) -> Self {
        match self {
            Self::A1(side) | Self::A2(side) => Self::Aca(side),
            Self::P1(side) | Self::P2(side) => Self::Pca(side),
            Self::M1(side) => Self::Mca(side),
            other => other,
        }
    }

    /// Its name without the side.
    pub fn stem(self) -> &'static str {
        match self {
            Self::Ica(_) => "ICA",
            Self::M1(_) => "M1",
            Self::A1(_) => "A1",
            Self::A2(_) => "A2",
            Self::P1(_) => "P1",
            Self::P2(_) => "P2",
            Self::PComm(_) => "PComm",
            Self::Va(_) => "VA",
            Self::AComm => "AComm",
            Self::Ba => "BA",
            Self::ThirdA2 => "3rd-A2",
            Self::Mca(_) => "MCA",
            Self::Aca(_) => "ACA",
            Self::Pca(_) => "PCA",
        }
    }
}

/// The house name: `L-A1`, `AComm`, `BA`.
impl fmt::Display for Artery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = match self.side() {
            Some(Side::Left) => "L-",
            Some(Side::Right) => "R-",
            None => "",
        };
        write!(f, "{side}{}", self.stem())
    }
}
