//! Ranges and ticks of real numbers on a linear axis.

use super::axis::{Label, Tick};

/// A range of real numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearRange {
    /// The smallest value.
    pub low: f64,
    /// The largest value, above it.
    pub high: f64,
}

impl LinearRange {
    /// The range of the finite ones among `values` with a little air at each end; `None` without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let finite = values.into_iter().filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return None;
        }
        let air = (0.06 * (high - low)).max(1e-3 * low.abs().max(high.abs())).max(1e-6);
        Some(Self { low: low - air, high: high + air })
    }

    /// The share of the range below `value`.
    pub fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Ticks at a step of 1, 2 or 5 times a power of ten, at most `most` (two or more) of them.
    pub fn ticks(&self, most: usize) -> Vec<Tick> {
        let span = self.high - self.low;
        let power = (span / most as f64).log10().floor() as i32;
        let fits = |(m, e): &(f64, i32)| span / (m * 10_f64.powi(*e)) <= most as f64 - 1.0 + 1e-9;
        let steps = (power..).flat_map(|e| [1.0, 2.0, 5.0].map(|m| (m, e)));
        let (m, e) = steps.into_iter().find(fits).unwrap_or((1.0, power));
        let step = m * 10_f64.powi(e);
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        (first..=last).map(|k| Tick { at: k as f64 * step, label: label(k as f64 * step, e) }).collect()
    }
}

/// A multiple of 10^e with the decimals that it takes.
fn label(value: f64, e: i32) -> Label {
    let text =
        if value != 0.0 && !(-6..6).contains(&e) { format!("{value:e}") } else { format!("{value:.*}", (-e).max(0) as usize) };
    Label::plain(text.replace('-', "\u{2212}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_a_few_round_numbers() {
        let read = |low, high| {
            let ticks = LinearRange { low, high }.ticks(6);
            ticks.into_iter().map(|t| t.label.text).collect::<Vec<_>>()
        };
        assert_eq!(read(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(read(-3.2, 1.1), ["\u{2212}3", "\u{2212}2", "\u{2212}1", "0", "1"]);
        assert_eq!(read(0.0, 4200.0), ["0", "1000", "2000", "3000", "4000"]);
        assert_eq!(LinearRange::of([f64::NAN]), None);
        assert!(LinearRange::of([2.0, 2.0]).is_some_and(|r| r.low < 2.0 && r.high > 2.0));
    }
}
