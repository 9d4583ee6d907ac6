//! What the inputs were like that weights were fitted to. Where another one is unlike all of them, its probabilities may be off.

use serde::{Deserialize, Serialize};

use crate::candidates::features::Extraction;
use crate::candidates::features::root_features::{radius_variation, width_in_spacings};

/// Figures of an extraction as a whole, or their range over several.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Usual {
    /// How many fragments it has.
    pub fragments: [f64; 2],
    /// Free ends of a fragment, mean.
    pub free_ends: [f64; 2],
    /// Radius of a fragment's widest end in steps of the points, geometric mean.
    pub end_radius: [f64; 2],
    /// Standard deviation of ln r along a fragment, mean.
    pub radius_variation: [f64; 2],
}

impl Usual {
    /// Those of an extraction, as a range of one; `None` without a fragment.
    pub fn new(extraction: &Extraction) -> Option<Self> {
        let fragments = &extraction.fragments;
        let mean = |of: &dyn Fn(usize) -> f64| (0..fragments.len()).map(of).sum::<f64>() / fragments.len() as f64;
        (!fragments.is_empty()).then(|| Self {
            fragments: [fragments.len() as f64; 2],
            free_ends: [mean(&|f| fragments[f].free_ends as f64); 2],
            end_radius: [mean(&|f| width_in_spacings(extraction, &fragments[f])).exp(); 2],
            radius_variation: [mean(&|f| radius_variation(extraction, &fragments[f])); 2],
        })
    }

    /// The figures with their names.
    pub fn figures(&self) -> [(&'static str, [f64; 2]); 4] {
        [
            ("fragments", self.fragments),
            ("free ends a fragment", self.free_ends),
            ("steps in the radius of an end", self.end_radius),
            ("variation of the radius", self.radius_variation),
        ]
    }

    /// The range that has both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            fragments: both(self.fragments, other.fragments),
            free_ends: both(self.free_ends, other.free_ends),
            end_radius: both(self.end_radius, other.end_radius),
            radius_variation: both(self.radius_variation, other.radius_variation),
        }
    }

    /// What to tell a person of an extraction with a figure that none of those in the range `seen` had; `None` where it has none.
    pub fn unlike(self, seen: Self) -> Option<String> {
        let outside = |(here, [least, most]): ([f64; 2], [f64; 2])| here[0] < least || here[0] > most;
        let named = self.figures().into_iter().zip(seen.figures()).filter(|((_, here), (_, range))| outside((*here, *range)));
        let told: Vec<String> = named
            .map(|((name, [here, _]), (_, [least, most]))| {
                format!("{} {name} (there {} to {})", short(here), short(least), short(most))
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

#[cfg(test)]
mod tests {
    use super::Usual;

    fn of(fragments: f64, variation: f64) -> Usual {
        Usual { fragments: [fragments; 2], free_ends: [2.0; 2], end_radius: [1.5; 2], radius_variation: [variation; 2] }
    }

    #[test]
    fn what_no_case_had_is_told_with_its_figure_and_the_range() {
        let seen = of(3.0, 0.1).with(of(250.0, 0.3));
        assert_eq!(of(3.0, 0.3).unlike(seen), None);
        let told = of(1204.0, 0.2).unlike(seen).expect("a note");
        assert!(told.contains("1204 fragments (there 3 to 250)") && !told.contains("variation"), "{told}");
        assert!(of(9.0, 0.05).unlike(seen).expect("a note").contains("0.05 variation of the radius (there 0.10 to 0.30)"));
    }
}
