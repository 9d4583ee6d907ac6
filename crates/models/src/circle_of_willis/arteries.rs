//! The arteries of the Circle of Willis, with those that feed it and those that leave it, and its variant: which of its segments are there.

use std::fmt;

use Artery::{A1, A2, AComm, Aca, Ba, Ica, M1, M2, Mca, P1, P2, PComm, Pca, Va};
use BodySide::{Left, Right};
use serde::{Deserialize, Serialize};

use willis_core::network::{Network, Origin};
use willis_core::support::geometry::Point;

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
pub const RING: [Artery; 7] = [A1(Left), A1(Right), AComm, P1(Left), P1(Right), PComm(Left), PComm(Right)];

/// The segments in which a fenestration is looked for, in the order of [`Variant::fenestration`].
pub const FENESTRATED: [Artery; 5] = [A1(Left), AComm, A1(Right), P1(Left), P1(Right)];

/// The arteries that feed a circle, which are closed one at a time.
pub const FEEDERS: [Artery; 3] = [Ica(Left), Ica(Right), Ba];

/// The territories of the brain, by the arteries that lead to them.
pub const TERRITORIES: [Artery; 6] = [A2(Left), A2(Right), M1(Left), M1(Right), P2(Left), P2(Right)];

/// How the atlas of names cuts an artery into states of 4 mm, and where its first state lies.
#[derive(Debug)]
pub struct AtlasArtery {
    /// The artery of a side, or in the midline.
    pub artery: fn(BodySide) -> Artery,
    /// How many states it has; the last one takes all that is further.
    pub bins: usize,
    /// Arteries at its reference end, from which distances along it are counted.
    pub begins_at: &'static [fn(BodySide) -> Artery],
    /// The direction (RAS, of the left one) in which the reference end lies if none of them is traced.
    pub begins: Point,
}

const UP: Point = [0.0, 0.0, 1.0];
const DOWN: Point = [0.0, 0.0, -1.0];
const FRONT: Point = [0.0, 1.0, 0.0];
const MEDIAL: Point = [1.0, 0.0, 0.0];
const LATERAL: Point = [-1.0, 0.0, 0.0];

/// The arteries that the atlas holds, sided ones first, then the basilar and the anterior communicating artery.
pub const IN_ATLAS: &[AtlasArtery] = &[
    AtlasArtery { artery: Ica, bins: 12, begins_at: &[M1, A1], begins: UP },
    AtlasArtery { artery: M1, bins: 6, begins_at: &[Ica, A1], begins: MEDIAL },
    AtlasArtery { artery: M2, bins: 8, begins_at: &[M1], begins: MEDIAL },
    AtlasArtery { artery: A1, bins: 5, begins_at: &[Ica, M1], begins: LATERAL },
    AtlasArtery { artery: A2, bins: 6, begins_at: &[A1, |_| AComm], begins: DOWN },
    AtlasArtery { artery: P1, bins: 4, begins_at: &[|_| Ba], begins: MEDIAL },
    AtlasArtery { artery: P2, bins: 7, begins_at: &[P1, PComm], begins: FRONT },
    AtlasArtery { artery: PComm, bins: 4, begins_at: &[Ica], begins: FRONT },
    AtlasArtery { artery: |_| Ba, bins: 7, begins_at: &[P1], begins: UP },
    AtlasArtery { artery: |_| AComm, bins: 1, begins_at: &[], begins: UP },
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
    pub(crate) const PAIRED: &[fn(BodySide) -> Self] = &[Ica, M1, M2, Mca, A1, A2, Aca, P1, P2, Pca, PComm, Va];

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

    /// Its row in [`RING`]; `None` of an artery that is no segment of it.
    pub fn in_ring(self) -> Option<usize> {
        RING.iter().position(|segment| *segment == self)
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

/// The anatomy of one circle. Pairs are left, right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Variant {
    /// For each segment of [`RING`] whether it is present and connects what it should.
    pub present: [bool; 7],
    /// Whether each internal carotid is present up to its end.
    pub ica: [bool; 2],
    /// Whether the basilar artery is present.
    pub ba: bool,
    /// Whether the posterior cerebral artery is of fetal type: the carotid feeds it more than the basilar artery.
    pub fetal: [bool; 2],
    /// Whether there is a third A2.
    pub third_a2: bool,
    /// Whether L-A1, AComm, R-A1, L-P1, R-P1 ([`FENESTRATED`]) have two channels somewhere.
    pub fenestration: [bool; 5],
}

/// The missing segments of those of the ten variants that Padmos et al., J R Soc Interface 19:20220649 (2022), publish that lack two; each
/// segment is missing alone in one of the others.
const PUBLISHED: [[Artery; 2]; 3] = [[PComm(Left), PComm(Right)], [P1(Right), PComm(Left)], [P1(Left), PComm(Right)]];

/// How much of the circle is complete: both parts, one of them, or neither (as in Naveen, Bhat, Karthik, Ann Indian Acad Neurol
/// 18:391-397 (2015)). The anterior part is both A1 and AComm, the posterior part both P1 and both PComm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Completeness {
    /// All seven segments.
    Complete,
    /// Only the anterior part.
    AnteriorComplete,
    /// Only the posterior part.
    PosteriorComplete,
    /// Neither part.
    Incomplete,
}

impl Completeness {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["complete", "anterior complete", "posterior complete", "incomplete"][self as usize]
    }
}

impl Variant {
    /// Whether a segment of the ring is present; false for other arteries.
    pub fn has(&self, segment: Artery) -> bool {
        segment.in_ring().is_some_and(|row| self.present[row])
    }

    /// The segments of the ring that are absent.
    pub fn missing(&self) -> Vec<Artery> {
        RING.into_iter().zip(self.present).filter(|(_, present)| !present).map(|(artery, _)| artery).collect()
    }

    /// Sets whether a segment of the ring is present.
    pub(crate) fn set(&mut self, segment: Artery, present: bool) {
        if let Some(row) = segment.in_ring() {
            self.present[row] = present;
        }
    }

    /// Sets whether a posterior cerebral artery is of fetal type: PComm is present, and P1 is absent or narrower. `wider` returns whether
    /// PComm is wider by a twentieth, by the 25th percentiles of the radii along both (Musio et al. 2026).
    pub(crate) fn set_fetal(&mut self, side: BodySide, wider: impl FnOnce() -> bool) {
        self.fetal[side.index()] = self.has(Artery::PComm(side)) && (!self.has(Artery::P1(side)) || wider());
    }

    /// How much of the circle is complete.
    pub fn completeness(&self) -> Completeness {
        let all = |rows: std::ops::Range<usize>| self.present[rows].iter().all(|present| *present);
        match (all(0..3), all(3..7)) {
            (true, true) => Completeness::Complete,
            (true, false) => Completeness::AnteriorComplete,
            (false, true) => Completeness::PosteriorComplete,
            (false, false) => Completeness::Incomplete,
        }
    }

    /// Its name, from the missing segments: `complete`, `without L-A1`, `without L-P1, R-PComm`.
    pub fn name(&self) -> String {
        match self.missing()[..] {
            [] => "complete".to_owned(),
            ref missing => format!("without {}", missing.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
        }
    }

    /// Whether it is the complete circle or one of the ten variants published by Padmos et al. 2022.
    pub fn is_published(&self) -> bool {
        let missing = self.missing();
        missing.len() < 2 || PUBLISHED.iter().any(|pair| missing == pair)
    }

    /// Its description: `complete anterior part, left fetal-type PCA, R-PComm absent`.
    pub fn words(&self) -> String {
        // In the order of the variants of `Completeness`; the last one has no part.
        let complete = ["circle", "anterior part", "posterior part"].get(self.completeness() as usize);
        let mut words: Vec<String> = complete.into_iter().map(|part| format!("complete {part}")).collect();
        for side in BodySide::BOTH {
            match (self.fetal[side.index()], self.has(Artery::P1(side))) {
                (true, true) => words.push(format!("{} fetal-type PCA, partial (PComm wider than P1)", side.name())),
                (true, false) => words.push(format!("{} fetal-type PCA", side.name())),
                _ => {}
            }
        }
        // The full fetal type implies that P1 is absent.
        let implied = |artery: &Artery| matches!(artery, Artery::P1(side) if self.fetal[side.index()]);
        words.extend(self.missing().into_iter().filter(|artery| !implied(artery)).map(|artery| format!("{artery} absent")));
        let unseen = BodySide::BOTH.into_iter().filter(|side| !self.ica[side.index()]);
        words.extend(unseen.map(|side| format!("{} not seen", Ica(side))));
        if !self.ba {
            words.push("BA not seen".to_owned());
        }
        if self.third_a2 {
            words.push("a third A2".to_owned());
        }
        let fenestrated = FENESTRATED.into_iter().zip(self.fenestration).filter(|(_, is)| *is);
        words.extend(fenestrated.map(|(artery, _)| format!("{artery} fenestrated")));
        words.join(", ")
    }
}

/// For each vessel of a graph file whether it counts as present, and a note where some do not. All count where the file says what an
/// earlier run kept, for those that it pruned are not read; else the observed ones, or all where it does not say what was observed.
pub fn present_vessels(network: &Network) -> (Vec<bool>, Option<&'static str>) {
    let states_kept = network.vessels().any(|(_, vessel)| vessel.kept.is_some());
    let observed: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.origin == Origin::Observed).collect();
    if !states_kept && observed.contains(&true) && observed.contains(&false) {
        return (observed, Some("candidates do not count: nothing says which were kept"));
    }
    (vec![true; network.vessel_count()], None)
}
