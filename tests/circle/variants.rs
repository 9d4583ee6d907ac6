//! Variants of the Circle of Willis: what is left out and nothing else, as shipped in data, against the published configurations and
//! openBF's copy of the table.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use willis::internals::formats::{ReadOptions, read_graphml};
use willis::internals::network::units::metres;
use willis::internals::network::{Condition, Network, Role, cycles, fragments};
use willis::internals::phantom::{Anatomy, Recipe, without};

/// The ten published variants by what they lack.
const VARIANTS: [&[&str]; 10] = [
    &["AComm"],
    &["L-A1"],
    &["R-A1"],
    &["L-P1"],
    &["R-P1"],
    &["L-PComm"],
    &["R-PComm"],
    &["L-PComm", "R-PComm"],
    &["L-PComm", "R-P1"],
    &["R-PComm", "L-P1"],
];

fn complete() -> Network {
    Anatomy::Cerebral.network(&Recipe { spacing: Some(metres(5.0)), ..Recipe::default() }).unwrap()
}

fn name(missing: &[&str]) -> String {
    if missing.is_empty() { "complete.graphml".into() } else { format!("without-{}.graphml", missing.join("-")) }
}

fn shipped(missing: &[&str]) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/circle-of-willis").join(name(missing))
}

fn read(missing: &[&str]) -> Network {
    read_graphml(&std::fs::read(shipped(missing)).unwrap()[..], &ReadOptions::default()).unwrap().0
}

fn labels(network: &Network) -> Vec<&str> {
    network.vessels().map(|(_, vessel)| vessel.label.as_str()).collect()
}

/// A file of the shared data, or `None` after saying that it is not there.
fn shared(file: &str) -> Option<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(file);
    let text = std::fs::read_to_string(&path).ok();
    if text.is_none() {
        println!("skipped: {} is not there", path.display());
    }
    text
}

/// Whether two figures agree but for the rounding of a text in mm and mmHg.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-14 * b.abs()
}

#[test]
fn a_variant_lacks_the_missing_vessels_and_nothing_else() {
    let complete = complete();
    for missing in VARIANTS {
        let variant = without(&complete, missing).unwrap();
        let left: Vec<&str> = labels(&complete).into_iter().filter(|label| !missing.contains(label)).collect();
        assert_eq!(labels(&variant), left);
        assert_eq!((left.len(), variant.node_count()), (20 - missing.len(), 20), "{missing:?}");
        for (row, node) in complete.nodes().enumerate() {
            assert_eq!(variant.node(row), node);
        }
        let of = |label: &str| complete.vessels().find(|(_, vessel)| vessel.label == label).unwrap();
        assert!(variant.vessels().all(|(ends, vessel)| of(&vessel.label) == (ends, vessel)));
        // The one ring is open, and what two missing vessels part has an inlet on either side.
        assert_eq!((cycles(&variant), fragments(&variant, |_, _| true).count), (0, missing.len()), "{missing:?}");
    }
}

#[test]
fn ends_that_are_left_behind_are_neither_inlet_nor_outlet() {
    let variant = without(&complete(), &["BA"]).unwrap();
    let stub = variant.nodes().find(|node| node.id == "15").unwrap();
    assert_eq!((stub.role, stub.condition), (Some(Role::Inner), None));
    assert_eq!(fragments(&variant, |_, _| true).count, 2);
    let shorter = without(&complete(), &["L-P2"]).unwrap();
    assert_eq!((shorter.node_count(), shorter.nodes().filter(|node| node.role == Some(Role::Outlet)).count()), (19, 5));
}

#[test]
fn unknown_vessels_and_the_last_way_in_are_refused() {
    let unknown = without(&complete(), &["L-A1", "Acomm"]).unwrap_err().to_string();
    let said = "without \"Acomm\": did you mean \"AComm\"? expected labels among L-ICA I, ";
    assert!(unknown.starts_with(said), "{unknown}");
    let shut = without(&complete(), &["L-ICA I", "R-ICA I", "L-VA", "R-VA"]).unwrap_err().to_string();
    assert!(shut.contains("leaves no inlet"), "{shut}");
}

/// The files hold what the library makes, conditions included, and no other file lies there.
#[test]
fn shipped_files_hold_the_complete_circle_and_its_variants() {
    let here = tempfile::tempdir().unwrap();
    let mut expected = BTreeSet::new();
    for missing in [&[][..]].into_iter().chain(VARIANTS) {
        let (file, made) = (read(missing), without(&complete(), missing).unwrap());
        assert_eq!(labels(&file), labels(&made));
        for ((ends, vessel), (made_ends, made)) in file.vessels().zip(made.vessels()) {
            assert_eq!(ends, made_ends);
            assert!(close(vessel.length, made.length) && close(vessel.radius, made.radius), "{}", vessel.label);
        }
        for (node, made) in file.nodes().zip(made.nodes()) {
            assert_eq!((&node.id, node.role.unwrap_or(Role::Inner)), (&made.id, made.role.unwrap()));
            match (node.condition, made.condition) {
                (None, None) => {}
                (Some(Condition::Pressure(p)), Some(Condition::Pressure(made))) => assert!(close(p, made)),
                (
                    Some(Condition::Resistance { resistance, venous }),
                    Some(Condition::Resistance { resistance: made, venous: 0.0 }),
                ) => assert!(close(resistance, made) && venous == 0.0),
                other => panic!("{}: {other:?}", node.id),
            }
        }
        let mut arguments = vec!["phantom", "cerebral", "--spacing", "5mm", "-o", "made.graphml", "--force"];
        let list = missing.join(",");
        if !missing.is_empty() {
            arguments.extend(["--without", &list]);
        }
        let output = Command::new(env!("CARGO_BIN_EXE_willis")).current_dir(here.path()).args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        assert_eq!(said.contains("falls into 2 parts"), missing.len() == 2, "{said}");
        assert!(std::fs::read(here.path().join("made.graphml")).unwrap() == std::fs::read(shipped(missing)).unwrap(), "{list}");
        expected.insert(name(missing));
    }
    let folder = std::fs::read_dir(shipped(&[]).parent().unwrap()).unwrap();
    let found: BTreeSet<String> = folder.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    assert_eq!(found, expected);
}

#[test]
fn an_unknown_vessel_ends_the_command_with_status_2() {
    let here = tempfile::tempdir().unwrap();
    let arguments = ["phantom", "cerebral", "--without", "AComm,L-ACA", "-o", "a.graphml"];
    let output = Command::new(env!("CARGO_BIN_EXE_willis")).current_dir(here.path()).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("without \"L-ACA\": expected labels among ") && !here.path().join("a.graphml").exists(), "{said}");
}

/// Padmos et al. 2022 (doi:10.1098/rsif.2022.0649) distribute one configuration a variant, a missing vessel with length zero.
#[test]
fn the_choice_of_variants_is_that_of_padmos() {
    let Some(text) = shared("padmos-cow-phenotypes/derived_edges.csv") else { return };
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let mut absent: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for line in text.lines().skip(1) {
        // Names hold commas, quoted: id first, the figures from the right.
        let cells: Vec<&str> = line.rsplitn(header.len() - 1, ',').collect();
        let vessel = cells[cells.len() - 1].split_once(',').unwrap().1.trim_matches('"');
        for (column, cell) in header.iter().rev().zip(&cells) {
            if column.starts_with("present_CoW_") && *column != "present_CoW_Complete" {
                let absent = absent.entry(column).or_default();
                if *cell == "0" {
                    absent.insert(vessel.to_owned());
                }
            }
        }
    }
    let ours = |label: &str| {
        let stem = label.split_once('-').map_or(label, |(_, stem)| stem);
        let theirs = BTreeMap::from([("AComm", "ACoA"), ("PComm", "PCoA"), ("A1", "ACA, A1"), ("P1", "PCA, P1")]);
        if stem == label { theirs[stem].to_owned() } else { format!("{}. {}", &label[..1], theirs[stem]) }
    };
    let ours = VARIANTS.map(|missing| missing.iter().map(|label| ours(label)).collect::<BTreeSet<_>>());
    assert_eq!(absent.into_values().collect::<BTreeSet<_>>(), BTreeSet::from(ours));
}

/// openBF's copy of Alastruey et al. 2007, vessel by vessel between the table's numbers of the nodes.
#[test]
fn lengths_and_radii_are_those_of_openbf() {
    let Some(text) = shared("openbf-models/circle_of_willis.yaml") else { return };
    let mut table = BTreeMap::new();
    for block in text.split("- label:").skip(1) {
        let value = |key: &str| {
            let line = block.lines().find_map(|line| line.trim().strip_prefix(key)?.strip_prefix(':'));
            line.map(|word| word.trim().to_owned())
        };
        let figure = |key: &str| value(key).unwrap().parse::<f64>().unwrap();
        let row = [figure("L"), figure("Rp"), figure("Rd")];
        table.insert([value("sn").unwrap(), value("tn").unwrap()], (row, value("R1").map(|r| r.parse::<f64>().unwrap())));
    }
    for missing in [&[][..]].into_iter().chain(VARIANTS) {
        let file = read(missing);
        for (ends, vessel) in file.vessels() {
            let ([length, proximal, distal], terminal) = &table[&ends.map(|end| file.node(end).id.clone())];
            assert!(close(vessel.length, *length), "{}", vessel.label);
            assert!(close(vessel.radius, *proximal) && close(vessel.radius, *distal), "{}", vessel.label);
            let stated = match file.node(ends[1]).condition {
                Some(Condition::Resistance { resistance, .. }) => Some(resistance),
                _ => None,
            };
            assert_eq!(stated.is_some(), terminal.is_some(), "{}", vessel.label);
            assert!(stated.zip(*terminal).is_none_or(|(ours, theirs)| close(ours, theirs)), "{}", vessel.label);
        }
    }
}
