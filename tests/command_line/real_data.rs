//! Every real extraction at hand runs to an answer with no option but its unit. Skipped where the data is absent.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The files below a folder of the shared data with this ending; none, and a word, where it is absent.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(folder);
    let mut open = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(at) = open.pop() {
        for entry in fs::read_dir(&at).into_iter().flatten().map(|e| e.expect("an entry").path()) {
            if entry.is_dir() {
                open.push(entry);
            } else if entry.extension().is_some_and(|e| e == ending) {
                found.push(entry);
            }
        }
    }
    if found.is_empty() {
        eprintln!("skipped: no {}", root.display());
    }
    found.sort();
    found
}

/// Runs a file to an answer and returns what was said.
fn answer(input: &Path, extra: &[&str]) -> String {
    let here = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_willis"));
    let output = command.current_dir(here.path()).arg("infer").arg(input).args(["-o", "out"]).args(extra).output().expect("runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{}: {said}", input.display());
    let edges = fs::read_to_string(here.path().join("out/edges.csv")).expect("edges.csv");
    let mut rows = csv::Reader::from_reader(edges.as_bytes());
    let likelihood = rows.headers().expect("a header").iter().position(|h| h == "likelihood").expect("a column");
    let sum: f64 = rows.records().map(|r| r.expect("a row")[likelihood].parse::<f64>().expect("a number")).sum();
    assert!(sum.is_finite() && sum > 0.0, "{}: no vessel carries flow", input.display());
    said
}

#[test]
fn every_insist_tracing() {
    for input in files("insist-cow", "swc") {
        let info = fs::read_to_string(input.with_file_name("Image_info.txt")).expect("Image_info.txt");
        let spacing = info.lines().find_map(|l| l.strip_prefix("Voxel spacing:")).expect("a spacing");
        let spacing = spacing.split_whitespace().next().expect("a number");
        answer(&input, &["--units", "voxel", "--spacing", spacing]);
    }
}

#[test]
fn every_brava_tree() {
    for input in files("brava/vtp", "vtp") {
        answer(&input, &[]);
    }
}

#[test]
fn what_zero_radii_become_is_printed() {
    let subject = files("brava/vtp", "vtp").into_iter().find(|p| p.to_string_lossy().contains("BG0002"));
    if let Some(input) = subject {
        let said = answer(&input, &[]);
        assert!(said.contains("1 point without a positive finite radius: interpolated"), "{said}");
    }
}
