//! The convergence of the likelihood: mean contribution per sample against the number of samples.

use super::axis::{LogRange, TickLabel, count_ticks, grouped};
use super::colour::{INK, KEPT, PAPER, PRUNED, Rgb};
use super::figure::Figure;
use super::legend::{self, LegendKey, REFERENCE};
use super::sheet::{Align, Sheet, SheetPlace};
use super::style::{BOLD, CURVE, NAME_BELOW, NAME_LEFT, POINTS_PER_INCH, TICK};
use willis_core::sampling::Weight;
use willis_io::output::names::CONVERGENCE_PICTURE;

const PAGE: [f64; 2] = [6.4 * POINTS_PER_INCH, 4.6 * POINTS_PER_INCH];
/// Left, top, right and bottom of the axes, points.
const BOX: [f64; 4] = [62.0, 50.0, 440.0, 284.0];
/// Height of the line of zeros, points.
const ZERO: f64 = BOX[3] - 5.0;
/// The distance between that line and the lowest positive value, points.
const GAP: f64 = 16.0;

/// The largest number of curves of kept vessels, and of pruned ones; more cannot be distinguished.
const MOST_CURVES: usize = 400;

/// The width of the thinnest curve, points.
const THIN: f64 = 0.5;

/// What the line across the curves is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutLine {
    /// The threshold of the rule: vessels above it are kept.
    Threshold,
    /// The median of L, above which lies the topology of that name. The rule decides by something else than L.
    Median,
}

/// Draws the mean contribution per sample, L/n, of every uncertain vessel against the number of samples n, on a
/// logarithmic axis, 6.4 by 4.6 inches. The median is a dashed line.
///
/// - `samples`: n at each checkpoint, positive and rising.
/// - `series`: for each vessel L/n at each checkpoint. Of more than 400 that are kept, or pruned, only a regular selection is drawn.
/// - `threshold`: the threshold or median on L/n at each checkpoint, as `cut` says; NaN where there is none.
/// - `kept`: for each vessel whether it is kept.
/// - `weight`: what L adds up, from which its unit follows.
///
/// Zeros, and values more than twelve decades below the largest, lie on a line of their own below the smallest positive value; curves
/// do not join the two. A single checkpoint is drawn as dashes. A picture without a vessel, a checkpoint or a positive value is one sentence.
pub fn convergence(
    samples: &[u64],
    series: &[Vec<f64>],
    (cut, threshold): (CutLine, &[f64]),
    kept: &[bool],
    weight: Weight,
) -> Figure {
    let mut sheet = Sheet::default();
    let [left, top, right, bottom] = BOX;
    sheet.title("Convergence of the likelihood of uncertain vessels", left);

    let values = || series.iter().flatten().chain(threshold).copied();
    let range = if series.is_empty() { None } else { LogRange::of(values()) };
    let Some(range) = range.map(LogRange::padded) else {
        let note = match (series.is_empty(), samples.is_empty()) {
            (true, _) => "Every vessel is certain: there is no likelihood that could converge.",
            (_, true) => "No sample was drawn.",
            _ => "No uncertain vessel carries blood in any sample.",
        };
        sheet.plain(note, [left, top], Align::Begin);
        return Figure::new(CONVERGENCE_PICTURE, PAGE, sheet);
    };

    let lowest = values().fold(f64::INFINITY, f64::min);
    let axes = ConvergenceAxes { last: samples.last().copied().unwrap_or(1), range, zeros: range.share(lowest) < 0.0 };
    axes.ticks(&mut sheet, weight);
    // A few curves are thick and opaque, thousands thin and transparent.
    let curves = [false, true].map(|kept_ones| {
        let all: Vec<&Vec<f64>> =
            series.iter().zip(kept).filter(|(_, kept)| **kept == kept_ones).map(|(values, _)| values).collect();
        let step = all.len().div_ceil(MOST_CURVES).max(1);
        all.into_iter().step_by(step).collect::<Vec<_>>()
    });
    let sparse = (10.0 / (curves[0].len() + curves[1].len()) as f64).sqrt().clamp(0.0, 1.0);
    let width = THIN + sparse * (CURVE - THIN);
    let opacity = 0.05 + 0.85 * sparse.powf(0.7);
    for (curves, rgb) in curves.iter().zip([PRUNED, KEPT]) {
        for run in curves.iter().flat_map(|values| axes.runs(samples, values)) {
            axes.stroke(&mut sheet, &run, width, rgb, opacity);
        }
    }
    for run in axes.runs(samples, threshold) {
        match cut {
            CutLine::Threshold => {
                axes.stroke(&mut sheet, &run, 2.0 * BOLD, PAPER, 0.8);
                axes.stroke(&mut sheet, &run, BOLD, INK, 1.0);
            }
            CutLine::Median => axes.dashes(&mut sheet, &run),
        }
    }
    sheet.frame([left, top], [right - left, bottom - top]);
    let stay = kept.iter().filter(|kept| **kept).count();
    let count = |word: &str, n: usize| format!("{word} ({})", grouped(n as u64));
    let counts = [count("kept", stay), count("pruned", kept.len() - stay)];
    let line = match cut {
        CutLine::Threshold => ("threshold", LegendKey::Line(BOLD), INK),
        CutLine::Median => ("median of L (not the rule)", REFERENCE.0, REFERENCE.1),
    };
    let line = threshold.iter().any(|cut| !cut.is_nan()).then_some(line);
    let curves = [(&*counts[0], LegendKey::Line(CURVE), KEPT), (&*counts[1], LegendKey::Line(CURVE), PRUNED)];
    legend::legend(&mut sheet, left, &curves.into_iter().chain(line).collect::<Vec<_>>());
    Figure::new(CONVERGENCE_PICTURE, PAGE, sheet)
}

/// The positions of numbers of samples and contributions on the page.
struct ConvergenceAxes {
    last: u64,
    range: LogRange,
    /// Whether there is a line of zeros.
    zeros: bool,
}

impl ConvergenceAxes {
    fn x(&self, samples: f64) -> f64 {
        // A small margin after the last checkpoint.
        BOX[0] + (BOX[2] - BOX[0]) * samples / (self.last as f64 * 1.02)
    }

    fn y(&self, share: f64) -> f64 {
        let lowest = if self.zeros { ZERO - GAP } else { BOX[3] };
        if share < 0.0 { ZERO } else { lowest - (lowest - BOX[1]) * share }
    }

    fn ticks(&self, sheet: &mut Sheet, weight: Weight) {
        let [left, top, right, bottom] = BOX;
        let counts = count_ticks(self.last, 6).into_iter();
        sheet.ticks_below([top, bottom], counts.map(|tick| (self.x(tick.at), tick.label)));
        let powers = self.range.ticks();
        let lowest = powers.first().filter(|_| self.range.clipped);
        let below = lowest.map_or_else(|| TickLabel::plain("0"), |tick| tick.label.clone().after("<"));
        let zeros = self.zeros.then_some((ZERO, below));
        let powers = powers.into_iter().map(|tick| (self.y(self.range.share_of_log(tick.at)), tick.label));
        sheet.ticks_left([left, right], powers.chain(zeros));
        let middle = [f64::midpoint(left, right), f64::midpoint(top, bottom)];
        sheet.plain("number of samples, n", [middle[0], bottom + TICK + NAME_BELOW], Align::Middle);
        let name = match weight {
            Weight::Resilience | Weight::Global => "mean contribution per sample L/n (W/m\u{b3})",
            Weight::Count => "share of samples L/n",
        };
        sheet.upright(name, [NAME_LEFT, middle[1]]);
    }

    /// The stretches of a curve, each a number of samples and a share of the axis: interrupted at NaN and between zero and positive values.
    fn runs(&self, samples: &[u64], values: &[f64]) -> Vec<Vec<(u64, f64)>> {
        let shares: Vec<_> = samples.iter().zip(values).map(|(n, v)| (*n, self.range.share(*v))).collect();
        let joined = |a: f64, b: f64| (a < 0.0) == (b < 0.0) && a.is_nan() == b.is_nan();
        shares.chunk_by(|a, b| joined(a.1, b.1)).filter(|run| !run[0].1.is_nan()).map(<[_]>::to_vec).collect()
    }

    /// Draws a stretch. A single checkpoint is a dash.
    fn stroke(&self, sheet: &mut Sheet, run: &[(u64, f64)], width: f64, rgb: Rgb, opacity: f64) {
        let mut path: Vec<SheetPlace> = run.iter().map(|(n, share)| [self.x(*n as f64), self.y(*share)]).collect();
        if let [[x, y]] = path[..] {
            let half = 2.0 + 2.0 * width;
            path = vec![[x - half, y], [x + half, y]];
        }
        sheet.line(path, width, rgb, opacity);
    }

    /// Draws a stretch of the median, a dash a checkpoint or more.
    fn dashes(&self, sheet: &mut Sheet, run: &[(u64, f64)]) {
        let place = |(n, share): &(u64, f64)| [self.x(*n as f64), self.y(*share)];
        if run.len() < 2 {
            return self.stroke(sheet, run, BOLD, INK, 1.0);
        }
        sheet.dashed(run.iter().map(place), 1.2, INK);
    }
}
