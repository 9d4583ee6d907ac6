//! `willis measure`: its tables of files, runs and cohorts, held against NetworkX, and what it refuses.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::{data, folder, stderr, willis};

fn table(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn cell(path: &Path, row: usize, column: &str) -> String {
    let table = table(path);
    let at = table[0].iter().position(|name| name == column).unwrap_or_else(|| panic!("{column}: {:?}", table[0]));
    table[row + 1][at].clone()
}

fn done(here: &Path, words: &[&str]) {
    let output = willis(here, words);
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
}

/// Of a ready graph that NetworkX reads: lengths, parts, loops and ways are those that it finds.
const BY_NETWORKX: &str = "
import sys, networkx as nx, pandas as pd
out, file = sys.argv[1:]
graph = nx.MultiGraph(nx.read_graphml(file, force_multigraph=True))
graph.remove_nodes_from([n for n, d in list(graph.degree()) if d == 0])
subject = pd.read_csv(out + '/subjects.csv').iloc[0]
length = sum(d['length_mm'] for _, _, d in graph.edges(data=True))
parts = nx.number_connected_components(graph)
assert abs(subject.length_mm - length) < 1e-9 * length, (subject.length_mm, length)
assert subject.parts == parts, (subject.parts, parts)
assert subject.loops == graph.number_of_edges() - graph.number_of_nodes() + parts
assert subject.ends == sum(d == 1 for _, d in graph.degree())
assert subject.bifurcations == sum(d > 2 for _, d in graph.degree())
inlets = [n for n, d in graph.nodes(data=True) if d.get('role') == 'inlet']
ways = nx.multi_source_dijkstra_path_length(graph, inlets, weight='length_mm')
ends = pd.read_csv(out + '/ends.csv', dtype={'id': str})
name = {str(d.get('id', n)): n for n, d in graph.nodes(data=True)}
for end in ends.itertuples():
    way = ways.get(name[end.id])
    assert (way is None and end.from_inlet_mm != end.from_inlet_mm) or abs(way - end.from_inlet_mm) < 1e-9 * max(way, 1), end
assert len(inlets) > 0 and len(ends) > 3
";

#[test]
fn a_run_is_measured_as_networkx_measures_its_topology() {
    let here = folder();
    done(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "-n", "10", "--dpi", "36"]);
    done(here.path(), &["measure", "out", "-o", "measured"]);
    let intervals = here.path().join("measured/intervals.csv");
    let rows = table(&intervals).len() - 1;
    assert_eq!(rows, 16, "a row for every figure of a whole network");
    let number = |row, column| cell(&intervals, row, column).parse::<f64>().unwrap_or(f64::NAN);
    for row in 0..rows {
        let [mean, low, high] = ["mean", "low", "high"].map(|column| number(row, column));
        assert!(low <= mean + 1e-9 * mean && mean <= high + 1e-9 * mean || mean.is_nan(), "{row}: {low} {mean} {high}");
    }
    // The pieces of a broken circle are joined in more ways than one.
    assert!((0..rows).any(|row| number(row, "low") < number(row, "high")));
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        println!("skipped: WILLIS_PYTHON names no Python with NetworkX");
        return;
    };
    let checked = Command::new(python)
        .current_dir(here.path())
        .args(["-c", BY_NETWORKX, "measured", "out/topology.graphml"])
        .output()
        .expect("runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

#[test]
fn several_inputs_are_one_below_the_other_and_one_that_fails_is_a_row() {
    let here = folder();
    for name in ["a", "b"] {
        fs::write(here.path().join(format!("{name}.swc")), "1 0 0 0 0 1 -1\n2 0 10 0 0 1 1\n3 0 20 0 0 1 2\n").expect("written");
    }
    fs::write(here.path().join("c.swc"), "1 0 0 0 zero 1 -1\n").expect("written");
    let done = willis(here.path(), &["measure", "*.swc", "-o", "out"]);
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    let [vessels, subjects] = ["vessels.csv", "subjects.csv"].map(|name| here.path().join("out").join(name));
    assert_eq!(table(&vessels).len(), 3, "two vessels under one header");
    assert_eq!(cell(&vessels, 1, "subject"), "b");
    assert_eq!(cell(&vessels, 1, "length_mm"), "20");
    assert_eq!(["a", "b", "c"].map(str::to_owned), [0, 1, 2].map(|row| cell(&subjects, row, "subject")));
    assert_eq!(cell(&subjects, 2, "status"), "failed");
    assert!(table(&here.path().join("out/intervals.csv"))[1..].is_empty());
}

#[test]
fn the_threads_change_nothing() {
    let here = folder();
    for threads in ["1", "4"] {
        done(here.path(), &["measure", &data("circle-of-willis/*.graphml"), "-o", threads, "--threads", threads]);
    }
    for name in ["vessels.csv", "bifurcations.csv", "ends.csv", "subjects.csv", "intervals.csv"] {
        let [one, four] = ["1", "4"].map(|threads| fs::read(here.path().join(threads).join(name)).expect("a table"));
        assert_eq!(one, four, "{name}");
    }
    let subjects = table(&here.path().join("1/subjects.csv"));
    assert!(subjects[0].iter().any(|name| name == "L-A1_diameter_mm"), "{:?}", subjects[0]);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let here = folder();
    fs::write(here.path().join("a.swc"), "1 0 0 0 0 1 -1\n2 0 10 0 0 1 1\n").expect("written");
    for (words, wanted) in [
        (&["measure", "a.swc", "-o", "out", "--smoothing", "0"][..], "--smoothing \"0\": expected a positive length"),
        (&["measure", "a.swc", "-o", "out", "--inlet", "7"], "--inlet"),
        (&["measure", "a.swc", "-o", "out", "--observed"], "--observed"),
        (&["measure", "absent.swc", "-o", "out"], "absent.swc"),
    ] {
        let done = willis(here.path(), words);
        let said = stderr(&done);
        assert!(
            done.status.code() == Some(2) && said.lines().last().is_some_and(|last| last.contains(wanted)),
            "{words:?}: {said}"
        );
        assert!(!here.path().join("out").exists(), "{words:?}");
    }
}
