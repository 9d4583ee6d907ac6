//! Running the command as a person does, in a folder of its own.

#![allow(dead_code, reason = "each test file uses its part")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// The command in a folder, for tests that give it arguments, variables or streams of their own.
pub fn builder(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_willis"));
    command.current_dir(folder);
    command
}

pub fn willis(folder: &Path, arguments: &[&str]) -> Output {
    builder(folder).args(arguments).output().expect("the binary runs")
}

pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

pub fn data(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).display().to_string()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file below a folder with its bytes, run.json without its times.
pub fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        for entry in fs::read_dir(at).expect("a folder").map(|e| e.expect("an entry").path()) {
            if entry.is_dir() {
                open.push(entry);
                continue;
            }
            let mut bytes = fs::read(&entry).expect("a file");
            if entry.ends_with("run.json") {
                let mut record: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
                record["time"] = serde_json::Value::Null;
                bytes = record.to_string().into_bytes();
            }
            files.push((entry.strip_prefix(folder).expect("below").to_owned(), bytes));
        }
    }
    files.sort();
    files
}

/// A run on `input` must fail with status 2, one line that holds all `words`, and nothing written.
pub fn refused(input: &[(&str, &[u8])], arguments: &[&str], words: &[&str]) {
    let here = folder();
    for (name, bytes) in input {
        fs::write(here.path().join(name), bytes).expect("written");
    }
    let before = contents(here.path());
    let output = willis(here.path(), arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("willis: ")).collect();
    assert_eq!(errors.len(), 1, "{said}");
    for word in words {
        assert!(errors[0].contains(word), "\"{word}\" is missing in: {}", errors[0]);
    }
    assert_eq!(contents(here.path()), before, "files were touched");
}
