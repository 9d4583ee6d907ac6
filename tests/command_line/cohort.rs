//! Cohorts: every subject as its single run, failures as rows, going on after a kill, names, patterns, the page.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::command::{builder, data, folder, stderr, willis};
use crate::refused::{contents, refused};
use serde_json::{Value, json};
use willis::cli::internals::{LONGEST, named};
use willis::internals::formats::write_csv;
use willis::internals::output::relative;
use willis::internals::report::cohort::{CohortRow, cohort_columns, needs_person, uncertainty};

/// Broken phantoms with these seeds, as `scan1.swc` and so on.
fn scans(here: &Path, seeds: &[u32]) {
    for seed in seeds {
        let name = format!("scan{seed}.swc");
        let made = willis(here, &["phantom", "cerebral", "--break", "--seed", &seed.to_string(), "-o", &name, "-q"]);
        assert!(made.status.success(), "{}", stderr(&made));
    }
}

fn cohort(here: &Path, inputs: &[&str], more: &[&str]) -> Output {
    willis(here, &[&["infer"], inputs, &["-o", "out", "-n", "64"], more].concat())
}

fn done(output: &Output) {
    assert!(output.status.success(), "{}", stderr(output));
}

fn table(here: &Path) -> Vec<u8> {
    fs::read(here.join("out/cohort.csv")).expect("a table")
}

/// The table as a header and rows; `wall` says whether the time stays.
fn rows(here: &Path, wall: bool) -> Vec<Vec<String>> {
    let text = table(here);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&text[..]);
    let all: Vec<Vec<String>> = reader.records().map(|r| r.expect("a row").iter().map(str::to_owned).collect()).collect();
    let at = all[0].iter().position(|name| name == "wall_s");
    let stays = |(column, _): &(usize, String)| wall || Some(*column) != at;
    all.into_iter().map(|row| row.into_iter().enumerate().filter(stays).map(|(_, cell)| cell).collect()).collect()
}

/// The values of a column.
fn column(here: &Path, name: &str) -> Vec<String> {
    let all = rows(here, true);
    let at = all[0].iter().position(|column| column == name).unwrap_or_else(|| panic!("{name} in {:?}", all[0]));
    all[1..].iter().map(|row| row[at].clone()).collect()
}

fn record(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path.join("run.json")).expect("a record")).expect("JSON")
}

/// A file in a subject's folder that only a new run takes away.
fn marker(here: &Path, subject: &str) -> PathBuf {
    here.join("out").join(subject).join("topology-median.graphml")
}

/// The truth is the single run: the same files with the same bytes, and the figures of its record.
#[test]
fn a_subject_is_its_single_run() {
    let here = folder();
    scans(here.path(), &[1, 2]);
    done(&cohort(here.path(), &["scan1.swc", "scan2.swc"], &["-q", "--seed", "5"]));
    for name in ["scan1", "scan2"] {
        done(&willis(
            here.path(),
            &["infer", &format!("{name}.swc"), "-o", name, "-n", "64", "-q", "--seed", "5", "--landmarks", "auto"],
        ));
        assert_eq!(contents(&here.path().join("out").join(name)), contents(&here.path().join(name)), "{name}");
    }
    let single = record(&here.path().join("scan2"));
    assert_eq!(column(here.path(), "subject"), ["scan1", "scan2"]);
    assert_eq!(column(here.path(), "status"), ["ok", "ok"]);
    for (name, pointer) in [
        ("sha256", "/input/sha256"),
        ("nodes", "/counts/nodes"),
        ("observed", "/counts/observed"),
        ("candidates", "/counts/candidates"),
        ("kept", "/counts/topology/kept_candidates"),
        ("components", "/counts/topology/components"),
        ("cycles", "/counts/topology/cycles"),
        ("undecided", "/convergence/undecided"),
        ("rho_G_W_per_m3", "/rho_G_W_per_m3"),
        ("expected_wrong", "/expected_errors/wrong"),
        ("expected_missed", "/expected_errors/missed"),
    ] {
        let (found, truth) = (&column(here.path(), name)[1], single.pointer(pointer).expect(pointer));
        match truth.as_f64() {
            Some(x) => assert_eq!(found.parse::<f64>().expect("a number").to_bits(), x.to_bits(), "{name}"),
            None => assert_eq!(found, truth.as_str().expect("text"), "{name}"),
        }
    }
    let number = |name| column(here.path(), name)[1].parse::<f64>().expect("a number");
    assert_eq!(number("sparsity"), number("kept") / number("candidates"));
    assert_eq!(number("wall_s"), record(&here.path().join("out/scan2"))["time"]["wall_s"].as_f64().expect("seconds"));
}

/// The truth is the single run here too. What failed is a row, and what is done is not done again until its file changes.
#[test]
fn a_labelled_subject_is_its_single_label() {
    let here = folder();
    scans(here.path(), &[1]);
    fs::write(here.path().join("bad.swc"), "1 0 a b c d -1\n").expect("written");
    let label = |words: &[&str]| willis(here.path(), &[&["label", "scan1.swc", "bad.swc", "-o"], words].concat());
    let output = label(&["out"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert_eq!(column(here.path(), "status"), ["ok", "failed"]);
    assert!(column(here.path(), "error")[1].starts_with("bad.swc:1: "));
    fs::create_dir(here.path().join("single")).expect("made");
    let printed = willis(here.path(), &["label", "scan1.swc", "-o", "single/labelled.graphml", "--json", "-q"]);
    done(&printed);
    let mut files = contents(&here.path().join("out/scan1"));
    files.retain(|(path, _)| !path.ends_with("run.json"));
    assert_eq!(files.len(), 5, "{files:?}");
    assert_eq!(files, contents(&here.path().join("single")));
    let said: Value = serde_json::from_slice(&printed.stdout).expect("JSON");
    assert_eq!(column(here.path(), "named")[0], said["counts"]["named"].to_string());
    let found = column(here.path(), "p_L-P1")[0].parse::<f64>().expect("a number");
    assert_eq!(Some(found), said["segments"]["L-P1"].as_f64());
    let marker = here.path().join("out/scan1/labelled.names.csv");
    fs::remove_file(&marker).expect("there");
    let output = label(&["out"]);
    assert!(stderr(&output).contains("1 of 2 subjects done already"), "{}", stderr(&output));
    assert!(!marker.exists());
    let before = contents(here.path());
    for (words, why) in [
        (&["out", "--max-gap", "3"][..], "with other parameters (max-gap-m was not given"),
        (&["named.vtp"], "expected a folder"),
    ] {
        let output = label(words);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(why), "{}", stderr(&output));
    }
    assert_eq!(contents(here.path()), before);
}

#[test]
fn the_threads_change_nothing() {
    let here = folder();
    scans(here.path(), &[1, 2, 3]);
    let inputs = ["scan1.swc", "scan2.swc", "scan3.swc"];
    let mut found = Vec::new();
    for threads in ["1", "2", "5"] {
        done(&cohort(here.path(), &inputs, &["-q", "--force", "--threads", threads]));
        let mut files = contents(&here.path().join("out"));
        files.retain(|(path, _)| !path.ends_with("cohort.csv"));
        found.push((files, rows(here.path(), false)));
    }
    assert!(found.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn a_subject_that_fails_is_a_row() {
    let here = folder();
    scans(here.path(), &[1, 2]);
    fs::write(here.path().join("bad.swc"), "1 0 a b c d -1\n").expect("written");
    let inputs = ["scan1.swc", "bad.swc", "scan2.swc", "absent.swc"];
    let output = cohort(here.path(), &inputs, &[]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.lines().last(), Some("willis: 2 of 4 subjects failed"));
    assert_eq!(column(here.path(), "subject"), ["scan1", "bad", "scan2", "absent"]);
    assert_eq!(column(here.path(), "status"), ["ok", "failed", "ok", "failed"]);
    let errors = column(here.path(), "error");
    assert!(errors[0].is_empty() && errors[1].starts_with("bad.swc:1: ") && errors[3].starts_with("absent.swc: cannot be read"));
    assert!(column(here.path(), "nodes")[1].is_empty() && column(here.path(), "sha256")[3].is_empty());
    assert!(here.path().join("out/scan2/report.html").is_file() && !here.path().join("out/bad").exists());

    // Mended, it is done; the others stay.
    let before = fs::metadata(marker(here.path(), "scan1")).expect("a file").modified().expect("a time");
    fs::copy(here.path().join("scan1.swc"), here.path().join("bad.swc")).expect("copied");
    let output = cohort(here.path(), &inputs, &[]);
    assert!(stderr(&output).contains("2 of 4 subjects done already"), "{}", stderr(&output));
    assert_eq!(column(here.path(), "status"), ["ok", "ok", "ok", "failed"]);
    assert_eq!(fs::metadata(marker(here.path(), "scan1")).expect("a file").modified().expect("a time"), before);
}

#[test]
fn what_is_done_is_not_done_again() {
    let here = folder();
    scans(here.path(), &[1, 2]);
    let inputs = ["scan1.swc", "scan2.swc"];
    done(&cohort(here.path(), &inputs, &["-q"]));
    let whole = contents(&here.path().join("out"));
    fs::write(marker(here.path(), "scan1"), "untouched").expect("written");
    let before = table(here.path());
    let output = cohort(here.path(), &inputs, &["--threads", "1"]);
    done(&output);
    assert!(stderr(&output).contains("2 of 2 subjects done already"), "{}", stderr(&output));
    assert_eq!(fs::read(marker(here.path(), "scan1")).expect("a file"), b"untouched");
    assert_eq!(table(here.path()), before);

    // One that lacks what other commands read is made again, with the same bytes.
    let second = contents(&here.path().join("out/scan2"));
    fs::remove_file(here.path().join("out/scan2/edges.csv")).expect("there");
    let output = cohort(here.path(), &inputs, &[]);
    assert!(stderr(&output).contains("1 of 2 subjects done already"), "{}", stderr(&output));
    assert_eq!(contents(&here.path().join("out/scan2")), second);

    // More inputs go on with it, another content of an input is done again, and so is all of it by force.
    scans(here.path(), &[3]);
    let three = [&inputs[..], &["scan3.swc"]].concat();
    done(&cohort(here.path(), &three, &["-q"]));
    assert_eq!(column(here.path(), "subject").len(), 3);
    assert_eq!(fs::read(marker(here.path(), "scan1")).expect("a file"), b"untouched");
    fs::copy(here.path().join("scan3.swc"), here.path().join("scan1.swc")).expect("copied");
    done(&cohort(here.path(), &three, &["-q"]));
    assert_ne!(fs::read(marker(here.path(), "scan1")).expect("a file"), b"untouched");
    assert_eq!(column(here.path(), "nodes")[0], column(here.path(), "nodes")[2]);
    done(&willis(here.path(), &["phantom", "cerebral", "--break", "--seed", "1", "-o", "scan1.swc", "-q", "--force"]));
    fs::write(marker(here.path(), "scan2"), "untouched").expect("written");
    done(&cohort(here.path(), &inputs, &["-q", "--force"]));
    let again: Vec<_> =
        contents(&here.path().join("out")).into_iter().filter(|(path, _)| !path.ends_with("cohort.csv")).collect();
    assert_eq!(again, whole.into_iter().filter(|(path, _)| !path.ends_with("cohort.csv")).collect::<Vec<_>>());
}

/// The truth is a run that nobody disturbed; wall time alone may differ from it.
#[test]
fn a_killed_cohort_goes_on() {
    let here = folder();
    scans(here.path(), &[1, 2, 3, 4, 5, 6]);
    let inputs = ["scan1.swc", "scan2.swc", "scan3.swc", "scan4.swc", "scan5.swc", "scan6.swc"];
    done(&cohort(here.path(), &inputs, &["-q"]));
    let (truth, page) = (rows(here.path(), false), fs::read(here.path().join("out/cohort.html")).expect("a page"));
    fs::rename(here.path().join("out"), here.path().join("whole")).expect("renamed");

    let mut child = builder(here.path());
    child.args(["infer"]).args(inputs).args(["-o", "out", "-n", "64", "--threads", "1"]);
    let mut child = child.stderr(Stdio::null()).spawn().expect("runs");
    let started = Instant::now();
    let subjects = || inputs.iter().filter(|name| here.path().join("out").join(name.trim_end_matches(".swc")).exists()).count();
    while subjects() == 0 && started.elapsed() < Duration::from_mins(1) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("killed");
    child.wait().expect("gone");
    let stood = subjects();
    assert!((1..6).contains(&stood), "{stood} subjects stood");
    assert!(!here.path().join("out/cohort.csv").exists());
    fs::create_dir(here.path().join("out/.willis-left")).expect("made");
    fs::write(here.path().join("out/.willis-left/half"), "half").expect("written");

    let output = cohort(here.path(), &inputs, &[]);
    done(&output);
    assert!(stderr(&output).contains(&format!("{stood} of 6 subjects done already")), "{}", stderr(&output));
    assert_eq!(rows(here.path(), false), truth);
    assert_eq!(fs::read(here.path().join("out/cohort.html")).expect("a page"), page);
    let left = |folder: &str| {
        let names = fs::read_dir(here.path().join(folder)).expect("a folder").map(|e| e.expect("an entry").file_name());
        names.filter(|name| name.to_string_lossy().starts_with('.')).count()
    };
    assert_eq!(left("out"), 0);
    for name in inputs.map(|name| name.trim_end_matches(".swc")) {
        assert_eq!(contents(&here.path().join("out").join(name)), contents(&here.path().join("whole").join(name)), "{name}");
    }
    let second = table(here.path());
    done(&cohort(here.path(), &inputs, &["-q"]));
    assert_eq!(table(here.path()), second);
}

#[test]
fn a_cohort_of_another_kind_is_refused() {
    let here = folder();
    scans(here.path(), &[1, 2]);
    let inputs = ["scan1.swc", "scan2.swc"];
    done(&cohort(here.path(), &inputs, &["-q"]));
    let before = contents(here.path());
    let no = |inputs: &[&str], more: &[&str], words: &[&str]| {
        let output = cohort(here.path(), inputs, more);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(words.iter().all(|word| said.contains(word)) && said.lines().count() == 1, "{said}");
        assert_eq!(contents(here.path()), before, "files were touched");
    };
    no(&inputs, &["--seed", "9"], &["other parameters", "seed was 0, now 9", "--force"]);
    no(&inputs, &["--inlet", "1"], &["inlet was [], now"]);
    no(&inputs[..1], &["--max-gap", "5mm"], &["exists already"]);
    no(&["scan1.swc", "scan1.swc", "absent.swc"], &[], &["holds subject scan2 of scan2.swc"]);
    no(&inputs, &["--force", "--epsilon", "2"], &["--epsilon"]);
    no(&inputs, &["--force", "--epsilon", "0.2,0.5"], &["--epsilon 0.2,0.5", "a cohort"]);
    no(&inputs, &["--force", "-k", "0"], &["k 0"]);
    no(&inputs, &["--force", "--prior", "evidenc"], &["evidence"]);
    no(&["scan*.vtp"], &["--force"], &["\"scan*.vtp\"", "matches no file"]);

    // What is not ours stays, by force too.
    fs::write(here.path().join("out/scan2/thesis.txt"), "x").expect("written");
    let output = cohort(here.path(), &inputs, &["--force"]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("thesis.txt"), "{}", stderr(&output));
    assert!(here.path().join("out/scan2/thesis.txt").is_file());
}

#[test]
fn a_folder_that_is_no_cohort_is_refused() {
    let circle = fs::read(data("broken-circle-of-willis.swc")).expect("data");
    let files: [(&str, &[u8]); 3] = [("a.swc", &circle), ("b.swc", &circle), ("out", b"x")];
    refused(&files, &["infer", "a.swc", "b.swc", "-o", "out"], &["out: exists already"]);
    refused(&files, &["infer", "a.swc", "b.swc", "-o", "out", "--force"], &["--output out"]);
}

/// Patterns reach the command as they are: nothing expands them on the way.
#[test]
fn a_pattern_is_expanded_and_names_are_unique() {
    let here = folder();
    let circle = fs::read(data("broken-circle-of-willis.swc")).expect("data");
    for name in ["p2/t.swc", "p1/t.swc", "p1/u.swc", "[odd].swc"] {
        let path = here.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, &circle).expect("written");
    }
    done(&cohort(here.path(), &["p?/t.swc"], &["-q"]));
    assert_eq!(column(here.path(), "subject"), ["p1", "p2"]);
    assert_eq!(record(&here.path().join("out/p2"))["command"], "willis infer p2/t.swc -n 64 --landmarks auto -o again");
    done(&cohort(here.path(), &["p[12]/*.swc"], &["-q", "--force"]));
    assert_eq!(column(here.path(), "subject"), ["p1-t", "u", "p2-t"]);
    assert_eq!(column(here.path(), "input"), ["p1/t.swc", "p1/u.swc", "p2/t.swc"]);
    // A pattern that finds one file makes a cohort, a file with such a name none.
    done(&cohort(here.path(), &["p1/u*"], &["-q", "--force"]));
    assert_eq!(column(here.path(), "subject"), ["u"]);
    done(&cohort(here.path(), &["[odd].swc"], &["-q", "--force"]));
    assert!(here.path().join("out/run.json").is_file() && !here.path().join("out/cohort.json").exists());
}

/// Every file that an option names goes into the runs: one that has changed makes them anew, as a cohort of its own has them.
#[test]
fn a_file_of_an_option_counts_as_input() {
    let here = folder();
    scans(here.path(), &[1, 2]);
    let write = |complete: f64| {
        let table = format!("missing,share\ncomplete,{complete}\nL-PComm,{}\n", 1.0 - complete);
        fs::write(here.path().join("shares.csv"), table).expect("written");
    };
    let options = ["--landmarks", "auto", "--variant-prior", "shares.csv"];
    write(0.9);
    done(&cohort(here.path(), &["scan*.swc"], &options));
    let before = column(here.path(), "p_variant");
    write(0.1);
    let again = cohort(here.path(), &["scan*.swc"], &options);
    assert!(again.status.success() && !stderr(&again).contains("done already"), "{}", stderr(&again));
    let after = column(here.path(), "p_variant");
    assert_ne!(before, after);
    done(&cohort(here.path(), &["scan*.swc"], &[&options[..], &["-q", "--force"]].concat()));
    assert_eq!(column(here.path(), "p_variant"), after);
}

/// A table of nodes is read with the table of edges beside it, in whatever capitals: a change there is a change of the input.
#[test]
fn a_file_that_is_read_beside_an_input_counts_as_input() {
    let here = folder();
    let nodes = "node,x_mm,y_mm,z_mm\na,0,0,0\nb,10,0,0\nc,20,0,0\n";
    let write = |name: &str, text: &str| fs::write(here.path().join(name), text).expect("written");
    for (edges, of_nodes) in [("s1_edges.csv", "s1_nodes.csv"), ("S2-Edges.csv", "S2-Nodes.csv")] {
        write(of_nodes, nodes);
        write(edges, "node_a,node_b,radius_mm\na,b,1\nb,c,1\n");
    }
    // Voreen's input may be its table of nodes.
    write("v_nodes.csv", "id;pos_x;pos_y;pos_z\n0;0;0;0\n1;10;0;0\n");
    let edges = |radius: &str| format!("id;node1id;node2id;length;avgRadiusAvg\n0;0;1;10;{radius}\n");
    write("v_edges.csv", &edges("1"));
    write("other_nodes.csv", "x");
    let inputs = ["s1_edges.csv", "S2-Edges.csv", "v_nodes.csv"];
    let said = |done: &str| {
        let output = cohort(here.path(), &inputs, &[]);
        let said = stderr(&output);
        assert!(output.status.success() && said.contains(done), "{done}: {said}");
    };
    done(&cohort(here.path(), &inputs, &["-q"]));
    said("3 of 3 subjects done already");
    write("v_edges.csv", &edges("2"));
    said("2 of 3 subjects done already");
    write("S2-Nodes.csv", &nodes.replace("20", "25"));
    said("2 of 3 subjects done already");
    // What no reader takes is no input.
    write("other_nodes.csv", "y");
    write("v_vertices.csv", "z");
    said("3 of 3 subjects done already");
}

#[test]
fn files_that_go_with_a_subject_are_named_by_it() {
    let here = folder();
    scans(here.path(), &[1, 2]);
    fs::create_dir(here.path().join("bc")).expect("made");
    fs::write(here.path().join("scan1.bc.csv"), "node,kind\n1,inlet\n").expect("written");
    let output = cohort(here.path(), &["scan1.swc", "scan2.swc"], &["--bc", "{}.bc.csv"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let errors = column(here.path(), "error");
    assert!(errors[0].is_empty() && errors[1].starts_with("scan2.bc.csv: cannot be read"), "{errors:?}");
    let inlets = |name: &str| {
        let record = record(&here.path().join("out").join(name));
        let all = record["boundary_conditions"].as_array().expect("conditions").clone();
        all.iter().filter(|c| c["role"] == "inlet").map(|c| c["id"].as_str().expect("an id").to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(inlets("scan1"), ["1"]);
    // Another content of that file does the subject again; {dir} is its folder.
    fs::write(here.path().join("scan2.bc.csv"), "node,kind,value\n1,inlet,90\n").expect("written");
    let output = cohort(here.path(), &["scan1.swc", "scan2.swc"], &["--bc", "{}.bc.csv"]);
    done(&output);
    assert!(stderr(&output).contains("1 of 2 subjects done already"), "{}", stderr(&output));
    fs::write(here.path().join("scan1.bc.csv"), "node,kind,value\n1,inlet,80\n").expect("written");
    done(&cohort(here.path(), &["scan1.swc", "scan2.swc"], &["--bc", "{}.bc.csv", "-q"]));
    assert_eq!(
        record(&here.path().join("out/scan1"))["boundary_conditions"][0]["pressure_mmHg"].as_f64().map(f64::round),
        Some(80.0)
    );
    done(&willis(here.path(), &["infer", "scan1.swc", "-o", "one", "-n", "64", "-q", "--bc", "{dir}/scan1.bc.csv"]));
}

#[test]
fn rows_are_printed_as_json() {
    let here = folder();
    scans(here.path(), &[1]);
    let output = cohort(here.path(), &["scan1.swc", "absent.swc"], &["--json", "-q"]);
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    let lines: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(lines.iter().map(|l| l["status"].as_str()).collect::<Vec<_>>(), [Some("ok"), Some("failed")]);
    assert_eq!(lines[0]["nodes"].as_f64(), record(&here.path().join("out/scan1"))["counts"]["nodes"].as_f64());
}

/// The data of the page, cut out as a browser does.
fn page(here: &Path) -> (String, Value) {
    let html = fs::read_to_string(here.join("out/cohort.html")).expect("a page");
    let (_, rest) = html.split_once("<script type=\"application/json\" id=\"data\">").expect("a block of data");
    let (json, _) = rest.split_once("</script").expect("its end");
    let data = serde_json::from_str(json).expect("JSON");
    (html, data)
}

#[test]
fn names_are_text_in_the_page() {
    let here = folder();
    let circle = fs::read(data("broken-circle-of-willis.swc")).expect("data");
    let hostile = "<img src=x onerror=alert(1)>&\"'.swc";
    fs::write(here.path().join(hostile), &circle).expect("written");
    fs::write(here.path().join("<script>.swc"), "1 0 <script>alert(2)</script> b c d -1\n").expect("written");
    let output = cohort(here.path(), &[hostile, "<script>.swc"], &["-q"]);
    assert_eq!(output.status.code(), Some(1));
    let (html, data) = page(here.path());
    assert_eq!((html.matches("<script").count(), html.matches("</script").count()), (2, 2));
    assert!(!html.contains("<img") && !html.contains("http://www.w3.org/1999") && html.contains("default-src 'none'"));
    let words: Vec<&Value> = data["table"]["columns"].as_array().expect("columns").iter().map(|c| &c["words"]).collect();
    // The failed one first.
    assert_eq!(words[0], &serde_json::json!(["_script_", "_img_src_x_onerror_alert_1_____"]));
    assert_eq!(words[1], &serde_json::json!(["<script>.swc", hostile]));
    assert_eq!(data["failed"], 1);
}

/// Needs `WILLIS_CHROMIUM`: what a browser makes of the page, read off its document.
#[test]
fn the_page_works_in_chromium() {
    let Ok(chromium) = std::env::var("WILLIS_CHROMIUM") else {
        eprintln!("skipped: WILLIS_CHROMIUM names no Chromium");
        return;
    };
    let here = folder();
    scans(here.path(), &[1, 2]);
    fs::write(here.path().join("<b>bad.swc"), "1 0 a b c d -1\n").expect("written");
    assert_eq!(cohort(here.path(), &["scan1.swc", "scan2.swc", "<b>bad.swc"], &["-q"]).status.code(), Some(1));
    let address = format!("file://{}", here.path().join("out/cohort.html").display());
    let mut browser = Command::new(chromium);
    browser.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=5000", "--dump-dom"]);
    let output =
        browser.arg(format!("--user-data-dir={}", here.path().join("profile").display())).arg(address).output().expect("runs");
    let document = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(document.contains("data-ready=\"yes\""), "{}", stderr(&output));
    for name in ["scan1", "scan2"] {
        assert!(document.contains(&format!("<a href=\"{name}/report.html?from=..%2Fcohort.html\">{name}</a>")), "{name}");
    }
    assert!(document.contains("<tr class=\"failed\"><td class=\"text\">_b_bad</td>"));
    assert!(document.contains("<b>_b_bad</b>: &lt;b&gt;bad.swc:1: "));
    assert!(document.contains("<select id=\"column\">") && document.contains("sparsity</option>"));
    let rows = &document[document.find("<tr class=\"failed\">").expect("a row")..];
    let (failed, first) = (rows.find("<td class=\"text\">_b_bad"), rows.find("<a href=\"scan"));
    assert!(failed.is_some() && failed < first);
}

fn subject_row(subject: &str, figures: Result<Vec<(&'static str, Value)>, String>) -> CohortRow {
    let figures = figures.map(|figures| figures.into_iter().map(|(name, cell)| (name.into(), cell)).collect());
    CohortRow {
        subject: subject.into(),
        input: String::new(),
        sha256: String::new(),
        covariates: Vec::new(),
        page: None,
        figures,
    }
}

#[test]
fn columns_are_those_of_all_rows() {
    let rows = [
        subject_row("a", Ok(vec![("nodes", json!(3.0))])),
        subject_row("b", Err("unreadable".into())),
        subject_row("c", Ok(vec![("variant", json!("complete")), ("nodes", json!(4.0))])),
    ];
    let columns = cohort_columns(&rows);
    let names: Vec<&str> = columns.iter().map(|c| &*c.name).collect();
    assert_eq!(names, ["subject", "input", "sha256", "status", "error", "nodes", "variant"]);
    let mut table = Vec::new();
    write_csv(&mut table, &columns).expect("columns of one length");
    let lines = "a,,,ok,,3,\nb,,,failed,unreadable,,\nc,,,ok,,4,complete\n";
    assert_eq!(String::from_utf8(table).expect("text").split_once('\n').expect("a header").1, lines);
}

/// What could change the variant needs a person, and nothing else where arteries are known.
#[test]
fn a_person_is_needed_where_the_variant_could_change() {
    let subject = |p: f64, share: f64, without: f64| {
        let deciding = json!([{ "share": share, "variant_with": 0.99, "variant_without": without }]);
        json!({
            "phenotype": { "probabilities": { "variant": p, "deciding": deciding } },
            "convergence": { "undecided": 4 },
            "expected_errors": { "wrong": 1.0, "missed": 1.0 },
        })
    };
    // Undecided connections that leave the variant as it is are no reason.
    assert_eq!(needs_person(&subject(0.97, 0.5, 0.95)), "");
    assert_eq!(needs_person(&subject(0.97, 0.98, 0.1)), "");
    assert_eq!(needs_person(&subject(0.899, 0.5, 0.8)), "variant uncertain, P = 0.899");
    assert_eq!(needs_person(&subject(0.91, 0.85, 0.4)), "1 open connection would change the variant");
    // A circle whose vessels are taken as they are has no probability.
    assert_eq!(needs_person(&json!({ "phenotype": {} })), "");
    let without_circle = json!({ "convergence": { "undecided": 4 }, "expected_errors": { "wrong": 1.0, "missed": 0.5 } });
    assert_eq!(needs_person(&without_circle), "4 undecided; about 1.0 wrong and 0.5 missed expected");
    assert_eq!(
        needs_person(&json!({ "convergence": { "undecided": 0 }, "expected_errors": { "wrong": 0.1, "missed": 0.2 } })),
        ""
    );
}

#[test]
fn failed_and_uncertain_subjects_come_first() {
    let sure = |wrong: f64| Ok(vec![("expected_wrong", json!(wrong)), ("expected_missed", json!(0.5))]);
    let undecided = subject_row("u", Ok(vec![("undecided", json!(2.0))]));
    let order = [
        subject_row("f", Err(String::new())),
        subject_row("w", sure(3.0)),
        undecided,
        subject_row("s", sure(0.0)),
        subject_row("n", Ok(vec![])),
    ];
    assert!(order.windows(2).all(|pair| uncertainty(&pair[0]) > uncertainty(&pair[1])));
    let variant = |p: f64| subject_row("v", Ok(vec![("p_variant", json!(p)), ("undecided", json!(10.0 * p))]));
    assert!(uncertainty(&variant(0.4)) > uncertainty(&variant(0.9)));
}

fn names_of(paths: &[&str]) -> Vec<String> {
    named(&paths.iter().map(PathBuf::from).collect::<Vec<_>>())
}

#[test]
fn names_are_unique_and_safe() {
    assert_eq!(names_of(&["x/a.swc", "y/b.vtp"]), ["a", "b"]);
    assert_eq!(names_of(&["x/t.swc", "y/t.swc"]), ["x", "y"]);
    assert_eq!(names_of(&["x/t.swc", "y/t.swc", "y/b.swc"]), ["x-t", "y-t", "b"]);
    assert_eq!(names_of(&["1/x/t.swc", "2/x/T.swc"]), ["x", "x-2"]);
    assert_eq!(names_of(&["x/t.swc", "x/t.vtp", "x-2.swc"]), ["x-t", "x-t-2", "x-2"]);
    assert_eq!(names_of(&["a-2.swc", "a.swc", "A.vtp", "q.swc"]), ["a-2", "a", "A-3", "q"]);
    assert_eq!(
        names_of(&["<script>.swc", "..swc", "média 中.swc", "cohort.csv.swc"]),
        ["_script_", "subject", "média_中", "cohort.csv-2"]
    );
    assert!(names_of(&[&"y".repeat(300)])[0].len() <= LONGEST);
}

/// A folder has no ending: runs `p.1` and `p.2` were called after the folder in which they lie.
#[test]
fn folders_keep_their_dots() {
    let here = folder();
    let paths = ["c/p.1", "c/p.2", "c/T1.5T"].map(|name| here.path().join(name));
    for path in &paths {
        fs::create_dir_all(path).expect("a folder");
    }
    assert_eq!(named(&paths), ["p.1", "p.2", "T1.5T"]);
}

#[cfg(unix)]
#[test]
fn a_way_leads_from_folder_to_file() {
    let way = |file: &str, folder: &str| relative(Path::new(file), Path::new(folder)).expect("a way");
    assert_eq!(way("/a/runs/x/r.html", "/a/cohort"), "../runs/x/r.html");
    assert_eq!(way("runs/x/r.html", "./out/../cohort"), "../runs/x/r.html");
    assert_eq!(way("cohort/x/r.html", "cohort"), "x/r.html");
    assert_eq!(way("/b/r.html", "/a/c/d"), "../../../b/r.html");
}
