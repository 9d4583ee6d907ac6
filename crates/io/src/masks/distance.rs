//! The exact Euclidean distance from every voxel of a vessel to the nearest voxel outside, with voxels that are boxes of any lengths.
//!
//! Squared distances along one axis after the other, each by the lower envelope of parabolas: Felzenszwalb and Huttenlocher, "Distance
//! transforms of sampled functions", Theory of Computing 8 (2012). Beyond the image's border nothing is known, so that is no outside.

/// The distance of each voxel, in the unit of `spacing`; infinite where the image has no voxel outside vessels.
pub fn distances(vessels: &super::foreground::Foreground, spacing: [f64; 3]) -> Vec<f64> {
    let strides = vessels.strides();
    let mut squared = vec![f64::INFINITY; vessels.count()];
    let (mut run, mut values) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for place in vessels.places() {
            if vessels.contains(place - strides[axis]) {
                continue;
            }
            run.clear();
            run.extend((0..).map_while(|n| vessels.row(place + n * strides[axis])));
            let (first, last) = (vessels.voxel_at(place), vessels.voxel_at(place + (run.len() - 1) * strides[axis]));
            values.clear();
            values.push(if vessels.is_last(first, axis, false) { f64::INFINITY } else { 0.0 });
            values.extend(run.iter().map(|row| squared[*row]));
            values.push(if vessels.is_last(last, axis, true) { f64::INFINITY } else { 0.0 });
            let lowest = envelope(&values, spacing[axis]);
            run.iter().zip(&lowest[1..]).for_each(|(row, value)| squared[*row] = *value);
        }
    }
    for value in &mut squared {
        *value = value.sqrt();
    }
    squared
}

/// The least of `values[q] + (step (p - q))²` over q, for every p.
fn envelope(values: &[f64], step: f64) -> Vec<f64> {
    let square = |x: f64| x * x;
    let mut parabolas: Vec<(usize, f64)> = Vec::new();
    for (q, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        let mut from = f64::NEG_INFINITY;
        while let Some((p, begins)) = parabolas.last() {
            let (a, b) = (values[*p] + square(step * *p as f64), value + square(step * q as f64));
            from = (b - a) / (2.0 * square(step) * (q - p) as f64);
            if from > *begins {
                break;
            }
            parabolas.pop();
            from = f64::NEG_INFINITY;
        }
        parabolas.push((q, from));
    }
    let mut at = 0;
    (0..values.len())
        .map(|p| {
            while parabolas.get(at + 1).is_some_and(|(_, from)| *from <= p as f64) {
                at += 1;
            }
            parabolas.get(at).map_or(f64::INFINITY, |(q, _)| values[*q] + square(step * p.abs_diff(*q) as f64))
        })
        .collect()
}
