//! The likelihood matrix L as a picture with logarithmic colours: all vessels, and beside them the uncertain ones alone.

use std::collections::HashSet;

use super::axis::{LogRange, TickLabel, count_ticks, grouped};
use super::colour::{GREY, ZERO, colour};
use super::colour_bar::colour_bar;
use super::figure::Figure;
use super::sheet::{Align, FilledBox, Mark, Sheet};
use super::style::{self, HAIR, NAME_BELOW, NAME_LEFT, SMALL, TEXT, TICK};
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
/// Two names of blocks are so far apart, points.
const APART: f64 = 9.5;

/// A positive cell of the upper triangle, and its value.
type Cell = ([usize; 2], f64);

/// A symmetric matrix over the nodes, by its non-zero cells.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LikelihoodMatrix<'a> {
    /// N, the number of rows and columns, at most 2³² - 1; rows are 0-based.
    pub nodes: usize,
    /// One entry per vessel: its two nodes in either order, and its likelihood L.
    ///
    /// An entry stands for both of its cells, (a, b) and (b, a). Entries of the same two nodes (parallel vessels) add up.
    pub entries: &'a [(u32, u32, f64)],
    /// For each entry whether its vessel is uncertain; empty where no vessel is.
    pub uncertain: &'a [bool],
    /// The blocks, which hold every node once; fewer than two for the order of the nodes.
    pub blocks: &'a [NodeBlock],
}

/// Nodes that stand side by side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeBlock {
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

impl LikelihoodMatrix<'_> {
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
    for (cell, _) in &mut cells {
        cell.sort_unstable();
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
pub fn heat_map(matrix: &LikelihoodMatrix<'_>, weight: Weight) -> Figure {
    let grids = matrix.grids();
    let left = LEFT[usize::from(!grids[0].blocks.is_empty())];
    let range = LogRange::of(grids.iter().flat_map(|grid| grid.cells.iter().map(|cell| cell.1)));
    let mut sheet = Sheet::default();
    for (at, grid) in grids.iter().enumerate() {
        draw(&mut sheet, grid, left + at as f64 * (left + SIDE), range);
    }
    let right = grids.len() as f64 * (left + SIDE);
    if let Some(range) = range {
        let ticks = range.ticks().into_iter().enumerate().map(|(row, tick)| {
            let label = if row == 0 && range.clipped { tick.label.after("\u{2264}") } else { tick.label };
            (range.share_of_log(tick.at), label)
        });
        colour_bar(&mut sheet, [right + BAR, TOP], SIDE, ticks, &format!("L ({})", weight.unit()));
    } else {
        sheet.plain("no likelihood above zero", [left + SIDE / 2.0, TOP + SIDE / 2.0], Align::Middle);
    }
    Figure::new(LIKELIHOOD_PICTURE, [right + RIGHT, HEIGHT], sheet)
}

fn draw(sheet: &mut Sheet, grid: &Grid, left: f64, range: Option<LogRange>) {
    let ground = ([[left, TOP], [left + SIDE, TOP + SIDE]], ZERO);
    let squares = range.map(|range| squares(grid, left, range)).unwrap_or_default();
    sheet.marks.push(Mark::Boxes([ground].into_iter().chain(squares).collect()));
    borders(sheet, grid, left);
    sheet.frame([left, TOP], [SIDE, SIDE]);
    let middle = [left + SIDE / 2.0, TOP + SIDE / 2.0];
    if grid.blocks.is_empty() {
        if grid.rows > 0 {
            for tick in count_ticks(grid.rows as u64 - 1, 6) {
                let at = (tick.at + 0.5) / grid.rows as f64 * SIDE;
                sheet.tick_below([left + at, TOP + SIDE], &tick.label, TEXT);
                sheet.tick_left([left, TOP + at], &tick.label, TEXT);
            }
        }
        sheet.plain("node", [middle[0], TOP + SIDE + TICK + NAME_BELOW - 1.0], Align::Middle);
        sheet.upright("node", [left - LEFT[0] + NAME_LEFT, middle[1]]);
    } else {
        names(sheet, grid, left);
        sheet.plain("nodes, by nearest inlet or by fragment", [middle[0], TOP + SIDE + 15.0], Align::Middle);
    }
    sheet.title(&grid.title, left);
}

/// Both squares of every cell, at least as wide as a mark.
fn squares(grid: &Grid, left: f64, range: LogRange) -> Vec<FilledBox> {
    let extent = |row: usize| {
        let [low, high] = [row, row + 1].map(|row| row as f64 * SIDE / grid.rows as f64);
        let size = (high - low).max(MARK);
        let low = low.min(SIDE - size);
        [low, low + size]
    };
    let each = grid.cells.iter().flat_map(|([a, b], value)| {
        let (rgb, a, b) = (colour(range.share(*value)), extent(*a), extent(*b));
        [(a, b), (b, a)].map(|(x, y)| ([0, 1].map(|end| [left + x[end], TOP + y[end]]), rgb))
    });
    each.collect()
}

/// The lines between blocks, where they are not as close as the marks of vessels.
fn borders(sheet: &mut Sheet, grid: &Grid, left: f64) {
    let (mut rows, mut last) = (0, 0.0);
    for (_, own) in grid.blocks.iter().take(grid.blocks.len().saturating_sub(1)) {
        rows += own;
        let at = rows as f64 / grid.rows as f64 * SIDE;
        if at - last < MARK {
            continue;
        }
        last = at;
        sheet.line([[left + at, TOP], [left + at, TOP + SIDE]], HAIR, GREY, 1.0);
        sheet.line([[left, TOP + at], [left + SIDE, TOP + at]], HAIR, GREY, 1.0);
    }
}

/// The names of the blocks at the left. Neighbours without room are named together by their number.
fn names(sheet: &mut Sheet, grid: &Grid, left: f64) {
    let row = SIDE / grid.rows as f64;
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
        let y = TOP + f64::midpoint(from, to);
        if y < free {
            continue;
        }
        free = y + APART;
        let text = if count > 1 { format!("{count} small ones") } else { name.to_owned() };
        let text = style::fitting(&text, LEFT[1] - TICK - 8.0, SMALL);
        sheet.tick_left([left, y], &TickLabel::plain(text), SMALL);
    }
}
