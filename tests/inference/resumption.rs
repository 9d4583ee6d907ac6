//! What a stop leaves of a run makes the run, bit for bit, through its file; a file that no run can have left is refused.

use std::io::Cursor;

use crate::draw::Draw;
use crate::networks::{boundary, radii, random_conditions, random_network};
use willis::error::Error;
use willis::internals::decision::{Keep, all_decided};
use willis::internals::flow::Boundary;
use willis::internals::formats::{read_arrays, write_arrays};
use willis::internals::network::Network;
use willis::internals::output::{read_part, write_part};
use willis::internals::sampling::{Likelihood, PartialRun, Progress, Sampling, SamplingOptions, Uncertain, infer};

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
    let mut file = Cursor::new(Vec::new());
    write_part(&mut file, part).unwrap();
    file.into_inner()
}

fn through_a_file(part: &PartialRun) -> PartialRun {
    read_part(&written(part), part.uncertain().to_vec()).unwrap()
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

/// A file that is cut, or of another network, is refused, whatever byte is wrong first.
#[test]
fn a_damaged_file_is_refused() {
    let (network, boundary) = graph();
    let sampling = Sampling::new(&network, &boundary, &params(448)).unwrap();
    let mut part = sampling.part();
    sampling.sample(&mut part, &mut |_: u64, _: u64| true).unwrap();
    let bytes = written(&part);
    assert_eq!(read_part(&bytes, part.uncertain().to_vec()).unwrap(), part);
    assert!(read_part(&bytes, vec![true; 19]).is_err());
    for end in (0..bytes.len()).step_by(97) {
        assert!(read_part(&bytes[..end], part.uncertain().to_vec()).is_err(), "{end}");
    }
    // Every value has its checksum in the archive: what is read is what was written, or nothing.
    for at in (0..bytes.len()).step_by(7) {
        let mut other = bytes.clone();
        other[at] ^= 0x10;
        if let Ok(read) = read_part(&other, part.uncertain().to_vec()) {
            assert_eq!(read, part, "{at}");
        }
    }
}

/// An array of the file, and what becomes of a figure in it.
type Case = (&'static str, fn(f64) -> f64);

/// Sums that no samples can have: the truth is what sums of figures of zero or more are.
#[test]
fn sums_that_no_samples_have_are_refused() {
    let (network, boundary) = graph();
    let sampling = Sampling::new(&network, &boundary, &params(192)).unwrap();
    let mut part = sampling.part();
    sampling.sample(&mut part, &mut |_: u64, _: u64| true).unwrap();
    let whole = written(&part);
    let place = |values: &[f64]| values.iter().position(|x| *x > 0.0).unwrap();
    let cases: [Case; 24] = [
        ("count", |_| 1e9),
        ("count", |_| -1.0),
        ("count", |x| x - 0.5),
        ("count", |_| f64::NAN),
        ("count", |_| 0.0),
        ("likelihood", |x| -x),
        ("likelihood", |x| 1e3 * x),
        ("likelihood", |x| x / 1e3),
        ("likelihood", |_| f64::INFINITY),
        ("likelihood", |_| f64::NAN),
        ("square", |x| -x),
        ("square", |x| 1e6 * x),
        ("square", |x| x / 1e6),
        ("square", |_| f64::NAN),
        ("rho_G", |x| -x),
        ("rho_G", |_| f64::INFINITY),
        ("residual", |_| -1.0),
        ("residual", |_| f64::NAN),
        ("samples", |x| x + 1.0),
        ("samples", |_| -1.0),
        ("blocks", |_| 3.0),
        ("trace", |x| -x),
        ("trace", |x| 2.0 * x),
        ("run", |x| x - 1.0),
    ];
    for (name, change) in cases {
        let mut arrays = read_arrays(&whole).unwrap();
        let array = arrays.iter_mut().find(|array| array.name == name).unwrap();
        let at = if name == "residual" { 0 } else { place(&array.values) };
        array.values[at] = change(array.values[at]);
        let mut bytes = Cursor::new(Vec::new());
        write_arrays(&mut bytes, arrays).unwrap();
        assert!(read_part(bytes.get_ref(), part.uncertain().to_vec()).is_err(), "{name}");
    }
}
