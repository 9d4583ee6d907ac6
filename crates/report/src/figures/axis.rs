//! The ranges of axes and their ticks: counts, logarithmic and linear axes.

use plotters::coord::ranged1d::{BoldPoints, Ranged};

/// The text at a tick: `text`, then an exponent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TickLabel {
    /// The text on the line.
    pub text: String,
    /// The exponent after it.
    pub exponent: String,
}

/// A tick in the coordinate of its axis (the value, or its log10).
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// The position.
    pub at: f64,
    /// The text.
    pub label: TickLabel,
}

impl TickLabel {
    /// A label without an exponent.
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), exponent: String::new() }
    }

    /// This label with a sign before it.
    #[must_use]
    pub fn after(self, sign: &str) -> Self {
        Self { text: format!("{sign} {}", self.text), ..self }
    }

    /// A power of ten after a factor.
    pub fn power(prefix: &str, exponent: i32) -> Self {
        Self { text: format!("{prefix}10"), exponent: exponent.to_string().replace('-', "\u{2212}") }
    }
}

/// A range of positive values by their log10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRange {
    /// log10 of the smallest value.
    pub low: f64,
    /// log10 of the largest value.
    pub high: f64,
    /// Whether smaller positive values were left out.
    pub clipped: bool,
}

/// How many decades below the largest value an axis shows. Smaller values are rounding or practically zero.
const DECADES: f64 = 12.0;

impl LogRange {
    /// The range of the positive `values`: at least one decade, and at most `DECADES` below the largest.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let positive = values.into_iter().filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) = positive.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        if high <= 0.0 {
            return None;
        }
        let (low, high) = (low.log10(), high.log10());
        let clipped = high - low > DECADES;
        Some(Self { low: if clipped { (high - DECADES).ceil() } else { low.min(high - 1.0) }, high, clipped })
    }

    /// The range with a margin at each end, but none where smaller values were left out.
    #[must_use]
    pub fn padded(self) -> Self {
        let margin = (self.high - self.low) * 0.04;
        Self { low: if self.clipped { self.low } else { self.low - margin }, high: self.high + margin, ..self }
    }

    /// The share of the range below `value`; negative below the range, which zero always is.
    pub fn share(&self, value: f64) -> f64 {
        self.share_of_log(value.log10())
    }

    /// The share of the range below the value with that log10.
    pub fn share_of_log(&self, log: f64) -> f64 {
        (log - self.low) / (self.high - self.low)
    }

    /// Ticks at powers of ten, or in 1-2-5 steps where the range has fewer than three powers.
    pub fn ticks(&self) -> Vec<Tick> {
        let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
        if last - first >= 2 {
            let step = (last - first) / 10 + 1;
            let power = |e| Tick { at: f64::from(e), label: TickLabel::power("", e) };
            return (first..=last).step_by(step as usize).map(power).collect();
        }
        let short = self.low >= -3.0 && self.high < 5.0;
        let mut ticks = Vec::new();
        for e in first - 1..=last {
            for m in [1, 2, 5] {
                let at = f64::from(e) + f64::from(m).log10();
                if at < self.low - 1e-9 || at > self.high + 1e-9 {
                    continue;
                }
                let label = match m {
                    _ if short => TickLabel::plain(format!("{:.*}", (-e).max(0) as usize, f64::from(m) * 10_f64.powi(e))),
                    1 => TickLabel::power("", e),
                    _ => TickLabel::power(&format!("{m}\u{b7}"), e),
                };
                ticks.push(Tick { at, label });
            }
        }
        ticks
    }
}

/// Ticks at whole numbers from 0 to `last`, in steps of 1, 2 or 5 times a power of ten; at most `most` after 0.
pub fn count_ticks(last: u64, most: usize) -> Vec<Tick> {
    // Over at least `most` whole numbers a step is one or more.
    let ticks = LinearRange { low: 0.0, high: last.max(most as u64) as f64 }.ticks(most + 1);
    ticks.into_iter().filter(|tick| tick.at <= last as f64).collect()
}

/// How many decimals show three significant digits of a number, or all of those before the point: none of zero. 0.9999 is 1.00.
pub fn decimals(x: f64) -> usize {
    let rounded = format!("{x:.2e}");
    let exponent = rounded.split_once('e').and_then(|(_, digits)| digits.parse().ok()).unwrap_or(0);
    if x == 0.0 { 0 } else { (2_i32 - exponent).max(0) as usize }
}

/// A whole number with commas between its thousands.
pub fn with_commas(n: u64) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(|g| std::str::from_utf8(g).ok()).collect();
    groups.join(",")
}

/// The same from five digits on.
pub fn grouped(n: u64) -> String {
    if n < 10_000 { n.to_string() } else { with_commas(n) }
}

/// A range of real numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearRange {
    /// The smallest value.
    pub low: f64,
    /// The largest value, above it.
    pub high: f64,
}

impl LinearRange {
    /// The range of the finite `values` with a margin at each end; `None` without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let finite = values.into_iter().filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return None;
        }
        let margin = (0.06 * (high - low)).max(1e-3 * low.abs().max(high.abs())).max(1e-6);
        Some(Self { low: low - margin, high: high + margin })
    }

    /// The share of the range below `value`.
    pub fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Ticks in steps of 1, 2 or 5 times a power of ten, at most `most` (two or more); none where numbers are too coarse for them: a range
    /// below 1e-300, infinite, or narrower than 1e-12 of its ends.
    pub fn ticks(&self, most: usize) -> Vec<Tick> {
        let rough = (self.high - self.low) / (most as f64 - 1.0);
        if !(rough.is_finite() && rough > (1e-12 * self.low.abs().max(self.high.abs())).max(1e-300)) {
            return Vec::new();
        }
        let points = plotters::coord::types::RangedCoordf64::from(self.low..self.high).key_points(BoldPoints(most));
        let [first, second, ..] = points[..] else { return Vec::new() };
        let step = second - first;
        let power = (step.log10() + 1e-6).floor() as i32;
        let factor = (step / 10_f64.powi(power)).round() as i64;
        let label = |at: f64| multiple((at / step).round() as i64 * factor, power);
        points.into_iter().map(|at| Tick { at, label: label(at) }).collect()
    }
}

/// `k` times ten to the `power`, in full where that is short.
fn multiple(k: i64, power: i32) -> TickLabel {
    let sign = if k < 0 { "\u{2212}" } else { "" };
    let digits = k.unsigned_abs();
    match power {
        _ if k == 0 => TickLabel::plain("0"),
        0..=5 => TickLabel::plain(format!("{sign}{}", grouped(digits * 10_u64.pow(power as u32)))),
        -3..0 => TickLabel::plain(format!("{sign}{:.*}", -power as usize, digits as f64 / 10_f64.powi(-power))),
        _ => TickLabel::power(&format!("{sign}{digits}\u{b7}"), power),
    }
}
