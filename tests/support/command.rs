//! Running the command as a person does, in a folder of its own.

use std::path::Path;
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
