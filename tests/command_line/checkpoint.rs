//! Nothing is lost: what a kill, a stop or a full disk leaves of a run is gone on with to the same bytes, and what stood before
//! stands until then.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::command::{data, folder, stderr, willis};
use crate::refused::contents;
use crate::signals::with_signals;

/// A run of a second or two in release builds.
const LONG: [&str; 6] = ["-n", "4000000", "--threads", "2", "--dpi", "40"];

pub fn run(here: &Path, more: &[&str]) -> Vec<String> {
    fs::copy(data("broken-circle-of-willis.swc"), here.join("a.swc")).expect("copied");
    [&["infer", "a.swc", "-o", "out"], &LONG[..], more].concat().into_iter().map(str::to_owned).collect()
}

fn words(arguments: &[String]) -> Vec<&str> {
    arguments.iter().map(String::as_str).collect()
}

fn spawn(here: &Path, arguments: &[String]) -> Child {
    with_signals(here, "--default-signal=INT,TERM,HUP").args(arguments).stderr(Stdio::piped()).spawn().expect("runs")
}

/// The command in full, in a folder of its own.
fn truth(more: &[&str]) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let here = folder();
    let arguments = run(here.path(), more);
    let output = willis(here.path(), &words(&arguments));
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(hidden(here.path()).is_empty());
    contents(&here.path().join("out"))
}

fn hidden(here: &Path) -> Vec<String> {
    let names = fs::read_dir(here).expect("a folder").map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with('.')).collect()
}

/// What is kept beside `out`, in bytes.
pub fn kept(here: &Path) -> u64 {
    let entries = fs::read_dir(here.join(".willis-out")).into_iter().flatten().flatten();
    entries.filter(|e| e.path().extension().is_some_and(|e| e == "part")).filter_map(|e| e.metadata().ok()).map(|m| m.len()).sum()
}

pub fn wait_until(what: impl Fn() -> bool) {
    let start = Instant::now();
    while !what() && start.elapsed() < Duration::from_mins(1) {
        sleep(Duration::from_millis(2));
    }
}

pub fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().expect("kill").success());
}

fn resumed(output: &Output) -> bool {
    stderr(output).lines().any(|line| line.trim_start().starts_with("resumed"))
}

/// Killed at moments all over a run, twice in a row, and gone on with. `WILLIS_KILLS` asks for more than a few.
#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes() {
    let kills = std::env::var("WILLIS_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(4_u64);
    let whole = truth(&["--checkpoint=0"]);
    let (mut killed, mut went_on, mut moment) = (0, 0, 12_345_u64);
    while killed < kills {
        let here = folder();
        let arguments = run(here.path(), &["--checkpoint=0"]);
        for _ in 0..2 {
            let mut child = spawn(here.path(), &arguments);
            moment = moment.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            if killed % 4 == 0 {
                wait_until(|| kept(here.path()) > 0 || here.path().join("out").exists());
            }
            sleep(Duration::from_millis((moment >> 33) % 600));
            // One that is done already stays so.
            let _ = child.kill();
            child.wait().expect("gone");
        }
        let out = here.path().join("out");
        if out.exists() {
            assert_eq!(contents(&out), whole, "it appears whole or not at all");
            continue;
        }
        killed += 1;
        let output = willis(here.path(), &words(&arguments));
        assert!(output.status.success(), "{}", stderr(&output));
        went_on += usize::from(resumed(&output));
        assert_eq!(contents(&out), whole, "kill {killed}");
        assert!(hidden(here.path()).is_empty(), "{:?}", hidden(here.path()));
    }
    eprintln!("{killed} runs killed twice, {went_on} went on from what was kept");
    assert!(went_on > 0);
}

/// Ctrl-C and SIGTERM keep what is finished, however short the run has been, and say where.
#[test]
fn a_run_that_is_stopped_says_what_it_keeps_and_goes_on() {
    let whole = truth(&["--epsilon", "0.3,0.5"]);
    for name in ["-INT", "-TERM"] {
        let here = folder();
        let arguments = run(here.path(), &["--epsilon", "0.3,0.5"]);
        let child = spawn(here.path(), &arguments);
        // It listens from before this folder is there.
        wait_until(|| here.path().join(".willis-out/new/epsilon-0.3").exists());
        sleep(Duration::from_millis(150));
        signal(&child, name);
        let output = child.wait_with_output().expect("ends");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        let last = said.lines().last().expect("an error");
        assert!(last.starts_with("willis: stopped after") && last.contains("kept in .willis-out"), "{said}");
        assert!(!here.path().join("out").exists() && kept(here.path()) > 0);
        let output = willis(here.path(), &words(&arguments));
        assert!(output.status.success() && resumed(&output), "{}", stderr(&output));
        assert!(!stderr(&output).contains("another run"), "{}", stderr(&output));
        assert_eq!(contents(&here.path().join("out")), whole);
        assert!(hidden(here.path()).is_empty());
    }
}

/// A run until stable goes on as well.
#[test]
fn a_run_until_stable_goes_on() {
    let here = folder();
    // The median of L is undecided for long.
    let all = run(here.path(), &["--until", "stable", "--keep", "median"]);
    let all: Vec<String> = all.into_iter().filter(|word| !["-n", "4000000"].contains(&word.as_str())).collect();
    let output = willis(here.path(), &words(&all));
    assert!(output.status.success(), "{}", stderr(&output));
    let whole = contents(&here.path().join("out"));
    fs::rename(here.path().join("out"), here.path().join("whole")).expect("renamed");
    let arguments: Vec<String> = all.into_iter().chain(["--checkpoint=0".to_owned()]).collect();
    let mut child = spawn(here.path(), &arguments);
    wait_until(|| kept(here.path()) > 0 || here.path().join("out").exists());
    child.kill().expect("killed");
    child.wait().expect("gone");
    if !here.path().join("out").exists() {
        let output = willis(here.path(), &words(&arguments));
        assert!(output.status.success() && resumed(&output), "{}", stderr(&output));
    }
    assert_eq!(contents(&here.path().join("out")), whole);
}

/// What another command left is neither used nor lost: it is told of, and its command goes on with it.
#[test]
fn what_another_run_left_stays_for_it() {
    let here = folder();
    let first = run(here.path(), &["--checkpoint=0"]);
    let mut child = spawn(here.path(), &first);
    wait_until(|| kept(here.path()) > 0);
    child.kill().expect("killed");
    child.wait().expect("gone");
    assert!(!here.path().join("out").exists());
    let other = willis(here.path(), &["infer", "a.swc", "-o", "out", "-n", "64", "--dpi", "40"]);
    let said = stderr(&other);
    assert!(other.status.success() && !resumed(&other), "{said}");
    assert!(said.contains(".willis-out also keeps") && said.contains("another run: willis infer a.swc -n 4000000"), "{said}");
    let again: Vec<&str> = words(&first).into_iter().chain(["--force"]).collect();
    let output = willis(here.path(), &again);
    assert!(output.status.success() && resumed(&output), "{}", stderr(&output));
    assert!(hidden(here.path()).is_empty());
}

/// A damaged file is said to be one, and the run begins anew.
#[test]
fn what_is_kept_and_damaged_is_not_used() {
    let here = folder();
    let arguments = run(here.path(), &["--checkpoint=0"]);
    let mut child = spawn(here.path(), &arguments);
    wait_until(|| kept(here.path()) > 0);
    child.kill().expect("killed");
    child.wait().expect("gone");
    for entry in fs::read_dir(here.path().join(".willis-out")).expect("kept").flatten() {
        if entry.path().extension().is_some_and(|e| e == "part") {
            let bytes = fs::read(entry.path()).expect("bytes");
            fs::write(entry.path(), &bytes[..bytes.len() / 2]).expect("written");
        }
    }
    let output = willis(here.path(), &words(&arguments));
    assert!(output.status.success() && stderr(&output).contains("the run begins anew"), "{}", stderr(&output));
    assert_eq!(contents(&here.path().join("out")), truth(&["--checkpoint=0"]));
}

/// While one run is at an output, no other is; once it is killed, the next one is free to.
#[test]
fn two_runs_at_one_output_are_one_too_many() {
    let here = folder();
    let mut arguments = run(here.path(), &["--checkpoint=off"]);
    arguments[5] = "1000000000000".to_owned();
    assert_eq!(arguments[4], "-n");
    let mut child = spawn(here.path(), &arguments);
    wait_until(|| here.path().join(".willis-out/new").exists());
    let before = fs::read_dir(here.path().join(".willis-out")).expect("a folder").count();
    for second in [&["infer", "a.swc", "-o", "out", "-n", "64"][..], &["simulate", "a.swc", "-o", "./out", "--force"]] {
        let output = willis(here.path(), second);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        let last = said.lines().last().expect("an error");
        assert!(last.contains("out: another willis (process ") && last.contains(&child.id().to_string()), "{said}");
        assert_eq!(fs::read_dir(here.path().join(".willis-out")).expect("a folder").count(), before);
    }
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "other", "-n", "64", "-q"]).status.success());
    child.kill().expect("killed");
    child.wait().expect("gone");
    assert_eq!(hidden(here.path()), [".willis-out"]);
    // A command at another output leaves what there is; one at this output clears it.
    fs::create_dir(here.path().join(".willis-mine")).expect("made");
    fs::write(here.path().join(".willis-mine/new"), "precious").expect("written");
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "third", "-n", "64", "-q"]).status.success());
    let mut left = hidden(here.path());
    left.sort();
    assert_eq!(left, [".willis-mine", ".willis-out"]);
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "out", "-n", "64", "-q"]).status.success());
    assert_eq!(hidden(here.path()), [".willis-mine"]);
    assert_eq!(fs::read(here.path().join(".willis-mine/new")).expect("there"), b"precious");
}

/// A kill between the two renames of a replacement leaves the earlier output aside; the next command puts it back.
#[test]
fn an_output_that_was_put_aside_comes_back() {
    let here = folder();
    fs::copy(data("broken-circle-of-willis.swc"), here.path().join("a.swc")).expect("copied");
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "out", "-n", "64", "-q"]).status.success());
    let before = contents(&here.path().join("out"));
    fs::create_dir_all(here.path().join(".willis-out/new")).expect("made");
    fs::write(here.path().join(".willis-out/lock"), "").expect("written");
    fs::rename(here.path().join("out"), here.path().join(".willis-out/old")).expect("renamed");
    let output = willis(here.path(), &["infer", "a.swc", "-o", "out", "-n", "64"]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("exists already"), "{}", stderr(&output));
    assert_eq!(contents(&here.path().join("out")), before);
    assert!(hidden(here.path()).is_empty());
}

/// Nothing larger than 100 KB can be written: that is known before the work begins, and what stood stands.
#[test]
fn a_limit_on_files_is_known_before_the_work() {
    let here = folder();
    let arguments = run(here.path(), &["--force"]);
    assert!(willis(here.path(), &["infer", "a.swc", "-o", "out", "-n", "64", "-q"]).status.success());
    let before = contents(here.path());
    for trap in ["trap '' XFSZ; ", ""] {
        let mut limited = Command::new("bash");
        limited.current_dir(here.path()).arg("-c").arg(format!("{trap}ulimit -f 100; exec \"$@\""));
        let output = limited.args(["bash", env!("CARGO_BIN_EXE_willis")]).args(&arguments).output().expect("bash");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with("willis: --output out: files may have 102400 bytes at most here"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert_eq!(contents(here.path()), before);
    }
}

/// On a disk of 1 MB: the error is clear, what stood (why there was no run) stands, and what was finished when the disk was full is gone on
/// with. Needs the right to mount one.
#[test]
fn a_full_disk_leaves_what_stood_and_what_was_finished() {
    let here = folder();
    let disk = here.path().join("disk");
    fs::create_dir(&disk).expect("made");
    let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=1M", "tmpfs"]).arg(&disk).output();
    if !mounted.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: no right to mount a disk of 1 MB");
        return;
    }
    let arguments = run(&disk, &["--checkpoint=0", "--force"]);
    fs::write(disk.join("bad.swc"), "1 0 a b c d -1\n").expect("written");
    let small = willis(&disk, &["infer", "bad.swc", "-o", "out", "--record-failure", "-q"]);
    let before = contents(&disk.join("out"));
    let output = willis(&disk, &words(&arguments));
    let (after, kept) = (contents(&disk.join("out")), kept(&disk));
    let copied = Command::new("cp").arg("-r").args([disk.join(".willis-out"), disk.join("a.swc")]).arg(here.path()).status();
    assert!(Command::new("umount").arg(&disk).status().expect("umount").success());
    assert!(small.status.success() && !before.is_empty(), "{}", stderr(&small));
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let last = said.lines().last().expect("an error");
    assert!(last.starts_with("willis: out/") && last.contains("cannot be written: No space left on device"), "{said}");
    // With `-q` too, for it is part of the error.
    assert!(last.contains("samples are kept in .willis-out, and the same command goes on from there"), "{said}");
    assert!(after == before && kept > 0 && copied.expect("cp").success());
    let output = willis(here.path(), &words(&arguments));
    assert!(output.status.success() && resumed(&output), "{}", stderr(&output));
    assert_eq!(contents(&here.path().join("out")), truth(&[]));
}

/// A reader that goes away is no fault, and nothing is said of it.
#[test]
fn a_broken_pipe_is_quiet() {
    let here = folder();
    fs::copy(data("broken-circle-of-willis.swc"), here.path().join("a.swc")).expect("copied");
    for arguments in ["man", "completions bash", "--help", "infer --help", "infer a.swc -o out -n 64 -q --json --dpi 40"] {
        let line = format!("set -o pipefail; \"$0\" {arguments} | true");
        let mut shell = Command::new("bash");
        let output = shell.current_dir(here.path()).args(["-c", &line, env!("CARGO_BIN_EXE_willis")]).output().expect("bash");
        assert!(output.status.success() && output.stderr.is_empty(), "{arguments}: {}", stderr(&output));
    }
    assert!(here.path().join("out/run.json").exists());
}

/// A cohort that is killed goes on within the subject that it was at, and a second command at it is one too many.
#[test]
fn a_cohort_goes_on_within_a_subject() {
    let here = folder();
    for name in ["a.swc", "b.swc"] {
        fs::copy(data("broken-circle-of-willis.swc"), here.path().join(name)).expect("copied");
    }
    let arguments = [&["infer", "a.swc", "b.swc", "-o", "out", "--checkpoint=0"], &LONG[..]].concat();
    let mut child = spawn(here.path(), &arguments.iter().map(ToString::to_string).collect::<Vec<_>>());
    let is_kept = |name: &str| {
        let kept = fs::read_dir(here.path().join("out").join(name)).into_iter().flatten().flatten();
        kept.filter(|e| e.path().extension().is_some_and(|e| e == "part")).count() > 0
    };
    wait_until(|| is_kept(".willis-a") || is_kept(".willis-b"));
    let second = willis(here.path(), &arguments);
    assert!(second.status.code() == Some(2) && stderr(&second).contains("another willis"), "{}", stderr(&second));
    child.kill().expect("killed");
    child.wait().expect("gone");
    let output = willis(here.path(), &[&arguments[..], &["-v"]].concat());
    assert!(output.status.success() && resumed(&output), "{}", stderr(&output));
    assert!(hidden(here.path()).is_empty() && hidden(&here.path().join("out")).is_empty());
    assert_eq!(contents(&here.path().join("out/a")), truth(&["--landmarks", "auto"]));
}
