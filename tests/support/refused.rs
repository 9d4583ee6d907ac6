//! Lists the files of a folder, and checks that a run is refused and leaves them as they were.

use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{folder, stderr, willis};

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
