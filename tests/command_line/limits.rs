//! What the system does not allow is said in one line before the work begins: small files, little memory, a variable without a value. The
//! truth is the limit that the test sets.
#![cfg(target_os = "linux")]

use std::{fs, process::Command};

use crate::command::{builder, data, folder, stderr};
use crate::refused::contents;

/// The command under limits of a shell.
fn limited(limits: &str, arguments: &[&str]) -> (Option<i32>, String, bool) {
    let here = folder();
    let script = format!("{limits}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.current_dir(here.path()).args(["-c", &script, env!("CARGO_BIN_EXE_willis")]).args(arguments);
    let output = command.output().expect("runs");
    (output.status.code(), stderr(&output), contents(here.path()).is_empty())
}

fn errors(said: &str) -> Vec<&str> {
    said.lines().filter(|line| line.starts_with("willis: ")).collect()
}

/// A limit on the size of files ends a process by a signal that says nothing.
#[test]
fn a_limit_on_files_is_said_before_the_work_or_when_it_is_reached() {
    let swc = data("broken-circle-of-willis.swc");
    let (status, said, empty) = limited("ulimit -f 20", &["infer", &swc, "-o", "out", "-n", "1000000000000"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("ulimit -f") && empty, "{said}");
    // A single file may be small enough.
    let (status, said, _) = limited("ulimit -f 2", &["convert", &swc, "out.vtp"]);
    assert_eq!(status, Some(1), "{said}");
    assert!(errors(&said)[0].contains("out.vtp"), "{said}");
    let (status, said, _) = limited("ulimit -f 2000", &["convert", &swc, "out.vtp"]);
    assert_eq!(status, Some(0), "{said}");
}

#[test]
fn a_modulation_that_does_not_fit_into_memory_is_refused() {
    let here = folder();
    let made = builder(here.path()).args(["phantom", "circle-of-willis", "-o", "a.graphml"]).output().expect("runs");
    assert!(made.status.success(), "{}", stderr(&made));
    let graph = here.path().join("a.graphml").display().to_string();
    let arguments = ["modulate", &graph, "-o", "out", "-n", "1e7", "--save-samples"];
    let (status, said, empty) = limited("ulimit -v 4000000", &arguments);
    assert_eq!(status, Some(2), "{said}");
    assert_eq!(errors(&said).len(), 1, "{said}");
    assert!(said.contains("--samples 10000000: needs ") && said.contains("GiB of memory") && empty, "{said}");
}

/// Each of 5,000 separate vessels has its inlet, and each inlet a row for every vessel and outlet in territories.csv: 50 million rows.
#[test]
fn transport_of_more_inlets_than_fit_into_memory_is_refused() {
    let here = folder();
    let nodes = (0..10_000).map(|n| format!("{n},{}\n", if n % 2 == 0 { 100 } else { 0 }));
    let edges = (0..5_000).map(|e| format!("{},{},1,1\n", 2 * e, 2 * e + 1));
    fs::write(here.path().join("a.nodes.csv"), format!("node,pressure_mmHg\n{}", nodes.collect::<String>())).expect("writes");
    fs::write(here.path().join("a.csv"), format!("node_a,node_b,length_mm,radius_mm\n{}", edges.collect::<String>()))
        .expect("writes");
    let graph = here.path().join("a.csv").display().to_string();
    let arguments = ["simulate", &graph, "-o", "out", "--transport"];
    let (status, said, empty) = limited("ulimit -v 4000000", &arguments);
    assert_eq!(status, Some(2), "{said}");
    assert_eq!(errors(&said).len(), 1, "{said}");
    assert!(said.contains("--transport of 5000 inlets: needs ") && said.contains("GiB of memory") && empty, "{said}");
}

#[test]
fn a_variable_without_a_value_is_not_set() {
    let swc = data("broken-circle-of-willis.swc");
    for (value, status) in [("", 0), ("2", 0), ("x", 2), ("0", 2)] {
        let here = folder();
        let mut command = builder(here.path());
        let output = command.env("WILLIS_THREADS", value).args(["convert", &swc, "a.vtp", "-q"]).output().expect("runs");
        assert_eq!(output.status.code(), Some(status), "\"{value}\": {}", stderr(&output));
    }
    let here = folder();
    let output = builder(here.path()).args(["convert", &swc, "a.vtp", "--threads", ""]).output().expect("runs");
    assert_eq!(output.status.code(), Some(2), "an empty option is a mistake");
}
