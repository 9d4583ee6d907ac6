//! The distribution of hypertension forces: a histogram a class, with its gamma distribution and the threshold of risk.

use super::axis::{Label, LinearRange};
use super::canvas::{Align, HAIR, POINTS_PER_INCH, Place, Run, Sheet, TEXT, TITLE};
use super::colour::{EACH, GRID, INK, PRUNED};
use super::figure::Figure;
use super::modulation::{SIDES, TOP, WIDTH_INCHES};
use crate::error::Result;
use crate::output::names::HYPERTENSION_PICTURE;
use crate::support::gamma::Gamma;

/// Height of a heading, of a panel and of the gap below it, points.
const HEADING: f64 = 18.0;
const HEIGHT: f64 = 100.0;
const GAP: f64 = 10.0;
const EVERY: f64 = HEADING + HEIGHT + GAP;
/// Below the last panel, points.
const FOOT: f64 = 42.0;
const TICK: f64 = 4.0;
/// Points of a density's curve.
const CURVE: usize = 400;

/// The forces of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// What stands above the panel.
    pub heading: String,
    /// The density in each bin, mm²/mmHg.
    pub density: Vec<f64>,
    /// The fit, in mmHg/mm².
    pub fit: Option<Gamma>,
}

/// The forces of all classes.
#[derive(Debug, Clone, PartialEq)]
pub struct Histograms {
    /// The edges of the bins, mmHg/mm², rising from 0; none when there is no force.
    pub edges: Vec<f64>,
    /// Above this a vessel is at risk, mmHg/mm².
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
    let title = Label::plain("Hypertension: pressure over cross-section, all vessels and instances");
    sheet.text(&title, [middle, 15.0], TITLE, Align::Middle, Run::Right)?;
    let Some(last) = histograms.edges.last() else {
        sheet.text(&Label::plain("no force above zero"), [middle, points / 2.0], TEXT, Align::Middle, Run::Right)?;
        return Ok(());
    };
    legend(sheet)?;
    // The threshold is always on the page.
    let across = LinearRange { low: 0.0, high: 1.04 * last.max(histograms.threshold) };
    let x = |force: f64| left + (right - left) * across.share(force);
    let most = histograms.classes.iter().flat_map(|h| h.density.iter().copied()).fold(0.0, f64::max);
    let up = LinearRange { low: 0.0, high: if most > 0.0 { 1.1 * most } else { 1.0 } };
    for (at, histogram) in histograms.classes.iter().enumerate() {
        let top = TOP + EVERY * at as f64 + HEADING;
        let bottom = top + HEIGHT;
        let y = |density: f64| bottom - HEIGHT * up.share(density).min(1.0);
        sheet.text(&Label::plain(&histogram.heading), [left, top - HEADING / 2.0], TEXT, Align::Begin, Run::Right)?;
        for tick in up.ticks(5) {
            sheet.line([[left, y(tick.at)], [right, y(tick.at)]], HAIR, GRID, 1.0)?;
            sheet.line([[left - TICK, y(tick.at)], [left, y(tick.at)]], HAIR, INK, 1.0)?;
            sheet.text(&tick.label, [left - TICK - 3.0, y(tick.at)], TEXT, Align::End, Run::Right)?;
        }
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
    let name = Label::plain("hypertension force (mmHg/mm\u{b2})");
    sheet.text(&name, [middle, bottom + TICK + 25.0], TEXT, Align::Middle, Run::Right)?;
    sheet.text(&Label::plain("density (mm\u{b2}/mmHg)"), [9.0, f64::midpoint(TOP, bottom)], TEXT, Align::Middle, Run::Up)
}

fn legend(sheet: &mut Sheet<'_>) -> Result<()> {
    const KEY: f64 = 20.0;
    const SPACE: f64 = 5.0;
    const Y: f64 = 36.0;
    let mut x = SIDES[0];
    for (at, text) in ["vessels and instances", "gamma distribution, fitted", "threshold of risk"].into_iter().enumerate() {
        match at {
            0 => {
                sheet.rectangle([x, Y - 4.0], [KEY, 8.0], EACH)?;
                sheet.frame([x, Y - 4.0], [KEY, 8.0])?;
            }
            1 => sheet.line([[x, Y], [x + KEY, Y]], 1.6, PRUNED, 1.0)?,
            _ => sheet.dashes([[x, Y], [x + KEY, Y]], 1.2, INK)?,
        }
        sheet.text(&Label::plain(text), [x + KEY + SPACE, Y], TEXT, Align::Begin, Run::Right)?;
        x += KEY + SPACE + sheet.text_width(text, TEXT)? + 20.0;
    }
    Ok(())
}
