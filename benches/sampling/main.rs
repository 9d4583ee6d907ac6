//! Times the sampling loop: whole, by stage, against other forests, and on large graphs. `run.sh` asks and tabulates.

mod case;
mod clock;
mod forests;
mod large;
mod pulse;
mod pulse_solvers;
mod stages;

use std::error::Error;

use willis::internals::sampling::{Likelihood, Sampling, SamplingOptions, Solver, Sums, infer};

use case::{Case, params};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const USAGE: &str = "usage: sampling COMMAND
  time GRAPH THREADS SOLVER            microseconds a sample at the margin
  seconds GRAPH THREADS SAMPLES        the time of one run of so many samples
  whole ARRAYS.npz SAMPLES             the least time in s of reading the bytes of a file and inferring, by the front door, of twenty
  stages GRAPH                         microseconds a sample of each stage, one thread
  forests GRAPH                        microseconds a sample of the forest alone, by three algorithms
  count GRAPH SAMPLES                  that many samples in one thread, for an instruction counter
  large GRAPH SOLVER SECONDS           vessels, uncertain, solver, forest, s to compile, ms a sample, bytes a vessel of a worker and
                                       of what workers share, residual, peak MB; one thread
  pulse GRAPH HARMONICS                vessels, harmonics, milliseconds a cycle on one thread and on all
  pulse-solvers GRAPH HARMONICS        vessels, free nodes, harmonics; milliseconds for all harmonics by elimination and by faer's LU, one
                                       thread; their difference, and the residual of each";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["time", graph, threads, solver] => time(&Case::read(graph)?, threads.parse()?, solver_named(solver)?),
        ["seconds", graph, threads, samples] => seconds(&Case::read(graph)?, threads.parse()?, samples.parse()?),
        ["whole", arrays, samples] => whole(arrays, samples.parse()?),
        ["stages", graph] => stages::print(&Case::read(graph)?),
        ["forests", graph] => forests::print(&Case::read(graph)?),
        ["count", graph, samples] => count(&Case::read(graph)?, samples.parse()?),
        ["pulse", graph, harmonics] => pulse::print(&Case::read(graph)?, harmonics.parse()?),
        ["pulse-solvers", graph, harmonics] => pulse_solvers::print(&Case::read(graph)?, harmonics.parse()?),
        ["large", graph, solver, seconds] => large::print(&Case::read(graph)?, solver_named(solver)?, seconds.parse()?),
        _ => {
            println!("{USAGE}");
            Ok(())
        }
    }
}

fn solver_named(name: &str) -> Result<Solver> {
    match name {
        "auto" => Ok(Solver::Auto),
        "lanes" => Ok(Solver::Lanes),
        "gradients" => Ok(Solver::Gradients),
        "reference" => Ok(Solver::Reference),
        other => Err(format!("solver {other}: expected auto, lanes, gradients or reference").into()),
    }
}

fn pool(threads: usize) -> Result<rayon::ThreadPool> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
}

fn run(case: &Case, params: &SamplingOptions) -> Likelihood {
    let result = infer(&case.network, &case.boundary, params, &mut |_: u64, _: u64| true);
    result.expect("a benchmark graph can be sampled").0
}

fn time(case: &Case, threads: usize, solver: Solver) -> Result<()> {
    let pool = pool(threads)?;
    let micros = pool.install(|| {
        clock::marginal(|samples| {
            std::hint::black_box(run(case, &params(solver, samples)));
        })
    });
    println!("{micros:.4}");
    Ok(())
}

fn whole(arrays: &str, samples: u64) -> Result<()> {
    let (bytes, mut options) = (std::fs::read(arrays)?, willis::InferOptions::default());
    options.sampling.samples = samples;
    let mut least = f64::INFINITY;
    for _ in 0..20 {
        let start = std::time::Instant::now();
        let input = willis::read_bytes(arrays.as_ref(), &bytes, &willis::ReadOptions::default())?;
        std::hint::black_box(willis::infer(&input, &options)?);
        least = least.min(start.elapsed().as_secs_f64());
    }
    println!("{least:.5}");
    Ok(())
}

fn seconds(case: &Case, threads: usize, samples: u64) -> Result<()> {
    let params = params(Solver::Auto, samples);
    let pool = pool(threads)?;
    let start = std::time::Instant::now();
    std::hint::black_box(pool.install(|| run(case, &params)));
    println!("{:.4}", start.elapsed().as_secs_f64());
    Ok(())
}

fn count(case: &Case, samples: u64) -> Result<()> {
    let sampler = Sampling::new(&case.network, &case.boundary, &params(Solver::Lanes, samples))?;
    let (mut work, mut sums) = (sampler.workspace(), Sums::zero(case.network.vessel_count()));
    for block in 0..samples / willis::internals::support::random::BLOCK {
        work.block(block, willis::internals::support::random::BLOCK, &mut sums)?;
        std::hint::black_box(&sums);
    }
    Ok(())
}
