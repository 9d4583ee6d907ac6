//! What a stop leaves of a run makes the run, bit for bit, through its file; a file that was cut or altered is refused.

use crate::draw::Draw;
use crate::networks::{boundary, radii, random_conditions, random_network};
use willis::error::Error;
use willis::internals::decision::{Keep, all_decided};
use willis::internals::flow::Boundary;
use willis::internals::network::Network;
use willis::internals::output::{read_stored, write_stored};
use willis::internals::sampling::{Likelihood, PartialRun, Progress, Sampling, SamplingOptions, Sums, Uncertain, infer};

fn graph() -> (Network, Boundary) {
    let mut draw = Draw::new(7);
    let network = random_network(&mut draw, 12, 20, radii(0.3, 2.0));
    let conditions = random_conditions(&mut draw, 12);
    let boundary = boundary(&network, &conditions);
    (network, boundary)
}

fn params(samples: u64) -> SamplingOptions {
    SamplingOptions { samples, seed: 3, uncertain: Uncertain::All, ..SamplingOptions::default() }
}

/// Everything, as bits.
fn bits(l: &Likelihood) -> Vec<Vec<u64>> {
    let of = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    let mut all = vec![of(&l.likelihood), of(&l.std_error), of(&l.frequency), of(&[l.network_resilience]), vec![l.samples]];
    all.extend(l.trace.iter().flat_map(|s| [vec![s.samples], of(&s.likelihood)]));
    all
}

fn written(part: &PartialRun) -> Vec<u8> {
    let mut file = Vec::new();
    write_stored(&mut file, part).unwrap();
    file
}

fn through_a_file(part: &PartialRun) -> PartialRun {
    read_stored(&written(part)).unwrap()
}

/// Stops after so many reports, and keeps what was finished when it was last told.
struct StopAfter {
    reports: usize,
    kept: Option<PartialRun>,
}

impl Progress for StopAfter {
    fn report(&mut self, _: u64, _: u64) -> bool {
        self.reports = self.reports.saturating_sub(1);
        self.reports > 0
    }

    fn finished(&mut self, part: &PartialRun) {
        self.kept = Some(part.clone());
    }
}

/// A run that is stopped again and again: each time it goes on from what was kept, through a file, on other threads.
#[test]
fn a_run_that_is_stopped_goes_on_to_the_same_bits() {
    let (network, boundary) = graph();
    let whole = infer(&network, &boundary, &params(33_000), &mut |_: u64, _: u64| true).unwrap().0;
    let sampling = Sampling::new(&network, &boundary, &params(33_000)).unwrap();
    let mut part = sampling.part();
    let mut stops = 0;
    for threads in [1, 2, 8].into_iter().cycle() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut progress = StopAfter { reports: 20, kept: None };
        match pool.install(|| sampling.sample(&mut part, &mut progress)) {
            Ok(()) => break,
            Err(Error::Stopped { done, total }) => {
                assert_eq!((done, total), (part.done(), 33_000));
                stops += 1;
            }
            Err(error) => panic!("{error}"),
        }
        let kept = progress.kept.unwrap();
        assert!(kept.done() <= part.done());
        part = through_a_file(&kept);
    }
    assert!(stops > 3, "{stops} stops");
    assert_eq!(bits(&sampling.likelihood(&part)), bits(&whole));
}

/// A run until stable takes up its samples when it doubles them, with the bits of a run of as many; stopped and gone on with too.
#[test]
fn a_run_until_stable_is_the_run_of_as_many_samples() {
    let (network, boundary) = graph();
    let decided = |result: &Likelihood| all_decided(Keep::Quantile(0.45), &network, result);
    for samples in [1 << 10, 1 << 15] {
        let doubled = SamplingOptions { samples, ..params(1) };
        let mut part = Sampling::new(&network, &boundary, &doubled).unwrap().part();
        let mut sampling = Sampling::new(&network, &boundary, &params(1 << 10)).unwrap();
        let error = sampling.until_stable(&mut part, decided, &mut |done: u64, total: u64| done < total / 2);
        assert!(matches!(error, Err(Error::Stopped { .. })));
        let mut part = through_a_file(&part);
        let mut again = Sampling::new(&network, &boundary, &params(1 << 10)).unwrap();
        let result = again.until_stable(&mut part, decided, &mut |_: u64, _: u64| true).unwrap();
        let whole = infer(&network, &boundary, &params(result.samples), &mut |_: u64, _: u64| true).unwrap().0;
        assert!(result.samples >= samples);
        assert_eq!(bits(&result), bits(&whole));
    }
}

/// From one point every block to one every four: what was recorded in small steps is put together into large ones.
#[test]
fn doubling_keeps_the_convergence_record() {
    let (network, boundary) = graph();
    let mut sampling = Sampling::new(&network, &boundary, &params(1 << 13)).unwrap();
    let mut part = sampling.part();
    for samples in [1 << 13, 1 << 14, 1 << 15, 1 << 16] {
        sampling = Sampling::new(&network, &boundary, &params(samples)).unwrap();
        assert_eq!(part.samples(), samples);
        sampling.sample(&mut part, &mut |_: u64, _: u64| true).unwrap();
        let whole = infer(&network, &boundary, &params(samples), &mut |_: u64, _: u64| true).unwrap().0;
        assert_eq!(bits(&sampling.likelihood(&part)), bits(&whole), "{samples}");
        part.double();
    }
}

/// 2^24 numbers at the most for the record: 128 points up to 131,072 vessels uncertain, then fewer, and one at least.
#[test]
fn a_large_graph_has_a_shorter_convergence_record() {
    let step = |uncertain: usize, samples: u64| PartialRun::new(vec![true; uncertain], samples).step();
    assert_eq!([step(0, 64), step(20, 1000), step(1 << 17, 1 << 20)], [1, 1, 128]);
    assert_eq!([step(1 << 18, 1 << 20), step(1 << 20, 1 << 20), step(1 << 25, 1 << 20)], [256, 1024, 16_384]);
}

/// A file that is cut or altered is refused, whatever byte is wrong first.
#[test]
fn a_damaged_file_is_refused() {
    let (network, boundary) = graph();
    let sampling = Sampling::new(&network, &boundary, &params(448)).unwrap();
    let mut part = sampling.part();
    sampling.sample(&mut part, &mut |_: u64, _: u64| true).unwrap();
    let bytes = written(&part);
    let read = |bytes: &[u8]| read_stored::<PartialRun>(bytes);
    assert_eq!(read(&bytes).unwrap(), part);
    for end in (0..bytes.len()).step_by(97) {
        assert!(read(&bytes[..end]).is_err(), "{end}");
    }
    for at in (0..bytes.len()).step_by(7) {
        let mut other = bytes.clone();
        other[at] ^= 0x10;
        assert!(read(&other).is_err(), "{at}");
    }
}

/// Sums of squares may be beyond what a double can hold.
#[test]
fn infinite_sums_come_back() {
    let mut part = PartialRun::new(vec![true, false], 64);
    let sums = Sums { square: vec![f64::INFINITY, 1e-320], samples: 64, ..Sums::zero(2) };
    part.insert(0, 1, sums, &mut Vec::new());
    assert_eq!(through_a_file(&part), part);
}
