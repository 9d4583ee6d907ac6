//! One period of a pressure or a flow, as a table states it.

/// What a waveform is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Pa.
    Pressure,
    /// m³/s.
    Flow,
}

/// One period of a periodic signal: a line through points, whose last point is followed by the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Waveform {
    /// What it is of.
    pub quantity: Quantity,
    /// s, never falling; two points at one time are a step.
    pub times: Vec<f64>,
    /// Pa or m³/s.
    pub values: Vec<f64>,
}

/// How near to its first value, as a share of the swing, the last value of a waveform closes it.
const CLOSES: f64 = 1e-6;
/// How many times the largest step within a waveform the step from its last to its first value may be.
const MOST_STEP: f64 = 2.0;

impl Waveform {
    /// The period that its times mean, s: up to the last one where the last value closes the first, else a step further.
    pub fn own_period(&self) -> f64 {
        let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
        let step = last - self.times.iter().rev().copied().find(|t| *t < last).unwrap_or(first);
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = self.values.iter().fold(ends, |(low, high), x| (low.min(*x), high.max(*x)));
        let jump = (self.values[self.values.len() - 1] - self.values[0]).abs();
        last - first + if jump <= CLOSES * (high - low) { 0.0 } else { step }
    }

    /// Refuses points that are not one period of `period` s.
    ///
    /// # Errors
    ///
    /// What is wrong, and what is accepted.
    pub fn check(&self, period: f64) -> Result<(), (String, String)> {
        let largest = |of: &[f64]| of.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
        let gap = period - (last - first);
        // Times are printed with a few digits.
        if gap < -1e-9 * period {
            let found = format!("times over {} s, longer than the period of {period} s", last - first);
            return Err((found, "expected one period".to_owned()));
        }
        if gap > largest(&self.times) * (1.0 + 1e-6) {
            let found = format!("times that end {gap} s before the period of {period} s does");
            return Err((found, format!("expected one period: at most a step, {} s", largest(&self.times))));
        }
        let jump = (self.values[self.values.len() - 1] - self.values[0]).abs();
        let swing = largest(&self.values);
        if gap > 1e-9 * period && jump > MOST_STEP * swing * (1.0 + 1e-9) {
            let found = format!("values that end {:.3} times their largest step from where they begin", jump / swing);
            return Err((found, "expected one period, or two rows at one time where the signal jumps".to_owned()));
        }
        Ok(())
    }
}
