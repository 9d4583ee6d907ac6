//! Names that change along a line, where no vessel branches off: every command has them, and they say nothing of what is connected.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};

/// A basilar artery of 20 mm that divides; each side is a P1 of 8 mm and a P2 of 20 mm in one line.
const POSTERIOR: &str = "# label 16 BA\n# label 17 L-P1\n# label 18 L-P2\n# label 19 R-P1\n# label 20 R-P2
1 0 0 -20 0 1.5 -1\n2 16 0 -10 0 1.5 1\n3 16 0 0 0 1.5 2
4 17 -4 0 0 1 3\n5 17 -8 0 0 1 4\n6 18 -18 0 0 1 5\n7 18 -28 0 0 1 6
8 19 4 0 0 1 3\n9 19 8 0 0 1 8\n10 20 18 0 0 1 9\n11 20 28 0 0 1 10\n";

fn run(here: &Path, arguments: &[&str]) {
    let output = willis(here, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
}

fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).expect("a table").deserialize().map(|row| row.expect("a row")).collect()
}

/// The length of each vessel by its label, mm.
fn lengths(table: &Path) -> BTreeMap<String, f64> {
    let length = |row: &BTreeMap<String, String>| (row["label"].clone(), row["length_mm"].parse().expect("a number"));
    rows(table).iter().map(length).collect()
}

#[test]
fn every_command_has_both_names_of_a_line() {
    let here = folder();
    let by_hand = BTreeMap::from([("BA", 20.0), ("L-P1", 8.0), ("L-P2", 20.0), ("R-P1", 8.0), ("R-P2", 20.0)]);
    let expected: BTreeMap<String, f64> = by_hand.into_iter().map(|(name, length)| (name.to_owned(), length)).collect();
    fs::write(here.path().join("posterior.swc"), POSTERIOR).expect("written");
    run(here.path(), &["infer", "posterior.swc", "-n", "64", "-o", "out"]);
    assert_eq!(lengths(&here.path().join("out/edges.csv")), expected);
    run(here.path(), &["convert", "posterior.swc", "lines.vtp"]);
    run(here.path(), &["convert", "lines.vtp", "edges.csv"]);
    assert_eq!(lengths(&here.path().join("edges.csv")), expected);
    // With the right P1 closed no blood is left in the right P2, and that on the left flows on.
    run(here.path(), &["simulate", "posterior.swc", "--occlude", "R-P1", "-o", "closed"]);
    let flow: BTreeMap<String, f64> = rows(&here.path().join("closed/edges.csv"))
        .into_iter()
        .map(|row| (row["label"].clone(), row["flow_mL_per_min_perturbed"].parse().expect("a number")))
        .collect();
    assert!(flow["R-P2"] == 0.0 && flow["L-P2"].abs() > 0.0, "{flow:?}");
}

/// Every five points of the broken circle have one of two names; candidates and their probabilities are those without names.
#[test]
fn names_say_nothing_of_what_is_connected() {
    let here = folder();
    let plain = fs::read_to_string(data("broken-circle-of-willis.swc")).expect("read");
    let mut named = "# label 16 L-M1\n# label 17 L-M2\n".to_owned();
    for line in plain.lines() {
        let mut cells: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        if !line.starts_with('#') {
            let number: usize = cells[0].parse().expect("a number");
            cells[1] = (16 + number / 5 % 2).to_string();
        }
        writeln!(named, "{}", cells.join(" ")).expect("written");
    }
    fs::write(here.path().join("named.swc"), named).expect("written");
    fs::write(here.path().join("plain.swc"), plain).expect("written");
    let candidates = |name: &str| {
        run(here.path(), &["infer", &format!("{name}.swc"), "-n", "64", "-o", name]);
        let nodes = rows(&here.path().join(name).join("nodes.csv"));
        let place = |node: &str| ["x_mm", "y_mm", "z_mm"].map(|axis| nodes[node.parse::<usize>().expect("a row")][axis].clone());
        let edges = rows(&here.path().join(name).join("edges.csv"));
        let uncertain = edges.iter().filter(|edge| edge["origin"] != "observed");
        let found: Vec<_> =
            uncertain.map(|e| (place(&e["node_a"]), place(&e["node_b"]), e["probability"].clone(), e["kept"].clone())).collect();
        (edges.len() - found.len(), found)
    };
    let ((whole, expected), (divided, found)) = (candidates("plain"), candidates("named"));
    assert!(divided > 2 * whole && !expected.is_empty(), "{divided} {whole}");
    assert_eq!(found, expected);
}
