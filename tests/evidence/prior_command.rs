//! `--prior` and `--keep` as a person uses them: files of priors, evidence by way of a file, errors in one line.

use std::fs;

use crate::command::{data, folder, stderr, willis};
use crate::refused::refused;

/// The columns of a CSV file by name.
fn column(text: &str, name: &str) -> Vec<String> {
    let mut lines = text.lines();
    let at = lines.next().expect("a header").split(',').position(|c| c == name).expect("the column");
    lines.map(|line| line.split(',').nth(at).expect("a field").to_owned()).collect()
}

const BROKEN: &str = "broken-circle-of-willis.swc";

#[test]
fn centerlines_come_with_evidence_and_a_candidate_graph_hands_it_on() {
    let here = folder();
    let run = |arguments: &[&str]| {
        let output = willis(here.path(), arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let said = run(&["infer", &data(BROKEN), "-o", "direct"]);
    assert!(said.contains("by evidence") && said.contains("the most probable forest") && said.contains("expected"), "{said}");
    run(&["candidates", &data(BROKEN), "-o", "graph.graphml"]);
    run(&["infer", "graph.graphml", "-o", "again"]);
    let edges = |folder: &str| fs::read_to_string(here.path().join(folder).join("edges.csv")).expect("written");
    assert_eq!(edges("direct"), edges("again"));
    let origin = column(&edges("direct"), "origin");
    let (prior, probability) = (column(&edges("direct"), "prior"), column(&edges("direct"), "probability"));
    assert!(origin.iter().any(|o| o == "candidate"));
    for ((origin, prior), probability) in origin.iter().zip(&prior).zip(&probability) {
        assert_eq!(if origin == "candidate" { prior.as_str() } else { "" }, probability);
    }
    // Another way of table: CSV holds as much.
    run(&["convert", "graph.graphml", "graph.csv"]);
    run(&["infer", "graph.csv", "-o", "table"]);
    assert_eq!(edges("direct"), edges("table"));
    // Without evidence the graph is that of the nearest neighbours, and the median decides.
    let said = run(&["infer", &data(BROKEN), "-o", "plain", "--prior", "none"]);
    assert!(said.contains("k = 6") && !said.contains("expected"), "{said}");
    let plain = edges("plain");
    assert_eq!(column(&plain, "kept"), column(&plain, "above_median"));
    assert!(column(&plain, "probability").iter().all(String::is_empty));
}

/// Of three vessels one cannot be, one always is: its frequency says so.
#[test]
fn priors_come_from_a_matrix_or_a_table() {
    let here = folder();
    let graph = "node_a,node_b,length_mm,radius_mm,prior\n0,1,10,1,1\n1,2,10,1,1\n0,2,30,1,0.5\n";
    let nodes = "node,role\n0,inlet\n1,inner\n2,outlet\n";
    fs::write(here.path().join("edges.csv"), graph).expect("written");
    fs::write(here.path().join("nodes.csv"), nodes).expect("written");
    // numpy.save of [[0, 1, .25], [1, 0, .5], [.25, .5, 0]], byte for byte of the format's description.
    let mut npy = b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }".to_vec();
    npy.resize(127, b' ');
    npy.push(b'\n');
    npy.extend([0.0, 1.0, 0.25, 1.0, 0.0, 0.5, 0.25, 0.5, 0.0].iter().flat_map(|x: &f64| x.to_le_bytes()));
    fs::write(here.path().join("A.npy"), &npy).expect("written");
    fs::write(here.path().join("by-row.csv"), "edge,prior\n2,0.25\n1,0.5\n").expect("written");
    fs::write(here.path().join("by-nodes.csv"), "node_a,node_b,prior\n2,0,0.25\n1,2,0.5\n0,1,\n").expect("written");
    let mut all = Vec::new();
    for prior in ["A.npy", "by-row.csv", "by-nodes.csv"] {
        let output = willis(here.path(), &["infer", "edges.csv", "--prior", prior, "-o", "out", "--force", "--exact"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let edges = fs::read_to_string(here.path().join("out/edges.csv")).expect("written");
        assert_eq!(column(&edges, "prior"), ["1", "0.5", "0.25"], "{prior}");
        let record = fs::read_to_string(here.path().join("out/run.json")).expect("written");
        let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
        assert_eq!(record["parameters"]["prior"]["path"], prior);
        assert_eq!(record["parameters"]["prior"]["sha256"].as_str().expect("a checksum").len(), 64);
        all.push(edges);
    }
    assert!(all.windows(2).all(|w| w[0] == w[1]));
}

#[test]
fn faults_of_priors_and_rules_are_one_line() {
    let graph: (&str, &[u8]) = ("edges.csv", b"node_a,node_b,length_mm,radius_mm\n0,1,10,1\n1,2,10,1\n");
    let with = |name: &'static str, bytes: &'static [u8]| [graph, (name, bytes)];
    let infer = |prior: &'static str| ["infer", "edges.csv", "-o", "out", "--prior", prior];
    refused(&[graph], &infer("evidense"), &["--prior \"evidense\"", "did you mean \"evidence\"?"]);
    refused(&[graph], &infer("evidence"), &["--prior evidence", "ready graph"]);
    refused(&[graph], &infer("none.npy"), &["none.npy: cannot be read"]);
    refused(&with("a.npy", b"\x93NUM"), &infer("a.npy"), &["a.npy: array A: not a NumPy array"]);
    refused(&with("a.csv", b"edge,prior\n2,1\n"), &infer("a.csv"), &["a.csv:2: edge \"2\"; expected a row below 2"]);
    refused(&with("a.csv", b"edge,prior\n1,1.5\n"), &infer("a.csv"), &["a.csv:2: prior 1.5; expected a number from 0 to 1"]);
    let twice = b"edge,prior\n1,0.5\n0,1\n1,0.5\n1,0.6\n";
    refused(&with("a.csv", twice), &infer("a.csv"), &["a.csv:5: prior 0.6 of edge 1, which is another one on line 4"]);
    refused(&with("a.csv", b"node_a,node_b,prior\n0,2,1\n"), &infer("a.csv"), &["a.csv:2: 0 - 2", "a vessel joins"]);
    refused(&with("a.csv", b"node_a,prior\n0,1\n"), &infer("a.csv"), &["a.csv:1: columns node_a,prior", "node_a,node_b"]);
    let keep = |rule: &'static str| ["infer", "edges.csv", "-o", "out", "--keep", rule];
    refused(&[graph], &keep("probable"), &["--keep probable: asks for probabilities"]);
    refused(&[graph], &keep("probability=0.5"), &["--keep probability: asks for probabilities"]);
    refused(&[graph], &keep("probability=1.5"), &["--keep", "1.5", "from 0 to 1"]);
    refused(&[graph], &keep("probable=-1"), &["--keep probable -1", "from 0 to 1000"]);
    refused(&[graph], &keep("probible"), &["did you mean \"probable\"?"]);
}
