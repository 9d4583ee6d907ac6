//! Large graphs: milliseconds a sample, and the memory of one worker.

use std::time::Instant;

use willis::internals::sampling::{Sampling, SamplingOptions, Solver, Sums};
use willis::internals::support::random::BLOCK;

use crate::Result;
use crate::case::Case;

/// Samples a case whose candidates are open with probability 0.25 and whose observed vessels are certain, in one thread, for about
/// so many seconds, and prints a line of figures, separated by commas.
pub fn print(case: &Case, solver: Solver, seconds: f64) -> Result<()> {
    let params = SamplingOptions { epsilon: 0.75, solver, ..SamplingOptions::default() };
    let vessels = case.network.vessel_count();
    let uncertain = params.uncertain.vessels(&case.network).iter().filter(|u| **u).count();
    let start = Instant::now();
    let mut sampler = None;
    let shared = allocation_counter::measure(|| sampler = Some(Sampling::new(&case.network, &case.boundary, &params)));
    let sampler = sampler.transpose()?.ok_or("no sampler")?;
    let compile = start.elapsed().as_secs_f64();
    let mut worker = None;
    let mut failed = None;
    let own = allocation_counter::measure(|| {
        let (mut work, mut sums) = (sampler.workspace(), Sums::zero(vessels));
        failed = work.block(0, BLOCK, &mut sums).err();
        worker = Some((work, sums));
    });
    let Some((mut work, mut sums)) = worker.filter(|_| failed.is_none()) else { return Err("a block failed".into()) };
    let (mut least, begin, mut block) = (f64::INFINITY, Instant::now(), 1);
    while block < 3 || begin.elapsed().as_secs_f64() < seconds {
        let start = Instant::now();
        work.block(block, BLOCK, &mut sums)?;
        least = least.min(1e3 * start.elapsed().as_secs_f64() / BLOCK as f64);
        block += 1;
    }
    let method = sampler.method();
    let each = |bytes: u64| bytes as f64 / vessels as f64;
    println!(
        "{vessels},{uncertain},{},{},{compile:.3},{least:.4},{:.0},{:.0},{:.1e},{}",
        method.solver,
        method.forest,
        each(own.bytes_max),
        each(shared.bytes_max),
        sums.residual,
        peak_mb().map_or(String::new(), |mb| format!("{mb:.0}")),
    );
    Ok(())
}

/// The most memory that the program has had, graph and reader included, where the system tells.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kib = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?;
    Some(kib.parse::<f64>().ok()? * 1.024e-3)
}
