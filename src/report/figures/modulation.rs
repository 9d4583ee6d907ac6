//! The response to resistance modulation: per class a box for every vessel or node and one for the network as a whole.

use super::axis::{Label, LinearRange};
use super::canvas::{Align, HAIR, POINTS_PER_INCH, Run, Sheet, TEXT, TITLE};
use super::colour::{EACH, GRID, INK, Rgb, WHOLE};
use super::figure::Figure;
use crate::error::Result;
use crate::output::names::MODULATION_PICTURE;

/// Width of this picture and that of hypertension.
pub(crate) const WIDTH_INCHES: f64 = 6.4;
/// Left and right of the axes in both, points.
pub(crate) const SIDES: [f64; 2] = [62.0, 448.0];
/// Where the panels begin in both, points.
pub(crate) const TOP: f64 = 54.0;
/// Height of each panel and the gap between two, points.
const HEIGHT: f64 = 132.0;
const GAP: f64 = 14.0;
/// Bottom of the last panel, points.
const BOTTOM: f64 = TOP + 3.0 * HEIGHT + 2.0 * GAP;
const TICK: f64 = 4.0;
/// Height of a row of class names, width of a digit in them and room between two, points.
const NAMES: [f64; 3] = [12.0, 5.3, 5.0];
/// From the last row of names to the axis's own, and from there to the edge, points.
const FOOT: [f64; 2] = [16.0, 14.0];
/// Ticks of a panel at the most.
const TICKS: usize = 7;
/// A box's width and the two boxes' distance from the class's middle, as shares of its room.
const BOX: f64 = 0.26;
const ASIDE: f64 = 0.19;

/// The quantiles 0.05, 0.25, 0.5, 0.75 and 0.95 of a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boxes {
    /// Over all vessels (or nodes) and instances.
    pub each: [f64; 5],
    /// Of the network's own figure over the instances.
    pub whole: [f64; 5],
}

/// One quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// The name of its axis, with its unit.
    pub name: String,
    /// Where nothing changes.
    pub unchanged: f64,
    /// By class.
    pub boxes: Vec<Boxes>,
}

/// Draws a panel a quantity, one above the other, 6.4 inches wide.
///
/// A box reaches from the first to the third quartile, its bar is the median, its whiskers reach from the 5th to the 95th
/// percentile. A dashed line stands where nothing changes. Figures that are no number are left out.
pub fn modulation(classes: Vec<String>, panels: [Panel; 3]) -> Figure {
    // Names too long for the room of a class stand on several rows in turn.
    let digits = classes.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64;
    let rows = ((digits * NAMES[1] + NAMES[2]) / room(&classes)).ceil().max(1.0) as usize;
    let foot = BOTTOM + TICK + NAMES[0] * (rows as f64 - 0.4) + FOOT[0];
    let inches = [WIDTH_INCHES, (foot + FOOT[1]) / POINTS_PER_INCH];
    Figure::new(MODULATION_PICTURE, inches, move |sheet| draw(sheet, &classes, &panels, rows, foot))
}

/// The width that a class has, points.
fn room(classes: &[String]) -> f64 {
    (SIDES[1] - SIDES[0]) / classes.len() as f64
}

fn draw(sheet: &mut Sheet<'_>, classes: &[String], panels: &[Panel; 3], rows: usize, foot: f64) -> Result<()> {
    let ([left, right], room) = (SIDES, room(classes));
    let middle = f64::midpoint(left, right);
    let title = Label::plain("Response to resistance modulation, against the unperturbed network");
    sheet.text(&title, [middle, 15.0], TITLE, Align::Middle, Run::Right)?;
    legend(sheet)?;
    let at = |class: usize| left + room * (class as f64 + 0.5);
    let mut top = TOP;
    for panel in panels {
        quantity(sheet, panel, top, room, at)?;
        top += HEIGHT + GAP;
    }
    for (class, name) in classes.iter().enumerate() {
        let y = BOTTOM + TICK + NAMES[0] * ((class % rows) as f64 + 0.6);
        sheet.line([[at(class), BOTTOM], [at(class), BOTTOM + TICK]], HAIR, INK, 1.0)?;
        sheet.text(&Label::plain(name), [at(class), y], TEXT, Align::Middle, Run::Right)?;
    }
    sheet.text(&Label::plain("modulation u, by class"), [middle, foot], TEXT, Align::Middle, Run::Right)
}

/// One panel below `top`.
fn quantity(sheet: &mut Sheet<'_>, panel: &Panel, top: f64, room: f64, at: impl Fn(usize) -> f64) -> Result<()> {
    let ([left, right], bottom) = (SIDES, top + HEIGHT);
    let figures = panel.boxes.iter().flat_map(|b| b.each.into_iter().chain(b.whole));
    if let Some(range) = LinearRange::of(figures.chain([panel.unchanged])) {
        let y = |value: f64| bottom - HEIGHT * range.share(value);
        for tick in range.ticks(TICKS) {
            sheet.line([[left, y(tick.at)], [right, y(tick.at)]], HAIR, GRID, 1.0)?;
            sheet.line([[left - TICK, y(tick.at)], [left, y(tick.at)]], HAIR, INK, 1.0)?;
            sheet.text(&tick.label, [left - TICK - 3.0, y(tick.at)], TEXT, Align::End, Run::Right)?;
        }
        sheet.dashes([[left, y(panel.unchanged)], [right, y(panel.unchanged)]], 1.0, INK)?;
        for (class, boxes) in panel.boxes.iter().enumerate() {
            for (quantiles, aside, rgb) in [(boxes.each, -ASIDE, EACH), (boxes.whole, ASIDE, WHOLE)] {
                if quantiles.iter().all(|q| q.is_finite()) {
                    boxed(sheet, at(class) + aside * room, BOX * room, quantiles.map(y), rgb)?;
                }
            }
        }
    }
    sheet.frame([left, top], [right - left, HEIGHT])?;
    sheet.text(&Label::plain(&panel.name), [9.0, top + HEIGHT / 2.0], TEXT, Align::Middle, Run::Up)
}

/// A box around x, with its quantiles at the heights `y`.
fn boxed(sheet: &mut Sheet<'_>, x: f64, width: f64, y: [f64; 5], rgb: Rgb) -> Result<()> {
    let [left, right] = [x - width / 2.0, x + width / 2.0];
    sheet.line([[x, y[0]], [x, y[1]]], 1.0, INK, 1.0)?;
    sheet.line([[x, y[3]], [x, y[4]]], 1.0, INK, 1.0)?;
    for whisker in [y[0], y[4]] {
        sheet.line([[x - width / 4.0, whisker], [x + width / 4.0, whisker]], 1.0, INK, 1.0)?;
    }
    sheet.rectangle([left, y[3]], [width, y[1] - y[3]], rgb)?;
    sheet.frame([left, y[3]], [width, y[1] - y[3]])?;
    sheet.line([[left, y[2]], [right, y[2]]], 1.8, INK, 1.0)
}

fn legend(sheet: &mut Sheet<'_>) -> Result<()> {
    const KEY: [f64; 2] = [16.0, 8.0];
    const Y: f64 = 36.0;
    let mut x = SIDES[0];
    for (text, rgb) in [("every vessel (pressure: node)", EACH), ("whole network", WHOLE)] {
        sheet.rectangle([x, Y - KEY[1] / 2.0], KEY, rgb)?;
        sheet.frame([x, Y - KEY[1] / 2.0], KEY)?;
        sheet.text(&Label::plain(text), [x + KEY[0] + 5.0, Y], TEXT, Align::Begin, Run::Right)?;
        x += KEY[0] + 5.0 + sheet.text_width(text, TEXT)? + 20.0;
    }
    sheet.dashes([[x, Y], [x + 22.0, Y]], 1.0, INK)?;
    sheet.text(&Label::plain("unperturbed"), [x + 27.0, Y], TEXT, Align::Begin, Run::Right)
}
