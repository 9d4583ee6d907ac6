//! Stenosis: a vessel narrowed over its whole length or over a stretch of it.

use crate::flow::Factors;

/// A narrowing. With the open share of the diameter o = 1 - s (s the reduction of diameter), and the narrowed share of the
/// length f = stretch/l, the narrowed and the normal stretch are in series under Poiseuille's law:
/// R' = R·(1 - f + f/o⁴), the volume of the lumen V' = V·(1 - f + f·o²), and the radius where it is narrowest r' = r·o.
///
/// A steady flow does not notice where along the vessel the stretch lies. The loss of a jet behind the narrowing, which
/// goes as the square of the flow (Young & Tsai 1973), is not part of this law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stenosis {
    /// What is left of the diameter, in (0, 1].
    pub open_diameter: f64,
    /// Length of the narrowed stretch, m; the whole vessel where there is none.
    pub stretch: Option<f64>,
    /// Where the stretch lies, which only a pulse notices.
    pub place: StretchPlace,
}

/// Where a narrowed stretch lies in a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StretchPlace {
    /// At the first node.
    Start,
    /// In the middle.
    #[default]
    Middle,
    /// At the second node.
    End,
}

impl Stenosis {
    /// A reduction of the diameter by the share `reduction` in [0, 1), over the whole vessel.
    pub fn of_diameter(reduction: f64) -> Self {
        Self { open_diameter: 1.0 - reduction, stretch: None, place: StretchPlace::Middle }
    }

    /// A reduction of the cross-section area by the share `reduction` in [0, 1): o = sqrt(1 - reduction).
    pub fn of_area(reduction: f64) -> Self {
        Self { open_diameter: (1.0 - reduction).sqrt(), stretch: None, place: StretchPlace::Middle }
    }

    /// The factors for a vessel of a length in m, at least the stretch.
    pub fn factors(&self, length: f64) -> Factors {
        let narrow = self.stretch.map_or(1.0, |stretch| stretch / length);
        let (normal, radius) = (1.0 - narrow, self.open_diameter);
        let (resistance, volume) = (normal + narrow / radius.powi(4), normal + narrow * radius * radius);
        Factors { resistance, volume, radius, length: 1.0 }
    }
}
