//! What a person calls a circle: the published variants, how complete it is, and the whole of it in words.

use super::artery::{Artery, FENESTRATED, Side};
use super::variant::Variant;

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
