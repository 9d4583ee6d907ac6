//! The arteries of the Circle of Willis, with those that feed it and those that leave it.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A side of the patient's body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum BodySide {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// An artery. Distal segments count as the one that they continue: A3 to A5 as A2, P3 and P4 as P2, and M2 to M4 as M1, which only
/// the atlas of names tells apart. Every segment of the internal carotid (C1 to C7, ICA I and II, ICA-T) counts as the internal carotid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Artery {
    /// Internal carotid artery.
    Ica(BodySide),
    /// First segment of the middle cerebral artery, and those that continue it.
    M1(BodySide),
    /// The middle cerebral artery beyond its bifurcation.
    M2(BodySide),
    /// Anterior cerebral artery up to the anterior communicating artery.
    A1(BodySide),
    /// Anterior cerebral artery beyond it.
    A2(BodySide),
    /// Posterior cerebral artery up to the posterior communicating artery.
    P1(BodySide),
    /// Posterior cerebral artery beyond it.
    P2(BodySide),
    /// Posterior communicating artery.
    PComm(BodySide),
    /// Vertebral artery.
    Va(BodySide),
    /// Anterior communicating artery.
    AComm,
    /// Basilar artery.
    Ba,
    /// A third A2, which leaves the anterior communicating artery between the two.
    ThirdA2,
    /// The middle cerebral artery, undivided.
    Mca(BodySide),
    /// The anterior cerebral artery, undivided: A1 and A2 under one name.
    Aca(BodySide),
    /// The posterior cerebral artery, undivided: P1 and P2 under one name.
    Pca(BodySide),
}

/// The seven segments that close the circle.
pub const RING: [Artery; 7] = [
    Artery::A1(BodySide::Left),
    Artery::A1(BodySide::Right),
    Artery::AComm,
    Artery::P1(BodySide::Left),
    Artery::P1(BodySide::Right),
    Artery::PComm(BodySide::Left),
    Artery::PComm(BodySide::Right),
];

/// The segments in which a fenestration is looked for, in the order of [`super::variant::Variant::fenestration`].
pub const FENESTRATED: [Artery; 5] = [
    Artery::A1(BodySide::Left),
    Artery::AComm,
    Artery::A1(BodySide::Right),
    Artery::P1(BodySide::Left),
    Artery::P1(BodySide::Right),
];

/// The arteries that feed a circle, which are closed one at a time.
pub const FEEDERS: [Artery; 3] = [Artery::Ica(BodySide::Left), Artery::Ica(BodySide::Right), Artery::Ba];

/// The territories of the brain, by the arteries that lead to them.
pub const TERRITORIES: [Artery; 6] = [
    Artery::A2(BodySide::Left),
    Artery::A2(BodySide::Right),
    Artery::M1(BodySide::Left),
    Artery::M1(BodySide::Right),
    Artery::P2(BodySide::Left),
    Artery::P2(BodySide::Right),
];

/// How the atlas of names cuts an artery into states of 4 mm, and where its first state lies.
#[derive(Debug)]
pub struct AtlasArtery {
    /// The artery of a side, or in the midline.
    pub artery: fn(BodySide) -> Artery,
    /// How many states it has; the last one takes all that is further.
    pub bins: usize,
    /// Arteries at its reference end, from which distances along it are counted.
    pub begins_at: &'static [fn(BodySide) -> Artery],
    /// Where the reference end lies if none of them is traced: up, down, in front, towards the middle, or to the side.
    pub begins: Direction,
}

/// A direction in the head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Superior.
    Up,
    /// Inferior.
    Down,
    /// Anterior.
    Front,
    /// Towards the midline.
    Medial,
    /// Away from the midline.
    Lateral,
}

const fn in_atlas(
    artery: fn(BodySide) -> Artery,
    bins: usize,
    begins_at: &'static [fn(BodySide) -> Artery],
    begins: Direction,
) -> AtlasArtery {
    AtlasArtery { artery, bins, begins_at, begins }
}

/// The arteries that the atlas holds, sided ones first, then the basilar and the anterior communicating artery.
pub const IN_ATLAS: &[AtlasArtery] = &[
    in_atlas(Artery::Ica, 12, &[Artery::M1, Artery::A1], Direction::Up),
    in_atlas(Artery::M1, 6, &[Artery::Ica, Artery::A1], Direction::Medial),
    in_atlas(Artery::M2, 8, &[Artery::M1], Direction::Medial),
    in_atlas(Artery::A1, 5, &[Artery::Ica, Artery::M1], Direction::Lateral),
    in_atlas(Artery::A2, 6, &[Artery::A1, |_| Artery::AComm], Direction::Down),
    in_atlas(Artery::P1, 4, &[|_| Artery::Ba], Direction::Medial),
    in_atlas(Artery::P2, 7, &[Artery::P1, Artery::PComm], Direction::Front),
    in_atlas(Artery::PComm, 4, &[Artery::Ica], Direction::Front),
    in_atlas(|_| Artery::Ba, 7, &[Artery::P1], Direction::Up),
    in_atlas(|_| Artery::AComm, 1, &[], Direction::Up),
];

/// The vessels of the arteries of a circle, as rows of its network.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ArteryVessels {
    /// For each feeder of [`FEEDERS`] the vessels by which it enters.
    pub feeders: [Vec<usize>; 3],
    /// For each segment of [`RING`] vessels along it; empty where it is missing.
    pub segments: [Vec<usize>; 7],
    /// For each territory of [`TERRITORIES`] vessels that lead to it; empty where it is not seen.
    pub territories: [Vec<usize>; 6],
}

impl BodySide {
    /// Left, then right.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The opposite side.
    #[must_use]
    pub fn other(self) -> Self {
        Self::BOTH[1 - self.index()]
    }

    /// 0 for left, 1 for right.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The word in lower case.
    pub fn name(self) -> &'static str {
        ["left", "right"][self.index()]
    }
}

impl Artery {
    /// The arteries that exist on both sides, by their numbers.
    pub(crate) const PAIRED: &[fn(BodySide) -> Self] = &[
        Self::Ica,
        Self::M1,
        Self::M2,
        Self::Mca,
        Self::A1,
        Self::A2,
        Self::Aca,
        Self::P1,
        Self::P2,
        Self::Pca,
        Self::PComm,
        Self::Va,
    ];

    /// Every artery.
    pub fn all() -> impl Iterator<Item = Self> {
        let sided = Self::PAIRED.iter().flat_map(|artery| BodySide::BOTH.map(artery));
        sided.chain([Self::AComm, Self::Ba, Self::ThirdA2])
    }

    /// Whether blood enters the circle by it.
    pub(crate) fn brings_blood(self) -> bool {
        matches!(self, Self::Ica(_) | Self::Ba | Self::Va(_))
    }

    /// A number for the artery of either side, its name without the side, and its side; `None` in the midline.
    fn parts(self) -> (usize, &'static str, Option<BodySide>) {
        match self {
            Self::Ica(side) => (0, "ICA", Some(side)),
            Self::M1(side) => (1, "M1", Some(side)),
            Self::M2(side) => (2, "M2", Some(side)),
            Self::Mca(side) => (3, "MCA", Some(side)),
            Self::A1(side) => (4, "A1", Some(side)),
            Self::A2(side) => (5, "A2", Some(side)),
            Self::Aca(side) => (6, "ACA", Some(side)),
            Self::P1(side) => (7, "P1", Some(side)),
            Self::P2(side) => (8, "P2", Some(side)),
            Self::Pca(side) => (9, "PCA", Some(side)),
            Self::PComm(side) => (10, "PComm", Some(side)),
            Self::Va(side) => (11, "VA", Some(side)),
            Self::AComm => (12, "AComm", None),
            Self::Ba => (13, "BA", None),
            Self::ThirdA2 => (14, "3rd-A2", None),
        }
    }

    /// The same artery of the other side; itself in the midline.
    #[must_use]
    pub fn opposite(self) -> Self {
        let (number, _, side) = self.parts();
        side.map_or(self, |side| Self::PAIRED[number](side.other()))
    }

    /// Its side; `None` in the midline.
    pub fn side(self) -> Option<BodySide> {
        self.parts().2
    }

    /// Its bit in a set of arteries.
    pub(crate) fn bit(self) -> u64 {
        let (number, _, side) = self.parts();
        1 << (2 * number + side.map_or(0, BodySide::index))
    }

    /// The arteries that a segment of [`RING`] joins, at either end.
    pub(crate) fn joins(self) -> [Vec<Self>; 2] {
        match self {
            Self::A1(side) => [vec![Self::Ica(side)], vec![Self::A2(side)]],
            Self::PComm(side) => [vec![Self::Ica(side)], vec![Self::P2(side), Self::P1(side)]],
            Self::P1(side) => [vec![Self::Ba, Self::P1(side.other())], vec![Self::P2(side)]],
            _ => BodySide::BOTH.map(|side| vec![Self::A1(side), Self::A2(side)]),
        }
    }

    /// The undivided artery that it is a segment of; itself where it is no such segment.
    #[must_use]
    pub fn undivided(self) -> Self {
        match self {
            Self::A1(side) | Self::A2(side) => Self::Aca(side),
            Self::P1(side) | Self::P2(side) => Self::Pca(side),
            Self::M1(side) | Self::M2(side) => Self::Mca(side),
            other => other,
        }
    }
}

/// The name that willis writes: `L-A1`, `AComm`, `BA`.
impl fmt::Display for Artery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (_, name, side) = self.parts();
        write!(f, "{}{name}", side.map_or("", |side| ["L-", "R-"][side.index()]))
    }
}
