//! Folders that others can write to: what they put there is never followed, emptied or waited for, and a link that is the output stays one.
//! The truth is what stood there before.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{chown, symlink};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::command::{builder, data, folder, stderr};
use crate::refused::contents;

const SECRET: &[u8] = b"what somebody wrote";

/// A command that writes to a place, with its status and what it says; one that waits for ever ends the test.
fn run(here: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let child = builder(here).args(arguments).stderr(std::process::Stdio::piped()).stdout(std::process::Stdio::null()).spawn();
    let mut child = child.expect("runs");
    for _ in 0..30_000 {
        if child.try_wait().expect("a status").is_some() {
            let output = child.wait_with_output().expect("ended");
            return (output.status.code(), stderr(&output));
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = child.kill();
    panic!("{arguments:?} waits for ever");
}

/// Commands that write, without their output, and the ending that it has.
fn commands() -> Vec<(Vec<String>, &'static str)> {
    let swc = data("broken-circle-of-willis.swc");
    let words = |line: &str| line.split(' ').map(|word| if word == "SWC" { swc.clone() } else { word.to_owned() }).collect();
    vec![
        (words("infer SWC -n 64 --dpi 36"), ""),
        (words("candidates SWC"), ".graphml"),
        (words("convert SWC"), ".swc"),
        (words("phantom arterial --edges 100"), ".csv"),
    ]
}

fn with_output(command: &[String], output: &str, more: &[&str]) -> Vec<String> {
    let option: &[&str] = if command[0] == "convert" { &[] } else { &["-o"] };
    let words = command.iter().map(String::as_str).chain(option.iter().copied());
    words.chain([output]).chain(more.iter().copied()).map(str::to_owned).collect()
}

/// Runs every command at another place beside a trap, then at the very place of the trap. `traps` are what it is made of, which must stay.
fn is_left_alone(trap: impl Fn(&Path, &str), at_the_place: bool) {
    for (command, ending) in commands() {
        let here = folder();
        trap(here.path(), &format!("x{ending}"));
        let before = contents(here.path());
        let hidden = || fs::symlink_metadata(here.path().join(format!(".willis-x{ending}"))).expect("stays").file_type();
        let kind = hidden();
        let beside = with_output(&command, &format!("anything{ending}"), &[]);
        let beside: Vec<&str> = beside.iter().map(String::as_str).collect();
        let (status, said) = run(here.path(), &beside);
        assert_eq!(status, Some(0), "{beside:?}: {said}");
        let after = contents(here.path());
        assert!(before.iter().all(|file| after.contains(file)), "{beside:?}");
        assert_eq!(hidden(), kind);

        let there = with_output(&command, &format!("x{ending}"), &[]);
        let there: Vec<&str> = there.iter().map(String::as_str).collect();
        let (status, said) = run(here.path(), &there);
        if at_the_place {
            assert_eq!(status, Some(2), "{there:?}: {said}");
            assert!(said.contains(".willis-x") && said.contains("remove it, or choose another"), "{said}");
            assert_eq!(hidden(), kind);
        }
        // The hidden folder is this user's own where the command may clear it; what its links point to stands outside.
        let own = |path: &Path| !at_the_place && path.to_string_lossy().starts_with(".willis-");
        let after = contents(here.path());
        assert!(before.iter().filter(|(path, _)| !own(path)).all(|file| after.contains(file)), "{there:?}");
    }
}

#[test]
fn a_lock_that_is_a_link_is_not_written() {
    is_left_alone(
        |here, name| {
            fs::write(here.join("victim"), SECRET).expect("written");
            fs::create_dir(here.join(format!(".willis-{name}"))).expect("made");
            symlink(here.join("victim"), here.join(format!(".willis-{name}/lock"))).expect("linked");
        },
        true,
    );
}

#[test]
fn a_lock_that_is_a_second_name_is_not_written() {
    is_left_alone(
        |here, name| {
            fs::write(here.join("victim"), SECRET).expect("written");
            fs::create_dir(here.join(format!(".willis-{name}"))).expect("made");
            fs::hard_link(here.join("victim"), here.join(format!(".willis-{name}/lock"))).expect("linked");
        },
        true,
    );
}

#[test]
fn a_hidden_folder_that_is_a_link_keeps_its_contents() {
    is_left_alone(
        |here, name| {
            for part in ["precious/new", "precious/old"] {
                fs::create_dir_all(here.join(part)).expect("made");
                fs::write(here.join(part).join("file"), SECRET).expect("written");
            }
            fs::write(here.join("precious/some.unfinished"), SECRET).expect("written");
            fs::write(here.join("precious/lock"), SECRET).expect("written");
            symlink("precious", here.join(format!(".willis-{name}"))).expect("linked");
        },
        true,
    );
}

/// A pipe that nobody reads makes who opens it wait.
#[test]
fn a_lock_that_is_a_pipe_is_not_waited_for() {
    for (command, ending) in commands() {
        let here = folder();
        let hidden = here.path().join(format!(".willis-x{ending}"));
        fs::create_dir(&hidden).expect("made");
        assert!(Command::new("mkfifo").arg(hidden.join("lock")).status().expect("mkfifo").success());
        for (name, status) in [("anything", 0), ("x", 2)] {
            let words = with_output(&command, &format!("{name}{ending}"), &[]);
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let (ended, said) = run(here.path(), &words);
            assert_eq!(ended, Some(status), "{words:?}: {said}");
        }
    }
}

/// Only the superuser can make files of others: elsewhere this test says that it is skipped.
#[test]
fn what_another_user_left_is_left_to_them() {
    let probe = folder();
    fs::write(probe.path().join("a"), "").expect("written");
    if chown(probe.path().join("a"), Some(12_345), None).is_err() {
        eprintln!("skipped: only the superuser can make files of another user");
        return;
    }
    is_left_alone(
        |here, name| {
            let hidden = here.join(format!(".willis-{name}"));
            fs::create_dir_all(hidden.join("new")).expect("made");
            for file in ["lock", "new/file"] {
                fs::write(hidden.join(file), SECRET).expect("written");
                chown(hidden.join(file), Some(12_345), None).expect("given");
            }
            for at in [hidden.join("new"), hidden] {
                chown(at, Some(12_345), None).expect("given");
            }
        },
        true,
    );
}

/// Links in a hidden folder of this user's are removed, and what they point to stays.
#[test]
fn links_in_the_hidden_folder_go_and_what_they_point_to_stays() {
    is_left_alone(
        |here, name| {
            for part in ["precious", "older"] {
                fs::create_dir(here.join(part)).expect("made");
                fs::write(here.join(part).join("file"), SECRET).expect("written");
            }
            let hidden = here.join(format!(".willis-{name}"));
            fs::create_dir(&hidden).expect("made");
            symlink(here.join("precious"), hidden.join("new")).expect("linked");
            symlink(here.join("older"), hidden.join("old")).expect("linked");
            symlink(here.join("precious/file"), hidden.join("a.unfinished")).expect("linked");
        },
        false,
    );
}

/// A link to an earlier output stays, and what it points to is written anew, wherever that is.
#[test]
fn an_output_that_is_a_link_is_followed() {
    for (command, ending) in commands() {
        let here = folder();
        fs::create_dir(here.path().join("far")).expect("made");
        let first = with_output(&command, &format!("far/real{ending}"), &[]);
        assert_eq!(run(here.path(), &first.iter().map(String::as_str).collect::<Vec<_>>()).0, Some(0));
        symlink(format!("far/real{ending}"), here.path().join(format!("link{ending}"))).expect("linked");
        let again = with_output(&command, &format!("link{ending}"), &["--force"]);
        let (status, said) = run(here.path(), &again.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(status, Some(0), "{again:?}: {said}");
        let link = here.path().join(format!("link{ending}"));
        assert!(fs::symlink_metadata(&link).expect("stays").is_symlink(), "{again:?}");
        assert!(link.exists());
        for place in [here.path(), &here.path().join("far")] {
            let names = fs::read_dir(place).expect("a folder").map(|e| e.expect("an entry").file_name());
            let hidden: Vec<_> = names.filter(|name| name.as_encoded_bytes().starts_with(b".")).collect();
            assert!(hidden.is_empty(), "{hidden:?}");
        }
    }
}

/// What can only fail at the end is refused at the beginning.
#[test]
fn what_cannot_be_replaced_is_refused_before_the_work() {
    let swc = data("broken-circle-of-willis.swc");
    let here = folder();
    fs::create_dir(here.path().join("sub")).expect("made");
    symlink("nowhere", here.path().join("dangling")).expect("linked");
    for (output, words) in [
        (".", "the current folder"),
        ("..", "the current folder"),
        ("sub/..", "the current folder"),
        ("/", "the current folder"),
        ("/dev/null", "is a device or a pipe"),
        ("/proc", "is where a file system is mounted"),
        ("dangling", "is a link to nothing"),
    ] {
        let (status, said) = run(here.path(), &["infer", &swc, "-o", output, "-n", "1000000000000", "--force"]);
        assert_eq!(status, Some(2), "{output}: {said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{output}: {said}");
    }
    assert!(here.path().join("sub").exists());
}
