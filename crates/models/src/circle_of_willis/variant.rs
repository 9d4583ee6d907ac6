//! The variant of a circle: which segments are present, and the name and description of the whole.

use super::arteries::{Artery, BodySide, FENESTRATED, RING};
use willis_core::network::{Network, Origin};

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

/// The missing segments of the ten variants that Padmos et al., J R Soc Interface 19:20220649 (2022), publish.
const PUBLISHED: [&[Artery]; 10] = [
    &[Artery::AComm],
    &[Artery::A1(BodySide::Left)],
    &[Artery::A1(BodySide::Right)],
    &[Artery::P1(BodySide::Left)],
    &[Artery::P1(BodySide::Right)],
    &[Artery::PComm(BodySide::Left)],
    &[Artery::PComm(BodySide::Right)],
    &[Artery::PComm(BodySide::Left), Artery::PComm(BodySide::Right)],
    &[Artery::P1(BodySide::Right), Artery::PComm(BodySide::Left)],
    &[Artery::P1(BodySide::Left), Artery::PComm(BodySide::Right)],
];

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
        match self {
            Self::Complete => "complete",
            Self::AnteriorComplete => "anterior complete",
            Self::PosteriorComplete => "posterior complete",
            Self::Incomplete => "incomplete",
        }
    }
}

impl Variant {
    /// Whether a segment of the ring is present; false for other arteries.
    pub fn has(&self, segment: Artery) -> bool {
        RING.iter().position(|artery| *artery == segment).is_some_and(|row| self.present[row])
    }

    /// The segments of the ring that are absent.
    pub fn missing(&self) -> Vec<Artery> {
        RING.into_iter().zip(self.present).filter(|(_, present)| !present).map(|(artery, _)| artery).collect()
    }

    /// Sets whether a segment of the ring is present.
    pub(crate) fn set(&mut self, segment: Artery, present: bool) {
        if let Some(row) = RING.iter().position(|artery| *artery == segment) {
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
        missing.is_empty() || PUBLISHED.contains(&&missing[..])
    }

    /// Its description: `complete anterior part, left fetal-type PCA, R-PComm absent`.
    pub fn words(&self) -> String {
        let complete = match self.completeness() {
            Completeness::Complete => Some("complete circle"),
            Completeness::AnteriorComplete => Some("complete anterior part"),
            Completeness::PosteriorComplete => Some("complete posterior part"),
            Completeness::Incomplete => None,
        };
        let mut words: Vec<String> = complete.into_iter().map(str::to_owned).collect();
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
        words.extend(
            BodySide::BOTH.into_iter().filter(|s| !self.ica[s.index()]).map(|side| format!("{} not seen", Artery::Ica(side))),
        );
        if !self.ba {
            words.push("BA not seen".to_owned());
        }
        if self.third_a2 {
            words.push("a third A2".to_owned());
        }
        words.extend(
            FENESTRATED.into_iter().zip(self.fenestration).filter(|(_, is)| *is).map(|(a, _)| format!("{a} fenestrated")),
        );
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
