//! Which way vessels lead from the inlets, and their orders: generation, Strahler's, and Strahler's by diameter. Bifurcations: angles,
//! asymmetry, and Murray's exponent.

use super::{VesselLine, vessel_lines::vessel_lines};
use crate::network::{Network, Role, ShortestPaths, Vessel, lengths_at};
use crate::support::{Point, counted, cross, dot, grouped, norm_squared, sub, unit};

/// So often orders by diameter are found again at most.
const MOST_PASSES: usize = 100;

/// The vessels of a network and the ways to them from the inlets. Each vessel is reached by the shortest way; one that closes a loop leads
/// to no other.
pub struct InletWays {
    /// The vessels, each from the end that is nearer to an inlet on; from the wider one where no inlet leads.
    pub lines: Vec<VesselLine>,
    /// By node, how many lines end there.
    pub degree: Vec<usize>,
    /// By node, the length of the way from the nearest inlet, m; infinite without one.
    pub from_inlet: Vec<f64>,
    /// By node, the line by which the way arrives.
    pub arrives_by: Vec<Option<usize>>,
    /// By node, the lines that ways take from it.
    leaving: Vec<Vec<usize>>,
    /// The nodes that ways reach, the nearest first.
    reached: Vec<usize>,
}

impl InletWays {
    /// Finds the ways; `role` says of each node whether blood enters or leaves there.
    pub fn of(network: &Network, role: impl Fn(usize) -> Role) -> Self {
        let nodes = network.node_count();
        let inlets: Vec<usize> = (0..nodes).filter(|node| role(*node) == Role::Inlet).collect();
        let mut lines = vessel_lines(network, |node| role(node) != Role::Inner);
        let at = lengths_at(nodes, lines.iter().enumerate().map(|(row, line)| (row, line.ends, line.length)));
        let (mut paths, mut reached) = (ShortestPaths::new(nodes), Vec::new());
        let edges = |node: usize| at[node].iter().copied();
        paths.search(&inlets, f64::INFINITY, edges, |_, node| {
            reached.push(node);
            true
        });
        let from_inlet = paths.lengths().to_vec();
        let mut arrives_by = vec![None; nodes];
        for node in &reached {
            arrives_by[*node] = paths.previous(*node).map(|(_, line)| line);
        }
        let mut leaving = vec![Vec::new(); nodes];
        for (row, line) in lines.iter_mut().enumerate() {
            let [a, b] = line.ends.map(|node| from_inlet[node]);
            // Where no inlet leads, from the wider end on, however the file draws it.
            if b < a || a.is_infinite() && line.end_radius(true) > line.end_radius(false) {
                line.turn();
            }
            if a.is_finite() {
                leaving[line.ends[0]].push(row);
            }
        }
        let degree = counted(nodes, lines.iter().flat_map(|line| line.ends));
        Self { lines, degree, from_inlet, arrives_by, leaving, reached }
    }

    /// By line the first territory on the way to its end, from those of the vessels.
    pub fn territories(&self, of_vessel: &[Option<usize>]) -> Vec<Option<usize>> {
        let own = |line: &VesselLine| line.pieces.iter().find_map(|row| of_vessel.get(*row).copied().flatten());
        let mut marks: Vec<Option<usize>> = self.lines.iter().map(own).collect();
        for node in &self.reached {
            let before = self.arrives_by[*node].and_then(|row| marks[row]);
            for row in &self.leaving[*node] {
                marks[*row] = before.or(marks[*row]);
            }
        }
        marks
    }
}

/// By line how many bifurcations lie before it, none where no inlet leads, and the product of the probabilities of all connections on the
/// way to its end, there not a number.
pub fn generations(network: &Network, ways: &InletWays) -> (Vec<Option<usize>>, Vec<f64>) {
    let mut generation: Vec<Option<usize>> = vec![None; ways.lines.len()];
    let mut probability = vec![f64::NAN; ways.lines.len()];
    for node in &ways.reached {
        let before = ways.arrives_by[*node];
        let here = before.map_or(0, |row| generation[row].unwrap_or(0) + usize::from(ways.degree[*node] > 2));
        for row in &ways.leaving[*node] {
            generation[*row] = Some(here);
            let open = ways.lines[*row].pieces.iter().map(|row| network.vessel(*row)).filter(|vessel| !vessel.certain);
            let within: f64 = open.filter_map(Vessel::evidence).map(|evidence| evidence.probability).product();
            probability[*row] = within * before.map_or(1.0, |row| probability[row]);
        }
    }
    (generation, probability)
}

/// Strahler's orders: that of an end is 1, that of another the largest of its children, and one more where two children have it and
/// `rises` says so of the line and that order.
fn raised(ways: &InletWays, rises: impl Fn(usize, usize) -> bool) -> Vec<Option<usize>> {
    let mut order: Vec<Option<usize>> = vec![None; ways.lines.len()];
    // The farthest first.
    for row in ways.reached.iter().rev().flat_map(|node| ways.leaving[*node].iter().copied()) {
        let end = ways.lines[row].ends[1];
        let children: &[usize] = if ways.arrives_by[end] == Some(row) { &ways.leaving[end] } else { &[] };
        let of: Vec<usize> = children.iter().filter_map(|child| order[*child]).collect();
        let most = of.iter().copied().max();
        order[row] = Some(most.map_or(1, |most| {
            let several = of.iter().filter(|order| **order == most).count() > 1;
            most + usize::from(several && rises(row, most))
        }));
    }
    order
}

/// By line Strahler's order, and the same by diameter; none where no inlet leads.
///
/// By diameter orders rise only where the vessel is wider than its children by more than chance: than halfway from the mean and one standard
/// deviation of their order to the mean less one of the next (Jiang, Kassab and Fung 1994, doi:10.1152/jappl.1994.76.2.882).
pub fn strahler(ways: &InletWays) -> [Vec<Option<usize>>; 2] {
    let strahler = raised(ways, |_, _| true);
    let radius: Vec<f64> = ways.lines.iter().map(VesselLine::radius).collect();
    let mut order = strahler.clone();
    for _ in 0..MOST_PASSES {
        let spread = |of: usize| {
            let values: Vec<f64> = order.iter().zip(&radius).filter(|(order, _)| **order == Some(of)).map(|(_, r)| *r).collect();
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            (n > 0.0).then(|| [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()])
        };
        let most = order.iter().flatten().copied().max().unwrap_or(0);
        let limit = |of: usize| match (spread(of), spread(of + 1)) {
            (Some([mean, deviation]), Some([next, of_next])) => f64::midpoint(mean + deviation, next - of_next),
            (Some([mean, deviation]), None) => mean + deviation,
            (None, _) => f64::INFINITY,
        };
        let limit: Vec<f64> = (0..=most).map(limit).collect();
        let again = raised(ways, |row, of| radius[row] > limit.get(of).copied().unwrap_or(f64::INFINITY));
        if again == order {
            break;
        }
        order = again;
    }
    [strahler, order]
}

/// The direction and the width of a vessel are those between so many and so many radii of the widest vessel there.
const STRETCH: [f64; 2] = [2.0, 6.0];
/// A child is narrower than its parent by more than this, in parts of the parent: twice what rounding to single precision does to the ratio.
const NARROWER: f64 = 1.0 / (1 << 22) as f64;
/// Murray's exponent is looked for up to here.
const MOST_EXPONENT: f64 = 1e3;

/// A node where three or more vessels meet. Figures are missing where nobody knows them: directions without positions.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredBifurcation {
    /// The row of its node.
    pub node: usize,
    /// How many vessel ends meet.
    pub degree: usize,
    /// The vessel by which blood comes from the nearest inlet; without an inlet the widest.
    pub parent: usize,
    /// The other vessels, the widest first.
    pub children: Vec<usize>,
    /// Of the parent and the two widest children, m.
    pub radii: [f64; 3],
    /// Between the two widest children, rad.
    pub angle: f64,
    /// From the direction of the parent to that of each of them, rad; zero goes straight on.
    pub bends: [f64; 2],
    /// The narrower of the two by the wider.
    pub asymmetry: f64,
    /// The sum of the children's cross-sections over the parent's.
    pub area_ratio: f64,
    /// k in r^k = Σ r_child^k; none where a child is as wide as the parent, since no k fulfils it then.
    pub murray: Option<f64>,
    /// Between the direction of the parent and the plane of the two children, rad; zero is flat.
    pub elevation: f64,
}

/// A vessel end at a bifurcation.
struct Leg {
    line: usize,
    radius: f64,
    direction: Option<Point>,
}

/// The bifurcations of a network, by node.
pub fn bifurcations(network: &Network, ways: &InletWays) -> Vec<MeasuredBifurcation> {
    let lines = &ways.lines;
    let ends = lines.iter().enumerate().flat_map(|(row, line)| [(line.ends[0], (row, false)), (line.ends[1], (row, true))]);
    let ends = grouped(network.node_count(), ends);
    let measured = |node: usize| {
        let widest = ends[node].iter().map(|(line, _)| lines[*line].radius()).fold(0.0, f64::max);
        let position = network.node(node).position;
        let legs = ends[node].iter().map(|(line, last)| leg(&lines[*line], *line, *last, widest, position)).collect();
        bifurcation(node, legs, ways.arrives_by[node])
    };
    (0..network.node_count()).filter(|node| ways.degree[*node] > 2).map(measured).collect()
}

fn bifurcation(node: usize, mut legs: Vec<Leg>, arrives_by: Option<usize>) -> MeasuredBifurcation {
    let degree = legs.len();
    legs.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let first = arrives_by.and_then(|row| legs.iter().position(|leg| leg.line == row)).unwrap_or(0);
    let parent = legs.remove(first);
    let ratios: Vec<f64> = legs.iter().map(|leg| leg.radius / parent.radius).collect();
    let angle = |a: Option<Point>, b: Option<Point>| a.zip(b).map_or(f64::NAN, |(a, b)| dot(a, b).clamp(-1.0, 1.0).acos());
    let onwards = parent.direction.map(|d| d.map(|x| -x));
    let flat = legs[0].direction.zip(legs[1].direction).map(|(a, b)| cross(a, b)).filter(|n| norm_squared(*n) > 1e-12);
    MeasuredBifurcation {
        node,
        degree,
        parent: parent.line,
        radii: [parent.radius, legs[0].radius, legs[1].radius],
        angle: angle(legs[0].direction, legs[1].direction),
        bends: [0, 1].map(|child| angle(onwards, legs[child].direction)),
        asymmetry: legs[1].radius / legs[0].radius,
        area_ratio: ratios.iter().map(|ratio| ratio * ratio).sum(),
        murray: murray(&ratios),
        elevation: flat.zip(onwards).map_or(f64::NAN, |(n, d)| dot(unit(n), d).abs().min(1.0).asin()),
        children: legs.into_iter().map(|leg| leg.line).collect(),
    }
}

fn leg(line: &VesselLine, row: usize, last: bool, widest: f64, position: Option<Point>) -> Leg {
    let [near, far] = STRETCH.map(|radii| (radii * widest).min(line.length));
    // A short vessel has the direction and the width of all of it.
    let near = if far - near > 0.25 * (STRETCH[1] - STRETCH[0]) * widest { near } else { 0.0 };
    let radius = if last { line.radius_between(line.length - far, line.length - near) } else { line.radius_between(near, far) };
    let from = if near > 0.0 { line.place(near, last) } else { position };
    let direction = from.zip(line.place(far, last)).map(|(a, b)| sub(b, a)).filter(|d| norm_squared(*d) > 0.0).map(unit);
    Leg { line: row, radius, direction }
}

/// The k > 0 at which the k-th powers of the ratios add up to 1, by bisection. Their sum falls with k if every ratio is below 1, from more than
/// 1 to 0, so there is just one; else there is none. Files may have radii in single precision, each off by 2⁻²⁴ of itself: a ratio within
/// [`NARROWER`] of 1 may be 1, where no k would do.
fn murray(ratios: &[f64]) -> Option<f64> {
    if ratios.iter().any(|ratio| !(*ratio > 0.0 && *ratio < 1.0 - NARROWER)) {
        return None;
    }
    let sum = |k: f64| ratios.iter().map(|ratio| ratio.powf(k)).sum::<f64>();
    let [mut low, mut high] = [0.0, MOST_EXPONENT];
    if sum(high) > 1.0 {
        return None;
    }
    while high - low > 1e-12 * high {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if sum(middle) > 1.0 { low = middle } else { high = middle }
    }
    Some(high)
}
