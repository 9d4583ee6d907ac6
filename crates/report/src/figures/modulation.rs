//! The response to resistance modulation, a box over all vessels or nodes for each class and one for the whole network; and for each class the distribution of hypertension forces.

use super::axis::LinearRange;
use super::figure::Figure;
use super::sheet::{Align, BOLD, CURVE, HAIR, LegendKey, NAME_BELOW, NAME_LEFT, POINTS_PER_INCH, REFERENCE, Sheet, TEXT, TICK};
use super::{EACH, INK, PRUNED, Rgb, WHOLE};
use willis_io::output::names::{HYPERTENSION_PICTURE, MODULATION_PICTURE};

/// Width of this picture and that of hypertension, points.
const WIDTH: f64 = 6.4 * POINTS_PER_INCH;
/// Left and right of the axes in both, points.
const SIDES: [f64; 2] = [62.0, 448.0];
/// Where the panels begin in both, points.
const TOP: f64 = 54.0;
/// Height of each panel and the gap between two, points.
const HEIGHT: f64 = 132.0;
const GAP: f64 = 14.0;
/// Bottom of the last panel, points.
const BOTTOM: f64 = TOP + 3.0 * HEIGHT + 2.0 * GAP;
/// Height of a row of class names, width of a digit in them and room between two, points.
const NAMES: [f64; 3] = [12.0, 5.3, 5.0];
/// From the last row of names to the axis's own, and from there to the edge, points.
const FOOT: [f64; 2] = [16.0, 14.0];
/// The largest number of ticks of a panel.
const TICKS: usize = 7;
/// The width of a box and the distance of the two boxes from the middle of their class, as shares of the width of the class.
const BOX: f64 = 0.26;
const ASIDE: f64 = 0.19;

/// The quantiles 0.05, 0.25, 0.5, 0.75 and 0.95 of a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boxes {
    /// Over all vessels (or nodes) and instances.
    pub each: [f64; 5],
    /// Over the instances, of the whole network.
    pub whole: [f64; 5],
}

/// One quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// The name of its axis, with the unit.
    pub name: String,
    /// Its value without modulation.
    pub unchanged: f64,
    /// By class.
    pub boxes: Vec<Boxes>,
}

/// Draws one panel per quantity, one above the other, 6.4 inches wide.
///
/// A box reaches from the first to the third quartile, its bar is the median, its whiskers reach from the 5th to the 95th
/// percentile. A dashed line marks the value without modulation. NaN values are left out.
pub fn modulation(classes: &[String], panels: &[Panel; 3]) -> Figure {
    let [left, right] = SIDES;
    let room = (right - left) / classes.len() as f64;
    // Names that are too wide for a class alternate between rows.
    let digits = classes.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64;
    let rows = ((digits * NAMES[1] + NAMES[2]) / room).ceil().max(1.0) as usize;
    let foot = BOTTOM + TICK + NAMES[0] * (rows as f64 - 0.4) + FOOT[0];
    let mut sheet = Sheet::default();
    let middle = f64::midpoint(left, right);
    sheet.title("Response to resistance modulation, against the unperturbed network", left);
    let keys = [("every vessel (pressure: node)", LegendKey::Box, EACH), ("whole network", LegendKey::Box, WHOLE)];
    sheet.legend(left, &[keys[0], keys[1], ("unperturbed", REFERENCE.0, REFERENCE.1)]);
    let at = |class: usize| left + room * (class as f64 + 0.5);
    let mut top = TOP;
    for panel in panels {
        let bottom = top + HEIGHT;
        let figures = panel.boxes.iter().flat_map(|b| b.each.into_iter().chain(b.whole));
        if let Some(range) = LinearRange::of(figures.chain([panel.unchanged])) {
            let y = |value: f64| bottom - HEIGHT * range.share(value);
            sheet.ticks_left(SIDES, range.ticks(TICKS).into_iter().map(|tick| (y(tick.at), tick.label)));
            sheet.dashed(SIDES.map(|x| [x, y(panel.unchanged)]), CURVE, INK);
            for (class, boxes) in panel.boxes.iter().enumerate() {
                for (quantiles, aside, rgb) in [(boxes.each, -ASIDE, EACH), (boxes.whole, ASIDE, WHOLE)] {
                    if quantiles.iter().all(|q| q.is_finite()) {
                        boxed(&mut sheet, at(class) + aside * room, BOX * room, quantiles.map(y), rgb);
                    }
                }
            }
        }
        sheet.frame([left, top], [right - left, HEIGHT]);
        sheet.upright(&panel.name, [NAME_LEFT, top + HEIGHT / 2.0]);
        top += HEIGHT + GAP;
    }
    for (class, name) in classes.iter().enumerate() {
        let y = BOTTOM + TICK + NAMES[0] * ((class % rows) as f64 + 0.6);
        sheet.line([[at(class), BOTTOM], [at(class), BOTTOM + TICK]], HAIR, INK, 1.0);
        sheet.plain(name, [at(class), y], Align::Middle);
    }
    sheet.plain("modulation u, by class", [middle, foot], Align::Middle);
    Figure::new(MODULATION_PICTURE, [WIDTH, foot + FOOT[1]], sheet)
}

/// A box around x, with its quantiles at the heights `y`.
fn boxed(sheet: &mut Sheet, x: f64, width: f64, y: [f64; 5], rgb: Rgb) {
    let [left, right] = [x - width / 2.0, x + width / 2.0];
    for (quartile, whisker) in [(y[1], y[0]), (y[3], y[4])] {
        sheet.line([[x, quartile], [x, whisker]], CURVE, INK, 1.0);
        sheet.line([[x - width / 4.0, whisker], [x + width / 4.0, whisker]], CURVE, INK, 1.0);
    }
    sheet.rectangle([left, y[3]], [width, y[1] - y[3]], rgb);
    sheet.frame([left, y[3]], [width, y[1] - y[3]]);
    sheet.line([[left, y[2]], [right, y[2]]], BOLD, INK, 1.0);
}

/// Height of a heading, of a histogram and of the gap below it, points.
const HISTOGRAM: [f64; 3] = [18.0, 100.0, 10.0];
/// Below the last histogram, points.
const BELOW: f64 = 42.0;
/// Points of the curve of a density.
const STEPS: usize = 400;

/// The forces of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// The text above the panel.
    pub heading: String,
    /// The density in each bin, mm²/mmHg.
    pub density: Vec<f64>,
    /// The fit, in mmHg/mm².
    pub fit: Option<willis_core::support::gamma::Gamma>,
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
    let [heading, high, gap] = HISTOGRAM;
    let every = heading + high + gap;
    let height = TOP + every * histograms.classes.len() as f64 + BELOW;
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
    sheet.legend(left, &keys);
    // The threshold is always visible.
    let across = LinearRange { low: 0.0, high: 1.04 * last.max(histograms.threshold) };
    let x = |force: f64| left + (right - left) * across.share(force);
    let most = histograms.classes.iter().flat_map(|h| h.density.iter().copied()).fold(0.0, f64::max);
    let up = LinearRange { low: 0.0, high: if most > 0.0 { 1.1 * most } else { 1.0 } };
    for (at, histogram) in histograms.classes.iter().enumerate() {
        let top = TOP + every * at as f64 + heading;
        let bottom = top + high;
        let y = |density: f64| bottom - high * up.share(density).min(1.0);
        sheet.plain(&histogram.heading, [left, top - heading / 2.0], Align::Begin);
        sheet.ticks_left(SIDES, up.ticks(5).into_iter().map(|tick| (y(tick.at), tick.label)));
        for (edges, density) in histograms.edges.windows(2).zip(&histogram.density).filter(|(_, density)| **density > 0.0) {
            let (corner, size) = ([x(edges[0]), y(*density)], [x(edges[1]) - x(edges[0]), bottom - y(*density)]);
            sheet.rectangle(corner, size, EACH);
            sheet.frame(corner, size);
        }
        if let Some(gamma) = &histogram.fit {
            let force = |i: usize| across.high * (i as f64 + 0.5) / STEPS as f64;
            sheet.line((0..STEPS).map(|i| [x(force(i)), y(gamma.density(force(i)))]), 1.6, PRUNED, 1.0);
        }
        sheet.dashed([top, bottom].map(|y| [x(histograms.threshold), y]), 1.2, INK);
        sheet.frame([left, top], [right - left, high]);
    }
    let bottom = height - BELOW - gap;
    for tick in across.ticks(9) {
        sheet.tick_below([x(tick.at), bottom], &tick.label, TEXT);
    }
    sheet.plain("hypertension force (mmHg/mm\u{b2})", [middle, bottom + TICK + NAME_BELOW], Align::Middle);
    sheet.upright("density (mm\u{b2}/mmHg)", [NAME_LEFT, f64::midpoint(TOP, bottom)]);
    Figure::new(HYPERTENSION_PICTURE, [WIDTH, height], sheet)
}
