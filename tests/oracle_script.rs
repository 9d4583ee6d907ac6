//! The exact expectation from an independent enumeration in Python, against sampled runs of the command.

use std::path::Path;
use std::process::Command;

#[test]
fn sampled_likelihoods_agree_with_the_enumeration_of_all_subgraphs() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/oracle/exact_likelihood.py");
    let python = std::env::var("WILLIS_PYTHON").unwrap_or_else(|_| "python3".into());
    if !script.exists() || Command::new(&python).arg("--version").output().is_err() {
        eprintln!("skipped: no {} or no {python}", script.display());
        return;
    }
    let here = tempfile::tempdir().expect("a temporary folder");
    let run = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).current_dir(here.path()).args(arguments).output().expect("runs");
        let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{program} {arguments:?}: {said}");
    };
    let script = script.display().to_string();
    for seed in 1..=8 {
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
