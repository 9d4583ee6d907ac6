//! The likelihood matrix L as a picture with logarithmic colours: all vessels, and beside them the uncertain ones alone.

use std::collections::HashSet;

use super::axis::{Label, LogRange, count_ticks, grouped};
use super::canvas::{Align, Image, Run, Sheet};
use super::colour::{GREY, INK, Rgb, ZERO, colour};
use super::colour_bar::colour_bar;
use super::figure::Figure;
use super::style::{self, HAIR, NAME_BELOW, NAME_LEFT, POINTS_PER_INCH, SMALL, TEXT, TICK};
use crate::run_record::unit_of;
use willis_core::error::{Error, Result};
use willis_core::sampling::Weight;
use willis_io::output::names::LIKELIHOOD_PICTURE;

/// Height of the figure, and upper edge and side of a matrix, points.
const HEIGHT: f64 = 403.2;
const TOP: f64 = 34.0;
const SIDE: f64 = 318.0;
/// Left of a matrix with the numbers of its nodes, and with the names of its blocks, points.
const LEFT: [f64; 2] = [54.0, 92.0];
/// Gap before the colour bar, and all that is right of a matrix with a bar, points.
const BAR: f64 = 18.0;
const RIGHT: f64 = 88.8;
/// The smallest mark of a vessel, points, so that a single vessel among thousands of nodes is visible.
const MARK: f64 = 2.0;
/// The size of a pixel that is too small to see, points.
const INVISIBLE: f64 = 0.05;
/// The largest number of rectangles in an SVG; beyond it a matrix is one image.
const RECTANGLES: usize = 4000;
/// The side of that image, pixels: about 600 per inch.
const IMAGE: usize = 2650;
/// Two names of blocks are so far apart, points.
const APART: f64 = 9.5;

/// A positive cell of the upper triangle, and its value.
type Cell = ([usize; 2], f64);

/// A symmetric matrix over the nodes, by its non-zero cells.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Matrix<'a> {
    /// N, the number of rows and columns, at most 2³² - 1; rows are 0-based.
    pub nodes: usize,
    /// One entry per vessel: its two nodes in either order, and its likelihood L, finite and not negative.
    ///
    /// An entry stands for both of its cells, (a, b) and (b, a). Entries of the same two nodes (parallel vessels) add up.
    pub entries: &'a [(u32, u32, f64)],
    /// For each entry whether its vessel is uncertain; empty where no vessel is.
    pub uncertain: &'a [bool],
    /// The blocks, which hold every node once; fewer than two for the order of the nodes.
    pub blocks: &'a [Block],
}

/// Nodes that stand side by side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// What they have in common.
    pub name: String,
    /// The nodes in their order.
    pub nodes: Vec<usize>,
}

/// One matrix of the picture.
struct Grid {
    title: String,
    /// The number of its rows.
    rows: usize,
    cells: Vec<Cell>,
    /// Name and number of rows of each block.
    blocks: Vec<(String, usize)>,
}

impl Matrix<'_> {
    fn validate(&self) -> Result<()> {
        if u32::try_from(self.nodes).is_err() {
            return Err(Error::parameter("nodes", self.nodes, format!("expected at most {}", u32::MAX)));
        }
        for &(a, b, value) in self.entries {
            if a.max(b) as usize >= self.nodes {
                let accepted = format!("expected two nodes below {}", self.nodes);
                return Err(Error::parameter("matrix entry", format!("({a}, {b})"), accepted));
            }
            if !value.is_finite() || value < 0.0 {
                let name = format!("likelihood of ({a}, {b})");
                return Err(Error::parameter(name, value, "expected a finite number from 0 up"));
            }
        }
        if !self.uncertain.is_empty() && self.uncertain.len() != self.entries.len() {
            let accepted = format!("expected one for each of {} entries", self.entries.len());
            return Err(Error::parameter("uncertain", format!("of {} values", self.uncertain.len()), accepted));
        }
        if self.blocks.is_empty() {
            return Ok(());
        }
        let all = self.blocks.iter().flat_map(|block| block.nodes.iter().copied());
        let once: HashSet<usize> = all.clone().filter(|node| *node < self.nodes).collect();
        if once.len() == self.nodes && all.count() == self.nodes {
            return Ok(());
        }
        Err(Error::parameter("blocks", format!("of {} nodes", once.len()), format!("expected each of {} nodes once", self.nodes)))
    }

    /// The matrix of the entries that `shown` says, over the nodes that it says.
    fn grid(&self, title: &str, has_node: impl Fn(usize) -> bool, shown: impl Fn(usize) -> bool) -> Grid {
        let mut row_of = vec![usize::MAX; self.nodes];
        let mut rows = 0;
        let mut take = |nodes: &mut dyn Iterator<Item = usize>| {
            let before = rows;
            for node in nodes.filter(|node| has_node(*node)) {
                row_of[node] = rows;
                rows += 1;
            }
            rows - before
        };
        let blocks: Vec<(String, usize)> = if self.blocks.len() < 2 {
            take(&mut (0..self.nodes));
            Vec::new()
        } else {
            self.blocks.iter().map(|block| (block.name.clone(), take(&mut block.nodes.iter().copied()))).collect()
        };
        let entries = self.entries.iter().enumerate().filter(|(at, _)| shown(*at));
        let cells = entries.map(|(_, (a, b, value))| ([row_of[*a as usize], row_of[*b as usize]], *value));
        let title = format!("{title} ({} {})", grouped(rows as u64), if rows == 1 { "node" } else { "nodes" });
        Grid { title, rows, cells: added(cells.collect()), blocks: blocks.into_iter().filter(|(_, rows)| *rows > 0).collect() }
    }

    /// All vessels, and the uncertain ones alone where there are some of each.
    fn grids(&self) -> Vec<Grid> {
        let whole = self.grid("Likelihood matrix", |_| true, |_| true);
        let open = |at: usize| self.uncertain.get(at) == Some(&true) && self.entries[at].2 > 0.0;
        let of_open = self.entries.iter().enumerate().filter(|(at, _)| open(*at));
        let nodes: HashSet<usize> = of_open.flat_map(|(_, (a, b, _))| [*a as usize, *b as usize]).collect();
        let some_certain = self.uncertain.contains(&false);
        let alone =
            (some_certain && !nodes.is_empty()).then(|| self.grid("Uncertain vessels", |node| nodes.contains(&node), open));
        [whole].into_iter().chain(alone).collect()
    }
}

/// The positive cells of the upper triangle, sorted by value; those in one place add up.
fn added(mut cells: Vec<Cell>) -> Vec<Cell> {
    for ([a, b], _) in &mut cells {
        (*a, *b) = (*a.min(b), *a.max(b));
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
    cells
}

/// Draws the likelihood matrix L, 5.6 inches high; its unit is that of the `weight`. Where some vessels are certain and some are not, a second
/// matrix has the uncertain vessels alone, over the nodes that these join.
///
/// Rows go from top to bottom, columns from left to right, both in the order of the blocks, with a line between two blocks. The
/// colour is that of log10 L from the smallest to the largest positive value, over at least one decade and at most twelve. Smaller
/// values take the lowest colour, and the bar has `≤`. Zero is light grey ([`ZERO`]). A cell is at least 2 points wide, and where
/// cells share a pixel the largest value is drawn. In SVG more than 2000 vessels are one embedded image.
///
/// # Errors
///
/// When an entry names a node that does not exist, when a value is negative or not finite, when `uncertain` is not one for each entry,
/// and when the blocks do not hold every node once.
pub fn heat_map(matrix: &Matrix<'_>, weight: Weight) -> Result<Figure> {
    matrix.validate()?;
    let grids = matrix.grids();
    let left = LEFT[usize::from(!grids[0].blocks.is_empty())];
    let width = grids.len() as f64 * (left + SIDE) + RIGHT;
    let inches = [width, HEIGHT].map(|points| points / POINTS_PER_INCH);
    Ok(Figure::new(LIKELIHOOD_PICTURE, inches, move |sheet| draw(sheet, &grids, left, unit_of(weight))))
}

fn draw(sheet: &mut Sheet<'_>, grids: &[Grid], left: f64, unit: &str) -> Result<()> {
    let values = || grids.iter().flat_map(|grid| grid.cells.iter().map(|cell| cell.1));
    let range = LogRange::of(values());
    for (at, grid) in grids.iter().enumerate() {
        draw_grid(sheet, grid, [left + at as f64 * (left + SIDE), TOP], range)?;
    }
    let right = grids.len() as f64 * (left + SIDE);
    let Some(range) = range else {
        return sheet.plain("no likelihood above zero", [left + SIDE / 2.0, TOP + SIDE / 2.0], Align::Middle);
    };
    let ticks = range.ticks().into_iter().enumerate().map(|(row, tick)| {
        let label = if row == 0 && range.clipped { tick.label.after("\u{2264}") } else { tick.label };
        (range.share_of_log(tick.at), label)
    });
    colour_bar(sheet, [right + BAR, TOP], SIDE, ticks, &format!("L ({unit})"))
}

fn draw_grid(sheet: &mut Sheet<'_>, grid: &Grid, corner: [f64; 2], range: Option<LogRange>) -> Result<()> {
    let room = sheet.pixels(SIDE);
    // Cells need equal sizes only where pixels are visible.
    let side = if sheet.points(1) < INVISIBLE { room } else { even(room, grid.rows) };
    let inner = corner.map(|c| sheet.pixels(c));
    sheet.fill(inner, [side, side], ZERO)?;
    let [left, top] = inner.map(|c| sheet.points(c));
    let span = sheet.points(side);
    borders(sheet, grid, [left, top], span)?;
    if let Some(range) = range
        && (2 * grid.cells.len() <= RECTANGLES || !image(sheet, inner, side, grid, range)?)
    {
        let mark = sheet.pixels(MARK);
        for (at, size, rgb) in squares(&grid.cells, grid.rows, range, side, mark) {
            sheet.fill([inner[0] + at[0], inner[1] + at[1]], size, rgb)?;
        }
    }
    sheet.frame([left, top], [span, span])?;
    if grid.blocks.is_empty() {
        node_axes(sheet, [left, top], span, grid.rows)?;
    } else {
        names(sheet, grid, [left, top], span)?;
        sheet.plain("nodes, by nearest inlet or by fragment", [left + span / 2.0, top + span + 15.0], Align::Middle)?;
    }
    sheet.title(&grid.title, corner[0])
}

/// The side of a matrix in a space of `room` pixels. Cells of four or more pixels all get the same size.
fn even(room: usize, rows: usize) -> usize {
    if rows > 0 && room / rows >= 4 { room / rows * rows } else { room }
}

/// Corner, size and colour of both squares of every cell in a matrix of `side` pixels; a square is at least `mark` wide.
fn squares(
    cells: &[Cell],
    rows: usize,
    range: LogRange,
    side: usize,
    mark: usize,
) -> impl Iterator<Item = ([usize; 2], [usize; 2], Rgb)> {
    let extent = move |row: usize| {
        let (low, high) = (row * side / rows, (row + 1) * side / rows);
        let size = (high - low).max(mark.max(1));
        (low.min(side - size), size)
    };
    cells.iter().flat_map(move |([a, b], value)| {
        let (rgb, a, b) = (colour(range.share(*value)), extent(*a), extent(*b));
        [(a, b), (b, a)].map(|(x, y)| ([x.0, y.0], [x.1, y.1], rgb))
    })
}

/// Draws the cells as an image; false where the page does not support images.
fn image(sheet: &mut Sheet<'_>, corner: [usize; 2], side: usize, grid: &Grid, range: LogRange) -> Result<bool> {
    let make = || {
        let pixels = even(IMAGE, grid.rows);
        let mut image = Image::new(pixels, ZERO);
        let mark = (MARK / SIDE * pixels as f64).round() as usize;
        for (at, size, rgb) in squares(&grid.cells, grid.rows, range, pixels, mark) {
            image.fill(at, size, rgb);
        }
        image
    };
    sheet.image(corner, [side, side], &make)
}

/// The lines between blocks, where they are not as close as the marks of vessels.
fn borders(sheet: &mut Sheet<'_>, grid: &Grid, [left, top]: [f64; 2], span: f64) -> Result<()> {
    let (mut rows, mut last) = (0, 0.0);
    for (_, own) in grid.blocks.iter().take(grid.blocks.len().saturating_sub(1)) {
        rows += own;
        let at = rows as f64 / grid.rows as f64 * span;
        if at - last < MARK {
            continue;
        }
        last = at;
        sheet.line([[left + at, top], [left + at, top + span]], HAIR, GREY, 1.0)?;
        sheet.line([[left, top + at], [left + span, top + at]], HAIR, GREY, 1.0)?;
    }
    Ok(())
}

/// The names of the blocks at the left. Neighbours without room are named together by their number.
fn names(sheet: &mut Sheet<'_>, grid: &Grid, [left, top]: [f64; 2], span: f64) -> Result<()> {
    let row = span / grid.rows as f64;
    let mut groups: Vec<(&str, usize, f64, f64)> = Vec::new();
    let mut from = 0.0;
    for (name, rows) in &grid.blocks {
        let to = from + *rows as f64 * row;
        match groups.last_mut() {
            Some(group) if group.3 - group.2 < APART && to - from < APART => (group.1, group.3) = (group.1 + 1, to),
            _ => groups.push((name, 1, from, to)),
        }
        from = to;
    }
    let mut free = f64::NEG_INFINITY;
    for (name, count, from, to) in groups {
        let y = top + f64::midpoint(from, to);
        if y < free {
            continue;
        }
        free = y + APART;
        let text = if count > 1 { format!("{count} small ones") } else { name.to_owned() };
        let text = style::fitting(sheet, &text, LEFT[1] - TICK - 8.0, SMALL)?;
        sheet.line([[left - TICK, y], [left, y]], HAIR, INK, 1.0)?;
        sheet.text(&Label::plain(text), [left - TICK - 3.0, y], SMALL, Align::End, Run::Right)?;
    }
    Ok(())
}

fn node_axes(sheet: &mut Sheet<'_>, [left, top]: [f64; 2], span: f64, rows: usize) -> Result<()> {
    let bottom = top + span;
    if rows > 0 {
        for tick in count_ticks(rows as u64 - 1, 6) {
            let at = (tick.at + 0.5) / rows as f64 * span;
            sheet.line([[left + at, bottom], [left + at, bottom + TICK]], HAIR, INK, 1.0)?;
            sheet.line([[left, top + at], [left - TICK, top + at]], HAIR, INK, 1.0)?;
            sheet.text(&tick.label, [left + at, bottom + TICK + 7.0], TEXT, Align::Middle, Run::Right)?;
            sheet.text(&tick.label, [left - TICK - 3.0, top + at], TEXT, Align::End, Run::Right)?;
        }
    }
    sheet.plain("node", [left + span / 2.0, bottom + TICK + NAME_BELOW - 1.0], Align::Middle)?;
    sheet.upright("node", [left - LEFT[0] + NAME_LEFT, top + span / 2.0])
}
