//! Bridges and features against the reference model, on real artery trees broken up. Needs `WILLIS_PYTHON` and the shared data.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::extracted::extracted;
use ndarray::Array2;
use willis::internals::candidates::features::{
    Extraction, FEATURES, FEEDBACK_FEATURES, ROOT_FEATURES, features, feedback_features, root_features,
};
use willis::internals::candidates::search::{EndCandidate, SearchOptions, search};
use willis::internals::forest_posterior;
use willis::internals::forest_posterior::{Forests, marginals};
use willis::internals::network::centerlines::Centerlines;
use willis::internals::network::{Network, RadiusRule, contract};

/// Two brains, one of them without known inlets, and two circles, one of which has a vessel that closes a loop.
const SUBJECTS: [&str; 5] = ["BG0002", "BG06", "BG06~", "INSIST_0027", "INSIST_0038"];

fn numbers(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).expect("a table");
    text.lines().map(|l| l.split(',').map(|x| x.parse().expect("a number")).collect()).collect()
}

/// The points of an SWC file as they stand, with the links that close loops.
fn centerlines(swc: &Path, loops: &Path) -> Centerlines {
    let mut lines = Centerlines::default();
    for (row, line) in fs::read_to_string(swc).expect("an SWC file").lines().enumerate() {
        let x: Vec<f64> = line.split_whitespace().map(|x| x.parse().expect("a number")).collect();
        lines.add_point([x[2], x[3], x[4]], x[5], row as u64 + 1, 0);
        if x[6] > 0.0 {
            lines.add_link([x[6] as u32 - 1, row as u32], "");
        }
    }
    for pair in numbers(loops) {
        lines.add_link([pair[0] as u32 - 1, pair[1] as u32 - 1], "");
    }
    lines
}

fn row_of(network: &Network, id: f64) -> usize {
    network.nodes().position(|n| n.id == id.to_string()).expect("an inlet at a node")
}

/// The feedback on the bridges between fragments, weighed as the reference does; zero for those within one.
fn feedback(e: &Extraction, bridges: &[EndCandidate], x: &Array2<f64>) -> Array2<f64> {
    let rows: Vec<usize> = (0..bridges.len()).filter(|row| !bridges[*row].within).collect();
    let between: Vec<EndCandidate> = rows.iter().map(|row| bridges[*row]).collect();
    let at = |row: usize, name: &str| x[[row, FEATURES.iter().position(|(n, _)| *n == name).expect("a feature")]];
    let weighed = |row: &usize| forest_posterior::Edge {
        child: e.ends[bridges[*row].end].fragment,
        parent: e.fragment[bridges[*row].point],
        log_weight: at(*row, "kink") - at(*row, "gap") - at(*row, "bend_child_sq"),
    };
    let slim = ROOT_FEATURES.iter().position(|(n, _)| *n == "slim").expect("a feature");
    let roots = root_features(e).column(slim).iter().map(|slim| slim - 4.0).collect();
    let forests = Forests::new(roots, rows.iter().map(weighed).collect()).expect("forests");
    let of_between = feedback_features(e, &between, &forests, &marginals(&forests));
    let mut out = Array2::zeros((bridges.len(), FEEDBACK_FEATURES.len()));
    for (row, features) in rows.iter().zip(of_between.rows()) {
        out.row_mut(*row).assign(&features);
    }
    out
}

/// Says what differs by more than rounding.
fn difference(name: &str, a: &[f64], b: &[f64]) -> String {
    let most = a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    // No number is no small difference.
    let near = a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-9);
    if near { String::new() } else { format!("{name} differs by {most:e}") }
}

#[test]
fn bridges_and_features_are_those_of_the_reference() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return;
    };
    if !shared.join("gapbench/model.py").exists() {
        eprintln!("skipped: no {}", shared.display());
        return;
    }
    let here = tempfile::tempdir().expect("a temporary folder");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/evidence/reference.py");
    let status = Command::new(python)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .arg(script)
        .arg(&shared)
        .arg(here.path())
        .args(SUBJECTS)
        .status()
        .expect("runs");
    assert!(status.success());
    let names = fs::read_to_string(here.path().join(format!("{}.names", SUBJECTS[0]))).expect("names");
    let columns: Vec<&str> = FEATURES.iter().map(|(n, _)| *n).chain(FEEDBACK_FEATURES.iter().copied()).collect();
    let ours: Vec<&str> = columns.iter().copied().chain(ROOT_FEATURES.iter().map(|(n, _)| *n)).collect();
    assert_eq!(names.lines().collect::<Vec<_>>(), ours);
    for subject in SUBJECTS {
        let at = |ending: &str| here.path().join(format!("{subject}.{ending}"));
        let network = contract(&centerlines(&at("swc"), &at("loops.csv")), RadiusRule::Mean, None).expect("vessels").network;
        let inlets: Vec<usize> = numbers(&at("inlets.csv")).iter().map(|r| row_of(&network, r[0])).collect();
        let extraction = extracted(&network, &inlets).expect("positions");
        let bridges = search(&extraction, &SearchOptions::default()).unwrap();
        let own = features(&extraction, &bridges);
        let from_others = feedback(&extraction, &bridges, &own);
        // By coordinates: the numbers of the points differ.
        let key = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        let mut mine = BTreeMap::new();
        for (row, bridge) in bridges.iter().enumerate() {
            let ends = [extraction.ends[bridge.end].point, bridge.point].map(|p| extraction.position[p]);
            let place: Vec<f64> = ends.concat().into_iter().chain([f64::from(u8::from(bridge.within))]).collect();
            assert!(
                mine.insert(key(&place), [own.row(row).to_vec(), from_others.row(row).to_vec()].concat()).is_none(),
                "a bridge twice"
            );
        }
        let reference: BTreeMap<Vec<u64>, Vec<f64>> =
            numbers(&at("bridges.csv")).iter().map(|r| (key(&r[..7]), r[7..].to_vec())).collect();
        let lost = reference.keys().filter(|k| !mine.contains_key(*k)).count();
        let extra = mine.keys().filter(|k| !reference.contains_key(*k)).count();
        assert!(
            reference.len() > 25 && (lost, extra) == (0, 0),
            "{subject}: {} bridges, {lost} lost, {extra} extra",
            reference.len()
        );
        let column = |table: &BTreeMap<Vec<u64>, Vec<f64>>, at: usize| table.values().map(|r| r[at]).collect::<Vec<f64>>();
        for (at, name) in columns.iter().enumerate() {
            assert_eq!(difference(name, &column(&mine, at), &column(&reference, at)), "", "{subject}");
            let silent = column(&mine, at).iter().all(|x| x.abs() < 0.1);
            assert!(!silent || subject != SUBJECTS[0], "{name} is nothing in a whole brain");
        }
        // Fragments are numbered by their first node here, by their first point there: each row by its own numbers.
        let sorted = |mut rows: Vec<Vec<f64>>| {
            rows.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
            rows
        };
        let roots = sorted(root_features(&extraction).rows().into_iter().map(|r| r.to_vec()).collect());
        let expected = sorted(numbers(&at("roots.csv")));
        assert_eq!(roots.len(), expected.len());
        for (a, b) in roots.iter().zip(&expected) {
            assert_eq!(difference("root", a, b), "", "{subject}");
        }
    }
}
