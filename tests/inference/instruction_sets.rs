//! Every instruction set and thread count gives the same bytes.

use std::path::Path;
use std::process::Command;
use willis::internals::sampling::coins::open_vessels;

/// edges.csv of a run with these variables in the environment.
fn edges(input: &str, arguments: &[&str], variables: &[(&str, &str)]) -> Vec<u8> {
    let here = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_willis"));
    command.current_dir(here.path()).args(["infer", input, "-o", "out", "-q", "-n", "1000"]).args(arguments);
    let output = command.envs(variables.iter().copied()).output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(here.path().join("out/edges.csv")).expect("edges.csv")
}

#[test]
fn the_bytes_do_not_depend_on_the_processor() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut inputs = vec![root.join("data/broken-circle-of-willis.swc")];
    for name in ["extraction-45-165", "brain-206-726-13-terminals"] {
        let shared = root.join("../shared/bench").join(name).with_extension("graphml");
        if shared.exists() {
            inputs.push(shared);
        } else {
            eprintln!("skipped: no {}", shared.display());
        }
    }
    for input in inputs.iter().map(|p| p.display().to_string()) {
        let arguments = ["--epsilon", "0.3", "--uncertain", "all", "--dpi", "36"];
        let reference = edges(&input, &arguments, &[("WILLIS_SIMD", "baseline"), ("WILLIS_THREADS", "1")]);
        for (simd, threads) in [("baseline", "2"), ("avx2", "1"), ("avx2", "8"), ("avx512", "2"), ("avx512", "1")] {
            let variables = [("WILLIS_SIMD", simd), ("WILLIS_THREADS", threads)];
            assert_eq!(edges(&input, &arguments, &variables), reference, "{input} {variables:?}");
        }
    }
}

/// Every word has bit i set in the first i of them, so that sample i is open in min(i, words) of them.
#[test]
fn open_vessels_are_counted() {
    for words in [0, 1, 7, 8, 9, 63, 64, 100] {
        let masks: Vec<u64> = (0..words).map(|word| (0..64).filter(|i| word < *i).map(|i| 1 << i).sum()).collect();
        let counted = open_vessels(&masks);
        for (sample, counted) in counted.iter().enumerate() {
            assert_eq!(*counted, sample.min(words) as f64, "{words} words, sample {sample}");
        }
    }
}
