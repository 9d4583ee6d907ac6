//! What the inputs were like that weights were fitted to. Where another one is unlike all of them, its probabilities may be off.

use crate::candidates::features::Extraction;
use crate::candidates::features::root_features::{radius_variation, width_in_spacings};

/// The figures by their names in files and in words: how many fragments there are, and of a fragment the mean of its free ends, the geometric
/// mean of the radius of its widest end in steps of the points, and the mean standard deviation of ln r along it.
pub const FIGURES: [(&str, &str); 4] = [
    ("fragments", "fragments"),
    ("free_ends", "free ends a fragment"),
    ("end_radius", "steps in the radius of an end"),
    ("radius_variation", "variation of the radius"),
];

/// The range of each of [`FIGURES`] over some extractions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Usual(pub [[f64; 2]; FIGURES.len()]);

impl Usual {
    /// That of one extraction; `None` without a fragment.
    pub fn new(extraction: &Extraction) -> Option<Self> {
        let fragments = &extraction.fragments;
        let mean = |of: &dyn Fn(usize) -> f64| (0..fragments.len()).map(of).sum::<f64>() / fragments.len() as f64;
        let figures = [
            fragments.len() as f64,
            mean(&|f| fragments[f].free_ends as f64),
            mean(&|f| width_in_spacings(extraction, &fragments[f])).exp(),
            mean(&|f| radius_variation(extraction, &fragments[f])),
        ];
        (!fragments.is_empty()).then(|| Self(figures.map(|x| [x; 2])))
    }

    /// The range over both.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        for ([least, most], [a, b]) in self.0.iter_mut().zip(other.0) {
            (*least, *most) = (least.min(a), most.max(b));
        }
        self
    }

    /// What to tell a person of one extraction with a figure that none of those in the range `seen` had; `None` where it has none.
    pub fn unlike(self, seen: Self) -> Option<String> {
        let figures = FIGURES.into_iter().zip(self.0).zip(seen.0);
        let told: Vec<String> = figures
            .filter(|((_, [here, _]), [least, most])| here < least || here > most)
            .map(|(((_, words), [here, _]), range)| {
                let [least, most] = range.map(short);
                format!("{} {words} (there {least} to {most})", short(here))
            })
            .collect();
        (!told.is_empty()).then(|| {
            format!(
                "the centerlines are unlike all that the probabilities were fitted to: {}; read them as a rank, not as a share",
                told.join(" and ")
            )
        })
    }
}

/// A whole number as it is, another with two digits behind the point.
fn short(x: f64) -> String {
    if x.fract() == 0.0 { format!("{x:.0}") } else { format!("{x:.2}") }
}
