//! What a program does with the library: inputs from bytes, a run decided again, kept as bytes, a network written.

use std::fs;
use std::path::Path;

use willis::error::Error;
use willis::{
    BoundaryOptions, FoundOutlets, InferOptions, Inference, Input, Keep, ReadOptions, SamplingOptions, SaveOptions, infer, read,
    read_bytes, write,
};

const BROKEN: &str = "data/broken-circle-of-willis.swc";

fn broken() -> Input {
    read(BROKEN.as_ref(), &ReadOptions::default()).unwrap()
}

fn options(samples: u64) -> InferOptions {
    let mut options = InferOptions::default();
    options.sampling.samples = samples;
    options
}

/// The files of a folder but run.json, which has the time.
fn saved(run: &Inference) -> Vec<(String, Vec<u8>)> {
    let here = tempfile::tempdir().unwrap();
    let folder = here.path().join("out");
    run.save(&folder, &SaveOptions::default()).unwrap();
    let mut files: Vec<(String, Vec<u8>)> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| !path.ends_with("run.json") && !path.ends_with("report.html"))
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn the_bytes_of_a_file_are_the_file() {
    let bytes = fs::read(BROKEN).unwrap();
    let from_bytes = read_bytes("mine.swc".as_ref(), &bytes, &ReadOptions::default()).unwrap();
    let from_file = broken();
    assert_eq!(from_bytes.provenance.sha256, from_file.provenance.sha256);
    assert_eq!(serde_json::to_string(&from_bytes.network).unwrap(), serde_json::to_string(&from_file.network).unwrap());
    assert_eq!(from_bytes.provenance.input, "mine.swc");
    let refused = read_bytes("mine.swc".as_ref(), b"1 2 3\n", &ReadOptions::default()).unwrap_err();
    assert!(matches!(&refused, Error::Input { path, .. } if path == Path::new("mine.swc")), "{refused}");
}

#[test]
fn a_run_decided_again_is_a_run_with_that_rule() {
    let (input, plain) = (broken(), options(256));
    let run = infer(&input, &plain).unwrap();
    let with = InferOptions { keep: Some(Keep::Median), ..plain };
    let [again, fresh] = [run.decided_by(Keep::Median).unwrap(), infer(&input, &with).unwrap()];
    assert_ne!(run.kept(), again.kept());
    assert_eq!(saved(&again), saved(&fresh));
    assert!(run.decided_by(Keep::Probability(2.0)).is_err());
}

/// What README says: by default geometry and mask decide. Nothing of the flow moves a probability or what is kept, though it moves L.
#[test]
fn flow_decides_neither_the_probability_nor_what_is_kept() {
    for file in [BROKEN, "data/scan.nii.gz"] {
        let input = read(file.as_ref(), &ReadOptions::default()).unwrap();
        let answer = |options: &InferOptions| {
            let run = infer(&input, options).unwrap();
            let [_, vessels] = run.tables().unwrap();
            let column = |name: &str| format!("{:?}", vessels.iter().find(|column| column.name == name).unwrap().values);
            ([column("probability"), column("kept")], column("likelihood"))
        };
        let plain = options(64);
        let sampled = |with: SamplingOptions| InferOptions { sampling: with, ..plain.clone() };
        let ground = BoundaryOptions { found_outlets: Some(FoundOutlets::Ground), ..BoundaryOptions::default() };
        let usual = answer(&plain);
        for other in [
            sampled(SamplingOptions { epsilon: 0.9, ..plain.sampling.clone() }),
            sampled(SamplingOptions { viscosity: 0.03, ..plain.sampling.clone() }),
            sampled(SamplingOptions { seed: 7, ..plain.sampling.clone() }),
            InferOptions { boundary: ground, ..plain.clone() },
        ] {
            let found = answer(&other);
            assert_eq!(usual.0, found.0, "{file}");
            assert_ne!(usual.1, found.1, "{file}");
        }
    }
}

#[test]
fn a_run_comes_back_from_its_bytes() {
    let run = infer(&broken(), &options(256)).unwrap();
    let bytes = run.to_bytes().unwrap();
    assert_eq!(saved(&Inference::from_bytes(&bytes).unwrap()), saved(&run));
    assert!(Inference::from_bytes(&bytes[..bytes.len() / 2]).is_err());
    // A likelihood of one vessel less is of another run.
    let mut other: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    other["likelihood"]["likelihood"].as_array_mut().unwrap().pop();
    assert!(Inference::from_bytes(other.to_string().as_bytes()).is_err());
}

#[test]
fn a_topology_is_written_and_read_again() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("kept.vtp");
    let topology = infer(&broken(), &options(64)).unwrap().topology();
    let written = write(&topology, &path, None, false).unwrap();
    assert_eq!(written.files, std::slice::from_ref(&path));
    let again = read(&path, &ReadOptions::default()).unwrap().network;
    let length = |network: &willis::Network| network.vessels().map(|(_, vessel)| vessel.length).sum::<f64>();
    assert!((length(&again) / length(&topology) - 1.0).abs() < 1e-6);
    assert!(matches!(write(&topology, &path, None, false), Err(Error::Exists { .. })));
    assert!(write(&topology, &here.path().join("kept.xyz"), None, false).is_err());
    // All of it was kept, which a format that holds a graph tells.
    let path = here.path().join("kept.graphml");
    write(&topology, &path, None, false).unwrap();
    let again = read(&path, &ReadOptions::default()).unwrap().network;
    assert_eq!(again.vessel_count(), topology.vessel_count());
    assert!(again.vessels().all(|(_, vessel)| vessel.kept == Some(true)));
}
