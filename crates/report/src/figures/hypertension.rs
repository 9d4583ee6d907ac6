//! The distribution of hypertension forces: for each class a histogram, the fitted gamma distribution and the threshold of risk.

use super::axis::LinearRange;
use super::canvas::{Align, Place, Run, Sheet};
use super::colour::{EACH, INK, PRUNED};
use super::figure::Figure;
use super::modulation::{SIDES, TOP, WIDTH_INCHES};
use super::style::{self, HAIR, Key, NAME_BELOW, NAME_LEFT, POINTS_PER_INCH, REFERENCE, TEXT, TICK};
use willis_core::error::Result;
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
pub fn hypertension(histograms: Histograms) -> Figure {
    let points = TOP + EVERY * histograms.classes.len() as f64 + FOOT;
    Figure::new(HYPERTENSION_PICTURE, [WIDTH_INCHES, points / POINTS_PER_INCH], move |sheet| draw(sheet, &histograms, points))
}

fn draw(sheet: &mut Sheet<'_>, histograms: &Histograms, points: f64) -> Result<()> {
    let [left, right] = SIDES;
    let middle = f64::midpoint(left, right);
    sheet.title("Hypertension: pressure over cross-section, all vessels and instances", left)?;
    let Some(last) = histograms.edges.last() else {
        sheet.plain("no force above zero", [middle, points / 2.0], Align::Middle)?;
        return Ok(());
    };
    let curve = histograms.classes.iter().any(|class| class.fit.is_some());
    let fit = curve.then_some(("gamma distribution, fitted", Key::Line(1.6), PRUNED));
    let keys = [("vessels and instances", Key::Box, EACH)].into_iter().chain(fit);
    let keys: Vec<_> = keys.chain([("threshold of risk", REFERENCE.0, REFERENCE.1)]).collect();
    style::legend(sheet, left, &keys)?;
    // The threshold is always visible.
    let across = LinearRange { low: 0.0, high: 1.04 * last.max(histograms.threshold) };
    let x = |force: f64| left + (right - left) * across.share(force);
    let most = histograms.classes.iter().flat_map(|h| h.density.iter().copied()).fold(0.0, f64::max);
    let up = LinearRange { low: 0.0, high: if most > 0.0 { 1.1 * most } else { 1.0 } };
    for (at, histogram) in histograms.classes.iter().enumerate() {
        let top = TOP + EVERY * at as f64 + HEADING;
        let bottom = top + HEIGHT;
        let y = |density: f64| bottom - HEIGHT * up.share(density).min(1.0);
        sheet.plain(&histogram.heading, [left, top - HEADING / 2.0], Align::Begin)?;
        sheet.ticks_left(SIDES, up.ticks(5).into_iter().map(|tick| (y(tick.at), tick.label)))?;
        for (edges, density) in histograms.edges.windows(2).zip(&histogram.density).filter(|(_, density)| **density > 0.0) {
            let (corner, size) = ([x(edges[0]), y(*density)], [x(edges[1]) - x(edges[0]), bottom - y(*density)]);
            sheet.rectangle(corner, size, EACH)?;
            sheet.frame(corner, size)?;
        }
        if let Some(gamma) = &histogram.fit {
            let force = |i: usize| across.high * (i as f64 + 0.5) / CURVE as f64;
            let curve: Vec<Place> = (0..CURVE).map(|i| [x(force(i)), y(gamma.density(force(i)))]).collect();
            sheet.line(curve, 1.6, PRUNED, 1.0)?;
        }
        sheet.dashes([[x(histograms.threshold), top], [x(histograms.threshold), bottom]], 1.2, INK)?;
        sheet.frame([left, top], [right - left, HEIGHT])?;
    }
    let bottom = points - FOOT - GAP;
    for tick in across.ticks(9) {
        sheet.line([[x(tick.at), bottom], [x(tick.at), bottom + TICK]], HAIR, INK, 1.0)?;
        sheet.text(&tick.label, [x(tick.at), bottom + TICK + 8.0], TEXT, Align::Middle, Run::Right)?;
    }
    sheet.plain("hypertension force (mmHg/mm\u{b2})", [middle, bottom + TICK + NAME_BELOW], Align::Middle)?;
    sheet.upright("density (mm\u{b2}/mmHg)", [NAME_LEFT, f64::midpoint(TOP, bottom)])
}
