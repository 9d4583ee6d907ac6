//! The likelihood matrix L as a picture with logarithmic colours, in the order of the nodes by inlet and fragment; and its convergence with the number of samples.

use std::cmp::Reverse;

use super::axis::{LogRange, TickLabel, count_ticks, grouped};
use super::figure::Figure;
use super::sheet::{
    Align, BOLD, CURVE, FilledBox, HAIR, LegendKey, Mark, NAME_BELOW, NAME_LEFT, POINTS_PER_INCH, REFERENCE, SMALL, Sheet,
    SheetPlace, TEXT, TICK, fitting,
};
use super::{GREY, INK, KEPT, PAPER, PRUNED, Rgb, ZERO, colour};
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::network::{Network, Origin, Role, fragments};
use willis_core::sampling::Weight;
use willis_io::output::names::{CONVERGENCE_PICTURE, LIKELIHOOD_PICTURE};

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
        let nodes: std::collections::HashSet<usize> = of_open.flat_map(|(_, (a, b, _))| [*a as usize, *b as usize]).collect();
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
        let left = left + at as f64 * (left + SIDE);
        let ground = ([[left, TOP], [left + SIDE, TOP + SIDE]], ZERO);
        let squares = range.map(|range| squares(grid, left, range)).unwrap_or_default();
        sheet.marks.push(Mark::Boxes([ground].into_iter().chain(squares).collect()));
        borders(&mut sheet, grid, left);
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
            names(&mut sheet, grid, left);
            sheet.plain("nodes, by nearest inlet or by fragment", [middle[0], TOP + SIDE + 15.0], Align::Middle);
        }
        sheet.title(&grid.title, left);
    }
    let right = grids.len() as f64 * (left + SIDE);
    if let Some(range) = range {
        let ticks = range.ticks().into_iter().enumerate().map(|(row, tick)| {
            let label = if row == 0 && range.clipped { tick.label.after("\u{2264}") } else { tick.label };
            (range.share_of_log(tick.at), label)
        });
        sheet.colour_bar([right + BAR, TOP], SIDE, ticks, &format!("L ({})", weight.unit()));
    } else {
        sheet.plain("no likelihood above zero", [left + SIDE / 2.0, TOP + SIDE / 2.0], Align::Middle);
    }
    Figure::new(LIKELIHOOD_PICTURE, [right + RIGHT, HEIGHT], sheet)
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

/// Neighbouring blocks with one name at the left, and from where to where they reach.
struct NamedBlocks<'a> {
    first: &'a str,
    count: usize,
    from: f64,
    to: f64,
}

/// The names of the blocks at the left. Neighbours without room are named together by their number.
fn names(sheet: &mut Sheet, grid: &Grid, left: f64) {
    let row = SIDE / grid.rows as f64;
    let mut groups: Vec<NamedBlocks<'_>> = Vec::new();
    let mut from = 0.0;
    for (first, rows) in &grid.blocks {
        let to = from + *rows as f64 * row;
        match groups.last_mut() {
            Some(group) if group.to - group.from < APART && to - from < APART => {
                group.count += 1;
                group.to = to;
            }
            _ => groups.push(NamedBlocks { first, count: 1, from, to }),
        }
        from = to;
    }
    let mut free = f64::NEG_INFINITY;
    for NamedBlocks { first, count, from, to } in groups {
        let y = TOP + f64::midpoint(from, to);
        if y < free {
            continue;
        }
        free = y + APART;
        let text = if count > 1 { format!("{count} small ones") } else { first.to_owned() };
        let text = fitting(&text, LEFT[1] - TICK - 8.0, SMALL);
        sheet.tick_left([left, y], &TickLabel::plain(text), SMALL);
    }
}

/// The blocks of all nodes: those nearest to each inlet along the observed vessels, then the fragments without an inlet, then all
/// nodes without an observed vessel in one. The largest of each kind comes first.
///
/// Within a block a node follows the one before it on the way from the inlet, or from the fragment's first node, smaller branches
/// first, so that the two ends of an observed vessel stand side by side where they can.
pub fn node_blocks(network: &Network, boundary: &willis_core::flow::Boundary) -> Vec<NodeBlock> {
    let count = network.node_count();
    let observed = network.vessels().enumerate().filter(|(_, (_, vessel))| vessel.origin == Origin::Observed);
    let at_node = lengths_at(count, observed.map(|(row, (ends, vessel))| (row, ends, vessel.length)));
    let name = |node: usize| {
        let node = network.node(node);
        if node.label.is_empty() { &node.id } else { &node.label }
    };
    let mut paths = ShortestPaths::new(count);
    let mut trees = |sources: &[usize]| {
        let mut visited = Vec::new();
        let around = |node: usize| at_node[node].iter().copied();
        paths.search(sources, f64::INFINITY, around, |_, node| {
            visited.push(node);
            true
        });
        let before = visited.iter().map(|node| paths.previous(*node).map(|(node, _)| node)).collect::<Vec<_>>();
        orders(sources, &visited, &before, count)
    };
    let inlets: Vec<usize> = (0..count).filter(|node| boundary.roles[*node] == Role::Inlet).collect();
    let mut fed = trees(&inlets);
    // Of every fragment without an inlet the first node; nodes without an observed vessel are none.
    let parts = fragments(network, |_, vessel| vessel.origin == Origin::Observed);
    let mut seen = vec![false; parts.count];
    for inlet in &inlets {
        seen[parts.of_node[*inlet]] = true;
    }
    let unfed: Vec<usize> = (0..count).filter(|node| !std::mem::replace(&mut seen[parts.of_node[*node]], true)).collect();
    let (alone, first): (Vec<usize>, Vec<usize>) = unfed.into_iter().partition(|node| at_node[*node].is_empty());
    let mut fragments = trees(&first);
    fed.sort_by_key(|nodes| Reverse(nodes.len()));
    fragments.sort_by_key(|nodes| Reverse(nodes.len()));
    let fed = fed.into_iter().map(|nodes| NodeBlock { name: format!("inlet {}", name(nodes[0])), nodes });
    let fragments = fragments.into_iter().map(|nodes| NodeBlock { name: format!("fragment of {}", name(nodes[0])), nodes });
    let alone = (!alone.is_empty()).then(|| NodeBlock { name: "no vessel".to_owned(), nodes: alone });
    fed.chain(fragments).chain(alone).collect()
}

/// The nodes of the tree of each source in the order of a walk that takes smaller branches first. `before` is the node before each visited one.
pub fn orders(sources: &[usize], visited: &[usize], before: &[Option<usize>], count: usize) -> Vec<Vec<usize>> {
    let mut size = vec![1_usize; count];
    let mut after = vec![Vec::new(); count];
    for (node, before) in visited.iter().zip(before).rev() {
        if let Some(before) = before {
            size[*before] += size[*node];
            after[*before].push(*node);
        }
    }
    let walk = |source: &usize| {
        let (mut order, mut open) = (Vec::new(), vec![*source]);
        while let Some(node) = open.pop() {
            order.push(node);
            let mut next = after[node].clone();
            next.sort_by_key(|node| (Reverse(size[*node]), Reverse(*node)));
            open.extend(next);
        }
        order
    };
    sources.iter().map(walk).collect()
}

const PAGE: [f64; 2] = [6.4 * POINTS_PER_INCH, 4.6 * POINTS_PER_INCH];
/// Left, top, right and bottom of the axes, points.
const BOX: [f64; 4] = [62.0, 50.0, 440.0, 284.0];
/// Height of the line of zeros, points.
const ZEROS: f64 = BOX[3] - 5.0;
/// The distance between that line and the lowest positive value, points.
const GAP: f64 = 16.0;

/// The largest number of curves of kept vessels, and of pruned ones; more cannot be distinguished.
const MOST_CURVES: usize = 400;

/// The width of the thinnest curve, points.
const THIN: f64 = 0.5;

/// What the line across the curves is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutLine {
    /// The threshold of the rule: vessels above it are kept.
    Threshold,
    /// The median of L, above which lies the topology of that name. The rule decides by something else than L.
    Median,
}

/// Draws the mean contribution per sample, L/n, of every uncertain vessel against the number of samples n, on a
/// logarithmic axis, 6.4 by 4.6 inches. The median is a dashed line.
///
/// - `samples`: n at each checkpoint, positive and rising.
/// - `series`: for each vessel L/n at each checkpoint. Of more than 400 that are kept, or pruned, only a regular selection is drawn.
/// - `line`: whether it is the threshold or the median, and that on L/n at each checkpoint; NaN where there is none.
/// - `kept`: for each vessel whether it is kept.
/// - `weight`: what L adds up, from which its unit follows.
///
/// Zeros, and values more than twelve decades below the largest, lie on a line of their own below the smallest positive value; curves
/// do not join the two. A single checkpoint is drawn as dashes. A picture without a vessel, a checkpoint or a positive value is one sentence.
pub fn convergence(samples: &[u64], series: &[Vec<f64>], line: (CutLine, &[f64]), kept: &[bool], weight: Weight) -> Figure {
    let (cut, threshold) = line;
    let mut sheet = Sheet::default();
    let [left, top, right, bottom] = BOX;
    sheet.title("Convergence of the likelihood of uncertain vessels", left);

    let values = || series.iter().flatten().chain(threshold).copied();
    let range = if series.is_empty() { None } else { LogRange::of(values()) };
    let Some(range) = range.map(LogRange::padded) else {
        let note = match (series.is_empty(), samples.is_empty()) {
            (true, _) => "Every vessel is certain: there is no likelihood that could converge.",
            (_, true) => "Every pattern was counted, so that nothing has to converge.",
            _ => "No uncertain vessel carries blood in any sample.",
        };
        sheet.plain(note, [left, top], Align::Begin);
        return Figure::new(CONVERGENCE_PICTURE, PAGE, sheet);
    };

    let lowest = values().fold(f64::INFINITY, f64::min);
    let axes = ConvergenceAxes { last: samples.last().copied().unwrap_or(1), range, zeros: range.share(lowest) < 0.0 };
    axes.ticks(&mut sheet, weight);
    // A few curves are thick and opaque, thousands thin and transparent.
    let curves = [false, true].map(|kept_ones| {
        let all: Vec<&Vec<f64>> =
            series.iter().zip(kept).filter(|(_, kept)| **kept == kept_ones).map(|(values, _)| values).collect();
        let step = all.len().div_ceil(MOST_CURVES).max(1);
        all.into_iter().step_by(step).collect::<Vec<_>>()
    });
    let sparse = (10.0 / (curves[0].len() + curves[1].len()) as f64).sqrt().clamp(0.0, 1.0);
    let width = THIN + sparse * (CURVE - THIN);
    let opacity = 0.05 + 0.85 * sparse.powf(0.7);
    for (curves, rgb) in curves.iter().zip([PRUNED, KEPT]) {
        for run in curves.iter().flat_map(|values| axes.runs(samples, values)) {
            stroke(&mut sheet, run, width, rgb, opacity);
        }
    }
    for run in axes.runs(samples, threshold) {
        if cut == CutLine::Median && run.len() > 1 {
            sheet.dashed(run, 1.2, INK);
            continue;
        }
        if cut == CutLine::Threshold {
            stroke(&mut sheet, run.clone(), 2.0 * BOLD, PAPER, 0.8);
        }
        stroke(&mut sheet, run, BOLD, INK, 1.0);
    }
    sheet.frame([left, top], [right - left, bottom - top]);
    let stay = kept.iter().filter(|kept| **kept).count();
    let count = |word: &str, n: usize| format!("{word} ({})", grouped(n as u64));
    let counts = [count("kept", stay), count("pruned", kept.len() - stay)];
    let line = match cut {
        CutLine::Threshold => ("threshold", LegendKey::Line(BOLD), INK),
        CutLine::Median => ("median of L (not the rule)", REFERENCE.0, REFERENCE.1),
    };
    let line = threshold.iter().any(|cut| !cut.is_nan()).then_some(line);
    let curves = [(&*counts[0], LegendKey::Line(CURVE), KEPT), (&*counts[1], LegendKey::Line(CURVE), PRUNED)];
    sheet.legend(left, &curves.into_iter().chain(line).collect::<Vec<_>>());
    Figure::new(CONVERGENCE_PICTURE, PAGE, sheet)
}

/// The positions of numbers of samples and contributions on the page.
struct ConvergenceAxes {
    last: u64,
    range: LogRange,
    /// Whether there is a line of zeros.
    zeros: bool,
}

impl ConvergenceAxes {
    fn x(&self, samples: f64) -> f64 {
        // A small margin after the last checkpoint.
        BOX[0] + (BOX[2] - BOX[0]) * samples / (self.last as f64 * 1.02)
    }

    fn y(&self, share: f64) -> f64 {
        let lowest = if self.zeros { ZEROS - GAP } else { BOX[3] };
        if share < 0.0 { ZEROS } else { lowest - (lowest - BOX[1]) * share }
    }

    fn ticks(&self, sheet: &mut Sheet, weight: Weight) {
        let [left, top, right, bottom] = BOX;
        let counts = count_ticks(self.last, 6).into_iter();
        sheet.ticks_below([top, bottom], counts.map(|tick| (self.x(tick.at), tick.label)));
        let powers = self.range.ticks();
        let lowest = powers.first().filter(|_| self.range.clipped);
        let below = lowest.map_or_else(|| TickLabel::plain("0"), |tick| tick.label.clone().after("<"));
        let zeros = self.zeros.then_some((ZEROS, below));
        let powers = powers.into_iter().map(|tick| (self.y(self.range.share_of_log(tick.at)), tick.label));
        sheet.ticks_left([left, right], powers.chain(zeros));
        let middle = [f64::midpoint(left, right), f64::midpoint(top, bottom)];
        sheet.plain("number of samples, n", [middle[0], bottom + TICK + NAME_BELOW], Align::Middle);
        let name = match weight {
            Weight::Resilience | Weight::Global => "mean contribution per sample L/n (W/m\u{b3})",
            Weight::Count => "share of samples L/n",
        };
        sheet.upright(name, [NAME_LEFT, middle[1]]);
    }

    /// The stretches of a curve on the page: interrupted at NaN and between zero and positive values.
    fn runs(&self, samples: &[u64], values: &[f64]) -> Vec<Vec<SheetPlace>> {
        let shares: Vec<_> = samples.iter().zip(values).map(|(n, v)| (*n, self.range.share(*v))).collect();
        let joined = |a: f64, b: f64| (a < 0.0) == (b < 0.0) && a.is_nan() == b.is_nan();
        let runs = shares.chunk_by(|a, b| joined(a.1, b.1)).filter(|run| !run[0].1.is_nan());
        runs.map(|run| run.iter().map(|(n, share)| [self.x(*n as f64), self.y(*share)]).collect()).collect()
    }
}

/// Draws a stretch of a curve. A single checkpoint is a dash.
fn stroke(sheet: &mut Sheet, mut path: Vec<SheetPlace>, width: f64, rgb: Rgb, opacity: f64) {
    if let [[x, y]] = path[..] {
        let half = 2.0 + 2.0 * width;
        path = vec![[x - half, y], [x + half, y]];
    }
    sheet.line(path, width, rgb, opacity);
}
