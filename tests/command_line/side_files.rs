//! Files that nobody named: beside an input, in a folder, found by a pattern. One that is there and cannot be read is an error, never absent,
//! and a pipe is not waited for. The truth is what was put there.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::checkpoint;
use crate::command::{builder, data, folder, stderr, willis};

/// The status of a command and what it says; one that waits for ever ends the test.
fn run(here: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut child = builder(here).args(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("runs");
    let start = Instant::now();
    while child.try_wait().expect("a status").is_none() && start.elapsed() < Duration::from_mins(4) {
        std::thread::sleep(Duration::from_millis(10));
    }
    let has_ended = child.try_wait().expect("a status").is_some();
    let _ = child.kill();
    let output = child.wait_with_output().expect("ended");
    assert!(has_ended, "{arguments:?} waits for ever");
    (output.status.code(), stderr(&output))
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}

/// What may stand in the place of a file, and the word for it.
const TRAPS: [&str; 3] = ["a link to nowhere, which is not there", "a folder", "a pipe"];

fn put(trap: &str, path: &Path) {
    match trap {
        "a folder" => fs::create_dir(path).expect("made"),
        "a pipe" => pipe(path),
        _ => symlink("nowhere", path).expect("linked"),
    }
}

/// A command that must be refused, naming the file and why.
fn refused(here: &Path, arguments: &[&str], words: &[&str]) {
    let (status, said) = run(here, arguments);
    assert_eq!(status, Some(2), "{arguments:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {words:?} in {said}");
}

#[test]
fn a_table_of_nodes_that_cannot_be_read_is_not_absent() {
    let here = folder();
    assert!(willis(here.path(), &["phantom", "arterial", "--edges", "100", "-o", "c.csv"]).status.success());
    let nodes = here.path().join("c.nodes.csv");
    fs::remove_file(&nodes).expect("there");
    refused(here.path(), &["simulate", "c.csv", "-o", "out"], &["c.csv: its table of nodes, c.nodes.csv, is not there"]);
    for trap in TRAPS {
        put(trap, &nodes);
        refused(here.path(), &["simulate", "c.csv", "-o", "out"], &["c.nodes.csv: ", trap, "expected a regular file"]);
        let _ = fs::remove_file(&nodes).or_else(|_| fs::remove_dir(&nodes));
    }
}

#[test]
fn every_file_beside_an_input_is_a_regular_one() {
    for trap in TRAPS {
        for (name, words) in [
            ("Image_info.txt", &["convert", "a.swc", "b.vtp"][..]),
            ("Feature_Vessel.csv", &["convert", "a.swc", "b.vtp"]),
            ("Image_info.txt", &["infer", "a.swc", "--spacing", "auto", "-o", "out"]),
            ("voxels.raw", &["skeleton", "m.mhd", "-o", "b.vtp"]),
        ] {
            let here = folder();
            fs::copy(data("broken-circle-of-willis.swc"), here.path().join("a.swc")).expect("copied");
            let header = "ObjectType = Image\nNDims = 3\nDimSize = 8 8 8\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\n\
                          ElementDataFile = voxels.raw\n";
            fs::write(here.path().join("m.mhd"), header).expect("written");
            put(trap, &here.path().join(name));
            refused(here.path(), words, &[name, trap, "expected a regular file"]);
        }
    }
}

#[test]
fn what_a_pattern_finds_and_nobody_can_read_is_a_row() {
    let here = folder();
    for name in ["a", "b", "c"] {
        fs::create_dir_all(here.path().join("scans").join(name)).expect("made");
    }
    let scan = |name: &str| here.path().join("scans").join(name).join("lines.swc");
    // One vessel, in which no artery is looked for.
    fs::write(scan("a"), "1 0 0 0 0 1 -1\n2 0 10 0 0 1 1\n3 0 20 0 0 1 2\n").expect("written");
    put(TRAPS[0], &scan("b"));
    put("a pipe", &scan("c"));
    let few = ["-n", "64", "--dpi", "36"];
    // The last name may be a pattern or not.
    for (pattern, output) in [("scans/*/*.swc", "one"), ("scans/*/lines.swc", "two")] {
        let (status, said) = run(here.path(), &[&["infer", pattern, "-o", output], &few[..]].concat());
        assert_eq!(status, Some(1), "{said}");
        assert!(said.contains("2 of 3 subjects failed"), "{said}");
        let table = fs::read_to_string(here.path().join(output).join("cohort.csv")).expect("a table");
        assert_eq!(table.lines().count(), 4, "{table}");
        assert!(table.contains("a link to nowhere, which is not there") && table.contains("a pipe"), "{table}");
    }
    let (status, said) = run(here.path(), &["measure", "scans/*/*.swc", "-o", "measured"]);
    assert_eq!(status, Some(1), "{said}");
    let table = fs::read_to_string(here.path().join("measured/subjects.csv")).expect("a table");
    assert!(table.contains("a link to nowhere, which is not there") && table.contains("a pipe"), "{table}");
    refused(here.path(), &["measure", "scans/c/*.swc", "-o", "alone"], &["lines.swc", "a pipe", "expected a regular file"]);
}

#[test]
fn the_files_of_a_run_are_regular_ones() {
    let here = folder();
    let swc = data("broken-circle-of-willis.swc");
    let made =
        ["infer", &swc, "--landmarks", &data("broken-circle-of-willis.landmarks.csv"), "-o", "run", "-n", "64", "--dpi", "36"];
    assert!(willis(here.path(), &made).status.success());
    for name in ["candidates.graphml", "landmarks.csv", "run.json"] {
        let file = here.path().join("run").join(name);
        let aside = here.path().join("aside");
        fs::rename(&file, &aside).expect("moved");
        for trap in TRAPS {
            put(trap, &file);
            refused(here.path(), &["classify", "run", "-o", "phenotype"], &[name, trap]);
            let _ = fs::remove_file(&file).or_else(|_| fs::remove_dir(&file));
        }
        fs::rename(&aside, &file).expect("moved");
    }
}

#[test]
fn the_files_of_a_dataset_are_regular_ones() {
    let here = folder();
    let root = here.path().join("study");
    let anatomy = root.join("derivatives/net/sub-01/anat");
    fs::create_dir_all(&anatomy).expect("made");
    let mask = anatomy.join("sub-01_desc-vessels_mask.nii.gz");
    let bids = ["bids", "study", "out", "participant", "-n", "64", "--dpi", "36"];
    for trap in ["a pipe", TRAPS[0]] {
        put(trap, &mask);
        let (status, said) = run(here.path(), &bids);
        assert!(status == Some(1) && said.contains(trap), "{said}");
        fs::remove_file(&mask).expect("there");
    }
    fs::copy(data("scan.nii.gz"), &mask).expect("copied");
    let description = root.join("dataset_description.json");
    put("a pipe", &description);
    refused(here.path(), &bids, &["dataset_description.json", "a pipe"]);
}

#[test]
fn a_checkpoint_that_is_a_pipe_is_not_waited_for() {
    let here = folder();
    let arguments = checkpoint::run(here.path(), &["--checkpoint=0"]);
    let mut child = builder(here.path()).args(&arguments).stderr(Stdio::null()).spawn().expect("runs");
    checkpoint::wait_until(|| checkpoint::kept(here.path()) > 0);
    child.kill().expect("killed");
    child.wait().expect("ended");
    let hidden = fs::read_dir(here.path().join(".willis-out")).expect("stays").map(|entry| entry.expect("an entry").path());
    for path in hidden.filter(|path| path.extension().is_some_and(|ending| ending == "part")) {
        fs::remove_file(&path).expect("there");
        pipe(&path);
    }
    let said = here.path().join("said");
    let file = fs::File::create(&said).expect("made");
    let mut child = builder(here.path()).args(&arguments).stderr(file).spawn().expect("runs");
    checkpoint::wait_until(|| fs::read_to_string(&said).is_ok_and(|said| said.contains("the run begins anew")));
    child.kill().expect("killed");
    child.wait().expect("ended");
    let said = fs::read_to_string(&said).expect("text");
    assert!(said.contains("a pipe; expected a regular file; the run begins anew"), "{said}");
}

/// Who names a pipe fills it.
#[test]
fn a_pipe_that_is_named_is_read() {
    let here = folder();
    pipe(&here.path().join("lines.swc"));
    let filled = here.path().join("lines.swc");
    let fill = std::thread::spawn(move || fs::copy(data("broken-circle-of-willis.swc"), filled).expect("written"));
    let (status, said) = run(here.path(), &["convert", "lines.swc", "lines.vtp"]);
    assert_eq!(status, Some(0), "{said}");
    fill.join().expect("ends");
}

/// Beside a file whose name is no UTF-8 a pattern finds every other, and it.
#[cfg(target_os = "linux")]
#[test]
fn a_pattern_finds_names_that_are_no_utf8() {
    use std::os::unix::ffi::OsStrExt;
    let here = folder();
    let circle = fs::read(data("broken-circle-of-willis.swc")).expect("data");
    let latin = std::ffi::OsStr::from_bytes(b"fran\xe7ois.swc");
    for path in
        [Path::new("a.swc"), latin.as_ref(), Path::new(".hidden.swc"), Path::new("deep/b.swc"), Path::new("deep/.c/d.swc")]
    {
        let path = here.path().join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, &circle).expect("written");
    }
    // The file that is named by such an input is beside it; but no record can hold its name.
    let conditions = std::ffi::OsStr::from_bytes(b"fran\xe7ois.bc.csv");
    fs::write(here.path().join(conditions), "node,kind,value,unit\n1,inlet,90,mmHg\n").expect("written");
    let (status, said) = run(here.path(), &["infer", "fran*.swc", "-n", "64", "-q", "--bc", "{}.bc.csv", "-o", "stated"]);
    assert_eq!(status, Some(1), "{said}");
    let table = fs::read_to_string(here.path().join("stated/cohort.csv")).expect("a table");
    assert!(table.contains("fran\u{fffd}ois.bc.csv: its name is no UTF-8"), "{table}");
    // Nor that of a file that others are given by its own name.
    for [command, option] in [["classify", "--landmarks"], ["measure", "--brain"], ["measure", "--bc"]] {
        let words = builder(here.path()).args([command, "a.swc", "-o", "refused", option]).arg(conditions).output();
        let output = words.expect("runs");
        assert_eq!(output.status.code(), Some(2), "{command} {option}");
        assert!(stderr(&output).contains("its name is no UTF-8"), "{}", stderr(&output));
    }
    let found = |pattern: &str| -> Vec<String> {
        let (status, said) = run(here.path(), &["infer", pattern, "-n", "64", "-q", "--dpi", "36", "-o", "out", "--force"]);
        assert_eq!(status, Some(0), "{said}");
        let table = fs::read_to_string(here.path().join("out/cohort.csv")).expect("a table");
        table.lines().skip(1).map(|row| row.split(',').take(2).collect::<Vec<_>>().join(" of ")).collect()
    };
    assert_eq!(found("./*.swc"), ["a of a.swc", "fran_ois of fran\u{fffd}ois.swc"]);
    assert_eq!(found("a*.swc"), ["a of a.swc"]);
    // Any number of folders, but none that is hidden, unless it is named.
    assert_eq!(found("**/[bcd].swc"), ["b of deep/b.swc"]);
    assert_eq!(found("*/.c/*"), ["d of deep/.c/d.swc"]);
}
