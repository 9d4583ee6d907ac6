//! Times the complex equations of a pulse by two solvers: the elimination of the library, and faer's sparse LU with partial pivoting.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::time::Instant;

use faer::Col;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};
use num_complex::Complex64;
use willis::internals::flow::{Tube, WallLaw};
use willis::internals::network::{Condition, Windkessel};
use willis::internals::simulation::pulse::elimination::Equations;
use willis::internals::simulation::pulse::womersley::Fluid;
use willis::internals::simulation::pulse::womersley::Halved;
use willis::internals::simulation::pulse::{Friction, terminals, walled};
use willis::internals::support::elimination::Elimination;

use crate::Result;
use crate::case::Case;

/// All harmonics are solved again and again for so long, s; the least time counts.
const BUDGET: f64 = 2.0;

/// The equations of one harmonic, before any solver: between free nodes, to the ground, and what is injected.
struct Harmonic {
    joins: Vec<Complex64>,
    ground: Vec<Complex64>,
    injected: Vec<Complex64>,
}

/// Prints vessels, free nodes, harmonics; milliseconds for all harmonics by elimination and by LU, one thread, without the admittances of
/// the vessels, which both need; the largest difference of a pressure, over the largest; and the largest residual of either.
pub fn print(case: &Case, harmonics: usize) -> Result<()> {
    let (network, boundary) = (&case.network, &case.boundary);
    let fluid = Fluid { viscosity: 3.5e-3, density: 1060.0, friction: Friction::Womersley, wall_viscosity: 0.0 };
    let vessels = walled(network, &Tube::at_rest(network, fluid.viscosity), &[], &WallLaw::OLUFSEN, &fluid)?;
    let stated = vec![Windkessel::default(); network.node_count()];
    let terminals = terminals(network, boundary, &stated, &vessels, &fluid, Some(0.69));
    let held = |node: usize| match boundary.condition(node) {
        Some(Condition::Pressure(pressure)) => Some(pressure),
        _ => None,
    };
    let mut free = HashMap::new();
    for node in (0..network.node_count()).filter(|node| held(*node).is_none()) {
        free.insert(node, free.len());
    }
    let rows = (0..network.vessel_count()).filter(|row| {
        let [a, b] = network.ends(*row);
        a != b && free.contains_key(&a) && free.contains_key(&b)
    });
    let rows: Vec<usize> = rows.collect();
    let links: Vec<[usize; 2]> = rows.iter().map(|row| network.ends(*row).map(|node| free[&node])).collect();
    let harmonic = |n: usize| {
        let frequency = TAU * n as f64;
        let ports: Vec<Halved> = vessels.iter().map(|vessel| Halved::of(&vessel.halves, &fluid, frequency)).collect();
        let mut ground = vec![Complex64::ZERO; free.len()];
        let mut injected = ground.clone();
        for (node, at) in &free {
            ground[*at] += terminals[*node].map_or(Complex64::ZERO, |terminal| terminal.admittance(frequency));
        }
        for (port, (ends, _)) in ports.iter().zip(network.vessels()) {
            for (k, node) in ends.into_iter().enumerate() {
                let Some(at) = free.get(&node) else { continue };
                ground[*at] += port.whole.shunts[k];
                // An inlet's pressure falls as one over the harmonic; the ground stays.
                if let Some(pressure) = held(ends[1 - k]) {
                    ground[*at] += port.whole.series;
                    injected[*at] += port.whole.series * (pressure / (1 + n) as f64);
                }
            }
        }
        Harmonic { joins: rows.iter().map(|row| ports[*row].whole.series).collect(), ground, injected }
    };
    let all: Vec<Harmonic> = (1..=harmonics).map(harmonic).collect();

    let elimination = Elimination::compile(free.len(), &links, 1 << 27).ok_or("too many joins")?;
    let (eliminated, ours) = least(|| all.iter().map(|one| eliminate(&elimination, &links, one)).collect());
    let pattern = Pattern::of(free.len(), &links)?;
    let (factored, theirs) = least(|| all.iter().map(|one| pattern.solve(&links, one)).collect());

    let highest = ours.iter().flatten().map(|p| p.norm()).fold(0.0, f64::max);
    let pairs = ours.iter().flatten().zip(theirs.iter().flatten());
    let difference = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / highest;
    let residual = |solved: &[Vec<Complex64>]| all.iter().zip(solved).map(|(one, p)| left(&links, one, p)).fold(0.0, f64::max);
    println!(
        "{} {} {harmonics} {eliminated:.4} {factored:.4} {difference:.1e} {:.1e} {:.1e}",
        network.vessel_count(),
        free.len(),
        residual(&ours),
        residual(&theirs)
    );
    Ok(())
}

/// The least time (ms), and what came out.
fn least(solve: impl Fn() -> Vec<Vec<Complex64>>) -> (f64, Vec<Vec<Complex64>>) {
    let (begun, mut least, mut out) = (Instant::now(), f64::INFINITY, Vec::new());
    while begun.elapsed().as_secs_f64() < BUDGET {
        let start = Instant::now();
        out = std::hint::black_box(solve());
        least = least.min(1e3 * start.elapsed().as_secs_f64());
    }
    (least, out)
}

fn eliminate(elimination: &Elimination, links: &[[usize; 2]], one: &Harmonic) -> Vec<Complex64> {
    let mut equations = Equations::new(elimination);
    for (node, (ground, injected)) in one.ground.iter().zip(&one.injected).enumerate() {
        equations.ground(elimination.place(node), *ground);
        equations.inject(elimination.place(node), *injected);
    }
    for ([a, b], join) in links.iter().zip(&one.joins) {
        equations.join(elimination.place(*a), elimination.place(*b), *join);
    }
    let solved = equations.solve();
    (0..one.ground.len()).map(|node| solved[elimination.place(node) as usize]).collect()
}

/// Where the entries of the matrix are, and their symbolic factors, worked out once.
struct Pattern {
    matrix: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
    factors: SymbolicLu<usize>,
}

impl Pattern {
    fn of(nodes: usize, links: &[[usize; 2]]) -> Result<Self> {
        let diagonal = (0..nodes).map(|node| Pair { row: node, col: node });
        let beside = links.iter().flat_map(|[a, b]| [Pair { row: *a, col: *b }, Pair { row: *b, col: *a }]);
        let twice = links.iter().flatten().map(|node| Pair { row: *node, col: *node });
        let places: Vec<Pair<usize, usize>> = diagonal.chain(beside).chain(twice).collect();
        let (matrix, order) =
            SymbolicSparseColMat::try_new_from_indices(nodes, nodes, &places).map_err(|why| format!("{why:?}"))?;
        let factors = SymbolicLu::try_new(matrix.as_ref()).map_err(|why| format!("{why:?}"))?;
        Ok(Self { matrix, order, factors })
    }

    fn solve(&self, links: &[[usize; 2]], one: &Harmonic) -> Vec<Complex64> {
        let beside = one.joins.iter().flat_map(|join| [-join, -join]);
        let twice = one.joins.iter().flat_map(|join| [*join, *join]);
        let values: Vec<Complex64> = one.ground.iter().copied().chain(beside).chain(twice).collect();
        debug_assert_eq!(values.len(), one.ground.len() + 4 * links.len());
        let matrix = SparseColMat::new_from_argsort(self.matrix.clone(), &self.order, &values).expect("the pattern");
        let lu = Lu::try_new_with_symbolic(self.factors.clone(), matrix.as_ref()).expect("factors");
        let right = Col::from_fn(one.injected.len(), |node| one.injected[node]);
        let solved = lu.solve(&right);
        (0..one.injected.len()).map(|node| solved[node]).collect()
    }
}

/// The largest residual at a node over what passes it.
fn left(links: &[[usize; 2]], one: &Harmonic, pressure: &[Complex64]) -> f64 {
    let mut left = one.injected.clone();
    let mut scale: Vec<f64> = left.iter().map(|q| q.norm()).collect();
    for (node, ground) in one.ground.iter().enumerate() {
        left[node] -= ground * pressure[node];
        scale[node] += (ground * pressure[node]).norm();
    }
    for ([a, b], join) in links.iter().zip(&one.joins) {
        let flow = join * (pressure[*a] - pressure[*b]);
        left[*a] -= flow;
        left[*b] += flow;
        scale[*a] += flow.norm();
        scale[*b] += flow.norm();
    }
    left.iter().zip(&scale).map(|(left, scale)| left.norm() / scale.max(f64::MIN_POSITIVE)).fold(0.0, f64::max)
}
