//! Lanes against Cholesky over graphs of growing size, and the cost model that the choice between them can follow.

use willis::hemodynamics::StarMesh;
use willis::hemodynamics::cholesky::{self, Cholesky};
use willis::inference::{Bottleneck, Solver};
use willis::rng::BLOCK;

use crate::Result;
use crate::case::Case;
use crate::clock::per_call;
use crate::fit::relative;
use crate::stages;
use crate::synthetic::Family;

const SIZES: [usize; 9] = [50, 100, 200, 400, 800, 1600, 3000, 5000, 8000];
/// Seconds for each figure.
const BUDGET: f64 = 0.25;
/// Models are fitted to shorter programs; beyond, lanes leave the cache and Cholesky gains from supernodes.
const FITTED: f64 = 5e6;
/// Programs longer than this are not timed.
const LONGEST: usize = 30_000_000;

struct Row {
    vessels: f64,
    joins_solve: f64,
    joins_forest: f64,
    entries: f64,
    lanes: f64,
    by_bottleneck: bool,
    cholesky: f64,
}

/// Prints the table as CSV, then the fitted constants as comments.
pub fn print() -> Result<()> {
    println!(
        "family,nodes,vessels,free,joins_solve,joins_forest,factor_entries,lanes_solve_us,lanes_forest_us,kruskal_forest_us,\
         cholesky_solve_us,lanes_us,lanes_forest,cholesky_us"
    );
    let mut rows = Vec::new();
    for family in Family::ALL {
        for nodes in SIZES {
            rows.push(row(family, nodes)?);
        }
    }
    rows.retain(|row| row.joins_solve < FITTED);
    fit("lanes = a joins_solve + b joins_forest + c vessels", &rows, |row| {
        row.by_bottleneck.then_some(([row.joins_solve, row.joins_forest, row.vessels], row.lanes))
    });
    fit("lanes, forest by Kruskal = a joins_solve + c vessels", &rows, |row| {
        (!row.by_bottleneck).then_some(([row.joins_solve, row.vessels], row.lanes))
    });
    fit("cholesky = d joins_solve + e vessels", &rows, |row| Some(([row.joins_solve, row.vessels], row.cholesky)));
    fit("cholesky = d joins_solve + e vessels + f factor_entries", &rows, |row| {
        Some(([row.joins_solve, row.vessels, row.entries], row.cholesky))
    });
    Ok(())
}

/// Prints the constants of a model and how far it is off.
fn fit<const N: usize>(model: &str, rows: &[Row], terms: impl Fn(&Row) -> Option<([f64; N], f64)>) {
    let terms: Vec<([f64; N], f64)> = rows.iter().filter_map(terms).collect();
    let (constants, worst) = relative(&terms);
    let ns: Vec<String> = constants.iter().map(|x| format!("{:.3}", 1e3 * x)).collect();
    println!("# {model}: {} ns; within {worst:.2}x of every measurement", ns.join(", "));
}

fn row(family: Family, nodes: usize) -> Result<Row> {
    let case = Case::new(family.graph(nodes))?;
    let pieces = case.pieces()?;
    let vessels = case.network.vessel_count();
    let solver = StarMesh::compile(&pieces.circuit, LONGEST).ok_or("a program too long")?;
    let bottleneck = Bottleneck::compile(nodes, &pieces.in_forest, LONGEST).ok_or("a forest program too long")?;
    let factor = Cholesky::compile(&pieces.circuit).ok_or("no factor")?;
    let free = pieces.circuit.fixed.iter().filter(|p| p.is_none()).count();

    let keys = pieces.keys(&solver, 16);
    let lanes_solve = stages::solve(&pieces, &solver, BUDGET);
    let lanes_forest = stages::forest(&bottleneck, &keys, BUDGET);
    let kruskal = crate::forests::kruskal(&case, &keys, BUDGET);
    let (mut masks, mut work, mut sample) = (Vec::new(), cholesky::Workspace::default(), 0);
    pieces.occlusion.draw(0, 0, &mut masks);
    let cholesky_solve = per_call(BUDGET, || {
        let open = |vessel: usize| masks[vessel] >> sample & 1 == 1;
        factor
            .solve(open, &mut work, |_, p| {
                std::hint::black_box(p);
            })
            .expect("a factorisation");
        sample = (sample + 1) % 64;
    });
    let (lanes, forest) = stages::whole(&case, Solver::Lanes, BLOCK, BUDGET)?;
    let (cholesky, _) = stages::whole(&case, Solver::Cholesky, 16, BUDGET)?;
    println!(
        "{},{nodes},{vessels},{free},{},{},{},{lanes_solve:.3},{lanes_forest:.3},{kruskal:.3},{cholesky_solve:.3},{lanes:.3},\
         {forest},{cholesky:.3}",
        family.name(),
        solver.updates(),
        bottleneck.joins(),
        factor.factor_entries()
    );
    Ok(Row {
        vessels: vessels as f64,
        joins_solve: solver.updates() as f64,
        joins_forest: bottleneck.joins() as f64,
        entries: factor.factor_entries() as f64,
        lanes,
        by_bottleneck: forest == "bottleneck",
        cholesky,
    })
}
