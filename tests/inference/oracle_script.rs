//! The exact expectation from an independent enumeration in Python, against sampled runs of the command.

use std::path::Path;
use std::process::Command;

use crate::python_oracle::oracle;

const SCRIPT: &str = "exact_likelihood.py";

fn run_in(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).current_dir(folder).args(arguments).output().expect("runs");
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{program} {arguments:?}: {said}");
    said
}

/// 1e-11 of each: the enumeration there solves densely, in another order.
#[test]
fn exact_likelihoods_are_those_of_the_enumeration() {
    const EXPECTED: &str = "import importlib.util as u, sys
s = u.spec_from_file_location('oracle', sys.argv[1]); o = u.module_from_spec(s); s.loader.exec_module(o)
mean, _, frequency = o.enumerate_graph(*o.read(sys.argv[2]), float(sys.argv[3]))
for row in zip(mean, frequency): print(*map(repr, map(float, row)))";
    let Some((script, python)) = oracle(SCRIPT) else { return };
    let here = tempfile::tempdir().expect("a temporary folder");
    for seed in 1..=9 {
        let (graph, out, epsilon) = (format!("g{seed}.graphml"), format!("out-{seed}"), ["0.2", "0.3", "0.5"][seed % 3]);
        run_in(here.path(), &python, &[&script, "--make", &seed.to_string(), &graph]);
        let expected = run_in(here.path(), &python, &["-c", EXPECTED, &script, &graph, epsilon]);
        let infer = ["infer", &graph, "-o", &out, "--epsilon", epsilon, "-n", "1", "-q", "--exact"];
        run_in(here.path(), env!("CARGO_BIN_EXE_willis"), &[&infer[..], &["--uncertain", "all", "--prior", "none"]].concat());
        let mut edges = csv::Reader::from_path(here.path().join(&out).join("edges.csv")).expect("edges.csv");
        let header = edges.headers().expect("a header").clone();
        let column = |name: &str| header.iter().position(|h| h == name).expect("the column");
        let columns = [column("likelihood"), column("frequency")];
        let mut rows = 0;
        for (record, line) in edges.records().zip(expected.lines()) {
            let record = record.expect("a row");
            for (at, expected) in columns.iter().zip(line.split_whitespace()) {
                let (got, expected): (f64, f64) = (record[*at].parse().expect("a figure"), expected.parse().expect("a figure"));
                assert!((got - expected).abs() <= 1e-11 * expected, "graph {seed}, vessel {rows}: {got} for {expected}");
            }
            rows += 1;
        }
        assert!(rows > 0 && rows == expected.lines().count(), "graph {seed}");
    }
}

#[test]
fn sampled_likelihoods_agree_with_the_enumeration_of_all_subgraphs() {
    let Some((script, python)) = oracle(SCRIPT) else { return };
    let here = tempfile::tempdir().expect("a temporary folder");
    let run = |program: &str, arguments: &[&str]| run_in(here.path(), program, arguments);
    for seed in 1..=4 {
        let graph = format!("g{seed}.graphml");
        run(&python, &[&script, "--make", &seed.to_string(), &graph]);
        for epsilon in ["0.2", "0.3", "0.5"] {
            let out = format!("out-{seed}-{epsilon}");
            let infer = ["infer", &graph, "-o", &out, "--epsilon", epsilon, "-n", "200000", "--seed", "1", "-q"];
            run(env!("CARGO_BIN_EXE_willis"), &[&infer[..], &["--uncertain", "all", "--prior", "none"]].concat());
            run(&python, &[&script, &graph, "--epsilon", epsilon, "--edges", &format!("{out}/edges.csv"), "--samples", "200000"]);
        }
    }
}
