//! What is allocated: by a block of samples nothing after the first, by the files of a run at most so much a vessel; counted by an allocator that counts.

use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::output::atomic::StagedFolder;
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::internals::sampling::{Sampling, SamplingOptions, Solver, Sums, Uncertain, Weight};
use willis::{InferOptions, ReadOptions, SaveOptions, infer, read_bytes};

/// Bytes that the files of a run take at most while they are written, beside the graph.
fn peak_of_files(leaves: usize) -> u64 {
    let rows: Vec<String> = (1..=leaves).map(|leaf| format!("0,{leaf},10,{}\n", 0.5 + 1e-4 * (leaf % 100) as f64)).collect();
    let star = format!("node_a,node_b,length_mm,radius_mm\n{}", rows.concat());
    let input = read_bytes("star.csv".as_ref(), star.as_bytes(), &ReadOptions::default()).expect("a graph");
    let mut options = InferOptions::default();
    options.sampling.samples = 64;
    options.boundary.inlet = vec!["1=100mmHg".to_owned()];
    let run = infer(&input, &options).expect("a run");
    let here = tempfile::tempdir().expect("a folder");
    let save = || run.save(&here.path().join("out"), &SaveOptions::default()).expect("saved");
    allocation_counter::measure(|| drop(save())).bytes_max
}

/// Columns of a table, the kept half of the graph or the page, never all at once; the graph itself has 0.4 kB a vessel.
#[test]
fn files_of_a_run_take_little_memory_a_vessel() {
    let [few, many] = [10_000, 26_000].map(peak_of_files);
    let each = (many as f64 - few as f64) / 16_000.0;
    assert!((100.0..1200.0).contains(&each), "{each:.0} bytes a vessel");
}

/// That a folder is one of willis is asked of its record, of which the conditions of many vessels are not kept in memory.
#[test]
fn a_long_record_is_recognised_in_little_more_than_its_size() {
    let here = tempfile::tempdir().expect("a folder");
    let conditions = vec![r#"{"found":true,"id":"17","node":17,"pressure_mmHg":0.0,"role":"outlet"}"#; 20_000].join(",");
    let record = format!(r#"{{"boundary_conditions":[{conditions}],"willis":"0.1.0"}}"#);
    std::fs::write(here.path().join("run.json"), &record).expect("written");
    let check = || StagedFolder::check(here.path(), true).expect("a folder of willis");
    let most = allocation_counter::measure(check).bytes_max as usize;
    assert!((record.len()..2 * record.len()).contains(&most), "{most} bytes for {}", record.len());
}

#[test]
fn a_block_allocates_nothing_once_warm() {
    let network = cerebral(&circle_of_willis(1e-3));
    let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground).expect("conditions");
    for weight in [Weight::Resilience, Weight::Global] {
        let params = SamplingOptions { uncertain: Uncertain::All, solver: Solver::Lanes, weight, ..SamplingOptions::default() };
        let sampler = Sampling::new(&network, &boundary, &params).expect("a sampler");
        let (mut work, mut sums) = (sampler.workspace(), Sums::zero(network.vessel_count()));
        let mut blocks = |range: std::ops::Range<u64>| {
            for block in range {
                work.block(block, 64, &mut sums).expect("solved");
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
