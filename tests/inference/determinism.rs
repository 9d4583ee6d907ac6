//! The same bits whatever the number of threads and of samples asked for.

use crate::draw::Draw;
use crate::networks::{radii, random_conditions, random_network, run};
use willis::internals::network::{Condition, Network};
use willis::internals::sampling::{DyadicSums, Likelihood, SamplingOptions, Solver, Sums, Uncertain, Weight};
use willis::internals::support::random::BLOCK;

fn graph() -> (Network, Vec<(usize, Condition)>) {
    let mut draw = Draw::new(7);
    (random_network(&mut draw, 20, 34, radii(0.3, 2.0)), random_conditions(&mut draw, 20))
}

fn on(threads: usize, params: &SamplingOptions) -> Likelihood {
    let (network, conditions) = graph();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| run(&network, &conditions, params))
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// Everything but the trace, as bits.
fn result_bits(l: &Likelihood) -> [Vec<u64>; 4] {
    [bits(&l.likelihood), bits(&l.std_error), bits(&l.frequency), bits(&[l.network_resilience])]
}

fn trace_bits(l: &Likelihood) -> Vec<(u64, Vec<u64>)> {
    l.trace.iter().map(|s| (s.samples, bits(&s.likelihood))).collect()
}

/// 1, 64 and 1000 samples are blocks cut short, one block, 16 blocks; 20,050 make tasks of two blocks, the
/// last one cut short in its second.
#[test]
fn one_two_and_eight_threads_give_the_same_bits() {
    for (samples, solver) in [
        (1, Solver::Lanes),
        (64, Solver::Reference),
        (1000, Solver::Reference),
        (1000, Solver::Gradients),
        (20_050, Solver::Lanes),
    ] {
        for weight in [Weight::Resilience, Weight::Global] {
            let params =
                SamplingOptions { samples, solver, weight, seed: 3, uncertain: Uncertain::All, ..SamplingOptions::default() };
            let one = on(1, &params);
            assert_eq!(one.samples, samples);
            for threads in [2, 8] {
                let many = on(threads, &params);
                assert_eq!(result_bits(&one), result_bits(&many), "{threads} threads, {params:?}");
                assert_eq!(trace_bits(&one), trace_bits(&many), "{threads} threads, {params:?}");
            }
        }
    }
}

/// The trace of the longer run passes through every answer of the shorter ones.
#[test]
fn the_first_samples_do_not_depend_on_how_many_are_asked_for() {
    let params = |samples| SamplingOptions { samples, seed: 5, uncertain: Uncertain::All, ..SamplingOptions::default() };
    let long = on(2, &params(6400));
    assert_eq!(long.trace.last().map(|s| s.samples), Some(6400));
    for samples in [64, 640, 3200] {
        let short = on(2, &params(samples));
        let at = long.trace.iter().find(|s| s.samples == samples).unwrap();
        assert_eq!(bits(&at.likelihood), bits(&short.likelihood));
        assert_eq!(trace_bits(&short), trace_bits(&long)[..short.trace.len()]);
    }
    // Tasks of two blocks: the record is coarser, the sums are the same.
    let longer = on(2, &params(20_480));
    let at = longer.trace.iter().find(|s| s.samples == 6400).unwrap();
    assert_eq!(bits(&at.likelihood), bits(&long.likelihood));
}

/// A run of n samples is the sum of single ones: n = 1..=70 crosses a group of lanes and a block. Counts are exact.
#[test]
fn a_block_cut_short_holds_its_first_samples() {
    let params =
        |samples| SamplingOptions { samples, weight: Weight::Count, uncertain: Uncertain::All, ..SamplingOptions::default() };
    let counts = |samples: u64| on(1, &params(samples)).likelihood;
    let mut last = counts(1);
    for samples in 2..=70 {
        let next = counts(samples);
        assert!(next.iter().zip(&last).all(|(b, a)| *b == *a || *b == a + 1.0), "{samples}");
        last = next;
    }
}

#[test]
fn another_seed_gives_other_samples() {
    let of = |seed| on(1, &SamplingOptions { seed, uncertain: Uncertain::All, ..SamplingOptions::default() });
    assert_ne!(result_bits(&of(0)), result_bits(&of(1)));
}

fn block(draw: &mut Draw) -> Sums {
    let mut sums = Sums::zero(3);
    for row in 0..3 {
        sums.likelihood[row] = draw.within(0.0, 1.0) * 10_f64.powf(draw.within(-8.0, 8.0));
        sums.square[row] = sums.likelihood[row].powi(2);
        sums.count[row] = (draw.bits() % 65) as f64;
    }
    sums.network_resilience = draw.within(0.0, 1e6);
    sums.samples = BLOCK;
    sums
}

fn sums_bits(s: &Sums) -> (Vec<u64>, Vec<u64>, Vec<u64>, u64, u64) {
    (bits(&s.likelihood), bits(&s.square), bits(&s.count), s.network_resilience.to_bits(), s.samples)
}

/// The dyadic tree by its definition: the largest aligned power of two to the left, the rest to the right.
fn tree(blocks: &[Sums]) -> Sums {
    if blocks.len() == 1 {
        return blocks[0].clone();
    }
    let left = blocks.len().next_power_of_two() / 2;
    tree(&blocks[..left]).plus(&tree(&blocks[left..]))
}

/// The maximal dyadic nodes of blocks from..to: first block, size and sum.
fn nodes_of(blocks: &[Sums], from: usize, to: usize) -> Vec<(u64, u64, Sums)> {
    let (mut nodes, mut at) = (Vec::new(), from);
    while at < to {
        let mut size = 1;
        while at.is_multiple_of(2 * size) && at + 2 * size <= to {
            size *= 2;
        }
        nodes.push((at as u64, size as u64, tree(&blocks[at..at + size])));
        at += size;
    }
    nodes
}

fn summed(nodes: impl IntoIterator<Item = (u64, u64, Sums)>) -> DyadicSums {
    let mut sum = DyadicSums::default();
    for (first, blocks, sums) in nodes {
        sum.insert(first, blocks, sums, &mut Vec::new(), |_, _, _| {});
    }
    sum
}

/// Exactly the recursion's bits from one block at a time in any order, and from any split into up to four parts in any order;
/// the plain running sum has others, so the order of additions does matter.
#[test]
fn dyadic_sums_are_the_same_from_any_split_and_order() {
    let mut draw = Draw::new(11);
    let mut plain_differs = false;
    for n in [1, 2, 3, 5, 8, 13, 64, 100, 127, 128, 129, 1000] {
        let blocks: Vec<Sums> = (0..n).map(|_| block(&mut draw)).collect();
        let whole = sums_bits(&tree(&blocks));
        let mut order: Vec<usize> = (0..n).collect();
        for _ in 0..3 {
            let one_by_one = summed(order.iter().map(|at| (*at as u64, 1, blocks[*at].clone())));
            assert_eq!(sums_bits(&one_by_one.total().unwrap()), whole, "{n}");
            assert_eq!(one_by_one.into_nodes().len() as u32, (n as u32).count_ones());
            draw.shuffle(&mut order);
        }
        let plain = blocks[1..].iter().fold(blocks[0].clone(), Sums::plus);
        plain_differs |= sums_bits(&plain) != whole;
        for _ in 0..20 {
            let mut cuts = [0, draw.below(n + 1), draw.below(n + 1), draw.below(n + 1), n];
            cuts.sort_unstable();
            let mut nodes: Vec<_> = cuts.windows(2).flat_map(|range| nodes_of(&blocks, range[0], range[1])).collect();
            draw.shuffle(&mut nodes);
            assert_eq!(sums_bits(&summed(nodes).total().unwrap()), whole, "{n} blocks cut at {cuts:?}");
        }
    }
    assert!(plain_differs);
    assert!(DyadicSums::default().total().is_none());
}

/// By hand: of blocks 0..16, 2..4 and 8..16 are there, which leaves 0..2 and 4..8.
#[test]
fn gaps_are_found() {
    let sum = summed([(3, 1, Sums::zero(1)), (8, 8, Sums::zero(1)), (2, 1, Sums::zero(1))]);
    assert_eq!(sum.nodes().map(|(first, blocks, _)| (first, blocks)).collect::<Vec<_>>(), [(2, 2), (8, 8)]);
    assert_eq!(sum.gaps(0..16), [0..2, 4..8]);
    assert_eq!(sum.gaps(3..20), [4..8, 16..20]);
    assert_eq!(sum.gaps(9..12), []);
}
