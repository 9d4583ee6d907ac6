//! What a Circle of Willis has and lacks, small enough to be counted.

use super::artery::{Artery, RING, Side};

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
    /// Whether L-A1, AComm, R-A1, L-P1, R-P1 ([`super::FENESTRATED`]) run in two channels somewhere.
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
    pub(super) fn set(&mut self, segment: Artery, present: bool) {
        if let Some(row) = RING.iter().position(|artery| *artery == segment) {
            self.present[row] = present;
        }
    }

    /// A fetal posterior cerebral artery: P1 is not there and PComm is, or PComm is wider by a twentieth (Musio et al. 2026, by the
    /// 25th percentile of the radii along either; `wider` says so).
    pub(super) fn set_fetal(&mut self, side: Side, wider: impl FnOnce() -> bool) {
        self.fetal[side.row()] = self.has(Artery::PComm(side)) && (!self.has(Artery::P1(side)) || wider());
    }
}
