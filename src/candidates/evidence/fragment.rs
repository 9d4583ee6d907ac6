//! What a fragment is as a whole: its size, its ends, and how even it is.

use super::extraction::Extraction;

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

impl Extraction {
    /// The fragments, so many.
    pub(super) fn measure_fragments(&self, count: usize) -> Vec<Fragment> {
        let mut out = vec![Fragment::default(); count];
        for (line, length) in self.lines.iter().zip(&self.roads.length) {
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
