//! Commands that write several files: killed at any rename, the same command completes the set, and never takes a file of somebody else for
//! its own. The truth is the set that a command makes which nobody kills.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Command;

use crate::command::{data, folder, stderr, willis};
use crate::refused::{contents, refused};

/// Commands with the file that they name.
fn commands() -> Vec<(Vec<String>, &'static str)> {
    let swc = data("broken-circle-of-willis.swc");
    let words = |line: &str| line.split(' ').map(|word| if word == "SWC" { swc.clone() } else { word.to_owned() }).collect();
    vec![
        (words("convert SWC c.csv"), "c.csv"),
        (words("phantom cerebral --break -o q.swc"), "q.swc"),
        (words("label SWC -o lab.vtp"), "lab.vtp"),
        (words("phantom circle-of-willis --break -o p.swc"), "p.swc"),
        (words("phantom arterial --edges 100 --break -o g.csv"), "g.csv"),
    ]
}

const RENAMES: &str = "rename,renameat,renameat2";

/// Runs a command that is killed as it begins its `at`-th call of a kind; whether it was.
fn killed_at(here: &Path, words: &[String], calls: &str, at: usize) -> bool {
    let [trace, inject] = [format!("trace={calls}"), format!("inject={calls}:signal=KILL:when={at}")];
    let mut strace = Command::new("strace");
    strace.args(["-f", "-qq", "-o", "/dev/null", "-e", &trace, "-e", &inject]);
    let output = strace.arg(env!("CARGO_BIN_EXE_willis")).args(words).current_dir(here).output().expect("strace runs");
    output.status.signal() == Some(9) || output.status.code() == Some(128 + 9)
}

fn killed(here: &Path, words: &[String], at: usize) -> bool {
    killed_at(here, words, RENAMES, at)
}

/// Whether there is a strace that may trace; elsewhere the tests say that they are skipped.
fn can_trace() -> bool {
    let traced = Command::new("strace").args(["-o", "/dev/null", "true"]).output().is_ok_and(|output| output.status.success());
    if !traced {
        eprintln!("skipped: no strace that may trace");
    }
    traced
}

fn again(here: &Path, words: &[String]) -> (Option<i32>, String) {
    let output = willis(here, &words.iter().map(String::as_str).collect::<Vec<_>>());
    (output.status.code(), stderr(&output))
}

#[test]
fn a_command_that_is_killed_at_a_rename_is_completed_by_the_same_command() {
    if !can_trace() {
        return;
    }
    for (words, main) in commands() {
        let whole = folder();
        assert_eq!(again(whole.path(), &words).0, Some(0), "{words:?}");
        let whole = contents(whole.path());
        // To name arteries takes seconds: in the middle of its set, unless more is asked for.
        let is_long = words[0] == "label" && std::env::var_os("WILLIS_KILLS").is_none();
        let mut renames = if is_long { 2 } else { 0 };
        loop {
            let here = folder();
            if !killed(here.path(), &words, renames + 1) {
                break;
            }
            renames += 1;
            // Twice, so that what the second kill leaves is the mixture of two.
            if renames > 1 && !is_long {
                killed(here.path(), &words, renames - 1);
            }
            let (status, said) = again(here.path(), &words);
            if here.path().join(main).exists() && status == Some(2) {
                assert!(said.contains("exists already"), "{said}");
            } else {
                assert_eq!(status, Some(0), "{words:?} killed at rename {renames}: {said}");
            }
            assert!(contents(here.path()) == whole, "{words:?} killed at rename {renames}");
            if is_long {
                break;
            }
        }
        assert!(renames >= 3, "{words:?}: {renames} renames");
    }
}

/// A run that is killed when its output is whole, and only its lock is left, leaves that to the next, which says that the output is there.
#[test]
fn a_command_that_is_killed_at_its_end_leaves_nothing_hidden_for_long() {
    if !can_trace() {
        return;
    }
    for (words, main) in commands().into_iter().filter(|(words, _)| words[0] == "convert" || words[0] == "phantom") {
        let mut left = 0;
        for at in 1.. {
            let here = folder();
            if !killed_at(here.path(), &words, "unlink,unlinkat,rmdir", at) {
                break;
            }
            let whole = here.path().join(main).exists();
            left += usize::from(whole && here.path().join(format!(".willis-{main}")).exists());
            assert_eq!(again(here.path(), &words).0, Some(if whole { 2 } else { 0 }), "{words:?} killed at removal {at}");
            let hidden = |name: &str| name.starts_with('.');
            let names = fs::read_dir(here.path()).expect("a folder").map(|e| e.expect("a name").file_name());
            assert!(!names.into_iter().any(|name| hidden(&name.to_string_lossy())), "{words:?} killed at removal {at}");
        }
        assert!(left > 0, "{words:?}");
    }
}

#[test]
fn a_file_that_somebody_put_there_since_is_not_taken_for_its_own() {
    if !can_trace() {
        return;
    }
    // One that is moved there, and one that is written into the file of the killed command, so that it has what the file system calls that.
    for is_moved in [true, false] {
        let here = folder();
        let (words, _) = commands().swap_remove(0);
        let nodes = here.path().join("c.nodes.csv");
        let at = (1..9).find(|at| killed(here.path(), &words, *at) && nodes.exists()).expect("the table of nodes comes first");
        if is_moved {
            fs::write(here.path().join("mine"), "mine").expect("written");
            fs::rename(here.path().join("mine"), &nodes).expect("moved");
        } else {
            fs::write(&nodes, "mine").expect("written");
        }
        let (status, said) = again(here.path(), &words);
        assert!(status == Some(2) && said.contains("c.nodes.csv: exists already"), "{at}: {said}");
        assert_eq!(fs::read(&nodes).expect("there"), b"mine");
    }
}

/// A disk that falters once at the removal of a lock leaves no lock: each removal of `merge` is tried once more. The truth is what stands when
/// no call fails.
#[test]
fn a_lock_that_cannot_be_removed_at_first_is_removed() {
    if !can_trace() {
        return;
    }
    let here = folder();
    let swc = fs::read(data("broken-circle-of-willis.swc")).expect("there");
    for name in ["a", "b"] {
        fs::write(here.path().join(format!("{name}.swc")), [swc.as_slice(), b"# ", name.as_bytes(), b"\n"].concat())
            .expect("written");
        let input = format!("{name}.swc");
        assert!(willis(here.path(), &["infer", &input, "-o", name, "-n", "64", "--dpi", "36", "-q"]).status.success());
    }
    let mut calls = 0;
    loop {
        let inject = format!("inject=unlink:error=EIO:when={}", calls + 1);
        let mut strace = Command::new("strace");
        strace.args(["-f", "-qq", "-o", "log", "-e", "trace=unlink", "-e", &inject, env!("CARGO_BIN_EXE_willis")]);
        let output = strace.args(["merge", "a", "b", "-o", "c", "-q"]).current_dir(here.path()).output().expect("strace runs");
        if !fs::read_to_string(here.path().join("log")).expect("a log").contains("INJECTED") {
            break;
        }
        calls += 1;
        let names = |path: &Path| fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.file_name()).collect::<Vec<_>>();
        let hidden = [here.path().to_owned(), here.path().join("c")]
            .iter()
            .flat_map(|path| names(path))
            .find(|name| name.as_encoded_bytes()[0] == b'.');
        assert_eq!(hidden, None, "unlink {calls}: {}", stderr(&output));
        let _ = fs::remove_dir_all(here.path().join("c"));
    }
    assert!(calls > 5, "{calls}");
}

#[test]
fn a_name_that_is_too_long_is_refused_before_the_work() {
    let swc = data("broken-circle-of-willis.swc");
    let long = "a".repeat(246);
    refused(&[], &["label", &swc, "-o", &format!("{long}.vtp")], &["--output", "256 bytes", "choose a shorter one"]);
    refused(&[], &["convert", &swc, &format!("{long}.csv")], &["256 bytes"]);
    refused(&[], &["phantom", "circle-of-willis", "--break", "-o", &format!("{long}.swc")], &["257 bytes"]);
}
