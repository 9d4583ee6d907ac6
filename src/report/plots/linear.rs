//! Ranges and ticks of real numbers on a linear axis.

use super::axis::{Label, Tick, grouped};

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

    /// Ticks a step of 1, 2 or 5 times a power of ten apart, at most `most` (two or more) of them.
    pub fn ticks(&self, most: usize) -> Vec<Tick> {
        let rough = (self.high - self.low) / (most as f64 - 1.0);
        let power = rough.log10().floor() as i32;
        let wide = |(factor, power): &(i64, i32)| *factor as f64 * 10_f64.powi(*power) >= rough * (1.0 - 1e-9);
        let next = (1, power + 1);
        let (factor, power) = [(1, power), (2, power), (5, power)].into_iter().find(wide).unwrap_or(next);
        let step = factor as f64 * 10_f64.powi(power);
        let (first, last) = ((self.low / step - 1e-9).ceil() as i64, (self.high / step + 1e-9).floor() as i64);
        (first..=last).map(|k| Tick { at: k as f64 * step, label: multiple(k * factor, power) }).collect()
    }
}

/// `k` times ten to the `power`, written out where that is short.
fn multiple(k: i64, power: i32) -> Label {
    let sign = if k < 0 { "\u{2212}" } else { "" };
    let digits = k.unsigned_abs();
    match power {
        _ if k == 0 => Label::plain("0"),
        0..=4 => Label::plain(format!("{sign}{}", grouped(digits * 10_u64.pow(power as u32)))),
        -3..0 => Label::plain(format!("{sign}{:.*}", -power as usize, digits as f64 / 10_f64.powi(-power))),
        _ => Label::power(&format!("{sign}{digits}\u{b7}"), power),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_a_few_round_numbers() {
        let read = |low, high, most| {
            let text = |t: Tick| match t.label.exponent.as_str() {
                "" => t.label.text,
                exponent => format!("{}^{exponent}", t.label.text),
            };
            LinearRange { low, high }.ticks(most).into_iter().map(text).collect::<Vec<_>>()
        };
        assert_eq!(read(0.0, 1.0, 6), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(read(-3.2, 1.1, 6), ["\u{2212}3", "\u{2212}2", "\u{2212}1", "0", "1"]);
        assert_eq!(read(0.0, 4200.0, 6), ["0", "1000", "2000", "3000", "4000"]);
        assert_eq!(read(-120.0, 230.0, 7), ["\u{2212}100", "0", "100", "200"]);
        assert_eq!(read(0.0, 0.04, 7), ["0", "0.01", "0.02", "0.03", "0.04"]);
        assert_eq!(read(0.0, 5e-7, 6)[..2], ["0", "1\u{b7}10^\u{2212}7"]);
        assert_eq!(LinearRange::of([f64::NAN]), None);
        assert!(LinearRange::of([2.0, 2.0]).is_some_and(|r| r.low < 2.0 && r.high > 2.0));
    }
}
