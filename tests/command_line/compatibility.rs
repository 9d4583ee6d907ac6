//! What earlier versions wrote is read: runs, shards, weights. `tests/compatibility/` holds a folder of each version, which
//! `tests/compatibility/make.sh` made; the truth is what that version made of it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{data, folder, stderr, willis};

/// The folders, one a version.
fn versions() -> Vec<PathBuf> {
    let saved = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compatibility");
    let entries = fs::read_dir(saved).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    assert!(!folders.is_empty());
    folders
}

fn done(here: &Path, arguments: &[&str]) -> String {
    let output = willis(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stderr(&output)
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a name")
}

/// The columns of a CSV file under some names.
fn columns(table: &str, names: &[&str]) -> Vec<Vec<String>> {
    let mut rows = table.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let head = rows.next().expect("a head");
    let at: Vec<usize> = names.iter().map(|name| head.iter().position(|column| column == name).expect("a column")).collect();
    rows.map(|row| at.iter().map(|at| row[*at].clone()).collect()).collect()
}

#[test]
fn shards_of_every_version_are_merged_to_the_same_figures() {
    for version in versions() {
        let here = folder();
        let shards = ["shard-0", "shard-640"].map(|name| version.join(name));
        done(here.path(), &["merge", text(&shards[0]), text(&shards[1]), "-o", "merged", "-q"]);
        let read = |path: PathBuf| fs::read_to_string(path).expect("read");
        // The columns whose meaning no version may change.
        let of = |table: &str| columns(table, &["node_a", "node_b", "origin", "likelihood", "frequency", "kept"]);
        assert_eq!(of(&read(here.path().join("merged/edges.csv"))), of(&read(version.join("edges.csv"))), "{version:?}");
    }
}

#[test]
fn a_run_of_every_version_is_asked_for_its_variant() {
    for version in versions() {
        let here = folder();
        done(here.path(), &["classify", text(&version.join("run")), "-o", "variant", "-q"]);
        let answer = fs::read_to_string(here.path().join("variant/phenotype.json")).expect("read");
        let answer: serde_json::Value = serde_json::from_str(&answer).expect("JSON");
        assert_eq!(answer["completeness"], "complete", "{version:?}");
    }
}

#[test]
fn weights_of_every_version_are_read() {
    for version in versions() {
        let here = folder();
        let circle = data("broken-circle-of-willis.swc");
        done(here.path(), &["candidates", &circle, "--prior", text(&version.join("weights.toml")), "-o", "a.graphml", "-q"]);
        assert!(here.path().join("a.graphml").exists());
    }
}
