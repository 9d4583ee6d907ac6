//! A block of samples allocates nothing after the first: counted by an allocator that counts.

use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::internals::sampling::{Sampler, SamplingOptions, Solver, Sums, Uncertain, Weight};

#[test]
fn a_block_allocates_nothing_once_warm() {
    let network = cerebral(&circle_of_willis(1e-3));
    let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground).expect("conditions");
    for weight in [Weight::Resilience, Weight::Global] {
        let params = SamplingOptions { uncertain: Uncertain::All, solver: Solver::Lanes, weight, ..SamplingOptions::default() };
        let sampler = Sampler::new(&network, &boundary, &params).expect("a sampler");
        let (mut work, mut sums) = (sampler.workspace(), Sums::zero(network.vessel_count()));
        let mut blocks = |range: std::ops::Range<u64>| {
            for block in range {
                sampler.block(block, 64, &mut work, &mut sums).expect("solved");
            }
        };
        let cold = allocation_counter::measure(|| blocks(0..1));
        let warm = allocation_counter::measure(|| blocks(1..200));
        assert!(cold.count_total < 10, "the memory comes with the workspace: {cold:?}");
        assert_eq!(warm.count_total, 0, "{warm:?}");
        // The counter counts.
        assert_eq!(allocation_counter::measure(|| drop(std::hint::black_box(vec![0_u8; 64]))).count_total, 1);
    }
}
