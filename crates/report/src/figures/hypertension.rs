//! The distribution of hypertension forces: for each class a histogram, the fitted gamma distribution and the threshold of risk.

use super::axis::LinearRange;
use super::colour::{EACH, INK, PRUNED};
use super::figure::Figure;
use super::legend::{self, LegendKey, REFERENCE};
use super::modulation::{SIDES, TOP, WIDTH};
use super::sheet::{Align, Sheet};
use super::style::{NAME_BELOW, NAME_LEFT, TEXT, TICK};
use willis_core::support::gamma::Gamma;
use willis_io::output::names::HYPERTENSION_PICTURE;

/// Height of a heading, of a panel and of the gap below it, points.
const HEADING: f64 = 18.0;
const HEIGHT: f64 = 100.0;
const GAP: f64 = 10.0;
const EVERY: f64 = HEADING + HEIGHT + GAP;
/// Below the last panel, points.
const FOOT: f64 = 42.0;
/// Points of the curve of a density.
const CURVE: usize = 400;

/// The forces of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// The text above the panel.
    pub heading: String,
    /// The density in each bin, mm²/mmHg.
    pub density: Vec<f64>,
    /// The fit, in mmHg/mm².
    pub fit: Option<Gamma>,
}

/// The forces of all classes.
#[derive(Debug, Clone, PartialEq)]
pub struct Histograms {
    /// The edges of the bins, mmHg/mm², rising from 0; empty when there is no force.
    pub edges: Vec<f64>,
    /// The force above which a vessel is at risk, mmHg/mm².
    pub threshold: f64,
    /// By class.
    pub classes: Vec<Histogram>,
}

/// Draws the histograms one above the other on common axes, 6.4 inches wide.
pub fn hypertension(histograms: &Histograms) -> Figure {
    let height = TOP + EVERY * histograms.classes.len() as f64 + FOOT;
    let mut sheet = Sheet::default();
    let [left, right] = SIDES;
    let middle = f64::midpoint(left, right);
    sheet.title("Hypertension: pressure over cross-section, all instances", left);
    let Some(last) = histograms.edges.last() else {
        sheet.plain("no force above zero", [middle, height / 2.0], Align::Middle);
        return Figure::new(HYPERTENSION_PICTURE, [WIDTH, height], sheet);
    };
    let curve = histograms.classes.iter().any(|class| class.fit.is_some());
    let fit = curve.then_some(("gamma distribution, fitted", LegendKey::Line(1.6), PRUNED));
    let keys = [("vessels and instances", LegendKey::Box, EACH)].into_iter().chain(fit);
    let keys: Vec<_> = keys.chain([("threshold of risk", REFERENCE.0, REFERENCE.1)]).collect();
    legend::legend(&mut sheet, left, &keys);
    // The threshold is always visible.
    let across = LinearRange { low: 0.0, high: 1.04 * last.max(histograms.threshold) };
    let x = |force: f64| left + (right - left) * across.share(force);
    let most = histograms.classes.iter().flat_map(|h| h.density.iter().copied()).fold(0.0, f64::max);
    let up = LinearRange { low: 0.0, high: if most > 0.0 { 1.1 * most } else { 1.0 } };
    for (at, histogram) in histograms.classes.iter().enumerate() {
        let top = TOP + EVERY * at as f64 + HEADING;
        let bottom = top + HEIGHT;
        let y = |density: f64| bottom - HEIGHT * up.share(density).min(1.0);
        sheet.plain(&histogram.heading, [left, top - HEADING / 2.0], Align::Begin);
        sheet.ticks_left(SIDES, up.ticks(5).into_iter().map(|tick| (y(tick.at), tick.label)));
        for (edges, density) in histograms.edges.windows(2).zip(&histogram.density).filter(|(_, density)| **density > 0.0) {
            let (corner, size) = ([x(edges[0]), y(*density)], [x(edges[1]) - x(edges[0]), bottom - y(*density)]);
            sheet.rectangle(corner, size, EACH);
            sheet.frame(corner, size);
        }
        if let Some(gamma) = &histogram.fit {
            let force = |i: usize| across.high * (i as f64 + 0.5) / CURVE as f64;
            sheet.line((0..CURVE).map(|i| [x(force(i)), y(gamma.density(force(i)))]), 1.6, PRUNED, 1.0);
        }
        sheet.dashed([top, bottom].map(|y| [x(histograms.threshold), y]), 1.2, INK);
        sheet.frame([left, top], [right - left, HEIGHT]);
    }
    let bottom = height - FOOT - GAP;
    across.ticks(9).iter().for_each(|tick| sheet.tick_below([x(tick.at), bottom], &tick.label, TEXT));
    sheet.plain("hypertension force (mmHg/mm\u{b2})", [middle, bottom + TICK + NAME_BELOW], Align::Middle);
    sheet.upright("density (mm\u{b2}/mmHg)", [NAME_LEFT, f64::midpoint(TOP, bottom)]);
    Figure::new(HYPERTENSION_PICTURE, [WIDTH, height], sheet)
}
