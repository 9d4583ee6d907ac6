//! The response to resistance modulation: for each class a box over all vessels or nodes, and one for the whole network.

use super::axis::LinearRange;
use super::colour::{EACH, INK, Rgb, WHOLE};
use super::figure::Figure;
use super::legend::{self, LegendKey, REFERENCE};
use super::sheet::{Align, Sheet};
use super::style::{BOLD, CURVE, HAIR, NAME_LEFT, POINTS_PER_INCH, TICK};
use willis_io::output::names::MODULATION_PICTURE;

/// Width of this picture and that of hypertension, points.
pub(crate) const WIDTH: f64 = 6.4 * POINTS_PER_INCH;
/// Left and right of the axes in both, points.
pub(crate) const SIDES: [f64; 2] = [62.0, 448.0];
/// Where the panels begin in both, points.
pub(crate) const TOP: f64 = 54.0;
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
    legend::legend(&mut sheet, left, &[keys[0], keys[1], ("unperturbed", REFERENCE.0, REFERENCE.1)]);
    let at = |class: usize| left + room * (class as f64 + 0.5);
    let mut top = TOP;
    for panel in panels {
        quantity(&mut sheet, panel, top, room, at);
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

/// One panel below `top`.
fn quantity(sheet: &mut Sheet, panel: &Panel, top: f64, room: f64, at: impl Fn(usize) -> f64) {
    let ([left, right], bottom) = (SIDES, top + HEIGHT);
    let figures = panel.boxes.iter().flat_map(|b| b.each.into_iter().chain(b.whole));
    if let Some(range) = LinearRange::of(figures.chain([panel.unchanged])) {
        let y = |value: f64| bottom - HEIGHT * range.share(value);
        sheet.ticks_left(SIDES, range.ticks(TICKS).into_iter().map(|tick| (y(tick.at), tick.label)));
        sheet.dashed(SIDES.map(|x| [x, y(panel.unchanged)]), CURVE, INK);
        for (class, boxes) in panel.boxes.iter().enumerate() {
            for (quantiles, aside, rgb) in [(boxes.each, -ASIDE, EACH), (boxes.whole, ASIDE, WHOLE)] {
                if quantiles.iter().all(|q| q.is_finite()) {
                    boxed(sheet, at(class) + aside * room, BOX * room, quantiles.map(y), rgb);
                }
            }
        }
    }
    sheet.frame([left, top], [right - left, HEIGHT]);
    sheet.upright(&panel.name, [NAME_LEFT, top + HEIGHT / 2.0]);
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
