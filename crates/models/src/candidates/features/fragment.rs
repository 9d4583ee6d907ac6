//! What is measured of a whole fragment: its size, its ends, the spread of its radii, and where blood may enter it.

use super::extraction::Extraction;
use super::tangent::{Heading, steps};
use willis_core::network::may_be_speck;
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{dot, sub, unit};
use willis_core::support::ties::steady;

/// What may be a speck is joined over no gap wider than so many of its lengths.
const SPECK_REACH: f64 = 2.0;

/// A connected part of what the image showed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fragment {
    /// The length of its vessels, m.
    pub length: f64,
    /// The geometric mean of its points' radii, m.
    pub radius: f64,
    /// The radius of its widest free end, m.
    pub widest_end: Option<f64>,
    /// The standard deviation of ln of its points' radii, averaged along the branches.
    pub radius_spread: f64,
    /// How many free ends it has.
    pub free_ends: usize,
    /// How many junctions it has.
    pub junctions: usize,
    /// Whether it holds an inlet.
    pub fed: bool,
}

impl Fragment {
    /// The widest gap (m) over which an automatic skeleton's fragment may be joined; infinite but for what may be a speck.
    pub fn reach(&self) -> f64 {
        if may_be_speck(self.length, 2.0 * self.radius) { SPECK_REACH * self.length } else { f64::INFINITY }
    }

    /// The radius (m) of its widest free end, half a spacing at least.
    pub fn end_radius(&self, spacing: f64) -> f64 {
        self.widest_end.unwrap_or(0.0).max(0.5 * spacing)
    }
}

/// The largest figures of an extraction, beside which those of its fragments and ends are measured.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Largest {
    /// Length of a fragment, m.
    pub length: f64,
    /// Radius of a free end, m.
    pub end: f64,
    /// Radius of a fragment's widest free end, half a spacing at least, m.
    pub fragment_end: f64,
}

impl Extraction {
    /// The largest figures; the fragments must be measured.
    pub(crate) fn measure_largest(&self) -> Largest {
        let most = |figures: &mut dyn Iterator<Item = f64>| figures.fold(0.0, f64::max);
        Largest {
            length: most(&mut self.fragments.iter().map(|f| f.length)),
            end: most(&mut self.ends.iter().map(|end| end.radius)),
            fragment_end: most(&mut self.fragments.iter().map(|f| f.end_radius(self.spacing))),
        }
    }

    /// The fragments, so many.
    pub(crate) fn measure_fragments(&self, count: usize) -> Vec<Fragment> {
        let mut out = vec![Fragment::default(); count];
        for (line, length) in self.lines.iter().zip(&self.graph.length) {
            out[self.fragment[line[0]]].length += length;
        }
        let mut points = vec![0.0; count];
        for (part, radius) in self.fragment.iter().zip(&self.radius) {
            out[*part].radius += radius.ln();
            points[*part] += 1.0;
        }
        for (part, points) in out.iter_mut().zip(&points) {
            part.radius = f64::exp(part.radius / f64::max(*points, 1.0));
        }
        for (part, spread) in out.iter_mut().zip(self.radius_spreads(&points)) {
            part.radius_spread = spread;
        }
        for (node, degree) in self.degree.iter().enumerate() {
            out[self.fragment[node]].junctions += usize::from(*degree > 2);
        }
        for end in &self.ends {
            let widest = &mut out[end.fragment].widest_end;
            *widest = Some(widest.map_or(end.radius, |r: f64| r.max(end.radius)));
            out[end.fragment].free_ends += 1;
        }
        for inlet in &self.inlets {
            out[self.fragment[*inlet]].fed = true;
        }
        out
    }

    /// Per fragment the standard deviation of ln of the smooth radii of its so many points.
    fn radius_spreads(&self, points: &[f64]) -> Vec<f64> {
        let mean = |of: &dyn Fn(usize, f64) -> f64| {
            let mut sum = vec![0.0; points.len()];
            for (part, radius) in self.fragment.iter().zip(&self.smooth.radius) {
                sum[*part] += of(*part, radius.ln());
            }
            sum.iter().zip(points).map(|(sum, points)| sum / f64::max(*points, 1.0)).collect::<Vec<f64>>()
        };
        let middle = mean(&|_, log| log);
        mean(&|part, log| (log - middle[part]).powi(2)).into_iter().map(f64::sqrt).collect()
    }
}

/// The branches at a junction are followed over so many of its radii, within so many points.
const ARM_RADII: f64 = 3.0;
const ARM_POINTS: [f64; 2] = [4.0, 12.0];
/// The orientation is the mean over so many junctions, the nearest along the vessels.
const JUNCTIONS: usize = 12;
/// Bound of the orientation.
const MOST: f64 = 1.5;

/// A branch at a junction.
struct Arm {
    branch: usize,
    /// The node at its other end.
    other: usize,
    /// J of this branch less the largest J of the others; J, if blood came by this branch, is the least cosine between the
    /// direction it came in and those it leaves by.
    preference: f64,
}

impl Extraction {
    /// Per free end the mean, in [-1.5, 1.5], over the twelve junctions nearest along the vessels (and those as near as the
    /// twelfth) of how much better blood divides there if it comes from this end; 0 without a junction.
    pub(crate) fn orientations(&self) -> Vec<f64> {
        let nodes = self.graph.nodes();
        let arms: Vec<Vec<Arm>> =
            (0..nodes).map(|node| if self.degree[node] > 2 { self.arms(node) } else { Vec::new() }).collect();
        let mut paths = ShortestPaths::new(nodes);
        let mean = |end: usize| {
            let (mut sum, mut count, mut last) = (0.0, 0, 0.0);
            self.graph.search(&[end], f64::INFINITY, &mut paths, |length, node| {
                let away = steady(length[node] / self.spacing);
                let by = |arm: &Arm| (steady((length[arm.other] + self.graph.length[arm.branch]) / self.spacing), arm.preference);
                let order = |a: &Arm, b: &Arm| by(a).0.total_cmp(&by(b).0).then(by(a).1.total_cmp(&by(b).1));
                if count >= JUNCTIONS && away > last {
                    return false;
                }
                if let Some(arm) = arms[node].iter().min_by(|a, b| order(a, b)) {
                    (sum, count, last) = (sum + arm.preference, count + 1, away);
                }
                true
            });
            if count > 0 { (sum / count as f64).clamp(-MOST, MOST) } else { 0.0 }
        };
        self.ends.iter().map(|end| end.point).map(mean).collect()
    }

    fn arms(&self, junction: usize) -> Vec<Arm> {
        let steps = steps(ARM_RADII, ARM_POINTS, self.smooth.radius[junction], self.spacing);
        let headings = self.headings(junction);
        let position = |point: usize| self.smooth.position[point];
        let directions: Vec<_> =
            headings.iter().map(|heading| unit(sub(position(self.walk(*heading, steps)), position(junction)))).collect();
        let others = |own: usize| (0..headings.len()).filter(move |other| *other != own);
        let forwards: Vec<f64> = (0..headings.len())
            .map(|own| others(own).map(|other| -dot(directions[own], directions[other])).fold(f64::INFINITY, f64::min))
            .collect();
        let arm = |(own, heading): (usize, &Heading)| Arm {
            branch: heading.branch,
            other: self.walk(*heading, usize::MAX / 2),
            preference: forwards[own] - others(own).map(|other| forwards[other]).fold(f64::NEG_INFINITY, f64::max),
        };
        headings.iter().enumerate().map(arm).collect()
    }
}
