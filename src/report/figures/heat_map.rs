//! The likelihood matrix L as a picture with logarithmic colours.

use super::axis::{Label, LogRange, count_ticks, grouped};
use super::canvas::{Align, HAIR, Image, POINTS_PER_INCH, Run, Sheet, TEXT, TICK, TITLE};
use super::colour::{INK, MAP, Rgb, ZERO, colour};
use super::figure::Figure;
use crate::error::{Error, Result};
use crate::output::names::LIKELIHOOD_PICTURE;
use crate::report::run_record::unit_of;
use crate::sampling::Weight;

const INCHES: [f64; 2] = [6.4, 5.6];
/// Upper left corner and side of the matrix, points.
const CORNER: [f64; 2] = [54.0, 34.0];
const SIDE: f64 = 318.0;
/// Gap before the colour bar, and its width, points.
const BAR: [f64; 2] = [18.0, 13.0];
/// The smallest mark of a vessel, points, so that a single vessel among thousands of nodes is visible.
const MARK: f64 = 1.0;
/// The size of a pixel that is too small to see, points.
const INVISIBLE: f64 = 0.05;
/// The largest number of rectangles in an SVG; beyond it the matrix is one image.
const RECTANGLES: usize = 4000;
/// The side of that image, pixels: about 600 per inch.
const IMAGE: usize = 2650;

/// A positive cell of the upper triangle, and its value.
type Cell = ([usize; 2], f64);

/// A symmetric matrix over the nodes, by its non-zero cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matrix<'a> {
    /// N, the number of rows and columns, at most 2³² - 1; rows are 0-based.
    pub nodes: usize,
    /// One entry per vessel: its two nodes in either order, and its likelihood L, finite and not negative.
    ///
    /// An entry stands for both of its cells, (a, b) and (b, a). Entries of the same two nodes (parallel vessels) add up.
    pub entries: &'a [(u32, u32, f64)],
}

impl Matrix<'_> {
    /// The positive cells of the upper triangle, sorted by value.
    fn cells(&self) -> Result<Vec<Cell>> {
        if u32::try_from(self.nodes).is_err() {
            return Err(Error::parameter("nodes", self.nodes, format!("expected at most {}", u32::MAX)));
        }
        let mut cells: Vec<Cell> = Vec::with_capacity(self.entries.len());
        for &(a, b, value) in self.entries {
            let [a, b] = [a, b].map(|node| node as usize);
            if a >= self.nodes || b >= self.nodes {
                let accepted = format!("expected two nodes below {}", self.nodes);
                return Err(Error::parameter("matrix entry", format!("({a}, {b})"), accepted));
            }
            if !value.is_finite() || value < 0.0 {
                let name = format!("likelihood of ({a}, {b})");
                return Err(Error::parameter(name, value, "expected a finite number from 0 up"));
            }
            cells.push(([a.min(b), a.max(b)], value));
        }
        cells.sort_by_key(|cell| cell.0);
        cells.dedup_by(|next, sum| {
            let parallel = next.0 == sum.0;
            if parallel {
                sum.1 = (sum.1 + next.1).min(f64::MAX);
            }
            parallel
        });
        cells.retain(|cell| cell.1 > 0.0);
        cells.sort_by(|a, b| a.1.total_cmp(&b.1));
        Ok(cells)
    }
}

/// Draws the likelihood matrix L, 6.4 by 5.6 inches; its unit is that of the `weight`.
///
/// Row 0 is at the top, column 0 at the left. The colour is that of log10 L from the smallest to the largest positive
/// value, over at least one decade and at most twelve. Smaller values take the lowest colour, and the bar has `≤`. Zero
/// is light grey ([`ZERO`]). A cell is at least 1 point wide, and where cells share a pixel the largest value is drawn.
/// In SVG more than 2000 vessels are one embedded image.
///
/// # Errors
///
/// When an entry names a node that does not exist, and when a value is negative or not finite.
pub fn heat_map(matrix: &Matrix<'_>, weight: Weight) -> Result<Figure> {
    let (cells, nodes) = (matrix.cells()?, matrix.nodes);
    Ok(Figure::new(LIKELIHOOD_PICTURE, INCHES, move |sheet| draw(sheet, &cells, nodes, unit_of(weight))))
}

fn draw(sheet: &mut Sheet<'_>, cells: &[Cell], nodes: usize, unit: &str) -> Result<()> {
    let range = LogRange::of(cells.iter().map(|cell| cell.1));
    let room = sheet.pixels(SIDE);
    // Cells need equal sizes only where pixels are visible.
    let side = if sheet.points(1) < INVISIBLE { room } else { even(room, nodes) };
    let corner = CORNER.map(|c| sheet.pixels(c) + (room - side) / 2);
    sheet.fill(corner, [side, side], ZERO)?;
    if let Some(range) = range
        && (2 * cells.len() <= RECTANGLES || !image(sheet, corner, side, cells, nodes, range)?)
    {
        let mark = sheet.pixels(MARK);
        for (at, size, rgb) in squares(cells, nodes, range, side, mark) {
            sheet.fill([corner[0] + at[0], corner[1] + at[1]], size, rgb)?;
        }
    }

    let [left, top] = corner.map(|c| sheet.points(c));
    let span = sheet.points(side);
    sheet.frame([left, top], [span, span])?;
    node_axes(sheet, [left, top], span, nodes)?;
    let title = Label::plain(format!("Likelihood matrix ({} nodes)", grouped(nodes as u64)));
    let middle = CORNER[0] + SIDE / 2.0;
    sheet.text(&title, [middle, CORNER[1] / 2.0], TITLE, Align::Middle, Run::Right)?;
    if let Some(range) = range {
        return bar(sheet, range, unit);
    }
    sheet.plain("no likelihood above zero", [middle, CORNER[1] + SIDE / 2.0], Align::Middle)
}

/// The side of a matrix in a space of `room` pixels. Cells of four or more pixels all get the same size.
fn even(room: usize, nodes: usize) -> usize {
    if nodes > 0 && room / nodes >= 4 { room / nodes * nodes } else { room }
}

/// Corner, size and colour of both squares of every cell in a matrix of `side` pixels; a square is at least `mark` wide.
fn squares(
    cells: &[Cell],
    nodes: usize,
    range: LogRange,
    side: usize,
    mark: usize,
) -> impl Iterator<Item = ([usize; 2], [usize; 2], Rgb)> {
    let extent = move |node: usize| {
        let (low, high) = (node * side / nodes, (node + 1) * side / nodes);
        let size = (high - low).max(mark.max(1));
        (low.min(side - size), size)
    };
    cells.iter().flat_map(move |([a, b], value)| {
        let (rgb, a, b) = (colour(range.share(*value)), extent(*a), extent(*b));
        [(a, b), (b, a)].map(|(x, y)| ([x.0, y.0], [x.1, y.1], rgb))
    })
}

/// Draws the matrix as an image; false where the page does not support images.
fn image(sheet: &mut Sheet<'_>, corner: [usize; 2], side: usize, cells: &[Cell], nodes: usize, range: LogRange) -> Result<bool> {
    let make = || {
        let pixels = even(IMAGE, nodes);
        let mut image = Image::new(pixels, ZERO);
        let mark = (MARK / SIDE * pixels as f64).round() as usize;
        for (at, size, rgb) in squares(cells, nodes, range, pixels, mark) {
            image.fill(at, size, rgb);
        }
        image
    };
    sheet.image(corner, [side, side], &make)
}

fn node_axes(sheet: &mut Sheet<'_>, [left, top]: [f64; 2], span: f64, nodes: usize) -> Result<()> {
    let bottom = top + span;
    if nodes > 0 {
        for tick in count_ticks(nodes as u64 - 1, 6) {
            let at = (tick.at + 0.5) / nodes as f64 * span;
            sheet.line([[left + at, bottom], [left + at, bottom + TICK]], HAIR, INK, 1.0)?;
            sheet.line([[left, top + at], [left - TICK, top + at]], HAIR, INK, 1.0)?;
            sheet.text(&tick.label, [left + at, bottom + TICK + 7.0], TEXT, Align::Middle, Run::Right)?;
            sheet.text(&tick.label, [left - TICK - 3.0, top + at], TEXT, Align::End, Run::Right)?;
        }
    }
    sheet.plain("node", [left + span / 2.0, bottom + TICK + 24.0], Align::Middle)?;
    sheet.upright("node", [9.0, top + span / 2.0])
}

fn bar(sheet: &mut Sheet<'_>, range: LogRange, unit: &str) -> Result<()> {
    let left = sheet.pixels(CORNER[0] + SIDE + BAR[0]);
    let (top, width, height) = (sheet.pixels(CORNER[1]), sheet.pixels(BAR[1]), sheet.pixels(SIDE));
    let drawn = sheet.ramp([left, top], [width, height], &MAP)?;
    for y in 0..if drawn { 0 } else { height } {
        let share = 1.0 - y as f64 / (height - 1).max(1) as f64;
        sheet.fill([left, top + y], [width, 1], colour(share))?;
    }
    let [left, top, width, height] = [left, top, width, height].map(|p| sheet.points(p));
    sheet.frame([left, top], [width, height])?;
    let right = left + width;
    for (row, tick) in range.ticks().into_iter().enumerate() {
        let y = top + (1.0 - range.share_of_log(tick.at)) * height;
        sheet.line([[right, y], [right + TICK, y]], HAIR, INK, 1.0)?;
        let label = if row == 0 && range.clipped { tick.label.after("\u{2264}") } else { tick.label };
        sheet.text(&label, [right + TICK + 3.0, y], TEXT, Align::Begin, Run::Right)?;
    }
    sheet.upright(&format!("L ({unit})"), [INCHES[0] * POINTS_PER_INCH - 9.0, top + height / 2.0])
}
