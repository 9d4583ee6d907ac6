//! Times that are worth quoting on a busy machine: minima over many short batches.

use std::time::Instant;

/// A batch of calls takes about so long, s.
const BATCH: f64 = 4e-3;
/// The longer run of a marginal cost takes longer than the shorter one by at least so much, s.
const MARGIN: f64 = 0.12;
/// Repeats of a marginal cost.
const REPEATS: usize = 6;

fn seconds(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

fn least(times: impl Iterator<Item = f64>) -> f64 {
    times.fold(f64::INFINITY, f64::min)
}

/// Microseconds a call, the least over batches for `budget` seconds and at least three of them.
pub fn per_call(budget: f64, mut call: impl FnMut()) -> f64 {
    let first = seconds(&mut call);
    let warm = if first < BATCH { seconds(&mut call) } else { first };
    let calls = (BATCH / warm.max(1e-9)).ceil();
    let mut batch = || seconds(|| (0..calls as u64).for_each(|_| call())) / calls;
    let batches = (budget / (calls * warm)).clamp(3.0, 1e3) as usize;
    1e6 * least((0..batches).map(|_| batch()))
}

/// Microseconds a sample at the margin: the difference of a long and a short run, so that start-up does not count.
pub fn marginal(mut run: impl FnMut(u64)) -> f64 {
    let few = 1 << 10;
    let short = seconds(|| run(few));
    let mut many = 2 * few;
    while seconds(|| run(many)) < short + MARGIN {
        many *= 2;
    }
    let times: Vec<[f64; 2]> = (0..REPEATS).map(|_| [few, many].map(|n| seconds(|| run(n)))).collect();
    let [short, long] = [0, 1].map(|i| least(times.iter().map(|t| t[i])));
    1e6 * (long - short) / (many - few) as f64
}
