//! Which vessels of a graph file count: those that are kept, else those that an image showed.

use super::arteries::{Artery, FENESTRATED, RING, Side};
use crate::network::{Network, Origin};

/// Per vessel whether it counts, and a word on it where some do not: those that an earlier run kept, where the file says so; otherwise
/// the observed vessels, or all of a graph that knows no origin.
pub fn counted(network: &Network) -> (Vec<bool>, Option<&'static str>) {
    if network.vessels().any(|(_, vessel)| vessel.kept.is_some()) {
        let kept: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.kept == Some(true)).collect();
        let note = kept.contains(&false).then_some("vessels that were not kept do not count");
        return (kept, note);
    }
    let observed: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.origin == Origin::Observed).collect();
    if observed.contains(&true) && observed.contains(&false) {
        return (observed, Some("candidates do not count: nothing says which were kept"));
    }
    (vec![true; network.vessel_count()], None)
}

/// What the ten variants lack of which Padmos et al., J R Soc Interface 19:20220649 (2022), distribute configurations.
const PUBLISHED: [&[Artery]; 10] = [
    &[Artery::AComm],
    &[Artery::A1(Side::Left)],
    &[Artery::A1(Side::Right)],
    &[Artery::P1(Side::Left)],
    &[Artery::P1(Side::Right)],
    &[Artery::PComm(Side::Left)],
    &[Artery::PComm(Side::Right)],
    &[Artery::PComm(Side::Left), Artery::PComm(Side::Right)],
    &[Artery::P1(Side::Right), Artery::PComm(Side::Left)],
    &[Artery::P1(Side::Left), Artery::PComm(Side::Right)],
];

/// How much of the circle is closed. Complete: both parts are; partially complete: one of them; incomplete: neither (as in Naveen, Bhat,
/// Karthik, Ann Indian Acad Neurol 18:391-397 (2015)). The anterior part is both A1 and AComm, the posterior part both P1 and both PComm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Completeness {
    /// All seven segments.
    Complete,
    /// The anterior part alone is complete.
    AnteriorComplete,
    /// The posterior part alone is complete.
    PosteriorComplete,
    /// A segment is missing in either part.
    Incomplete,
}

impl Completeness {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::AnteriorComplete => "anterior complete",
            Self::PosteriorComplete => "posterior complete",
            Self::Incomplete => "incomplete",
        }
    }
}

impl Variant {
    /// How much of the circle is closed.
    pub fn completeness(&self) -> Completeness {
        let all = |rows: std::ops::Range<usize>| self.present[rows].iter().all(|present| *present);
        match (all(0..3), all(3..7)) {
            (true, true) => Completeness::Complete,
            (true, false) => Completeness::AnteriorComplete,
            (false, true) => Completeness::PosteriorComplete,
            (false, false) => Completeness::Incomplete,
        }
    }

    /// The name by what is missing: `complete`, `without L-A1`, `without L-P1, R-PComm`.
    pub fn name(&self) -> String {
        match self.missing()[..] {
            [] => "complete".to_owned(),
            ref missing => format!("without {}", listed(missing)),
        }
    }

    /// Whether it is the complete circle or one of the ten variants published by Padmos et al. 2022.
    pub fn is_published(&self) -> bool {
        let missing = self.missing();
        missing.is_empty() || PUBLISHED.contains(&&missing[..])
    }

    /// The whole of it in words: `complete anterior part, left fetal-type PCA, R-PComm absent`.
    pub fn words(&self) -> String {
        let mut said = match self.completeness() {
            Completeness::Complete => vec!["complete circle".to_owned()],
            Completeness::AnteriorComplete => vec!["complete anterior part".to_owned()],
            Completeness::PosteriorComplete => vec!["complete posterior part".to_owned()],
            Completeness::Incomplete => Vec::new(),
        };
        for side in Side::BOTH {
            match (self.fetal[side.row()], self.has(Artery::P1(side))) {
                (true, true) => said.push(format!("{} fetal-type PCA, partial (PComm wider than P1)", side.name())),
                (true, false) => said.push(format!("{} fetal-type PCA", side.name())),
                _ => {}
            }
        }
        // That P1 is absent is said by the full fetal type.
        let told = |artery: &Artery| matches!(artery, Artery::P1(side) if self.fetal[side.row()]);
        said.extend(self.missing().into_iter().filter(|artery| !told(artery)).map(|artery| format!("{artery} absent")));
        said.extend(Side::BOTH.into_iter().filter(|s| !self.ica[s.row()]).map(|side| format!("{} not seen", Artery::Ica(side))));
        if !self.ba {
            said.push("BA not seen".to_owned());
        }
        if self.third_a2 {
            said.push("a third A2".to_owned());
        }
        said.extend(
            FENESTRATED.into_iter().zip(self.fenestration).filter(|(_, is)| *is).map(|(a, _)| format!("{a} fenestrated")),
        );
        said.join(", ")
    }

    /// The complete variant and the ten published ones, in the order of Padmos et al. 2022; P1 missing means a fetal type where PComm is
    /// there.
    pub fn published() -> Vec<Self> {
        let lacking = |missing: &[Artery]| {
            let mut variant = Self::COMPLETE;
            for artery in missing {
                variant.set(*artery, false);
            }
            for side in Side::BOTH {
                variant.set_fetal(side, || false);
            }
            variant
        };
        std::iter::once(Self::COMPLETE).chain(PUBLISHED.iter().map(|missing| lacking(missing))).collect()
    }
}

fn listed(arteries: &[Artery]) -> String {
    arteries.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The anatomy of one circle. Pairs are left, right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Variant {
    /// Per segment of [`RING`] whether it is there and connects what it should.
    pub present: [bool; 7],
    /// Whether the internal carotids are there, each as far as its end.
    pub ica: [bool; 2],
    /// Whether the basilar artery is there.
    pub ba: bool,
    /// Whether the posterior cerebral artery is of fetal type: fed by the carotid more than by the basilar artery.
    pub fetal: [bool; 2],
    /// Whether there is a third A2.
    pub third_a2: bool,
    /// Whether L-A1, AComm, R-A1, L-P1, R-P1 ([`super::arteries::FENESTRATED`]) run in two channels somewhere.
    pub fenestration: [bool; 5],
}

impl Variant {
    /// The variant with all seven segments, both carotids and the basilar artery, and nothing unusual.
    pub const COMPLETE: Self =
        Self { present: [true; 7], ica: [true; 2], ba: true, fetal: [false; 2], third_a2: false, fenestration: [false; 5] };

    /// Whether a segment of the ring is there; false for other arteries.
    pub fn has(&self, segment: Artery) -> bool {
        RING.iter().position(|artery| *artery == segment).is_some_and(|row| self.present[row])
    }

    /// The segments of the ring that are not there.
    pub fn missing(&self) -> Vec<Artery> {
        RING.into_iter().zip(self.present).filter(|(_, present)| !present).map(|(artery, _)| artery).collect()
    }

    /// Sets whether a segment of the ring is there.
    pub(crate) fn set(&mut self, segment: Artery, present: bool) {
        if let Some(row) = RING.iter().position(|artery| *artery == segment) {
            self.present[row] = present;
        }
    }

    /// A fetal posterior cerebral artery: P1 is not there and PComm is, or PComm is wider by a twentieth (Musio et al. 2026, by the
    /// 25th percentile of the radii along either; `wider` says so).
    pub(crate) fn set_fetal(&mut self, side: Side, wider: impl FnOnce() -> bool) {
        self.fetal[side.row()] = self.has(Artery::PComm(side)) && (!self.has(Artery::P1(side)) || wider());
    }
}
