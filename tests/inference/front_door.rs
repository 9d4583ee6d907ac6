//! What a program does with the library: inputs from bytes, a run decided again, kept as bytes, a network written.

use std::fs;
use std::path::Path;

use willis::error::Error;
use willis::{
    BoundaryOptions, Condition, Evidence, FlowOptions, FoundOutlets, Frame, InferOptions, Inference, Input, Keep, MeasureOptions,
    ModulationOptions, Network, Node, Origin, PathPoint, PhenotypeOptions, ReadOptions, SamplingOptions, SaveOptions, Silent,
    Unfed, Vessel, Wall, Windkessel, candidates, classify, infer, label, measure, modulate, read, read_bytes, simulate, write,
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
    // One digit is another one.
    let mut other = bytes.clone();
    let digit = other.iter_mut().filter(|byte| byte.is_ascii_digit()).nth(1000).unwrap();
    *digit ^= 1;
    assert!(Inference::from_bytes(&other).is_err());
}

#[test]
fn a_topology_is_written_and_read_again() {
    let here = tempfile::tempdir().unwrap();
    let path = here.path().join("kept.vtp");
    let topology = infer(&broken(), &options(64)).unwrap().topology();
    let written = write(&topology, &path, None, false).unwrap();
    assert_eq!(written.files, std::slice::from_ref(&path));
    let again = read(&path, &ReadOptions::default()).unwrap().network;
    let length = |network: &Network| network.vessels().map(|(_, vessel)| vessel.length).sum::<f64>();
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

/// A vessel that branches, with an inlet, two outlets and a candidate to one of them, as a program makes it.
fn by_hand() -> Network {
    let place = |id: &str, x: f64, y: f64| Node { id: id.to_owned(), position: Some([x, y, 0.0]), ..Node::default() };
    let nodes = vec![
        place("a", 0.0, 0.0),
        place("b", 1e-2, 0.0),
        place("c", 2e-2, 5e-3),
        place("d", 2e-2, -5e-3),
        place("e", 3e-2, 5e-3),
    ];
    let observed = |length, radius| Vessel::new(length, radius, Origin::Observed);
    let candidate = Vessel { prior: 0.5, ..Vessel::new(1e-2, 1e-3, Origin::Candidate) };
    let vessels = [([0, 1], observed(1e-2, 2e-3)), ([1, 2], observed(1.1e-2, 1.5e-3)), ([1, 3], observed(1.1e-2, 1.2e-3))];
    let mut network = Network::of(Frame::default(), nodes, vessels.into_iter().chain([([2, 4], candidate)]).collect());
    network.node_mut(0).condition = Some(Condition::Pressure(13_332.0));
    for outlet in [3, 4] {
        network.node_mut(outlet).condition = Some(Condition::Pressure(0.0));
    }
    network
}

/// What the readers of files refuse, a program may put into a network. No tube has a negative length or a radius that is no number.
#[test]
fn what_no_file_can_hold_is_refused_in_a_network_by_hand() {
    type Spoil = fn(&mut Network);
    let spoils: [(&str, Spoil); 17] = [
        ("vessel 1 (b - c) length -0.01: expected a positive number", |n| n.vessel_mut(1).length = -1e-2),
        ("vessel 1 (b - c) length 0: expected a positive number", |n| n.vessel_mut(1).length = 0.0),
        ("vessel 3 (c - e) radius -0.001: expected a positive number", |n| n.vessel_mut(3).radius = -1e-3),
        ("vessel 3 (c - e) radius NaN: expected a positive number", |n| n.vessel_mut(3).radius = f64::NAN),
        ("vessel 1 (b - c) resistance -1: expected a positive number", |n| n.vessel_mut(1).resistance = Some(-1.0)),
        ("vessel 3 (c - e) prior 2: expected a number from 0 to 1", |n| n.vessel_mut(3).prior = 2.0),
        ("vessel 3 (c - e) prior NaN: expected a number from 0 to 1", |n| n.vessel_mut(3).prior = f64::NAN),
        ("vessel 3 (c - e) probability 2: expected a number from 0 to 1", |n| {
            n.vessel_mut(3).evidence = Some(Box::new(Evidence::undirected(2.0)));
        }),
        ("vessel 1 (b - c) wall -1: expected a positive number", |n| n.vessel_mut(1).wall = Some(Wall::Speed(-1.0))),
        ("vessel 1 (b - c) radius of a point 0: expected a positive number", |n| {
            n.vessel_mut(1).path =
                [[1e-2, 0.0, 0.0], [2e-2, 5e-3, 0.0]].map(|position| PathPoint { position, radius: 0.0, id: None }).to_vec();
        }),
        ("node 2 (c) coordinate inf: expected one within 1e9 m", |n| n.node_mut(2).position = Some([f64::INFINITY, 0.0, 0.0])),
        ("node 2 (c) coordinate 2000000000: expected one within 1e9 m", |n| n.node_mut(2).position = Some([2e9, 0.0, 0.0])),
        ("node 2 (c) radius 0: expected a positive number", |n| n.node_mut(2).radius = Some(0.0)),
        ("node 0 (a) condition NaN: expected a finite number", |n| n.node_mut(0).condition = Some(Condition::Pressure(f64::NAN))),
        ("node 3 (d) resistance -1: expected a positive number", |n| {
            n.node_mut(3).condition = Some(Condition::Resistance { resistance: -1.0, venous: 0.0 });
        }),
        ("node 3 (d) compliance 0: expected a positive number", |n| {
            n.node_mut(3).windkessel = Some(Box::new(Windkessel { proximal: None, compliance: Some(0.0) }));
        }),
        ("node 2 (b): an earlier node has this id; expected one of its own", |n| n.node_mut(2).id = "b".to_owned()),
    ];
    let answers = |network: Network| {
        let (input, written) = (Input::from_network(network), tempfile::tempdir().unwrap());
        let none = &PhenotypeOptions::default();
        [
            infer(&input, &options(64)).err(),
            candidates(&input, &options(64)).err(),
            simulate(&input, &[], &FlowOptions::default()).err(),
            modulate(&input, &BoundaryOptions::default(), &ModulationOptions { samples: 2, ..Default::default() }, None).err(),
            measure("a", &input, &MeasureOptions::default(), &mut Silent).err(),
            write(&input.network, &written.path().join("a.graphml"), None, false).err(),
            classify(&input, None, none, &mut Silent).err(),
            label(input, &InferOptions::default(), &mut Silent).err(),
        ]
    };
    // These five vessels are no circle of Willis; no file has them.
    let refused: Vec<String> = answers(by_hand()).into_iter().flatten().map(|error| error.to_string()).collect();
    assert!(refused.len() == 1 && refused[0].starts_with(char::is_alphabetic), "{refused:?}");
    for (expected, spoil) in spoils {
        let mut network = by_hand();
        spoil(&mut network);
        for error in answers(network) {
            let error = error.expect(expected);
            assert!(matches!(error, Error::Parameter { .. }) && error.to_string() == expected, "{error} for {expected}");
        }
    }
}

/// Whose vessels are modulated is said of those of the input, also where the unfed ones are left out; a force per area is positive.
#[test]
fn a_modulation_asks_for_one_word_a_vessel_and_a_threshold_above_zero() {
    let (input, boundary) = (Input::from_network(by_hand()), BoundaryOptions::default());
    for threshold in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let options = ModulationOptions { samples: 2, ..Default::default() };
        let error = modulate(&input, &boundary, &options, Some(threshold)).unwrap_err().to_string();
        assert_eq!(error, format!("threshold {threshold}: expected a positive number of Pa/m2"));
    }
    for unfed in [Unfed::Keep, Unfed::Drop] {
        for (count, is_right) in [(1, false), (4, true), (5, false)] {
            let options = ModulationOptions { samples: 2, vessels: Some(vec![true; count]), unfed, ..Default::default() };
            let error = modulate(&input, &boundary, &options, None).err().map(|error| error.to_string());
            let expected = format!("vessels {count}: expected one for each of 4 vessels");
            assert_eq!(error, (!is_right).then_some(expected));
        }
    }
}
