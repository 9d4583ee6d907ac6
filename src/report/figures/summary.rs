//! A run in one picture: the vessels from two sides, the candidates by their probability, and the counts.

use super::axis::Label;
use super::canvas::{Align, HAIR, POINTS_PER_INCH, Run, Sheet, TEXT, TICK, TITLE};
use super::colour::{GREY, INK, MAP, Rgb, colour};
use super::figure::Figure;
use crate::error::Result;
use crate::output::names::SUMMARY_PICTURE;

const INCHES: [f64; 2] = [6.4, 3.9];
/// Left edge of each panel, their top, and their width and height, points.
const LEFT: [f64; 2] = [14.0, 206.0];
const TOP: f64 = 46.0;
const SIZE: [f64; 2] = [184.0, 204.0];
/// Height of the two lines of text above them, points.
const LINES: [f64; 2] = [16.0, 33.0];
/// The colour bar: left, top, width, height, points.
const BAR: [f64; 4] = [412.0, 76.0, 10.0, 144.0];
/// The scale bar stands so far above the lower edge of its panel, points.
const FOOT: f64 = 8.0;
/// The thinnest vessel, points.
const THIN: f64 = 0.45;
/// Widths of vessels are these shares of their diameters: one that was kept or seen, one that was left out.
const SHARE: [f64; 2] = [1.0, 0.4];

/// So many steps of a course are drawn in one line, as wide as the vessel is on average.
const TOGETHER: usize = 24;

/// A vessel of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnVessel {
    /// x, y, z and radius along it, mm.
    pub course: Vec<[f64; 4]>,
    /// The probability of one that is uncertain, in [0, 1]; `None` for one that is not, or of which none is known.
    pub probability: Option<f64>,
    /// Whether it is certain.
    pub certain: bool,
    /// Whether it is kept.
    pub kept: bool,
}

/// A view: which way is right and which way is up on the page, and what each is called.
#[derive(Debug, Clone, PartialEq)]
pub struct Projection {
    /// What it is called.
    pub name: &'static str,
    /// The direction to the right of the page.
    pub right: [f64; 3],
    /// The direction up the page.
    pub up: [f64; 3],
    /// What stands at its left and right edge.
    pub edges: [&'static str; 2],
}

/// Draws a run in one picture, 6.4 by 3.9 inches: what was found in words, and two views on one scale. Certain vessels are grey; the
/// others are coloured by probability, from 0 to 1, those that are left out thinner and paler.
pub fn summary(title: String, words: String, vessels: Vec<DrawnVessel>, views: [Projection; 2]) -> Figure {
    Figure::new(SUMMARY_PICTURE, INCHES, move |sheet| draw(sheet, &title, &words, &vessels, &views))
}

/// A piece of a vessel on the page: how far off, its course, and how it is drawn.
struct Piece {
    near: f64,
    path: Vec<[f64; 2]>,
    width: f64,
    rgb: Rgb,
    opacity: f64,
}

fn draw(sheet: &mut Sheet<'_>, title: &str, words: &str, vessels: &[DrawnVessel], views: &[Projection; 2]) -> Result<()> {
    sheet.text(&Label::plain(title), [LEFT[0], LINES[0]], TITLE, Align::Begin, Run::Right)?;
    sheet.plain(words, [LEFT[0], LINES[1]], Align::Begin)?;
    let boxes = [0, 1].map(|at| extent(vessels, &views[at]));
    // One scale for both views, points a millimetre.
    let fits = |[[west, east], [south, north]]: [[f64; 2]; 2]| {
        (SIZE[0] / (east - west).max(1e-9)).min((SIZE[1] - 14.0) / (north - south).max(1e-9))
    };
    let scale = 0.94 * fits(boxes[0]).min(fits(boxes[1]));
    for (at, view) in views.iter().enumerate() {
        let [[west, east], [south, north]] = boxes[at];
        let middle = [f64::midpoint(west, east), f64::midpoint(south, north)];
        let centre = [LEFT[at] + SIZE[0] / 2.0, TOP + (SIZE[1] - 14.0) / 2.0 + 12.0];
        let place = |p: &[f64; 4]| {
            let [x, y] = seen(p, view);
            [centre[0] + scale * (x - middle[0]), centre[1] - scale * (y - middle[1])]
        };
        for piece in pieces(vessels, view, scale, place) {
            sheet.line(piece.path, piece.width, piece.rgb, piece.opacity)?;
        }
        sheet.plain(view.name, [centre[0], TOP + 5.0], Align::Middle)?;
        for (text, x) in view.edges.iter().zip([LEFT[at] + 4.0, LEFT[at] + SIZE[0] - 4.0]) {
            sheet.plain(text, [x, centre[1]], Align::Middle)?;
        }
    }
    scale_bar(sheet, scale)?;
    bar(sheet)
}

/// The extent of the vessels in a view, mm; that of a point where there is none.
fn extent(vessels: &[DrawnVessel], view: &Projection) -> [[f64; 2]; 2] {
    let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    let points = vessels.iter().flat_map(|vessel| &vessel.course);
    let found = points.fold(none, |range, p| {
        let at = seen(p, view);
        [0, 1].map(|axis| [range[axis][0].min(at[axis] - p[3]), range[axis][1].max(at[axis] + p[3])])
    });
    if found[0][0] <= found[0][1] { found } else { [[-1.0, 1.0]; 2] }
}

fn seen(p: &[f64; 4], view: &Projection) -> [f64; 2] {
    [&view.right, &view.up].map(|way| (0..3).map(|axis| way[axis] * p[axis]).sum())
}

/// The pieces of all vessels from far to near; those that are uncertain come last, so that nothing hides them.
fn pieces(vessels: &[DrawnVessel], view: &Projection, scale: f64, place: impl Fn(&[f64; 4]) -> [f64; 2]) -> Vec<Piece> {
    let ([a, b, c], [d, e, f]) = (view.right, view.up);
    let back = [b * f - c * e, c * d - a * f, a * e - b * d];
    let depth = |p: &[f64; 4]| (0..3).map(|axis| back[axis] * p[axis]).sum::<f64>();
    let mut all = Vec::new();
    for vessel in vessels {
        let rgb = if vessel.certain { GREY } else { vessel.probability.map_or(INK, colour) };
        let share = SHARE[usize::from(!vessel.certain && !vessel.kept)];
        let opacity = if vessel.certain || vessel.kept { 1.0 } else { 0.7 };
        let order = match (vessel.certain, vessel.kept) {
            (true, _) => 0.0,
            (false, false) => 1e6,
            (false, true) => 2e6,
        };
        // A piece begins where the one before it ends.
        let last = vessel.course.len().saturating_sub(1);
        all.extend((0..last).step_by(TOGETHER).map(|first| {
            let part = &vessel.course[first..=(first + TOGETHER).min(last)];
            let mean = |of: &dyn Fn(&[f64; 4]) -> f64| part.iter().map(of).sum::<f64>() / part.len() as f64;
            Piece {
                near: order + mean(&depth),
                path: part.iter().map(&place).collect(),
                width: (2.0 * share * scale * mean(&|p| p[3])).max(THIN),
                rgb,
                opacity,
            }
        }));
    }
    all.sort_by(|a, b| a.near.total_cmp(&b.near));
    all
}

fn scale_bar(sheet: &mut Sheet<'_>, scale: f64) -> Result<()> {
    let widest = 60.0 / scale;
    let ten = 10_f64.powf(widest.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|m| m * ten).into_iter().find(|length| *length <= widest).unwrap_or(ten);
    let (x, y) = (LEFT[0], TOP + SIZE[1] + FOOT);
    sheet.line([[x, y], [x + scale * length, y]], 1.2, INK, 1.0)?;
    sheet.plain(&format!("{length} mm"), [x + scale * length + 5.0, y], Align::Begin)
}

fn bar(sheet: &mut Sheet<'_>) -> Result<()> {
    let [left, top, width, height] = BAR.map(|p| sheet.pixels(p));
    let drawn = sheet.ramp([left, top], [width, height], &MAP)?;
    for y in 0..if drawn { 0 } else { height } {
        let share = 1.0 - y as f64 / (height - 1).max(1) as f64;
        sheet.fill([left, top + y], [width, 1], colour(share))?;
    }
    let [left, top, width, height] = BAR;
    sheet.frame([left, top], [width, height])?;
    for share in [0.0, 0.5, 1.0] {
        let y = top + (1.0 - share) * height;
        sheet.line([[left + width, y], [left + width + TICK, y]], HAIR, INK, 1.0)?;
        sheet.plain(&share.to_string(), [left + width + TICK + 3.0, y], Align::Begin)?;
    }
    sheet.upright("probability", [INCHES[0] * POINTS_PER_INCH - TEXT / 2.0 - 2.0, top + height / 2.0])
}
