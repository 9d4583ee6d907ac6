//! The checkpoint of an interrupted run, as arrays that `numpy.load` reads.

use std::io::{self, Seek, Write};

use crate::formats::{NamedArray, ensure, read_arrays, write_arrays};
use willis_core::error::Fault;
use willis_core::sampling::{PartialRun, Sums};

type FigureOfSums = fn(&Sums) -> f64;
type VectorOfSums = fn(&Sums) -> &[f64];

/// The figures of a node, in the order in which they are written.
const FIGURES: [(&str, FigureOfSums); 4] = [
    ("samples", |sums| sums.samples as f64),
    ("rho_G", |sums| sums.network_resilience),
    ("perfused", |sums| sums.perfused),
    ("residual", |sums| sums.residual),
];
/// Its vectors.
const VECTORS: [(&str, VectorOfSums); 3] =
    [("likelihood", |sums| &sums.likelihood), ("square", |sums| &sums.square), ("count", |sums| &sums.count)];
const WRITTEN_BY: &str = "expected the file as willis wrote it";
/// No run has more samples.
const MOST_SAMPLES: f64 = (1_u64 << 50) as f64;

/// Writes a part of a run, all float64, with m nodes of the dyadic tree of blocks, V vessels, T of them uncertain:
///
/// - `run` (2): samples of the whole run, blocks between two points of the convergence record
/// - `blocks` (m, 2): first block and number of blocks of each node; `samples` (m), `rho_G` (m): Σ ρ_G in it, W/m³; `perfused` (m): how many of its
///   samples blood flows in; `residual` (m)
/// - `likelihood`, `square`, `count` (m, V): Σ of each vessel's contributions, of their squares, of its times in the forest
/// - `step` (k), `trace` (k, T): which points of the convergence record are finished, and L over the blocks of each
///
/// # Errors
///
/// The writer's own.
pub fn write_part(out: impl Write + Seek, part: &PartialRun) -> io::Result<()> {
    let (m, k) = (part.sums().nodes().len(), part.steps().len());
    let vessels = part.uncertain().len();
    let uncertain_count = part.uncertain().iter().filter(|u| **u).count();
    let array =
        |name: &str, shape: &[usize], values: Vec<f64>| NamedArray { name: name.to_owned(), shape: shape.to_vec(), values };
    let small = [
        array("run", &[2], vec![part.samples() as f64, part.step() as f64]),
        array("blocks", &[m, 2], part.sums().nodes().flat_map(|(first, blocks, _)| [first as f64, blocks as f64]).collect()),
    ];
    let figures = FIGURES.map(|(name, of)| array(name, &[m], part.sums().nodes().map(|(_, _, sums)| of(sums)).collect()));
    let large = VECTORS.iter().map(|(name, of)| {
        array(name, &[m, vessels], part.sums().nodes().flat_map(|(_, _, sums)| of(sums).iter().copied()).collect())
    });
    let steps = array("step", &[k], part.steps().map(|(at, _)| at as f64).collect());
    let trace = std::iter::once_with(|| {
        array("trace", &[k, uncertain_count], part.steps().flat_map(|(_, likelihood)| likelihood.iter().copied()).collect())
    });
    write_arrays(out, small.into_iter().chain(figures).chain(large).chain([steps]).chain(trace))
}

/// Reads what [`write_part`] wrote of a run with these vessels uncertain.
///
/// # Errors
///
/// A file that is cut or damaged, or is of another network.
pub fn read_part(bytes: &[u8], uncertain: Vec<bool>) -> Result<PartialRun, Fault> {
    let mut arrays = read_arrays(bytes)?;
    let mut take = |name: &str, columns: usize| -> Result<Vec<f64>, Fault> {
        let item = || format!("array {name}");
        let at = arrays.iter().position(|array| array.name == name);
        let array = arrays.swap_remove(at.ok_or_else(|| Fault::item(item(), "is missing", WRITTEN_BY))?);
        let found = array.shape.iter().skip(1).product::<usize>();
        ensure(found == columns, || Fault::item(item(), format!("{found} columns"), format!("expected {columns}")))?;
        Ok(array.values)
    };
    let vessels = uncertain.len();
    let uncertain_count = uncertain.iter().filter(|u| **u).count();
    let wrong = |item: &str| Fault::item(format!("array {item}"), "not the values of a part of a run", WRITTEN_BY);
    let whole = |x: f64| ((0.0..=MOST_SAMPLES).contains(&x) && x.fract() == 0.0).then_some(x as u64);
    let run = take("run", 1)?;
    let [samples, step] = run[..] else { return Err(wrong("run")) };
    let mut part = PartialRun::new(uncertain, whole(samples).filter(|n| *n > 0).ok_or_else(|| wrong("run"))?);
    ensure(whole(step) == Some(part.step()), || wrong("run"))?;
    let blocks = take("blocks", 2)?;
    let [samples, rho, perfused, residual] = FIGURES.map(|(name, _)| take(name, 1));
    let figures = [samples?, rho?, perfused?, residual?];
    let vectors = [take(VECTORS[0].0, vessels)?, take(VECTORS[1].0, vessels)?, take(VECTORS[2].0, vessels)?];
    let m = figures[0].len();
    let are_whole = figures.iter().all(|f| f.len() == m) && vectors.iter().all(|v| v.len() == m * vessels);
    ensure(blocks.len() == 2 * m && are_whole, || wrong("blocks"))?;
    for at in 0..m {
        let ends = whole(blocks[2 * at]).zip(whole(blocks[2 * at + 1]));
        let (first, blocks) = ends.filter(|(first, blocks)| part.takes(*first, *blocks)).ok_or_else(|| wrong("blocks"))?;
        let [samples, network_resilience, perfused, residual] = figures.each_ref().map(|figure| figure[at]);
        let samples = whole(samples).filter(|n| *n == part.samples_in(&(first..first + blocks)));
        let [likelihood, square, count] = vectors.each_ref().map(|v| v[at * vessels..(at + 1) * vessels].to_vec());
        let samples = samples.ok_or_else(|| wrong("samples"))?;
        let sums = Sums { likelihood, square, count, network_resilience, perfused, residual, samples };
        let impossible = || Fault::item(format!("sums of blocks {first}.."), "no samples can have them", WRITTEN_BY);
        ensure(sums.are_possible(), impossible)?;
        part.insert(first, blocks, sums, &mut Vec::new());
    }
    let (steps, trace) = (take("step", 1)?, take("trace", uncertain_count)?);
    ensure(trace.len() == steps.len() * uncertain_count, || wrong("trace"))?;
    for (at, step) in steps.iter().enumerate() {
        let number = whole(*step).filter(|n| part.holds_step(*n)).ok_or_else(|| wrong("step"))?;
        part.insert_step(number, trace[at * uncertain_count..(at + 1) * uncertain_count].to_vec());
    }
    ensure(part.is_traced() && part.is_trace_of_its_sums(), || wrong("trace"))?;
    Ok(part)
}
