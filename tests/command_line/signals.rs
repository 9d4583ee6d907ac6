//! Ctrl-C, SIGTERM and SIGHUP: one is a request, two are an order, and those that were ignored before the command began stay so. The
//! truth is POSIX: `nohup` and background jobs of a script ignore signals, and a signal's default action ends a process.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use crate::command::builder;

/// The command with signals set before it begins: `set` is `--default-signal=..` or `--ignore-signal=..` of GNU `env`, which other systems
/// lack. A script's job in the background, which these tests may be, has SIGINT ignored.
pub fn with_signals(folder: &Path, set: &str) -> Command {
    if !cfg!(target_os = "linux") {
        return builder(folder);
    }
    let mut command = Command::new("env");
    command.args([set, env!("CARGO_BIN_EXE_willis")]).current_dir(folder);
    command
}

#[cfg(target_os = "linux")]
mod linux {
    use std::io::{BufRead, BufReader, Write};
    use std::os::unix::process::ExitStatusExt;
    use std::process::Stdio;
    use std::thread::sleep;
    use std::time::Duration;

    use super::with_signals;
    use crate::checkpoint::{kept, run, signal, wait_until};
    use crate::command::{data, folder, stderr};

    /// Longer than two signals that are one request.
    const APART: Duration = Duration::from_millis(600);

    /// A terminal that closes sends SIGHUP: without `nohup` the run stops and keeps its sums, with it the run does not hear.
    #[test]
    fn signals_that_were_ignored_at_the_start_stay_ignored() {
        for (set, name, status) in [
            ("--ignore-signal=HUP", "-HUP", 0),
            ("--default-signal=HUP", "-HUP", 1),
            ("--ignore-signal=INT", "-INT", 0),
            ("--ignore-signal=HUP", "-TERM", 1),
        ] {
            let here = folder();
            let arguments = run(here.path(), &["--checkpoint=0"]);
            let child = with_signals(here.path(), set).args(&arguments).stderr(Stdio::piped()).spawn().expect("runs");
            wait_until(|| kept(here.path()) > 0);
            signal(&child, name);
            let output = child.wait_with_output().expect("ends");
            assert_eq!(output.status.code(), Some(status), "{set} {name}: {}", stderr(&output));
            assert_eq!(here.path().join("out/run.json").exists(), status == 0, "{set} {name}");
        }
    }

    /// `timeout` signals the process and its group: that is one request, and what was sampled is kept.
    #[test]
    fn a_signal_that_comes_twice_at_once_is_one() {
        let here = folder();
        let swc = data("broken-circle-of-willis.swc");
        let arguments = ["infer", &swc, "-o", "out", "-n", "1000000000000", "--checkpoint=0"];
        let mut command = with_signals(here.path(), "--default-signal=TERM");
        let child = command.args(arguments).stderr(Stdio::piped()).spawn().expect("runs");
        wait_until(|| kept(here.path()) > 0);
        signal(&child, "-TERM");
        signal(&child, "-TERM");
        let output = child.wait_with_output().expect("ends");
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains("which are kept"), "{}", stderr(&output));
    }

    /// `measure` keeps nothing of many subjects that it was stopped at, and says so.
    #[test]
    fn a_measurement_that_is_stopped_leaves_nothing() {
        let here = folder();
        let names: Vec<String> = (0..40).map(|at| format!("s{at}.nii.gz")).collect();
        for name in &names {
            std::fs::copy(data("scan.nii.gz"), here.path().join(name)).expect("copied");
        }
        let mut command = with_signals(here.path(), "--default-signal=TERM");
        let words = ["measure", "-o", "out", "--threads", "1"].into_iter().chain(names.iter().map(String::as_str));
        let mut child = command.args(words).stderr(Stdio::piped()).spawn().expect("runs");
        let mut said = BufReader::new(child.stderr.take().expect("a stream")).lines().map(|line| line.expect("text"));
        assert!(said.by_ref().any(|line| line.contains("done  1/40")));
        signal(&child, "-TERM");
        let last = said.last().expect("a line");
        assert!(last.starts_with("willis: stopped with") && last.ends_with("done; nothing is written"), "{last}");
        assert_eq!(child.wait().expect("ends").code(), Some(1));
        assert!(!here.path().join("out").exists());
    }

    /// A command that waits for ever, here for a reader of its JSON, ends at the second signal by that signal.
    #[test]
    fn a_second_signal_ends_a_command_that_hangs() {
        let here = folder();
        let (_reader, mut writer) = std::io::pipe().expect("a pipe");
        writer.write_all(&vec![0; 1 << 16]).expect("full");
        let swc = data("broken-circle-of-willis.swc");
        let mut command = with_signals(here.path(), "--default-signal=TERM");
        let mut child = command
            .args(["infer", &swc, "-o", "out", "-n", "64", "--json", "-q"])
            .stdout(Stdio::from(writer))
            .spawn()
            .expect("runs");
        wait_until(|| here.path().join("out/run.json").exists());
        sleep(APART);
        signal(&child, "-TERM");
        sleep(APART);
        assert!(child.try_wait().expect("a status").is_none(), "one signal is a request");
        signal(&child, "-TERM");
        for _ in 0..100 {
            if child.try_wait().expect("a status").is_some() {
                break;
            }
            sleep(APART / 10);
        }
        let ended = child.try_wait().expect("a status");
        let _ = child.kill();
        assert_eq!(ended.and_then(|status| status.signal()), Some(15));
    }
}
