//! `willis merge` of runs that were made apart, and `willis infer --record-failure`: the truth is the cohort of one command.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::{data, folder, stderr, willis};
use crate::refused::contents;
use serde_json::Value;

fn done(here: &Path, arguments: &[&str]) -> String {
    let output = willis(here, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stderr(&output)
}

/// The command fails with status 2 and one line that holds all words, and nothing is written.
fn refused(here: &Path, arguments: &[&str], words: &[&str]) {
    let before = contents(here);
    let output = willis(here, arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    let last = said.lines().last().expect("an error");
    assert!(words.iter().all(|word| last.contains(word)), "{words:?} in {said}");
    assert_eq!(contents(here), before, "files were touched");
}

/// The table of a cohort without its times.
fn rows(cohort: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(cohort.join("cohort.csv")).expect("a table");
    let all: Vec<Vec<String>> = reader.records().map(|r| r.expect("a row").iter().map(str::to_owned).collect()).collect();
    let time = all[0].iter().position(|name| name == "wall_s").expect("times");
    all.into_iter().map(|row| row.into_iter().enumerate().filter(|(at, _)| *at != time).map(|(_, cell)| cell).collect()).collect()
}

fn subjects(cohort: &Path) -> Vec<String> {
    rows(cohort).into_iter().skip(1).map(|row| row[0].clone()).collect()
}

/// Broken phantoms, a folder each, all files of one name but one; and a file that is none.
fn scans(here: &Path) {
    for (seed, name) in [("1", "p1/t.swc"), ("2", "p2/t.swc"), ("3", "other.swc")] {
        done(here, &["phantom", "cerebral", "--break", "--seed", seed, "-o", name, "-q"]);
    }
    fs::write(here.join("bad.swc"), "1 0 a b c d -1\n").expect("written");
}

const INPUTS: [&str; 5] = ["p1/t.swc", "bad.swc", "p2/t.swc", "absent.swc", "other.swc"];

/// Rows, names and their order are those of one command, and every report is where its link leads.
#[test]
fn runs_made_apart_are_the_cohort_of_one_command() {
    let here = folder();
    let here = here.path();
    scans(here);
    let whole = willis(here, &[&["infer"], &INPUTS[..], &["-o", "whole", "-n", "128", "--seed", "5", "-q"]].concat());
    assert_eq!(whole.status.code(), Some(1), "{}", stderr(&whole));
    for (at, input) in INPUTS.iter().enumerate() {
        let out = format!("on/machine-{at}/run & {at}");
        let auto = ["--landmarks", "auto"];
        done(
            here,
            &[&["infer", input, "-n128", "--seed=5", "--threads", "1", "--record-failure", "-o", &out, "-q"], &auto[..]].concat(),
        );
    }
    let said = done(here, &["merge", "on/machine-*/run*", "-o", "far/cohort"]);
    assert!(said.contains("5 subjects, 2 failed") && said.contains("bad: bad.swc:1: "), "{said}");
    assert_eq!(rows(&here.join("far/cohort")), rows(&here.join("whole")));
    assert_eq!(subjects(&here.join("whole")), ["p1-t", "bad", "p2-t", "absent", "other"]);

    let html = fs::read_to_string(here.join("far/cohort/cohort.html")).expect("a page");
    let (_, rest) = html.split_once("<script type=\"application/json\" id=\"data\">").expect("data");
    let page: Value = serde_json::from_str(rest.split_once("</script").expect("an end").0).expect("JSON");
    let names = page["table"]["columns"][0]["words"].as_array().expect("names").clone();
    let links: Vec<Option<&str>> = page["pages"].as_array().expect("links").iter().map(Value::as_str).collect();
    assert_eq!((names.len(), page["failed"].as_u64()), (5, Some(2)));
    for (name, link) in names.iter().zip(links) {
        let at = ["p1-t", "bad", "p2-t", "absent", "other"].iter().position(|n| name == n).expect("a subject");
        let expected = [0, 2, 4].contains(&at).then(|| format!("../../on/machine-{at}/run & {at}/report.html"));
        assert_eq!(link, expected.as_deref(), "{name}");
        assert!(link.is_none_or(|link| here.join("far/cohort").join(link).is_file()));
    }
    // The same command gives the same bytes, and takes the place of what was there by force only.
    let before = contents(&here.join("far"));
    refused(here, &["merge", "on/machine-*/run*", "-o", "far/cohort"], &["exists already"]);
    done(here, &["merge", "on/machine-*/run*", "-o", "far/cohort", "--force", "-q"]);
    assert_eq!(contents(&here.join("far")), before);
    // So does a cohort of its subjects' folders, and what is printed is its rows.
    let json = willis(here, &["merge", "whole/*", "-o", "again", "--json", "-q"]);
    let statuses: Vec<Value> = String::from_utf8_lossy(&json.stdout)
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["status"].clone())
        .collect();
    assert_eq!(statuses, ["ok", "ok", "ok"]);
    refused(here, &["infer", "p1/t.swc", "p2/t.swc", "-o", "again"], &["holds a cohort of willis merge"]);
}

/// Needs `WILLIS_CHROMIUM`: what a browser makes of the page, read off its document.
#[test]
fn the_links_of_the_page_work_in_chromium() {
    let Ok(chromium) = std::env::var("WILLIS_CHROMIUM") else {
        eprintln!("skipped: WILLIS_CHROMIUM names no Chromium");
        return;
    };
    let here = folder();
    let here = here.path();
    scans(here);
    for (input, out) in [("other.swc", "on/run & 1"), ("bad.swc", "on/run 2")] {
        done(here, &["infer", input, "-n", "64", "--record-failure", "-o", out, "-q"]);
    }
    done(here, &["merge", "on/*", "-o", "far/cohort", "-q"]);
    let mut browser = Command::new(chromium);
    browser.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--dump-dom"]);
    let address = format!("file://{}", here.join("far/cohort/cohort.html").display());
    let output = browser.arg(format!("--user-data-dir={}", here.join("profile").display())).arg(address).output().expect("runs");
    let document = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        document.contains("<a href=\"../../on/run%20%26%201/report.html?from=..%2F..%2Ffar%2Fcohort%2Fcohort.html\">other</a>"),
        "{}",
        stderr(&output)
    );
    assert!(document.contains("<tr class=\"failed\"><td class=\"text\">bad</td>"));
}

#[test]
fn runs_of_other_options_are_refused_by_what_differs() {
    let here = folder();
    let here = here.path();
    scans(here);
    let run = |out: &str, input: &str, more: &[&str]| {
        done(here, &[&["infer", input, "-o", out, "-q", "--record-failure"], more].concat());
    };
    run("a", "p1/t.swc", &["-n", "64"]);
    let cases: [(&str, &[&str], &[&str]); 6] = [
        ("seed", &["-n", "64", "--seed", "1"], &["seed: has seed 1, where a has 0"]),
        ("samples", &["-n", "128"], &["has samples 128", "a has 64"]),
        ("epsilon", &["-n", "64", "--epsilon", "0.3"], &["has epsilon 0.3", "a has 0.5"]),
        ("keep", &["-n", "64", "--keep", "otsu"], &["has keep \"otsu\", where a has not given"]),
        ("inlet", &["-n", "64", "--inlet", "1"], &["has inlet"]),
        ("bc", &["-n", "64", "--bc", "one.csv"], &["has bc \"a file\", where a has not given"]),
    ];
    fs::write(here.join("one.csv"), "node,kind\n1,inlet\n").expect("written");
    fs::write(here.join("two.csv"), "node,kind,value\n1,inlet,90\n").expect("written");
    for (out, more, words) in cases {
        run(out, "p2/t.swc", more);
        refused(here, &["merge", "a", out, "-o", "out"], words);
    }
    // A file of the subject is its own affair, as it is in a cohort of one command.
    run("bc2", "p1/t.swc", &["-n", "64", "--bc", "two.csv"]);
    done(here, &["merge", "bc", "bc2", "-o", "fine", "-q"]);
    refused(here, &["merge", "bc", "bc2", "a", "-o", "out"], &["a: has bc not given"]);

    run("failed", "bad.swc", &["-n", "64", "--seed", "1"]);
    refused(here, &["merge", "a", "failed", "-o", "out"], &["failed: has seed 1"]);
    run("same", "p1/t.swc", &["-n", "64"]);
    refused(here, &["merge", "a", "same", "-o", "out"], &["same: is of p1/t.swc, as a is"]);
    refused(here, &["merge", "a", "a", "-o", "out"], &["a: is of p1/t.swc, as a is"]);
    run("two", "p2/t.swc", &["-n", "64", "--epsilon", "0.2,0.5"]);
    refused(here, &["merge", "a", "two", "-o", "out"], &["two: a folder without run.json"]);
    refused(here, &["merge", "a", "p1/t.swc", "-o", "out"], &["p1/t.swc: a file; expected the folder of a run"]);
    done(here, &["merge", "a", "two/epsilon-0.5", "-o", "one", "-q"]);
    refused(here, &["merge", "a", "two/epsilon-0.2", "-o", "out"], &["has epsilon 0.2"]);
    done(here, &["simulate", &data("circle-of-willis/complete.graphml"), "-o", "flow", "-q"]);
    refused(here, &["merge", "a", "flow", "-o", "out"], &["flow: was made by willis simulate"]);
    refused(here, &["merge", "nothing*", "-o", "out"], &["matches no folder of a run"]);
    let text = fs::read_to_string(here.join("same/run.json")).expect("a record");
    fs::write(here.join("same/run.json"), text.replace("\"willis\": \"", "\"willis\": \"9.")).expect("written");
    refused(here, &["merge", "a", "same", "-o", "out"], &["same: was made by willis 9."]);
    fs::write(here.join("same/run.json"), &text[..text.len() / 2]).expect("written");
    let cut = willis(here, &["merge", "a", "same", "-o", "out"]);
    assert!(cut.status.code() == Some(2) && stderr(&cut).starts_with("willis: same/run.json: EOF"), "{}", stderr(&cut));
    fs::write(here.join("same/run.json"), "{}").expect("written");
    refused(here, &["merge", "a", "same", "-o", "out"], &["same: was made by willis "]);
    fs::write(here.join("failed/failed.json"), "{}").expect("written");
    refused(here, &["merge", "a", "failed", "-o", "out"], &["failed/failed.json: missing field"]);
}

/// A file of priors is what it holds, whatever it is called.
#[test]
fn priors_are_compared_by_content() {
    let here = folder();
    let here = here.path();
    for (name, length) in [("g.csv", 10), ("h.csv", 11), ("i.csv", 12)] {
        let rows = format!("node_a,node_b,length_mm,radius_mm\na,b,{length},1\nb,c,11,1.3\na,c,12.7,0.9\nc,d,3,1\n");
        fs::write(here.join(name), rows).expect("written");
    }
    let run = |out: &str, input: &str, prior: &str| {
        let more = ["-n", "64", "--inlet", "a", "--outlet", "d=ground", "--prior", prior, "--record-failure"];
        done(here, &[&["infer", input, "-o", out, "-q"], &more[..]].concat());
    };
    fs::write(here.join("p.csv"), "edge,prior\n0,0.5\n1,1\n2,1\n3,1\n").expect("written");
    fs::copy(here.join("p.csv"), here.join("q.csv")).expect("copied");
    run("a", "g.csv", "p.csv");
    run("b", "h.csv", "q.csv");
    done(here, &["merge", "a", "b", "-o", "same", "-q"]);
    run("none", "absent.csv", "p.csv");
    done(here, &["merge", "none", "a", "b", "-o", "failed", "-q"]);
    fs::write(here.join("p.csv"), "edge,prior\n0,0.4\n1,1\n2,1\n3,1\n").expect("written");
    run("c", "i.csv", "p.csv");
    refused(here, &["merge", "a", "c", "-o", "out"], &["c: has prior"]);
}

/// Runs in which the arteries were named, and others, have other columns: they are no cohort of one command.
#[test]
fn runs_whose_arteries_were_named_do_not_go_with_others() {
    let here = folder();
    let here = here.path();
    scans(here);
    done(here, &["infer", "p1/t.swc", "-o", "a", "-n", "64", "-q"]);
    done(here, &["infer", "p2/t.swc", "-o", "b", "-n", "64", "-q", "--landmarks", "auto"]);
    refused(here, &["merge", "a", "b", "-o", "out"], &["b: has landmarks \"auto\"", "a has not given", "the same options"]);
}

/// Each subject has an image of its own, by a pattern: its run is that with this image alone, and runs made apart are the same cohort.
#[test]
fn images_go_with_their_subjects() {
    let here = folder();
    let here = here.path();
    let more = ["-n", "64", "--landmarks", "auto", "-q"];
    for name in ["a", "b"] {
        let (mask, image) = (format!("{name}.nii.gz"), format!("{name}.tof.nii"));
        let seed = if name == "a" { "1" } else { "2" };
        let drawn = ["phantom", "tree", "--break", "--seed", seed, "--spacing", "2mm", "-o", &mask, "--image", &image, "-q"];
        done(here, &drawn);
        done(here, &[&["infer", &mask, "--image", &image, "-o", &format!("runs/{name}")], &more[..]].concat());
    }
    done(here, &[&["infer", "a.nii.gz", "b.nii.gz", "--image", "{}.tof.nii", "-o", "whole"], &more[..]].concat());
    done(here, &["merge", "runs/*", "-o", "apart", "-q"]);
    assert_eq!(rows(&here.join("apart")), rows(&here.join("whole")));
    for name in ["a", "b"] {
        let edges = |run: &str| fs::read(here.join(run).join(name).join("edges.csv")).expect("a table");
        assert_eq!(edges("whole"), edges("runs"));
    }
}

/// A tracing without iCafe's Image_info.txt beside it is a failure of the input, which goes with the runs of those that have one.
#[test]
fn a_spacing_that_nothing_states_is_a_failure_of_the_input() {
    let here = folder();
    let here = here.path();
    scans(here);
    fs::write(here.join("p1/Image_info.txt"), "Voxel spacing: 0.5\nOrigin: 0,0,0\n").expect("written");
    for (input, out) in [("p1/t.swc", "runs/a"), ("p2/t.swc", "runs/b")] {
        done(here, &["infer", input, "-o", out, "-n", "128", "--spacing", "auto", "--record-failure", "-q"]);
    }
    assert!(here.join("runs/a/run.json").is_file() && here.join("runs/b/failed.json").is_file());
    done(here, &["merge", "runs/*", "-o", "cohort"]);
    let rows = rows(&here.join("cohort"));
    let status = rows[0].iter().position(|name| name == "status").expect("a column");
    assert_eq!(rows[1..].iter().map(|row| &*row[status]).collect::<Vec<_>>(), ["ok", "failed"]);
}

/// What is wrong with the input is kept in the place of its run; what is wrong with the command, or the disk, is not.
#[test]
fn only_a_failure_of_the_input_is_recorded() {
    let here = folder();
    let here = here.path();
    scans(here);
    let infer = ["infer", "bad.swc", "-n", "128", "-o", "out", "--record-failure"];
    for (more, words) in [
        (&["-k", "0"][..], &["-k 0"][..]),
        (&["--prior", "evidenc"], &["evidence"]),
        (&["--epsilon", "2"], &["--epsilon"]),
        (&["--bc", "a.csv", "--units", "foot"], &["--units"]),
        (&["other.swc"], &["--record-failure", "one INPUT"]),
    ] {
        refused(here, &[&infer[..], more].concat(), words);
    }
    let said = done(here, &infer);
    assert_eq!(said.lines().collect::<Vec<_>>(), ["    failed  bad.swc:1: x \"a\"; expected a number"]);
    assert_eq!(contents(&here.join("out")).len(), 1);
    refused(here, &infer, &["exists already"]);

    // Mended, the run takes the place of the failure.
    fs::copy(here.join("other.swc"), here.join("bad.swc")).expect("copied");
    fs::create_dir(here.join("other")).expect("made");
    fs::copy(here.join("out/failed.json"), here.join("other/failed.json")).expect("copied");
    done(here, &[&infer[..], &["--force", "-q"]].concat());
    assert!(here.join("out/run.json").is_file() && !here.join("out/failed.json").exists());
    fs::write(here.join("other/thesis.txt"), "precious").expect("written");
    refused(here, &["infer", "bad.swc", "-o", "other", "--force"], &["thesis.txt"]);
}
