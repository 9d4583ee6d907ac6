//! Real extractions, some of all that are at hand, run to an answer with no option but their unit. Skipped where the data is absent.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One of so many is run: the experiments run them all.
const SOME: usize = 4;

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
fn insist_tracings() {
    for input in files("insist-cow", "swc").into_iter().step_by(SOME) {
        let info = fs::read_to_string(input.with_file_name("Image_info.txt")).expect("Image_info.txt");
        let spacing = info.lines().find_map(|l| l.strip_prefix("Voxel spacing:")).expect("a spacing");
        let spacing = spacing.split_whitespace().next().expect("a number");
        answer(&input, &["--units", "voxel", "--spacing", spacing]);
    }
}

#[test]
fn brava_trees() {
    for input in files("brava/vtp", "vtp").into_iter().step_by(SOME) {
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

/// The role of every node of the table in a folder, by its id.
fn roles(folder: &Path) -> std::collections::BTreeMap<String, String> {
    let table = fs::read_to_string(folder.join("nodes.csv")).expect("nodes.csv");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let header = rows.headers().expect("a header").clone();
    let at = |name: &str| header.iter().position(|h| h == name).expect("a column");
    let (id, role) = (at("id"), at("role"));
    rows.records().map(|row| row.expect("a row")).map(|row| (row[id].to_owned(), row[role].to_owned())).collect()
}

/// A wide piece 1 m away, as of a sinus, moves no role of a phantom or of a brain, in infer and in simulate.
#[test]
fn a_piece_far_away_moves_no_role() {
    let here = tempfile::tempdir().expect("a temporary folder");
    let run = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_willis")).current_dir(here.path()).args(arguments).output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let phantom = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/broken-circle-of-willis.swc");
    let brain = files("brava/vtp", "vtp").into_iter().next();
    for input in [Some(phantom), brain].into_iter().flatten() {
        run(&["convert", &input.display().to_string(), "alone.swc", "--force", "-q"]);
        let mut swc = fs::read_to_string(here.path().join("alone.swc")).expect("SWC");
        for step in 0..20_usize {
            let parent = if step == 0 { "-1".to_owned() } else { (900_000 + step - 1).to_string() };
            writeln!(swc, "{} 0 {} 0 -500 5 {parent}", 900_000 + step, 1000 + step).expect("written");
        }
        fs::write(here.path().join("with.swc"), swc).expect("written");
        for command in [&["infer", "-n", "64"][..], &["simulate"]] {
            for name in ["alone", "with"] {
                run(&[command, &[&format!("{name}.swc"), "-o", name, "--force", "-q"]].concat());
            }
            let [alone, mut with] = ["alone", "with"].map(|name| roles(&here.path().join(name)));
            with.retain(|id, _| !id.starts_with("9000"));
            assert!(alone.values().any(|role| role == "inlet"));
            assert_eq!(alone, with, "{} of {}", command[0], input.display());
        }
    }
}

/// The inlets of the circle that ships are those that its truth names: two carotids and two vertebral arteries.
#[test]
fn the_four_inlets_of_the_circle_that_ships_are_found() {
    let here = tempfile::tempdir().expect("a temporary folder");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let mut command = Command::new(env!("CARGO_BIN_EXE_willis"));
    let command = command.current_dir(here.path()).arg("infer").arg(data.join("broken-circle-of-willis.swc"));
    assert!(command.args(["-n", "64", "-q", "-o", "out"]).status().expect("it runs").success());
    let truth = fs::read(data.join("broken-circle-of-willis.truth.json")).expect("a truth");
    let truth: serde_json::Value = serde_json::from_slice(&truth).expect("JSON");
    let mut truth: Vec<String> = truth["inlets"].as_array().expect("inlets").iter().map(ToString::to_string).collect();
    truth.sort();
    let found = roles(&here.path().join("out")).into_iter().filter(|(_, role)| role == "inlet").map(|(id, _)| id);
    assert_eq!(found.collect::<Vec<_>>(), truth);
}
